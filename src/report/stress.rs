//! The report of `landfall stress`: a table and findings as text, SARIF and JSON.
//!
//! Formats the data of [`accuracy::stress`](landfall_accuracy::stress).

mod json;

use std::fmt::Write as _;
use std::sync::Arc;

#[cfg(feature = "schema")]
pub use self::json::schema;
pub use self::json::{STRESS_SCHEMA, json};
use super::bench::distributed;
use super::brief::{LINES, cut};
use super::prove::Listed;
use anstyle::Style;
use landfall_accuracy::stress::messages::{figure, number};
use landfall_accuracy::stress::{
    BackendReport, Disagreement, Report, StressFinding, Tally, Verdict, command, count_lines,
};
use landfall_exec::report::device::adapter;
use landfall_layout::finding::{Finding, Level};
use landfall_layout::format::columns::{GAP, WIDTH, wrapped};
use landfall_layout::format::paint::{CAUTION, FAINT, PLAIN, Paint, STRONG};
pub use landfall_layout::format::phrases;
use landfall_layout::layout::targets;
pub use landfall_layout::text::escape;
use landfall_lint::render::{ReportFormat, ReportOptions, report};

/// Returns what breaks: the samples, the largest error, and as many findings as fit.
pub fn brief(stressed: &Report, paint: Paint) -> String {
    let mut text = opening(stressed, paint);
    let Tally { nan, infinite, ulp, steps, .. } = &stressed.total;
    let not_finite =
        |count: u64, what| (count > 0).then(|| format!("{what} in {}, ", phrases::number(count)));
    let [nan, infinite] =
        [not_finite(*nan, "NaN"), not_finite(*infinite, "infinite")].map(Option::unwrap_or_default);
    indented(&format!("{nan}{infinite}{}", largest_error(ulp.max, steps.max)), &mut text);
    for backend in &stressed.backends {
        match backend.failure {
            Some(_) => failure(backend, paint, &mut text),
            None => {
                let Tally { ulp, steps, .. } = &backend.tally;
                let error = largest_error(ulp.max, steps.max);
                let _ = writeln!(text, "  {}: {error}", backend.backend);
            }
        }
    }
    let (shown, folded) = divided(stressed);
    let mut left = shown.len() + folded;
    let mut lines = text.lines().count() + 1;
    for found in &shown {
        let (style, all) = finding_lines(stressed, found);
        lines += all.len();
        if lines > LINES {
            break;
        }
        left -= 1;
        for (nth, line) in all.iter().enumerate() {
            let indent = if nth == 0 { "" } else { "  " };
            let style = if nth == 0 { style } else { PLAIN };
            let _ = writeln!(text, "{indent}{}", paint.text(style, line));
        }
    }
    let more = match left {
        0 if shown.is_empty() => "no findings; ".to_string(),
        0 => String::new(),
        left => format!(
            "{}; ",
            phrases::counted(left, if shown.is_empty() { "finding" } else { "further finding" })
        ),
    };
    let line = format!("{more}--details prints help and errors, --all every input");
    let _ = writeln!(text, "{}", paint.text(FAINT, &line));
    cut(text, paint)
}

fn largest_error(ulp: f64, steps: f64) -> String {
    match ulp {
        0.0 => "no error".to_string(),
        _ => format!("off by {} ULP, {} steps of 1/255", figure(ulp), figure(steps)),
    }
}

/// Returns the function, and how often it ran.
fn opening(stressed: &Report, paint: Paint) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{}  {}",
        paint.text(STRONG, &stressed.function),
        paint.text(FAINT, &escape::name(&stressed.path))
    );
    if let Some(note) = targets::note(stressed.assumed_target) {
        let _ = writeln!(text, "  {}", paint.text(CAUTION, &note));
    }
    let threads = match stressed.threads {
        1 => "1 thread".to_string(),
        threads => format!("{threads} threads"),
    };
    let ran = match stressed.every {
        Some(1) => "the only input".to_string(),
        Some(all) => format!("all {} inputs", phrases::number(all)),
        None => phrases::numbered(stressed.total.samples, "sample"),
    };
    let _ = writeln!(
        text,
        "  {ran} in {:.1} s, {} a second on {threads}, seed {}{}",
        stressed.seconds,
        phrases::number(stressed.rate as u64),
        stressed.seed,
        if stressed.stopped { ", stopped before the end" } else { "" }
    );
    text
}

