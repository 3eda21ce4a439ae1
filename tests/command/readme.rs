//! The commands of the README and the book print what is shown, and their links resolve.
//!
//! A block `console` is a session of trycmd: commands after `$ `, below each `? 1` where it does
//! not exit with 0, then its standard output and standard error, and an empty line at its end.
//! `...` on a line of its own stands for any lines and `[..]` for any characters. The sessions run
//! in the root of the repository, or where the page's `$ cd DIR` leads. `TRYCMD=overwrite` writes
//! output that differs into the page.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

use trycmd::TestCases;
use trycmd::schema::Bin;

use crate::support::command::{self, Place};

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

/// The command lines of a page's sessions.
fn commands(page: &Page) -> Vec<&str> {
    let sessions = page.text.split("```console\n").skip(1);
    let lines = sessions.flat_map(|block| block.lines().take_while(|line| *line != "```"));
    lines.filter_map(|line| line.strip_prefix("$ ")).collect()
}

/// The directory in which the commands of a page run.
fn directory(page: &Page) -> PathBuf {
    let commands = commands(page);
    let to = commands[0].strip_prefix("cd ");
    // trycmd leaves out programs that it does not know.
    for command in &commands[usize::from(to.is_some())..] {
        assert!(command.starts_with("landfall "), "{}: `{command}`", page.file.display());
    }
    Path::new(ROOT).join(to.unwrap_or(""))
}

/// trycmd runs a page in the folder beside it that ends in `.in`, and has no `cd`: each page is
/// run as a copy, beside which that folder is a link to its directory.
#[test]
fn every_command_prints_what_is_shown() {
    let copies = Place::new("pages");
    let pages: Vec<Page> =
        pages().into_iter().filter(|page| page.text.contains("```console\n")).collect();
    let cases = TestCases::new();
    cases.register_bin("landfall", Path::new(env!("CARGO_BIN_EXE_landfall")));
    cases.register_bin("cd", Bin::Ignore);
    for (nth, page) in pages.iter().enumerate() {
        copies.write(&format!("{nth}.md"), &page.text);
        symlink(directory(page), copies.0.join(format!("{nth}.in"))).expect("a new name");
        cases.case(copies.0.join(format!("{nth}.md")));
    }
    cases.run();
    for (nth, page) in pages.iter().enumerate() {
        let now = copies.read(&format!("{nth}.md"));
        // Only as `TRYCMD=overwrite`: otherwise what differs has failed.
        if now != page.text {
            fs::write(&page.file, now).expect("the page can be written");
        }
    }
    let commands: usize = pages.iter().map(|page| commands(page).len()).sum();
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
        for line in named(&page.text) {
            count += 1;
            // Options before `--help` are parsed; values are not looked at.
            let words = arguments(&line);
            let words = words[1..].iter().filter(|word| !word.is_empty());
            let options = words.filter(|word| !word.contains(['…', '|', '>']));
            let options: Vec<&str> = options.map(String::as_str).chain(["--help"]).collect();
            let ran = command::run(&options);
            if ran.code != 0 {
                wrong.push(format!("{}: {line}: {}", page.file.display(), ran.err));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(count >= 40, "{count} commands");
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
