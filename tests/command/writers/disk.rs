//! Writers whose disk is full, or that are killed, at each of their file operations in turn, by
//! interposed functions of the C library (`tests/support/disk.c`): a file is the old one or the
//! new one, an old one leaves only after its successor is on the disk, and two writers that run
//! at the same time, of which one dies, leave what one would.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use super::campaign::{COMMANDS, is_partial, old, outputs, rounds, whole};
use super::files;
use crate::support::command::{Place, Ran};

/// The library of the interposed functions, built once.
fn library() -> &'static Path {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(|| {
        let text = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/support/disk.c");
        let library = Path::new(env!("CARGO_TARGET_TMPDIR")).join("disk.so");
        let mut gcc = Command::new("gcc");
        gcc.args(["-shared", "-fPIC", "-O1", "-Wall", "-Wextra", "-Werror", "-o"]);
        let status = gcc.args([&*library, &*text]).arg("-ldl").status().expect("gcc runs");
        assert!(status.success());
        library
    })
}

/// A command whose file operations are interposed.
fn interposed(place: &Place, command: &[&str]) -> Command {
    let mut interposed = place.command(command);
    interposed.env("LD_PRELOAD", library());
    interposed
}

/// The file operations of a command.
fn operations(place: &Place, command: &[&str]) -> Vec<String> {
    let log = place.0.with_extension("log");
    let _ = fs::remove_file(&log);
    let ran = Ran::of(interposed(place, command).env("DISK_LOG", &log).output().unwrap());
    assert!(ran.code < 2, "{command:?}: {}", ran.err);
    fs::read_to_string(log).unwrap().lines().map(str::to_string).collect()
}

/// Puts the files of a place back.
fn restore(place: &Place, before: &[(String, Vec<u8>)]) {
    for (path, _) in files(&place.0) {
        if !before.iter().any(|(old, _)| *old == path) {
            fs::remove_file(path).unwrap();
        }
    }
    for (path, bytes) in before {
        if fs::read(path).ok().as_ref() != Some(bytes) {
            fs::write(path, bytes).unwrap();
        }
    }
}

fn partials(place: &Place) -> Vec<String> {
    files(&place.0).into_iter().map(|(name, _)| name).filter(|name| is_partial(name)).collect()
}

#[test]
fn a_writer_is_stopped_at_each_of_its_operations() {
    for (at, (target, command)) in COMMANDS.into_iter().enumerate() {
        let finished = old(&format!("disk-new-{at}"));
        let count = operations(&finished, command).len();
        let after = outputs(&finished, target);
        let place = old(&format!("disk-{at}"));
        let (all, before) = (files(&place.0), outputs(&place, target));
        let step = count.div_ceil(rounds(6) as usize).max(1);
        for operation in (1..=count).step_by(step) {
            let stopped = |fate: &str| {
                let mut command = interposed(&place, command);
                command.env("DISK_AT", operation.to_string()).env("DISK_FATE", fate);
                command.output().unwrap()
            };
            let full = Ran::of(stopped("full"));
            let what = format!("{command:?}, operation {operation} of {count}");
            let said = full.out + &full.err;
            assert_eq!(full.code, 2, "{what}: {said}");
            assert!(said.contains("no space left on device"), "{what}: {said}");
            whole(&place, target, &before, &after);
            assert_eq!(partials(&place), [""; 0], "{what}");
            restore(&place, &all);
            assert_eq!(stopped("killed").status.code(), None, "{what}");
            whole(&place, target, &before, &after);
            assert!(place.run(command).code < 2, "{what}");
            assert!(outputs(&place, target) == after, "{what}: the next run ends it");
            assert_eq!(partials(&place), [""; 0], "{what}");
            restore(&place, &all);
        }
    }
}

/// Where the system stops, a file that was renamed but whose bytes are not on the disk may be
/// empty afterwards.
#[test]
fn a_file_is_on_the_disk_before_it_replaces_another() {
    for (at, (_, command)) in COMMANDS.into_iter().enumerate() {
        let place = old(&format!("disk-sync-{at}"));
        let (mut synced, mut replaced) = (HashSet::new(), 0);
        for line in operations(&place, command) {
            let words: Vec<&str> = line.split(' ').collect();
            let name = |path: &str| path.rsplit('/').next().unwrap_or(path).to_string();
            match words[..] {
                ["write", file] => _ = synced.remove(&name(file)),
                ["sync", file] => _ = synced.insert(name(file)),
                ["replace", from, to] => {
                    assert!(synced.contains(&name(from)), "{command:?}: {to}");
                    replaced += 1;
                }
                _ => {}
            }
        }
        assert!(replaced > 0, "{command:?} replaces no file");
    }
}

#[test]
fn a_writer_is_killed_beside_another_one() {
    for (at, (target, command)) in COMMANDS.into_iter().enumerate() {
        let finished = old(&format!("beside-new-{at}"));
        let count = operations(&finished, command).len();
        let after = outputs(&finished, target);
        let place = old(&format!("beside-{at}"));
        let (all, before) = (files(&place.0), outputs(&place, target));
        let step = count.div_ceil(rounds(3) as usize).max(1);
        for operation in (1..=count).step_by(step) {
            let start = |mut command: Command| {
                command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
            };
            let mut dies = interposed(&place, command);
            dies.env("DISK_AT", operation.to_string()).env("DISK_FATE", "killed");
            let (mut dies, mut other) = (start(dies), start(place.command(command)));
            dies.wait().unwrap();
            let code = other.wait().unwrap().code().expect("it is not killed");
            // Two that mend one file see one another's edits, and say so.
            assert!(code < 2 || command.contains(&"--fix"), "{command:?}: {code}");
            whole(&place, target, &before, &after);
            assert!(place.run(command).code < 2, "{command:?}");
            assert!(outputs(&place, target) == after, "{command:?}");
            restore(&place, &all);
        }
    }
}
