//! The commands of the README and the book print what is shown, and their links resolve.
//!
//! A block `console` holds commands after `$ ` and below each its standard output. `$ cd DIR`
//! holds for the rest of the page; a command whose line ends in `# exits with 1` must do so, the
//! others exit with 0. In the output, `...` on a line of its own stands for any lines and `[..]`
//! for any characters. With `LANDFALL_BLESS=1` output that differs is written into the page.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const README: &str = include_str!("../../README.md");
const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// A page of Markdown.
pub struct Page {
    pub file: PathBuf,
    pub text: String,
}

/// The chapters of the book, without their summary.
pub fn chapters() -> Vec<Page> {
    let mut found = Vec::new();
    collect(&Path::new(ROOT).join("docs/src"), &mut found);
    found.retain(|page| !page.file.ends_with("SUMMARY.md"));
    found
}

fn collect(folder: &Path, found: &mut Vec<Page>) {
    for entry in fs::read_dir(folder).expect("the book is there") {
        let file = entry.expect("an entry").path();
        if file.is_dir() {
            collect(&file, found);
        } else if file.extension().is_some_and(|it| it == "md") {
            found.push(page(file));
        }
    }
    found.sort_by(|a, b| a.file.cmp(&b.file));
}

fn page(file: PathBuf) -> Page {
    let text = fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    Page { file, text }
}

/// Every page that people read, the book's summary first.
fn pages() -> Vec<Page> {
    let others = [
        "docs/src/SUMMARY.md",
        "README.md",
        "CHANGELOG.md",
        "CONTRIBUTING.md",
        "ARCHITECTURE.md",
        "examples/README.md",
        "shaders/README.md",
    ];
    let others = others.map(|name| page(Path::new(ROOT).join(name)));
    others.into_iter().chain(chapters()).collect()
}

/// Whether differing text is written into the pages instead of failing.
pub fn blesses() -> bool {
    std::env::var_os("LANDFALL_BLESS").is_some_and(|value| value != "0")
}

/// The arguments of a command line; single quotes keep one together.
fn arguments(command: &str) -> Vec<String> {
    let mut found = vec![String::new()];
    let mut quoted = false;
    for c in command.chars() {
        match c {
            '\'' => quoted = !quoted,
            ' ' if !quoted => found.push(String::new()),
            _ => found.last_mut().expect("never empty").push(c),
        }
    }
    found
}

/// Runs a command line of landfall; returns its standard output.
fn run(line: &str, folder: &Path) -> String {
    let (command, code) = match line.split_once("  # exits with ") {
        Some((command, code)) => (command, code.parse().expect("an exit code")),
        None => (line, 0),
    };
    let arguments = arguments(command.trim_end());
    assert_eq!(arguments[0], "landfall", "{command}");
    let run = Command::new(env!("CARGO_BIN_EXE_landfall"))
        .args(&arguments[1..])
        .current_dir(folder)
        .env_remove("COLUMNS")
        .output()
        .expect("the command of this package");
    let errors = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(code), "{command}: {errors}");
    String::from_utf8(run.stdout).expect("output is UTF-8")
}

/// Whether a line is what is shown, where `[..]` stands for any characters.
fn line_fits(shown: &str, printed: &str) -> bool {
    match shown.split_once("[..]") {
        None => shown == printed,
        Some((start, rest)) => printed.strip_prefix(start).is_some_and(|printed| {
            let mut ends = (0..=printed.len()).filter(|&at| printed.is_char_boundary(at));
            ends.any(|at| line_fits(rest, &printed[at..]))
        }),
    }
}

/// Whether lines are what is shown, where a line `...` stands for any lines.
fn fits(shown: &[&str], printed: &[&str]) -> bool {
    match (shown, printed) {
        (["...", rest @ ..], _) => (0..=printed.len()).any(|at| fits(rest, &printed[at..])),
        ([one, rest @ ..], [line, more @ ..]) => line_fits(one, line) && fits(rest, more),
        ([], rest) => rest.is_empty(),
        ([_, ..], []) => false,
    }
}

