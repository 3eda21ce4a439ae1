//! The commands of the README and the book do what is shown, and their links resolve.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const README: &str = include_str!("../../README.md");

/// The README and the pages of the book, each with its text.
fn pages() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let book = fs::read_dir(root.join("docs/src")).expect("the book is there");
    let files = book
        .map(|entry| entry.expect("an entry").path())
        .chain([root.join("README.md"), root.join("CHANGELOG.md")]);
    let markdown = files.filter(|file| file.extension().is_some_and(|it| it == "md"));
    markdown.map(|file| (file.clone(), fs::read_to_string(&file).expect("text"))).collect()
}

/// A command line after `$ ` and the output shown below it.
fn shown() -> Vec<(String, String)> {
    let mut found: Vec<(String, String)> = Vec::new();
    let pages = pages();
    let blocks = pages.iter().flat_map(|(_, text)| text.split("```console\n").skip(1));
    for block in blocks {
        let block = block.split("```").next().expect("a block ends");
        for line in block.lines() {
            match line.strip_prefix("$ ") {
                Some(command) => found.push((command.to_string(), String::new())),
                None => {
                    let (_, output) = found.last_mut().expect("a command stands before its output");
                    output.push_str(line);
                    output.push('\n');
                }
            }
        }
    }
    found
}

/// Words of a command line; single quotes keep one together.
fn words(command: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quoted = false;
    for c in command.chars() {
        match c {
            '\'' => quoted = !quoted,
            ' ' if !quoted => words.push(String::new()),
            _ => words.last_mut().expect("never empty").push(c),
        }
    }
    words
}

#[test]
fn every_command_prints_what_is_shown() {
    let shown = shown();
    assert!(shown.len() >= 10, "{} commands", shown.len());
    for (command, output) in shown {
        let words = words(&command);
        assert_eq!(words[0], "landfall", "{command}");
        let run = Command::new(env!("CARGO_BIN_EXE_landfall"))
            .args(&words[1..])
            .output()
            .expect("the command of this package");
        let printed = String::from_utf8_lossy(&run.stdout);
        assert_eq!(printed.trim_end(), output.trim_end(), "{command}");
        assert!(run.status.success(), "{command}: {}", String::from_utf8_lossy(&run.stderr));
    }
}

#[test]
fn the_two_commands_of_the_set_up_are_there() {
    assert!(README.contains("cargo run --release -- layout shaders\n"));
    assert!(README.contains("./tests/run\n"));
    assert!(std::path::Path::new("tests/run").is_file());
}

#[test]
fn every_relative_link_leads_to_a_file() {
    let mut links = 0;
    for (file, text) in pages() {
        let folder = file.parent().expect("a page is in a folder");
        for link in text.split("](").skip(1) {
            let link = link.split(')').next().expect("a link ends");
            let path = link.split('#').next().expect("never empty");
            if path.is_empty() || path.contains("://") {
                continue;
            }
            links += 1;
            assert!(folder.join(path).exists(), "{}: {link}", file.display());
        }
    }
    assert!(links >= 30, "{links} links");
}