/// Returns the findings that a scene meets, and how many others there are.
fn divided(stressed: &Report) -> (Vec<&StressFinding>, usize) {
    // Findings that no scene meets are only counted, unless their level was raised.
    let is_shown = |found: &&StressFinding| found.plausible || found.level != Level::Warn;
    let shown: Vec<&StressFinding> = stressed.findings.iter().filter(is_shown).collect();
    let folded = stressed.findings.len() - shown.len();
    (shown, folded)
}

/// Returns a finding by its place and its effect, in lines, and the style of the first.
fn finding_lines(stressed: &Report, found: &StressFinding) -> (Style, Vec<String>) {
    let lint = stressed.lint(found);
    let at = stressed.files.locate(found.place.span);
    let style = if found.level == Level::Deny { STRONG } else { CAUTION };
    let level = if lint.level() == Level::Deny { "error" } else { "warning" };
    let head = format!("{}:{}: {level}[{}]: ", at.line, at.column, lint.code);
    (style, wrapped(&format!("{head}{}", found.message()), WIDTH - 2))
}

/// Returns the text: a table of the samples, then the findings with their excerpts, the few that a
/// scene meets or all, then what is known of the operations.
pub fn text(stressed: &Report, listed: Listed, paint: Paint) -> String {
    let mut text = opening(stressed, paint);
    // Each input of a small domain is run, and nothing drawn.
    if stressed.every.is_none() && !stressed.distributions.is_empty() {
        let line = shortened(&format!("inputs drawn: {}", distributed(&stressed.distributions)));
        indented(&line, &mut text);
    }
    table(stressed, listed, paint, &mut text);
    if listed == Listed::All {
        largest(stressed, paint, &mut text);
    }
    stressed.backends.iter().for_each(|backend| driver(backend, paint, &mut text));
    for note in &stressed.notes {
        let note = wrapped(note, WIDTH - 4).join("\n    ");
        let _ = writeln!(text, "  {}", paint.text(FAINT, &note));
    }
    text.push('\n');
    let (shown, folded) = match listed {
        Listed::Few => divided(stressed),
        Listed::All => (stressed.findings.iter().collect(), 0),
    };
    let left = match listed {
        Listed::Few if shown.len() > EXCERPTS => briefly(stressed, &shown, paint, &mut text),
        Listed::Few | Listed::All => {
            if folded == 0 || !shown.is_empty() {
                let lints: Vec<Finding> = shown.iter().map(|found| stressed.lint(found)).collect();
                text.push_str(&printed(stressed, &lints, ReportFormat::Human, paint));
            }
            0
        }
    };
    if left > 0 {
        let findings = phrases::counted(left, "further finding");
        let line = format!("{findings}: printed with --all, and the inputs of each");
        let _ = writeln!(text, "{}", paint.text(FAINT, &line));
    }
    if folded > 0 {
        let noun = if shown.is_empty() { "finding" } else { "further finding" };
        let findings = phrases::counted(folded, noun);
        let line = format!("{findings} with values that no scene has: printed with --all");
        let _ = writeln!(text, "{}", paint.text(FAINT, &line));
    }
    if !stressed.operations.is_empty() {
        text.push('\n');
    }
    for line in count_lines(&stressed.operations) {
        let _ = writeln!(text, "{}", wrapped(&line, WIDTH - 2).join("\n  "));
    }
    text
}

/// The most findings printed with excerpts and inputs unless all are.
const EXCERPTS: usize = 2;

/// The lines of findings without excerpts: a screen has 24 to 30, of which others take ten.
const SCREEN: usize = 19;

/// Appends findings by place, effect and help, as many as fit a screen; returns how many are left.
fn briefly(stressed: &Report, shown: &[&StressFinding], paint: Paint, text: &mut String) -> usize {
    let mut lines = 0;
    for (nth, found) in shown.iter().enumerate() {
        let (style, mut all) = finding_lines(stressed, found);
        let first = all.remove(0);
        let lint = stressed.lint(found);
        let help = lint.help.map(|help| format!("help: {help}"));
        let rest = all.into_iter().chain(help.iter().flat_map(|help| wrapped(help, WIDTH - 4)));
        let rest: Vec<String> = rest.collect();
        lines += 1 + rest.len();
        // At least one finding, as in the brief report.
        if lines > SCREEN && nth > 0 {
            return shown.len() - nth;
        }
        let _ = writeln!(text, "{}", paint.text(style, &first));
        for line in rest {
            let _ = writeln!(text, "  {line}");
        }
    }
    0
}

