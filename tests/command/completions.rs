//! Shell completions and manual pages have every command and every option of the help.

use snapbox::str;
use std::collections::BTreeSet;
use std::process::Command;

use crate::reference::{commands, landfall};
use crate::support::command::{self, Place};

const SHELLS: [&str; 5] = ["bash", "elvish", "fish", "powershell", "zsh"];

/// The long options in the help of a command, without `--help`: it is in no description of one.
fn options(name: &str) -> BTreeSet<String> {
    let help = landfall(&[name, "-h"]);
    let long = help.lines().map(str::trim_start).filter_map(|line| {
        let long = match line.get(2..4) {
            Some(", ") if line.starts_with('-') => &line[4..],
            _ => line,
        };
        long.strip_prefix("--")
    });
    let names = long.map(|line| {
        let end = line.find(|c: char| c != '-' && !c.is_ascii_alphanumeric());
        line[..end.unwrap_or(line.len())].to_string()
    });
    let names: BTreeSet<String> = names.filter(|name| name != "help").collect();
    assert!(names.contains("quiet"), "{name}: {names:?}");
    names
}

#[test]
fn completions_have_every_command_and_option() {
    let options: Vec<(String, BTreeSet<String>)> =
        commands().into_iter().map(|name| (name.clone(), options(&name))).collect();
    for shell in SHELLS {
        let script = landfall(&["completions", shell]);
        for (name, options) in &options {
            assert!(script.contains(name.as_str()), "{shell}: {name}");
            for option in options {
                // fish writes `-l option`.
                let forms = [format!("--{option}"), format!("-l {option}")];
                assert!(forms.iter().any(|form| script.contains(form)), "{shell}: {option}");
            }
        }
    }
}

/// What bash offers for the last word of a line.
fn offered(script: &str, words: &[&str]) -> Vec<String> {
    let last = words.len() - 1;
    let (current, previous) = (words[last], words[last - 1]);
    let program = format!(
        "{script}\nCOMP_WORDS=({}); COMP_CWORD={last}\n\
         _landfall landfall '{current}' '{previous}'\nprintf '%s\\n' \"${{COMPREPLY[@]}}\"\n",
        words.join(" ")
    );
    let ran = Command::new("bash").args(["-c", &program]).output().expect("bash is there");
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    String::from_utf8(ran.stdout).expect("it is text").lines().map(str::to_string).collect()
}

#[test]
fn bash_completes_commands_options_and_values() {
    let script = landfall(&["completions", "bash"]);
    assert_eq!(offered(&script, &["landfall", "dec"]), ["decode"]);
    assert_eq!(offered(&script, &["landfall", "check", "--cache"]), ["--cache-dir"]);
    let values = offered(&script, &["landfall", "layout", "--format", "j"]);
    assert_eq!(values, ["json"]);
}

#[test]
fn manual_pages_have_every_command_and_option() {
    let place = Place::new("man");
    place.run(&["man", "pages"]).code(0).stdout_eq("").stderr_eq("");
    let main = place.read("pages/landfall.1");
    for name in commands() {
        let page = place.read(&format!("pages/landfall-{name}.1")).replace("\\-", "-");
        assert!(page.contains(&format!(".TH landfall-{name} 1")), "{name}: {page}");
        for option in options(&name) {
            assert!(page.contains(&format!("--{option}")), "{name}: {option}");
        }
        assert!(page.contains("Examples:"), "{name}");
        assert!(main.replace("\\-", "-").contains(&format!("landfall-{name}(1)")), "{name}");
    }
    assert!(main.contains(concat!("landfall ", env!("CARGO_PKG_VERSION"))), "{main}");
    assert!(!place.has("pages/landfall-reader.1"), "what is hidden");
}

#[test]
fn a_shell_without_completions_is_an_error() {
    let ran = command::run(&["completions", "cmd"]);
    ran.code(2);
    ran.stderr_eq(str![[r#"
error: invalid value 'cmd' for '<SHELL>'
  [possible values: bash, elvish, fish, powershell, zsh]

For more information, try '--help'.

"#]]);
}
