//! Locks in a check: drift, locks that are missing, broken or left behind, `--accept`.

use std::fs;

use snapbox::str;

use crate::cli_check::place::CLEAN;
use crate::support::command::{Place, Ran};

const LINTS: [&str; 8] =
    ["-A", "all", "-D", "layout-drift", "-W", "lock-missing", "-W", "lock-orphan"];

fn check(place: &Place, more: &[&str]) -> Ran {
    place.run(&[&["check", "-f", "short"], &LINTS[..], more].concat())
}

/// Two shaders with locks.
fn locked(name: &str) -> Place {
    let place = Place::new(&format!("check-{name}"));
    place.write("landfall.toml", "locks = \"layouts\"\npaths = [\"s\"]\n");
    place.write("s/a.frag", CLEAN).write("s/deep/b.frag", CLEAN);
    let ran = check(&place, &["--accept"]);
    ran.code(0).stdout_eq("").stderr_eq(str![[r#"
checked 2 shaders: no findings
accepted 2 layouts

"#]]);
    place
}

#[test]
fn without_locks_there_is_one_hint_and_no_finding() {
    let place = Place::new("check-no-locks");
    place.write("a.frag", CLEAN).write("b.frag", CLEAN);
    let ran = check(&place, &[]);
    ran.code(0).stdout_eq("").stderr_eq(str![[r#"
checked 2 shaders: no findings

"#]]);
    fs::create_dir(place.0.join("layouts")).unwrap();
    let ran = check(&place, &[]);
    ran.code(0).stdout_eq(str![[r#"
a.frag: warning[lock-missing] `a.frag` has no lock: changes of its layout go unseen
b.frag: warning[lock-missing] `b.frag` has no lock: changes of its layout go unseen

"#]]);
    let ran = check(&place, &["--locks", "elsewhere"]);
    ran.stdout_eq(str![[r#"
a.frag: warning[lock-missing] `a.frag` has no lock: changes of its layout go unseen
b.frag: warning[lock-missing] `b.frag` has no lock: changes of its layout go unseen

"#]]);
}

#[test]
fn a_layout_that_drifts_fails_until_it_is_accepted() {
    let place = locked("drift");
    assert!(place.has("layouts/s/a.frag.json") && place.has("layouts/s/deep/b.frag.json"));
    assert_eq!(check(&place, &[]).code, 0);
    place.write("s/a.frag", CLEAN.replace("vec4 position", "mat4 position"));
    let before = place.read("layouts/s/deep/b.frag.json");
    let ran = check(&place, &[]);
    ran.code(1).stdout_eq(str![[r#"
s/a.frag:2:37: error[layout-drift] `Light` differs from its lock: `position` changed from `vec4` to `mat4`; buffers filled for the lock's layout are misread

"#]]);
    let ran = check(&place, &["--accept"]);
    ran.code(0).stdout_eq("").stderr_eq(str![[r#"
checked 2 shaders: no findings
accepted 1 layout

"#]]);
    assert_eq!(check(&place, &["--accept"]).code, 0);
    assert_eq!(place.read("layouts/s/deep/b.frag.json"), before);
}

#[test]
fn drift_is_remembered_only_with_the_lock_it_was_found_against() {
    let place = locked("drift-cache");
    let cached = ["--cache-dir", "cache"];
    place.write("s/a.frag", CLEAN.replace("vec4 position", "mat4 position"));
    let lock = place.read("layouts/s/a.frag.json");
    assert_eq!(check(&place, &cached).code, 1);
    assert_eq!(check(&place, &cached).code, 1);
    let ran = check(&place, &["--accept", "--cache-dir", "cache"]);
    ran.code(0).stderr_eq(str![[r#"
checked 2 shaders: no findings
laid out 1 of 2 shaders, the rest is unchanged
accepted 1 layout

"#]]);
    let ran = check(&place, &cached);
    ran.code(0).stderr_eq(str![[r#"
checked 2 shaders: no findings
laid out 0 of 2 shaders, the rest is unchanged

"#]]);
    place.write("layouts/s/a.frag.json", lock);
    assert_eq!(check(&place, &cached).code, 1);
}

#[test]
fn a_file_may_allow_that_it_has_no_lock() {
    let place = locked("allow-lock");
    place.write("s/c.frag", format!("{CLEAN}// landfall: allow-file(lock-missing)\n"));
    let ran = check(&place, &["-W", "unused-allow"]);
    ran.code(0).stdout_eq("");
    check(&place, &["--accept"]);
    assert!(!place.has("layouts/s/c.frag.json"), "what is allowed is not mended either");
}

#[test]
fn a_lock_that_cannot_be_read_is_could_not_and_stays_as_it_is() {
    let place = locked("broken-lock");
    let text = place.read("layouts/s/a.frag.json");
    let cut = &text[..text.len() / 2];
    place.write("layouts/s/a.frag.json", cut);
    for more in [&[][..], &["--accept"]] {
        let ran = check(&place, more);
        ran.code(2).stdout_eq(str![[r#"
layouts/s/a.frag.json: error[unreadable-lock] `layouts/s/a.frag.json` is cut short: it ends in the middle, at line 12

"#]]);
        assert_eq!(place.read("layouts/s/a.frag.json"), cut);
    }
}

#[test]
fn locks_left_behind_are_told_where_their_folder_is_searched() {
    let place = locked("orphan");
    fs::remove_file(place.0.join("s/deep/b.frag")).unwrap();
    let ran = check(&place, &[]);
    ran.code(0).stdout_eq(str![[r#"
layouts/s/deep/b.frag.json: warning[lock-orphan] `layouts/s/deep/b.frag.json` is a lock without a shader

"#]]);
    ran.stdout_eq(str![[r#"
layouts/s/deep/b.frag.json: warning[lock-orphan] `layouts/s/deep/b.frag.json` is a lock without a shader

"#]]);
    assert_eq!(check(&place, &["s"]).out, ran.out);
    assert_eq!(check(&place, &["s/a.frag"]).out, "", "one file says nothing about the others");
    place.write("other/x.frag", CLEAN);
    let ran = check(&place, &["other", "-A", "lock-missing"]);
    assert_eq!(ran.out, "");
}