/// Appends the samples with the largest errors.
fn largest(stressed: &Report, paint: Paint, text: &mut String) {
    let worst = ["largest in ULP", "largest in steps"].into_iter().zip(&stressed.worst);
    for (what, worst) in worst.filter(|(_, worst)| worst.off.ulp > 0.0) {
        let [ulp, steps] = [worst.off.ulp, worst.off.steps].map(figure);
        let inputs = shortened(&worst.sample.shown());
        indented(&format!("{what}: {ulp} ULP, {steps} steps with {inputs}"), text);
        if let Some(condition) = worst.condition.as_ref().filter(|c| c.steps > 0.0) {
            let line = format!(
                "changing `{}` by one ULP changes the result by {} steps; condition number {}",
                condition.path,
                figure(condition.steps),
                figure(condition.number)
            );
            let line = wrapped(&line, WIDTH - 6).join("\n      ");
            let _ = writeln!(text, "    {}", paint.text(FAINT, &line));
        }
    }
}

/// The longest command shown as text, in characters.
const LONG: usize = 600;

/// Appends why a driver stopped or did not run.
fn failure(backend: &BackendReport, paint: Paint, text: &mut String) {
    let Some(failure) = &backend.failure else { return };
    let what = if backend.ran() { "stopped" } else { "did not run" };
    let line = format!("{} {what}: {failure}", backend.backend);
    let line = wrapped(&line, WIDTH - 4).join("\n    ");
    let _ = writeln!(text, "  {}", paint.text(CAUTION, &line));
}

/// Appends the results of a driver, below the table.
fn driver(backend: &BackendReport, paint: Paint, text: &mut String) {
    let name = backend.backend;
    if let Some(device) = &backend.device {
        let version = format!("{} {}", device.driver, device.version);
        let rate = match backend.ran() {
            true => format!(", {} samples a second", phrases::number(backend.rate as u64)),
            false => String::new(),
        };
        let _ = writeln!(text, "  {name}: {}, {}{rate}", adapter(device), version.trim());
    }
    failure(backend, paint, text);
    let same = |pair: &[_]| matches!(pair, [a, b] if a == b);
    let arguments: Vec<_> = backend.worst.iter().map(|worst| &worst.case.arguments).collect();
    // One sample may be the worst by both measures; it is printed once.
    let names: &[&str] = match same(&arguments) {
        true => &["largest in ULP and in steps"],
        false => &["largest in ULP", "largest in steps"],
    };
    for (what, case) in names.iter().zip(&backend.worst) {
        let verdict = match case.verdict {
            Some(Verdict::Permitted) => ", which the specification permits",
            Some(Verdict::Wrong) => ", more than the specification permits",
            None => "",
        };
        let off = case.off().unwrap_or_default();
        let (ulp, steps, inputs) =
            (figure(off.ulp), figure(off.steps), shortened(&case.case.shown()));
        let line = format!("{name}: {what}: {ulp} ULP, {steps} steps{verdict}, with {inputs}");
        indented(&line, text);
        let given = case.results.iter().zip(&case.case.results);
        let given: Vec<String> = given
            .map(|(single, truth)| {
                let (single, double) = (number(f64::from(*single)), number(truth.double));
                format!("{} is {single}, should be {double}", truth.path)
            })
            .collect();
        let again = match command(&case.case.arguments) {
            long if long.len() > LONG => {
                "`--format json` prints the command that reproduces it".into()
            }
            short => short,
        };
        for line in [shortened(&given.join("; ")), again] {
            let _ = writeln!(text, "{}", paint.text(FAINT, &format!("    {line}")));
        }
    }
    let parted = Disagreement { count: backend.parted, cases: Vec::new() };
    let disagreements = [
        (&backend.not_finite, "not finite where the interpreter is"),
        (&backend.hidden, "finite where the interpreter is not"),
        (&backend.apart, "off by more than the threshold where the interpreter is not"),
        (&parted, "discarded by either the driver or the interpreter, not both"),
    ];
    for (found, what) in disagreements.iter().filter(|(found, _)| found.count > 0) {
        let _ = writeln!(text, "  {name}: {} {what}", phrases::numbered(found.count, "sample"));
    }
}

