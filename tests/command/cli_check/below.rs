//! Commands in a directory below the root of the project, and the paths of their reports.

use std::fs;

use snapbox::str;

use crate::cli_check::place::CLEAN;
use crate::support::command::{Place, Ran};

/// A repository without a configuration, with a locked shader that has changed since.
fn drifted(name: &str) -> Place {
    let place = Place::new(name);
    fs::remove_file(place.0.join("landfall.toml")).unwrap();
    fs::create_dir(place.0.join(".git")).unwrap();
    place.write("shaders/deep/a.frag", CLEAN).run(&["lock"]).code(0);
    place.write("shaders/deep/a.frag", CLEAN.replace("vec4 position;", "vec4 n[2], position;"));
    place
}

fn run_in(place: &Place, folder: &str, arguments: &[&str]) -> Ran {
    let mut command = place.command(arguments);
    // As on a machine without CI: the directory of `.git` counts.
    command.env_remove("CI_PROJECT_DIR").current_dir(place.0.join(folder));
    Ran::of(command.output().expect("the command of this package"))
}

#[test]
fn locks_are_found_from_a_directory_below_them() {
    let place = drifted("check-below");
    for (folder, path) in [("", ""), ("shaders", "../shaders/"), ("shaders/deep", "../../shaders/")]
    {
        let path = if folder.is_empty() { "shaders/deep/".into() } else { format!("{path}deep/") };
        for extra in [&[][..], &["."]] {
            let ran = run_in(&place, folder, &[&["check", "-f", "short"], extra].concat());
            ran.code(1);
            let drift = format!("{path}a.frag:2:37: error[layout-drift]");
            assert!(ran.out.contains(&drift), "{folder} {extra:?}: {}", ran.out);
        }
    }
    // Where a configuration is on the way, its directory is the root, as before.
    place.write("shaders/landfall.toml", "");
    run_in(&place, "shaders/deep", &["check"]).code(0);
}

#[test]
fn lock_and_diff_use_the_locks_above() {
    let place = drifted("lock-below");
    let stale = run_in(&place, "shaders", &["lock", "--check"]);
    stale.code(1).stderr_eq(str![[r#"
error[stale-lock]: `../layouts/shaders/deep/a.frag.json` is out of date
  |
  = help: run the same command without `--check`, and commit what it writes

1 lock would change, 0 unchanged

"#]]);
    let diff = run_in(&place, "shaders", &["diff", "../layouts", "deep/a.frag"]);
    assert_eq!(diff.code, 2, "a directory is not compared with a file: {}", diff.err);
    run_in(&place, "shaders", &["diff", "../layouts", "."]).code(1);
    run_in(&place, "shaders", &["lock"]).code(0);
    assert!(!place.has("shaders/layouts"));
    run_in(&place, "", &["check"]).code(0);
}

#[test]
fn the_search_ends_at_the_root_of_the_repository() {
    let place = drifted("check-below-other");
    fs::create_dir(place.0.join("shaders/.git")).unwrap();
    run_in(&place, "shaders/deep", &["check"]).code(0).stderr_eq(str![[r#"
checked 1 shader: no findings

"#]]);
    // The locks of the current directory precede those of the paths.
    place.write("shaders/deep/b.frag", CLEAN);
    fs::remove_dir(place.0.join("shaders/.git")).unwrap();
    run_in(&place, "shaders/deep", &["lock", "--no-config"]).code(0);
    let ran = run_in(&place, "", &["check", "-f", "short", "shaders/deep/a.frag"]);
    ran.code(1).stdout_eq(str![[r#"
shaders/deep/a.frag:2:37: error[layout-drift] `Light` differs from its lock: `position` moved from 0 to 32; buffers filled for the lock's layout are misread

"#]]);
}

#[test]
fn reports_name_files_from_the_root_of_the_repository() {
    let place = drifted("check-below-reports");
    for format in ["github", "sarif", "junit"] {
        let check = ["check", "-f", format, "-W", "all", "-D", "layout-drift"];
        let root = run_in(&place, "", &check);
        root.code(1);
        assert!(root.out.contains("shaders/deep/a.frag"), "{}", root.out);
        // Messages name the lock from the current directory.
        let same = |ran: &Ran| ran.out.replace("../", "");
        for folder in ["shaders", "shaders/deep"] {
            assert_eq!(same(&run_in(&place, folder, &check)), same(&root), "{format} in {folder}");
        }
        // The directory that CI names is the root, even without `.git`.
        let mut command = place.command(&check);
        let ci = command.env_remove("CI_PROJECT_DIR").env("GITHUB_WORKSPACE", place.0.join(".."));
        let ran = Ran::of(ci.output().unwrap());
        let named = ["check-below-reports/shaders/deep/a.frag"];
        assert!(named.iter().all(|path| ran.out.contains(path)), "{}", ran.out);
        // One that does not contain the current directory is not.
        let ci = command.env("GITHUB_WORKSPACE", place.0.join("layouts"));
        assert_eq!(Ran::of(ci.output().unwrap()).out, root.out);
    }
    // For people and editors, paths start at the current directory.
    let short = run_in(&place, "shaders/deep", &["check", "-f", "short"]);
    short.stdout_eq(str![[r#"
../../shaders/deep/a.frag:2:37: error[layout-drift] `Light` differs from its lock: `position` moved from 0 to 32; buffers filled for the lock's layout are misread

"#]]);
    let stdin = ["check", "-f", "github", "-W", "all", "--language", "glsl", "-"];
    let mut command = place.command(&stdin);
    command.env_remove("CI_PROJECT_DIR").current_dir(place.0.join("shaders"));
    let ran = crate::support::command::with_stdin(command, b"#version 450\nuniform B {");
    ran.stdout_eq(str![[r#"
::error file=<stdin>,line=2,endLine=2,col=11,endColumn=12,title=unclosed-brace::`{` is never closed

"#]]);
}
