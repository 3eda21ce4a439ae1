//! Files that Landfall did not write, where locks, layouts and caches go: they stay.

use std::collections::BTreeSet;
use std::fs;
use std::process::{Command, Stdio};

use snapbox::str;

use super::files;
use crate::cli_check::place::CLEAN;
use crate::support::command::{Place, Ran, golden};

#[test]
fn locks_are_neither_written_over_files_of_others_nor_are_those_removed() {
    let place = Place::new("writers-locks");
    place.write("a.frag", CLEAN).write("assets/a.frag.json", "{\"mine\": 1}");
    place.write("assets/gone.frag.json", "{\"mine\": [\"schema_version\", 2]}");
    place.write("assets/bytes.frag.json", [0xff, 0, 1]);
    let before = files(&place.0.join("assets"));
    let command = ["lock", "--locks", "assets", "--prune"];
    place.run(&command).code(2).stderr_eq(str![[r#"
error[unreadable-file]: `assets/a.frag.json` has the name of a lock but is not a landfall lock
  |
  = help: move it away, keep locks elsewhere with `--locks DIR`, or overwrite it with `--force`

0 locks written, 0 unchanged

"#]]);
    assert!(files(&place.0.join("assets")) == before);
    // A lock that was cut off, or that git could not merge, is one.
    assert_eq!(place.run(&["lock", "--locks", "assets", "--force"]).code, 0);
    let lock = place.read("assets/a.frag.json");
    let conflict = format!("<<<<<<< HEAD\n{lock}=======\n{lock}>>>>>>> other\n");
    for broken in [&lock[..lock.len() / 2], &conflict, ""] {
        place.write("assets/a.frag.json", broken);
        assert_eq!(place.run(&["lock", "--locks", "assets"]).code, 0);
        assert_eq!(place.read("assets/a.frag.json"), lock);
    }
    place.write("assets/left.frag.json", &lock);
    assert_eq!(place.run(&["lock", "--locks", "assets", "--prune"]).code, 0);
    assert!(!place.has("assets/left.frag.json"), "a lock without a shader is removed");
    assert!(place.has("assets/gone.frag.json") && place.has("assets/bytes.frag.json"));
    let orphans = ["check", "-A", "all", "-W", "lock-orphan", "--locks", "assets", "-f", "short"];
    assert_eq!(place.run(&orphans).out, "", "nor is a file of others an orphan");
}

#[test]
fn layouts_are_written_only_over_layouts() {
    let place = Place::new("writers-layouts");
    place.write("a.frag", CLEAN);
    for format in ["table", "listing", "json", "csv", "md"] {
        let command = ["layout", "a.frag", "-f", format, "--out", "o"];
        let extension = if matches!(format, "table" | "listing") { "txt" } else { format };
        let target = format!("o/a.frag.{extension}");
        place.write(&target, "mine, all of it\n");
        let said = place.run(&command).code(2).err.replace(&target, "FILE");
        golden().eq(
            said,
            str![[r#"
error[cannot-write]: `FILE` already exists and was not written by `landfall layout`
  |
  = help: name another directory, or overwrite it with `--force`


"#]],
        );
        assert_eq!(place.read(&target), "mine, all of it\n");
        assert_eq!(place.run(&[&command[..], &["--force"]].concat()).code, 0);
        let written = place.read(&target);
        place.write("a.frag", format!("{CLEAN}// another\n"));
        assert_eq!(place.run(&command).code, 0, "{format}: one of ours is written anew");
        assert_eq!(place.read(&target), written);
    }
}

#[test]
fn a_folder_with_a_cache_keeps_the_files_of_others() {
    let place = Place::new("writers-cache");
    place.write("a.frag", CLEAN);
    for i in 0..40 {
        place.write(&format!("check-{i}.json"), "mine");
    }
    for i in 0..24 {
        // Other settings, another cache: there are more than are kept.
        let define = format!("N={i}");
        let ran = place.run(&["check", "a.frag", "--cache-dir", ".", "--define", &define]);
        assert_eq!(ran.code, 0, "{}", ran.err);
    }
    for i in 0..40 {
        assert_eq!(place.read(&format!("check-{i}.json")), "mine");
    }
    let count = fs::read_dir(&place.0).unwrap().count();
    assert_eq!(count, 40 + 16 + 2, "the oldest of our own are gone");
}

#[test]
fn what_a_killed_process_left_is_removed_and_nothing_else() {
    let place = Place::new("writers-partial");
    place.write("a.frag", CLEAN);
    let mut gone = Command::new("true").stdin(Stdio::null()).spawn().unwrap();
    gone.wait().unwrap();
    let left = format!("layouts/.landfall-{}-0badcafe-3.partial", gone.id());
    let alive = format!("layouts/.landfall-{}-0badcafe-3.partial", std::process::id());
    let others = ["layouts/.landfall-notes.partial", "layouts/a.frag.json.partial"];
    for path in [&left, &alive].into_iter().map(String::as_str).chain(others) {
        place.write(path, "half of");
    }
    assert_eq!(place.run(&["lock"]).code, 0);
    assert!(!place.has(&left) && place.has(&alive));
    assert!(others.iter().all(|other| place.has(other)));
}

/// The summary of a step and the key of caches, in whose places something else may be.
#[test]
fn what_the_environment_names_is_written_as_other_files_are() {
    let place = Place::new("writers-environment");
    place.write("a.frag", CLEAN);
    let pipe = |path: &str| {
        let made = Command::new("mkfifo").arg(place.path(path)).status();
        assert!(made.is_ok_and(|made| made.success()));
    };
    let check = |summary: &str| {
        let mut command = place.command(&["check", "a.frag", "-f", "github"]);
        Ran::of(command.env("GITHUB_STEP_SUMMARY", summary).output().unwrap())
    };
    place.write("summary.md", "earlier\n");
    assert_eq!(check("summary.md").code, 0);
    assert!(
        place.read("summary.md").starts_with("earlier\n") && place.read("summary.md").len() > 8
    );
    assert_eq!(check("/dev/null").code, 0);
    pipe("pipe");
    let ran = check("pipe");
    ran.code(2).stderr_eq(str![[r#"
error[cannot-write]: `pipe` is not a regular file


"#]]);
    check("a.frag").code(2).stderr_eq(str![[r#"
error[cannot-write]: `a.frag` is an input of this command, and would be overwritten
  |
  = help: name another file for the output


"#]]);
}

/// `gone/../a.frag` is `a.frag` as soon as `gone` is created for it.
#[test]
fn a_directory_that_is_not_there_leads_to_no_input() {
    let place = Place::new("writers-gone");
    place.write("a.frag", CLEAN).write("v.json", "{}");
    let before = files(&place.0);
    let mut said = BTreeSet::new();
    for command in [
        &["emit", "a.frag", "--lang", "c", "-o", "gone/../a.frag"][..],
        &["emit", "a.frag", "--lang", "rust", "-o", "./gone/x/../../a.frag"],
        &["encode", "a.frag", "v.json", "-o", "gone/../v.json"],
        &["port", "a.frag", "--no-compiler", "-o", "gone/../a.frag"],
        &["check", "a.frag", "-f", "json=gone/../a.frag"],
        &["lock", "a.frag", "--locks", "gone/../locks"],
        &["layout", "a.frag", "-f", "json", "--out", "gone/../out"],
    ] {
        let ran = place.run(command);
        assert_eq!(ran.code, 2, "{command:?}: {}", ran.err);
        said.extend(ran.err.lines().find(|line| line.starts_with("error")).map(str::to_string));
        assert!(files(&place.0) == before && !place.has("gone"), "{command:?} wrote");
    }
    let said: Vec<String> = said.into_iter().collect();
    golden().eq(
        said.join("\n"),
        str![[r#"
error[cannot-write]: `./gone/x/../..` cannot be created as a directory: no such file or directory
error[cannot-write]: `gone/../locks` cannot be created as a directory: no such file or directory
error[cannot-write]: `gone/../out` cannot be created as a directory: no such file or directory
error[cannot-write]: `gone/..` cannot be created as a directory: no such file or directory
"#]],
    );
}

/// Also by a link; another name of the same file is replaced, not the file.
#[test]
fn the_configuration_is_no_output() {
    let place = Place::new("writers-configuration");
    place.write("a.frag", CLEAN).write("v.json", "{}").write("x.toml", "gather = true\n");
    place.write("landfall.toml", "gather = false\n");
    std::os::unix::fs::symlink("landfall.toml", place.0.join("link.toml")).unwrap();
    let before = files(&place.0);
    for target in ["landfall.toml", "./link.toml"] {
        let report = format!("json={target}");
        for command in [
            &["emit", "a.frag", "--lang", "c", "-o", target][..],
            &["emit", "a.frag", "--lang", "rust", "--no-config", "-o", target],
            &["port", "a.frag", "--no-compiler", "-o", target],
            &["encode", "a.frag", "v.json", "-o", target],
            &["check", "a.frag", "-f", &report],
        ] {
            let ran = place.run(command);
            let said = ran.err.contains("is an input of this command, and would be overwritten");
            assert!(ran.code == 2 && said, "{command:?}: {}", ran.err);
            assert!(files(&place.0) == before, "{command:?} wrote");
        }
    }
    let command = ["emit", "a.frag", "--lang", "c", "--config", "x.toml", "-o", "x.toml"];
    place.run(&command).code(2);
    assert!(files(&place.0) == before);
}

/// A shader that an interrupted check did not reach.
#[cfg(target_os = "linux")]
#[test]
fn a_report_is_not_written_over_a_shader_that_was_not_read() {
    let place = Place::new("writers-unread");
    for n in 0..400 {
        place.write(&format!("t/{n:03}.frag"), CLEAN);
    }
    let mut command = place.command(&["check", "t", "-j", "1", "-f", "json=t/399.frag"]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(50));
    let process = child.id().to_string();
    Command::new("kill").args(["-INT", &process]).status().unwrap();
    // Whether it was in time or not.
    assert_ne!(child.wait().unwrap().code(), Some(0));
    assert_eq!(place.read("t/399.frag"), CLEAN);
}
