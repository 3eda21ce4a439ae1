//! Standard input is an input like any other, and a reader of standard output that is gone changes
//! no exit code.

use std::collections::BTreeSet;
use std::fs::File;
use std::process::Stdio;

use snapbox::str;

use crate::support::command::{Place, golden};

const SHADER: &str = "#version 450\nlayout(std140, binding = 0) uniform U { vec4 a; float b; } u;\n\
                      layout(location = 0) out vec4 o;\nvoid main() { o = u.a * u.b; }\n";

#[cfg(target_os = "linux")]
#[test]
fn no_output_is_written_over_the_file_of_standard_input() {
    let place = Place::new("streams-input");
    place.write("a.frag", SHADER).write("v.json", "{\"a\": [1, 2, 3, 4], \"b\": 5}");
    std::fs::hard_link(place.path("a.frag"), place.path("hard.frag")).unwrap();
    let before = (place.read("a.frag"), place.read("v.json"));
    // The error of each command, with its target as `FILE`.
    let mut errors = BTreeSet::new();
    for (input, line) in [
        ("a.frag", "emit --lang c --language glsl - -o a.frag"),
        ("a.frag", "emit --lang c --language glsl - -o hard.frag"),
        ("a.frag", "check --language glsl - -f json=a.frag"),
        ("v.json", "encode a.frag - -o v.json"),
    ] {
        let arguments: Vec<&str> = line.split(' ').collect();
        let file = File::open(place.path(input)).unwrap();
        let output = place.command(&arguments).stdin(Stdio::from(file)).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{line}: {said}");
        let target = line.rsplit([' ', '=']).next().expect("the last word");
        errors.insert(said.replace(&format!("`{target}`"), "`FILE`"));
        assert_eq!((place.read("a.frag"), place.read("v.json")), before, "{line}");
    }
    golden().eq(
        errors.into_iter().collect::<String>(),
        str![[r#"
error[cannot-write]: `FILE` is an input of this command, and would be overwritten
  |
  = help: name another file for the output


"#]],
    );
}

#[test]
fn a_reader_that_is_gone_changes_no_exit_code() {
    let place = Place::new("streams-reader");
    let more = SHADER.replace("float b;", "float c; float b;") + "// landfall: allow(drift)\n";
    place.write("a.frag", SHADER).write("b.frag", &more);
    place.write("bad.frag", "uniform B { float a[0]; };\n");
    // More than the buffer holds.
    let members: String = (0..4000).map(|n| format!("vec4 m{n};\n")).collect();
    place.write("long.frag", SHADER.replace("vec4 a;", &format!("{members}vec4 a;")));
    for (code, line) in [
        (0, "layout long.frag"),
        (0, "layout long.frag -f json"),
        (2, "layout long.frag bad.frag"),
        (1, "diff a.frag b.frag"),
        (1, "diff a.frag b.frag -f json"),
        (1, "check b.frag -D unused-allow"),
        (1, "check b.frag -D unused-allow -f sarif"),
        (2, "check bad.frag -f short"),
    ] {
        let arguments: Vec<&str> = line.split(' ').collect();
        let whole = place.run(&arguments);
        let mut child = place.command(&arguments).stdout(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let alone = child.wait().unwrap().code();
        assert_eq!((alone, whole.code), (Some(code), code), "{line}: {}", whole.err);
    }
}

/// Hints are for a person in a folder that has neither a configuration nor locks.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_has_one_summary_and_hints_only_before_a_project_is_set_up() {
    let place = Place::new("streams-terminal");
    place.write("a.frag", SHADER);
    let shown = |more: &str| {
        let command = format!("{} check a.frag {more}", env!("CARGO_BIN_EXE_landfall"));
        let mut terminal = std::process::Command::new("script");
        terminal.args(["-qec", &command, "/dev/null"]).current_dir(&place.0).stdin(Stdio::null());
        let quiet = [("NO_COLOR", "1"), ("TMPDIR", place.0.to_str().expect("it is text"))];
        let output = terminal.envs(quiet).output().expect("Debian's `script` runs");
        String::from_utf8_lossy(&output.stdout).replace('\r', "")
    };
    let hint = "no layouts are locked: `landfall lock` records them, so that check can tell when one \
                changes\n";
    assert_eq!(shown("--no-config"), format!("checked 1 shader: no findings\n{hint}"));
    // Not again within a day.
    assert_eq!(shown("--no-config"), "checked 1 shader: no findings\n");
    assert_eq!(shown(""), "checked 1 shader: no findings\n");
}
