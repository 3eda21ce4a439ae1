//! The reference chapters of the book are what the command prints. `SNAPSHOTS=overwrite` writes
//! the chapter of commands.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use snapbox::Data;

use crate::support::command::{self, golden};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// What a run prints that finds nothing.
pub fn landfall(arguments: &[&str]) -> String {
    let ran = command::run(arguments);
    ran.code(0);
    ran.out
}

fn chapter(name: &str) -> String {
    let file = Path::new(ROOT).join("docs/src/reference").join(name);
    fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()))
}

/// The names of the commands, in the order of the help.
pub fn commands() -> Vec<String> {
    let help = landfall(&["--help"]);
    let rows = help.lines().take_while(|line| *line != "Options:");
    let rows = rows.filter_map(|line| line.strip_prefix("  ")?.split_once("  "));
    let is_name = |name: &&str| !name.is_empty() && name.bytes().all(|b| b.is_ascii_lowercase());
    let names = rows.map(|(name, _)| name).filter(is_name).filter(|name| *name != "help");
    names.map(str::to_string).collect()
}

/// The text with each run of white space as one space.
fn joined(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The heading of a section of options that is not a command's own: `How shaders are read`.
fn heading(section: &str) -> Option<&str> {
    let heading = section.lines().next()?.strip_suffix(':')?;
    let own = ["Usage", "Arguments", "Options", "Commands"];
    (!heading.starts_with(' ') && !own.contains(&heading)).then_some(heading)
}

/// Commands that have the same section, from which on it is printed once.
const SHARED: usize = 4;

/// The chapter of commands: the short help of each, and sections that many have once.
fn reference() -> String {
    let names = commands();
    let helps: Vec<String> = names.iter().map(|name| landfall(&[name, "-h"])).collect();
    let helps: Vec<Vec<&str>> =
        helps.iter().map(|help| help.trim_end().split("\n\n").collect()).collect();
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for section in helps.iter().flatten() {
        *counts.entry(joined(section)).or_default() += 1;
    }
    let is_shared =
        |section: &str| heading(section).is_some() && counts[&joined(section)] >= SHARED;

    let mut text = String::from(
        "# Commands\n\n`landfall help COMMAND` prints more of each option. Every command exits \
         with 0 when all is well,\nwith 1 on a finding (a lint at level `deny`, a changed layout, \
         a byte read elsewhere), and with 2\nwhen something could not be done. Products go to \
         standard output, findings and progress to\nstandard error. Ctrl-C ends every command within half \
         a second with the results so far and exit\ncode 130; unfinished files are removed.\n\n\
         Every command runs within a budget, and ends with exit code 2 and the name of the limit \
         beyond it:\n\n| what | limit | option |\n|---|---|---|\n\
         | time of the command | 3600 s; `stress` at least twice its `--time` | `--max-time SECONDS` |\n\
         | memory of the process and of those it starts, such as drivers (Linux) | 8192 MiB | `--max-memory MIB` |\n\
         | size of a shader or an include | 64 MiB | |\n\
         | one job of a driver or the interpreter | 20 s | `--limit SECONDS` |\n\
         | triangles of a scene | 1,048,576 | |\n",
    );
    let mut shared: Vec<&str> = Vec::new();
    for (sections, name) in helps.iter().zip(&names) {
        let own: Vec<&str> = sections.iter().copied().filter(|it| !is_shared(it)).collect();
        write!(text, "\n## {name}\n\n```text\n{}\n```\n", own.join("\n\n")).expect("it grows");
        for section in sections.iter().filter(|section| is_shared(section)) {
            let title = heading(section).expect("a shared section has one");
            let anchor = title.to_lowercase().replace(' ', "-");
            write!(text, "\nAnd [{}](#{anchor}).\n", title.to_lowercase()).expect("it grows");
            if !shared.iter().any(|known| joined(known) == joined(section)) {
                shared.push(section);
            }
        }
    }
    for section in shared {
        let (title, options) = section.split_once(":\n").expect("a heading and its options");
        write!(text, "\n## {title}\n\n```text\n{options}\n```\n").expect("it grows");
    }
    text
}

#[test]
fn the_chapter_of_commands_is_the_help() {
    assert!(commands().len() >= 15, "{:?}", commands());
    let file = Path::new(ROOT).join("docs/src/reference/commands.md");
    golden().eq(reference(), Data::read_from(&file, None).raw());
}

#[test]
fn the_chapter_of_schemas_links_each_of_them() {
    let text = chapter("schemas.md");
    let rows: Vec<(&str, &str)> = text
        .lines()
        .filter_map(|line| {
            let (name, rest) = line.strip_prefix("| [`")?.split_once("`](")?;
            Some((name, rest.split_once(')')?.0))
        })
        .collect();
    for (name, path) in &rows {
        let file = Path::new(ROOT).join("docs/src/reference").join(path);
        let schema = fs::read_to_string(&file).unwrap_or_else(|e| panic!("{path}: {e}"));
        assert_eq!(landfall(&["schema", name]).trim_end(), schema.trim_end(), "{name}");
    }
    let named: BTreeSet<&str> = rows.iter().map(|(name, _)| *name).collect();
    let help = landfall(&["schema", "--help"]);
    let values = help.lines().filter_map(|line| line.trim_start().strip_prefix("- "));
    let known: BTreeSet<&str> = values.filter_map(|line| Some(line.split_once(':')?.0)).collect();
    assert_eq!(named, known, "the table has every schema");
}

#[test]
fn the_chapter_of_the_configuration_has_every_key() {
    let example = include_str!("../../crates/landfall-check/src/config/example.toml");
    let shown = format!("```toml\n{example}```\n");
    assert!(chapter("configuration.md").contains(&shown), "the example is:\n{shown}");
}