/// Output without the blank lines at its end.
fn lines(text: &str) -> Vec<&str> {
    text.trim_end().lines().map(str::trim_end).collect()
}

/// The page with what its commands print now, and the commands whose output is not as shown.
fn rerun(text: &str, commands: &mut usize) -> (String, Vec<String>) {
    let (mut now, mut differing) = (String::new(), Vec::new());
    let mut folder = PathBuf::from(ROOT);
    let mut rest = text;
    while let Some((before, block)) = rest.split_once("```console\n") {
        let (block, after) = block.split_once("```").expect("a block ends");
        writeln!(now, "{before}```console").expect("a string grows");
        assert!(block.starts_with("$ "), "a command stands before its output:\n{block}");
        for part in block.strip_prefix("$ ").expect("just seen").split("\n$ ") {
            let (command, shown) = part.split_once('\n').unwrap_or((part, ""));
            writeln!(now, "$ {command}").expect("a string grows");
            if let Some(to) = command.strip_prefix("cd ") {
                folder = folder.join(to);
                assert!(folder.is_dir(), "{command}");
                continue;
            }
            *commands += 1;
            let printed = run(command, &folder);
            if fits(&lines(shown), &lines(&printed)) {
                lines(shown).iter().for_each(|line| now.extend([line, "\n"]));
            } else {
                lines(&printed).iter().for_each(|line| now.extend([line, "\n"]));
                differing.push(format!("$ {command}\n{printed}"));
            }
        }
        now.push_str("```");
        rest = after;
    }
    now.push_str(rest);
    (now, differing)
}

#[test]
fn every_command_prints_what_is_shown() {
    let mut commands = 0;
    for page in pages() {
        let (now, differing) = rerun(&page.text, &mut commands);
        if blesses() && now != page.text {
            fs::write(&page.file, now).expect("the page can be written");
            continue;
        }
        let place = page.file.display();
        assert!(
            differing.is_empty(),
            "{place}: these print something else (LANDFALL_BLESS=1 writes it there):\n{}",
            differing.join("\n")
        );
        assert_eq!(now, page.text, "{place}: blank lines or spaces at the end of output");
    }
    assert!(commands >= 20, "{commands} commands");
}

/// The command lines of landfall that are named in prose and shown in blocks that are not run.
fn named(text: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let prose = prose(text);
    let spans = prose.split('`').skip(1).step_by(2).map(|span| span.replace('\n', " "));
    found.extend(spans.filter(|span| span.starts_with("landfall ")));
    let blocks = text.split("```").skip(1).step_by(2);
    for block in blocks.filter(|it| it.starts_with("sh\n") || it.starts_with("text\n")) {
        let joined = block.replace("\\\n", " ");
        let lines = joined.lines().map(|line| line.strip_prefix("$ ").unwrap_or(line));
        let lines = lines.filter(|line| line.starts_with("landfall "));
        found.extend(lines.map(|line| line.split("  #").next().expect("a line").to_string()));
    }
    let others = ["landfall help", "landfall = "];
    found.retain(|command| !others.iter().any(|other| command.starts_with(other)));
    found
}

