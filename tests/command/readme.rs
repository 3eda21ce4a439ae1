//! The README's commands do what it shows.

#![cfg(feature = "cli")]

use std::process::Command;

const README: &str = include_str!("../../README.md");

/// A command line after `$ ` and the output shown below it.
fn shown() -> Vec<(String, String)> {
    let mut found: Vec<(String, String)> = Vec::new();
    for block in README.split("```console\n").skip(1) {
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
    assert!(shown.len() >= 4, "{} commands", shown.len());
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