/// Returns an HTML page with the map of errors and the findings below it.
pub fn page(stressed: &Report, svg: &str) -> String {
    let title = escape::xml(&stressed.function);
    let text = text(stressed, Listed::Few, Paint::Plain);
    let findings: String = text.lines().map(|line| escape::xml(line) + "\n").collect();
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
         <body>\n{svg}\n<pre>{findings}</pre>\n</body>\n</html>\n"
    )
}

/// The longest line of values printed, in characters.
const LINE: usize = 400;

/// Writes a line below the heading, wrapped.
fn indented(line: &str, text: &mut String) {
    for (nth, line) in wrapped(line, WIDTH - 4).iter().enumerate() {
        let _ = writeln!(text, "{}{line}", if nth == 0 { "  " } else { "    " });
    }
}

fn shortened(values: &str) -> String {
    match values.char_indices().nth(LINE) {
        Some((at, _)) => format!("{}…", &values[..at]),
        None => values.to_string(),
    }
}

/// Returns the findings in a format of `check`.
pub fn rendered(stressed: &Report, format: ReportFormat, paint: Paint) -> String {
    printed(stressed, &stressed.lints(), format, paint)
}

fn printed(stressed: &Report, lints: &[Finding], format: ReportFormat, paint: Paint) -> String {
    let text = |path: &str| -> Option<Arc<str>> {
        stressed.files.iter().find(|file| file.path == path).map(|file| file.text.clone())
    };
    report(lints, format, &ReportOptions { paint, text: &text, shaders: 1 })
}

/// Returns the findings as SARIF.
pub fn sarif(stressed: &Report) -> String {
    rendered(stressed, ReportFormat::Sarif, Paint::Plain)
}

fn table(stressed: &Report, listed: Listed, paint: Paint, text: &mut String) {
    let head = ["", "samples", "NaN", "inf", "max", "99.9 %", "max", "99.9 %", "max", "99.9 %"];
    let mut rows: Vec<Vec<String>> = vec![head.map(str::to_string).to_vec()];
    let mut row = |name: &str, tally: &Tally| {
        let mut row = vec![name.to_string()];
        row.extend([tally.samples, tally.nan, tally.infinite].map(phrases::number));
        for spread in [&tally.ulp, &tally.relative, &tally.steps] {
            row.extend([figure(spread.max), figure(spread.p999())]);
        }
        rows.push(row);
    };
    for (family, tally) in &stressed.families {
        if tally.samples > 0 && listed == Listed::All {
            row(family.name(), tally);
        }
    }
    row("all finite", &stressed.total);
    for backend in stressed.backends.iter().filter(|backend| backend.ran()) {
        row(&format!("finite on {}", backend.backend), &backend.tally);
    }
    let mut widths: Vec<usize> = (0..head.len())
        .map(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0))
        .collect();
    let all = widths.iter().sum::<usize>() + 2 + GAP.len() * (widths.len() - 1);
    // Columns are set closer before the table is wider than the line.
    let gap = if all > WIDTH { " " } else { GAP };
    // Above the pairs of columns, the measures of error.
    let mut line = " ".repeat(2 + widths[..4].iter().sum::<usize>() + 3 * gap.len());
    for (measure, column) in [("ULP", 4), ("relative", 6), ("1/255 steps", 8)] {
        let pair = widths[column] + gap.len() + widths[column + 1];
        // A heading that is wider than its two columns widens the first of them.
        widths[column] += measure.len().saturating_sub(pair);
        line.push_str(&format!("{gap}{measure:>0$}", pair.max(measure.len())));
    }
    let _ = writeln!(text, "{}", paint.text(FAINT, &line));
    for (nth, row) in rows.iter().enumerate() {
        let mut line = String::from("  ");
        for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
            let pad = " ".repeat(width - cell.chars().count());
            match column {
                0 => line.push_str(&format!("{cell}{pad}")),
                _ => line.push_str(&format!("{gap}{pad}{cell}")),
            }
        }
        // Rows of the family `special` have such inputs, so such results are no fault.
        let non_finite = nth > 0 && (row[2] != "0" || row[3] != "0") && row[0] != "special";
        let style = if nth == 0 {
            FAINT
        } else if non_finite {
            CAUTION
        } else {
            PLAIN
        };
        let _ = writeln!(text, "{}", paint.text(style, line.trim_end()));
    }
}
