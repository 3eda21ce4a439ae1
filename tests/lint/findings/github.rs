//! Workflow commands, read as the runner reads them, and the summary of a step.

use std::collections::HashMap;

use landfall_layout::finding::{Finding, Level, Place};
use landfall_layout::format::Paint;
use landfall_lint::render::{ReportFormat, github_summary};

use crate::findings::{plain, sample};

/// A command as the runner takes it from a line of the log.
struct Command {
    name: String,
    properties: HashMap<String, String>,
    data: String,
}

fn command(line: &str) -> Command {
    let (head, data) = line.strip_prefix("::").and_then(|l| l.split_once("::")).expect("a command");
    let (name, properties) = head.split_once(' ').unwrap_or((head, ""));
    let unescaped = |text: &str, also: &[(&str, &str)]| {
        let mut text = text.to_string();
        for (code, character) in [("%0D", "\r"), ("%0A", "\n")].iter().chain(also) {
            text = text.replace(code, character);
        }
        text.replace("%25", "%")
    };
    let pairs = properties.split(',').map(|pair| {
        let (key, value) = pair.split_once('=').expect("a property has a value");
        (key.to_string(), unescaped(value, &[("%3A", ":"), ("%2C", ",")]))
    });
    Command { name: name.to_string(), properties: pairs.collect(), data: unescaped(data, &[]) }
}

fn commands(findings: &[Finding]) -> Vec<Command> {
    plain(findings, ReportFormat::Github).lines().map(command).collect()
}

#[test]
fn annotations_stand_at_their_place_errors_first() {
    let text = plain(&sample::findings(), ReportFormat::Github);
    let first = text.lines().next().expect("the error");
    assert_eq!(
        first,
        "::error file=shaders/lights.frag,line=7,endLine=7,col=24,endColumn=39,\
         title=block-mismatch::`PointLightBlock` has 6160 bytes here and 4112 bytes in \
         `shaders/copy.vert`%0A4112 bytes: shaders/copy.vert:2:24%0Astride 16, not 48: \
         shaders/copy.vert:3:5%0Ahelp: declare `data` as `PointLight data[128]` in \
         `shaders/copy.vert`"
    );
    let names: Vec<String> = commands(&sample::findings()).into_iter().map(|c| c.name).collect();
    assert_eq!(names, ["error", "warning", "warning"]);
    assert_eq!(plain(&[], ReportFormat::Github), "");
}

#[test]
fn hostile_strings_come_back() {
    // At most ten of each, so that none goes into the notice.
    for some in sample::hostile().chunks(9) {
        let commands = commands(some);
        assert_eq!(commands.len(), some.len());
        for finding in some {
            let path = kept(&finding.place().path);
            let found = commands.iter().find(|c| c.properties["file"] == path);
            let found = found.expect("every finding is annotated");
            assert!(found.data.starts_with(&kept(&finding.message)), "{:?}", found.data);
            assert_eq!(found.properties["title"], finding.code);
            let one_line =
                finding.place().line > 0 && finding.place().line == finding.place().end_line;
            assert_eq!(found.properties.contains_key("col"), one_line);
        }
    }
}

/// Marks that turn the direction of text, and Unicode's ends of lines (UAX #9, §2; UAX #14, BK).
const BIDI: &str = "\u{61c}\u{200e}\u{200f}\u{202a}\u{202b}\u{202c}\u{202d}\u{202e}\
                    \u{2066}\u{2067}\u{2068}\u{2069}\u{2028}\u{2029}";

/// What colours a log or turns its text around is left out.
fn kept(text: &str) -> String {
    let kept = |c: char| !(c.is_control() || BIDI.contains(c)) || "\t\r\n".contains(c);
    text.chars().map(|c| if kept(c) { c } else { '\u{fffd}' }).collect()
}

fn many(count: u32, level: Level) -> Vec<Finding> {
    let one = |line| {
        let place =
            Place { line, column: 1, end_line: line, end_column: 2, ..Place::file("a.frag") };
        let mut finding = Finding::at("vec3-array", format!("a{line}"), place, "costs 4 bytes");
        finding.severity = level.severity().expect("it reports");
        finding
    };
    (1..=count).map(one).collect()
}

#[test]
fn past_the_tenth_of_each_a_notice_lists_the_others() {
    let mut findings = many(12, Level::Warn);
    findings.extend(many(11, Level::Deny));
    let commands = commands(&findings);
    let count = |name: &str| commands.iter().filter(|c| c.name == name).count();
    assert_eq!((count("error"), count("warning"), count("notice")), (10, 10, 1));
    let notice = commands.last().expect("it comes last");
    assert_eq!(notice.properties["title"], "3 findings more");
    let lines: Vec<&str> = notice.data.lines().collect();
    assert_eq!(lines.len(), 4);
    assert_eq!(lines[1], "a.frag:11:1: error[vec3-array] costs 4 bytes");
    assert_eq!(lines[3], "a.frag:12:1: warning[vec3-array] costs 4 bytes");
    let thousands = plain(&many(9000, Level::Deny), ReportFormat::Github);
    assert!(thousands.len() < 64 << 10, "{} bytes", thousands.len());
    assert!(thousands.trim_end().ends_with("%0A… and 8890 more"));
}

fn summary(findings: &[Finding]) -> String {
    github_summary(findings, &sample::options(Paint::Plain))
}

#[test]
fn the_summary_is_a_table_errors_first() {
    assert_eq!(
        summary(&sample::findings()[1..]),
        "\
### Landfall

65 shaders: 1 error, 1 warning

| | place | lint | what |
|---|---|---|---|
| error | `shaders/lights.frag:7:24` | `block-mismatch` | `PointLightBlock` has 6160 bytes here and 4112 bytes in `shaders/copy.vert`<br>help: declare `data` as `PointLight data[128]` in `shaders/copy.vert` |
| warning | `layouts/gone.frag.json` | `lock-orphan` | this lock is of `shaders/gone.frag`, which is not there<br>help: delete the lock: `landfall lock &#45;&#45;prune` |
"
            .replace("&#45;", "-")
    );
    assert_eq!(summary(&[]), "### Landfall\n\n65 shaders: no findings\n");
}

/// The cells of a row as GitHub splits them: a backslash takes the next character with it.
fn cells(row: &str) -> usize {
    let mut pipes = 0;
    let mut letters = row.chars();
    while let Some(c) = letters.next() {
        match c {
            '\\' => drop(letters.next()),
            '|' => pipes += 1,
            _ => {}
        }
    }
    pipes - 1
}

#[test]
fn no_string_breaks_a_row_or_becomes_html() {
    let text = summary(&sample::hostile());
    let rows: Vec<&str> =
        text.lines().skip_while(|line| !line.starts_with("|---")).skip(1).collect();
    assert_eq!(rows.len(), sample::HOSTILE.len());
    for row in rows {
        assert_eq!(cells(row), 4, "{row}");
        let outside: String = row.split('`').step_by(2).collect();
        let bare = outside.replace("<br>", "").replace("<code>", "").replace("</code>", "");
        assert!(!bare.contains(['<', '>', '[', '*']), "{row}");
    }
}

#[test]
fn a_summary_stays_below_what_github_takes() {
    let text = summary(&many(50_000, Level::Deny));
    assert!(text.len() < 1 << 20);
    let rows = text.matches("| error |").count();
    assert!(text.ends_with(&format!("\n… and {} more\n", 50_000 - rows)));
}
