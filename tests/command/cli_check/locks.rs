//! Locks in a check: drift, locks that are missing, broken or left behind, `--accept`.

use std::fs;

use crate::cli_check::place::{CLEAN, Place};

const LINTS: [&str; 8] =
    ["-A", "all", "-D", "layout-drift", "-W", "lock-missing", "-W", "lock-orphan"];

fn check(place: &Place, more: &[&str]) -> (i32, String, String) {
    let ran = place.run(&[&["check", "-f", "short"], &LINTS[..], more].concat());
    (ran.code, ran.out, ran.err)
}

/// Two shaders with locks.
fn locked(name: &str) -> Place {
    let place = Place::new(name);
    place.write("landfall.toml", "locks = \"layouts\"\npaths = [\"s\"]\n");
    place.write("s/a.frag", CLEAN).write("s/deep/b.frag", CLEAN);
    let (code, out, err) = check(&place, &["--accept"]);
    assert_eq!((code, out.as_str()), (0, ""), "{err}");
    assert!(err.contains("accepted 2 layouts\n"), "{err}");
    place
}

#[test]
fn without_locks_there_is_one_hint_and_no_finding() {
    let place = Place::new("no-locks");
    place.write("a.frag", CLEAN).write("b.frag", CLEAN);
    let (code, out, err) = check(&place, &[]);
    assert_eq!((code, out.as_str()), (0, ""));
    assert_eq!(err.matches("`landfall lock`").count(), 1, "{err}");
    fs::create_dir(place.0.join("layouts")).unwrap();
    let (code, out, _) = check(&place, &[]);
    assert_eq!((code, out.matches("lock-missing").count()), (0, 2), "{out}");
    let (_, out, _) = check(&place, &["--locks", "elsewhere"]);
    assert_eq!(out.matches("lock-missing").count(), 2, "{out}");
}

#[test]
fn a_layout_that_drifts_fails_until_it_is_accepted() {
    let place = locked("drift");
    assert!(place.has("layouts/s/a.frag.json") && place.has("layouts/s/deep/b.frag.json"));
    assert_eq!(check(&place, &[]).0, 0);
    place.write("s/a.frag", CLEAN.replace("vec4 position", "mat4 position"));
    let before = place.read("layouts/s/deep/b.frag.json");
    let (code, out, _) = check(&place, &[]);
    assert_eq!(code, 1);
    assert!(out.contains("layout-drift") && out.contains("s/a.frag"), "{out}");
    let (code, out, err) = check(&place, &["--accept"]);
    assert_eq!((code, out.as_str()), (0, ""), "{err}");
    assert!(err.contains("accepted 1 layout\n"), "{err}");
    assert_eq!(check(&place, &["--accept"]).0, 0);
    assert_eq!(place.read("layouts/s/deep/b.frag.json"), before);
}

#[test]
fn drift_is_remembered_only_with_the_lock_it_was_found_against() {
    let place = locked("drift-cache");
    let cached = ["--cache-dir", "cache"];
    place.write("s/a.frag", CLEAN.replace("vec4 position", "mat4 position"));
    let lock = place.read("layouts/s/a.frag.json");
    assert_eq!(check(&place, &cached).0, 1);
    assert_eq!(check(&place, &cached).0, 1);
    let (code, _, err) = check(&place, &["--accept", "--cache-dir", "cache"]);
    assert!(code == 0 && err.contains("laid out 1 of 2"), "{err}");
    let (code, _, err) = check(&place, &cached);
    assert!(code == 0 && err.contains("laid out 0 of 2"), "{err}");
    place.write("layouts/s/a.frag.json", lock);
    assert_eq!(check(&place, &cached).0, 1);
}

#[test]
fn a_file_may_allow_that_it_has_no_lock() {
    let place = locked("allow-lock");
    place.write("s/c.frag", format!("{CLEAN}// landfall: allow-file(lock-missing)\n"));
    let (code, out, _) = check(&place, &["-W", "unused-allow"]);
    assert_eq!((code, out.as_str()), (0, ""));
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
        let (code, out, err) = check(&place, more);
        assert_eq!(code, 2, "{err}");
        assert!(out.contains("layouts/s/a.frag.json"), "{out}");
        assert_eq!(place.read("layouts/s/a.frag.json"), cut);
    }
}

#[test]
fn locks_left_behind_are_told_where_their_folder_is_searched() {
    let place = locked("orphan");
    fs::remove_file(place.0.join("s/deep/b.frag")).unwrap();
    let (code, out, _) = check(&place, &[]);
    assert_eq!((code, out.matches("lock-orphan").count()), (0, 1), "{out}");
    assert!(out.contains("layouts/s/deep/b.frag.json"), "{out}");
    assert_eq!(check(&place, &["s"]).1, out);
    assert_eq!(check(&place, &["s/a.frag"]).1, "", "one file says nothing about the others");
    place.write("other/x.frag", CLEAN);
    let (_, out, _) = check(&place, &["other", "-A", "lock-missing"]);
    assert_eq!(out, "");
}
