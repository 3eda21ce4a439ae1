//! Writers that are killed, have no room, or run at the same time: a file is the old one or the
//! new one, and nothing is left beside it once somebody writes there again.

use std::fs;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use snapbox::str;

use super::{files, scene};
use crate::cli_check::place::{CLEAN, idle};
use crate::support::command::{Place, Ran, golden};
use crate::support::sample::everything;

/// How often each thing is tried: as often as said, where everything is.
pub fn rounds(usual: u32) -> u32 {
    if everything() { usual } else { usual.div_ceil(6) }
}

/// A project whose files of landfall's are all of an older layout.
pub fn old(name: &str) -> Place {
    let place = Place::new(&format!("campaign-{name}"));
    for i in 0..12 {
        place.write(&format!("s/{i}.frag"), CLEAN);
        // A comment that allows nothing, to be mended.
        place.write(&format!("f/{i}.frag"), idle());
    }
    place.write("many.frag", many(400)).write("m.rs", "").write("p.png", "");
    place.write("scene.json", scene());
    assert_eq!(place.run(&["lock", "s"]).code, 0);
    assert_eq!(place.run(&["layout", "s", "--out", "o"]).code, 0);
    assert!(place.run(&["check", "s", "-f", "sarif=r.sarif"]).code < 2);
    for i in 0..12 {
        let text = CLEAN.replace("vec4 color;\n}", "vec4 color;\n    vec4 more;\n}");
        place.write(&format!("s/{i}.frag"), text);
    }
    place
}

/// A shader with a block of that many members.
fn many(members: usize) -> String {
    let list: String = (0..members).map(|i| format!("    vec4 member_{i};\n")).collect();
    format!("#version 450\nlayout(std140, binding = 0) uniform B {{\n{list}}};\nvoid main() {{}}\n")
}

/// Commands that write, each with the folder or file it writes.
pub const COMMANDS: [(&str, &[&str]); 7] = [
    ("layouts", &["lock", "s"]),
    ("m.rs", &["emit", "many.frag", "--lang", "rust", "--out", "m.rs"]),
    ("f", &["check", "f", "--fix", "-A", "all", "-W", "unused-allow", "-W", "stale-comment"]),
    (
        "p.png",
        &[
            "render",
            "scene.json",
            "--reference",
            "--model",
            "multi",
            "--size",
            "48x48",
            "-o",
            "p.png",
        ],
    ),
    ("layouts", &["check", "s", "--accept"]),
    ("o", &["layout", "s", "--out", "o"]),
    ("r.sarif", &["check", "s", "f", "-f", "sarif=r.sarif", "-A", "all", "-W", "unused-allow"]),
];

/// What a command leaves, from its name.
pub fn outputs(place: &Place, target: &str) -> Vec<(String, Vec<u8>)> {
    let path = place.0.join(target);
    let mut found = if path.is_dir() { files(&path) } else { Vec::new() };
    if path.is_file() {
        found.push((path.display().to_string(), fs::read(&path).unwrap()));
    }
    let root = place.0.display().to_string();
    found.iter_mut().for_each(|(name, _)| *name = name.replace(&root, ""));
    found
}

pub fn is_partial(name: &str) -> bool {
    name.rsplit('/').next().is_some_and(|name| name.starts_with(".landfall-"))
}

/// Each file is as it was before or as it is after.
pub fn whole(
    place: &Place,
    target: &str,
    before: &[(String, Vec<u8>)],
    after: &[(String, Vec<u8>)],
) {
    for (name, bytes) in outputs(place, target) {
        if is_partial(&name) {
            continue;
        }
        let is = |state: &[(String, Vec<u8>)]| state.contains(&(name.clone(), bytes.clone()));
        assert!(is(before) || is(after), "{name} is neither the old file nor the new one");
    }
}

#[test]
fn a_writer_that_is_killed_leaves_old_files_or_new_ones() {
    let mut random = fastrand::Rng::with_seed(16);
    for (at, (target, command)) in COMMANDS.into_iter().enumerate() {
        let finished = old(&format!("kill-new-{at}"));
        let begun = Instant::now();
        assert!(finished.run(command).code < 2, "{command:?}");
        let usual = begun.elapsed();
        let after = outputs(&finished, target);
        let place = old(&format!("kill-{at}"));
        let before = outputs(&place, target);
        assert!(before != after, "{command:?} writes nothing");
        for _ in 0..rounds(6) {
            let mut child =
                place.command(command).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            sleep(Duration::from_micros(random.u64(0..=usual.as_micros() as u64)));
            let _ = child.kill();
            child.wait().unwrap();
            whole(&place, target, &before, &after);
        }
        assert!(place.run(command).code < 2, "{command:?}");
        assert!(outputs(&place, target) == after, "{command:?}: the next run ends what was begun");
        let left: Vec<String> = files(&place.0).into_iter().map(|(name, _)| name).collect();
        assert!(!left.iter().any(|name| is_partial(name)), "{left:?}");
    }
}

#[test]
fn a_full_disk_leaves_the_old_files() {
    let mut said = String::new();
    for (at, (target, command)) in COMMANDS.into_iter().enumerate() {
        let place = old(&format!("full-{at}"));
        let before = files(&place.0);
        // No file may have a byte: what a disk says that is full, but for the number of the error.
        let words = command.join(" ");
        let landfall = env!("CARGO_BIN_EXE_landfall");
        let script = format!("trap '' XFSZ; ulimit -f 0; exec {landfall} {words}");
        let mut shell = Command::new("sh");
        shell.args(["-c", &script]).current_dir(&place.0).stdin(Stdio::null());
        let ran = Ran::of(shell.output().unwrap());
        assert_eq!(ran.code, 2, "{command:?}: {}\n{}", ran.out, ran.err);
        let all = ran.out + &ran.err;
        let first = all.lines().find(|line| line.contains("error[")).unwrap_or(&all);
        said += &format!("{}: {first}\n", command[0]);
        assert!(files(&place.0) == before, "{command:?} changed a file in {target}");
    }
    golden().eq(
        said,
        str![[r#"
lock: error[cannot-write]: `layouts/s/0.frag.json` cannot be written: file too large
emit: error[cannot-write]: `m.rs` cannot be written: file too large
check: error[cannot-write]: `f/0.frag` cannot be written: file too large
render: error[cannot-write]: `p.png` cannot be written: file too large
check: error[cannot-write]: `layouts/s/0.frag.json` cannot be written: file too large
layout: error[cannot-write]: `o/0.frag.txt` cannot be written: file too large
check: error[cannot-write]: `r.sarif` cannot be written: file too large

"#]],
    );
}

#[test]
fn writers_at_the_same_time_leave_what_one_would() {
    for (at, (target, command)) in COMMANDS.into_iter().enumerate() {
        // Two that mend one file see one another's edits, and say so.
        let mends = command.contains(&"--fix");
        let finished = old(&format!("race-new-{at}"));
        assert!(finished.run(command).code < 2);
        let after = outputs(&finished, target);
        let place = old(&format!("race-{at}"));
        let before = outputs(&place, target);
        for _ in 0..rounds(1) {
            let start = || {
                place.command(command).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
            };
            let running: Vec<_> = (0..3).map(|_| start()).collect();
            for mut child in running {
                let code = child.wait().unwrap().code().expect("not killed");
                assert!(code < 2 || mends, "{command:?}: {code}");
            }
            whole(&place, target, &before, &after);
        }
        assert!(place.run(command).code < 2);
        assert!(outputs(&place, target) == after, "{command:?}");
    }
}