#[test]
fn every_command_that_is_named_has_the_options_it_is_named_with() {
    let (mut count, mut wrong) = (0, Vec::new());
    for page in pages().iter().filter(|page| !page.file.ends_with("CHANGELOG.md")) {
        for command in named(&page.text) {
            count += 1;
            // Options before `--help` are parsed; values are not looked at.
            let words = arguments(&command);
            let words = words[1..].iter().filter(|word| !word.is_empty());
            let options = words.filter(|word| !word.contains(['…', '|', '>']));
            let run = Command::new(env!("CARGO_BIN_EXE_landfall"))
                .args(options)
                .arg("--help")
                .output()
                .expect("the command of this package");
            let errors = String::from_utf8_lossy(&run.stderr);
            if !run.status.success() {
                wrong.push(format!("{}: {command}: {errors}", page.file.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(count >= 40, "{count} commands");
}

#[test]
fn placeholders_stand_for_any_text_and_nothing_else() {
    assert!(fits(&["a", "...", "d"], &["a", "b", "c", "d"]));
    assert!(fits(&["...", "d"], &["d"]));
    assert!(!fits(&["a", "...", "d"], &["a", "b"]));
    assert!(!fits(&["a"], &["a", "b"]));
    assert!(line_fits("time [..] s", "time 0.11 s"));
    assert!(!line_fits("time [..] s", "time 0.11 ms or so"));
    let (_, differing) = rerun("```console\n$ landfall --version\nlandfall 0\n```\n", &mut 0);
    assert_eq!(differing.len(), 1, "a wrong line is found");
}

#[test]
fn the_two_commands_of_the_set_up_are_there() {
    assert!(README.contains("cargo run --release -- layout shaders\n"));
    assert!(README.contains("./tests/run\n"));
    assert!(Path::new(ROOT).join("tests/run").is_file());
}

/// The examples are built and run, so lines that are theirs compile.
#[test]
fn every_build_script_that_is_shown_is_made_of_lines_of_the_examples() {
    let folders = ["tests/example", "examples/gl_lights", "examples/wgpu_lights"];
    let scripts = folders.map(|folder| {
        let file = Path::new(ROOT).join(folder).join("build.rs");
        fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()))
    });
    let known: Vec<&str> = scripts.iter().flat_map(|text| text.lines().map(str::trim)).collect();
    let mut blocks = 0;
    for page in pages() {
        for block in page.text.split("```rust,no_run\n").skip(1) {
            blocks += 1;
            let lines = block.split("```").next().expect("a block ends").lines().map(str::trim);
            for line in lines.filter(|line| !line.starts_with("//")) {
                assert!(known.contains(&line), "{}: `{line}`", page.file.display());
            }
        }
    }
    assert!(blocks >= 3, "{blocks} blocks");
}

/// The text outside of fenced blocks.
fn prose(text: &str) -> String {
    let mut fenced = false;
    let outside = text.lines().filter(|line| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        !fenced && !fence
    });
    outside.flat_map(|line| [line, "\n"]).collect()
}

/// The anchors of the headings, as GitHub and mdBook make them.
fn anchors(text: &str) -> Vec<String> {
    let headings = prose(text);
    let headings = headings.lines().filter_map(|line| {
        let title = line.trim_start_matches('#');
        (title.len() < line.len() && title.starts_with(' ')).then(|| title.trim().to_lowercase())
    });
    let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
    headings.map(|title| title.chars().filter(kept).collect::<String>().replace(' ', "-")).collect()
}

#[test]
fn every_relative_link_leads_to_a_file_and_a_heading() {
    let mut links = 0;
    for page in pages() {
        let folder = page.file.parent().expect("a page is in a folder");
        for link in prose(&page.text).split("](").skip(1) {
            let link = link.split(')').next().expect("a link ends");
            if link.contains("://") {
                continue;
            }
            links += 1;
            let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
            let to = if path.is_empty() { page.file.clone() } else { folder.join(path) };
            assert!(to.exists(), "{}: {link}", page.file.display());
            if !anchor.is_empty() {
                let text = fs::read_to_string(&to).expect("an anchor is in a page");
                let known = anchors(&text);
                let place = page.file.display();
                assert!(known.iter().any(|it| it == anchor), "{place}: {link} of {known:?}");
            }
        }
    }
    assert!(links >= 60, "{links} links");
}

#[test]
fn the_summary_lists_every_chapter_once() {
    let book = Path::new(ROOT).join("docs/src");
    let summary = fs::read_to_string(book.join("SUMMARY.md")).expect("the summary");
    for chapter in chapters() {
        let path = chapter.file.strip_prefix(&book).expect("it is of the book");
        let path = path.to_str().expect("names are ASCII").replace('\\', "/");
        assert_eq!(summary.matches(&format!("]({path})")).count(), 1, "{path}");
        assert!(chapter.text.starts_with("# "), "{path} starts with its title");
    }
}
