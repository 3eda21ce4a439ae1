//! Symbolic links that lead out of the tree which a command writes: nothing is written there.

use std::fs;
use std::os::unix::fs::symlink;

use snapbox::str;

use super::files;
use crate::cli_check::place::{CLEAN, idle};
use crate::support::command::{Place, golden};

#[test]
fn nothing_is_written_through_a_link_out_of_the_tree() {
    let outside = Place::new("writers-outside");
    outside.write("kept", "kept");
    outside.write("far.frag", idle());
    let away = outside.0.display().to_string();
    let before = files(&outside.0);
    let fresh = |name: &str| {
        let place = Place::new(&format!("writers-links-{name}"));
        place.write("a.frag", CLEAN);
        place
    };
    let cases: [(&str, &str, &str, &[&str]); 8] = [
        ("locks", &away, "layouts", &["lock"]),
        ("lock", "../../writers-outside/new.json", "layouts/a.frag.json", &["lock"]),
        ("accept", &away, "layouts", &["check", "--accept", "--locks", "layouts/../layouts/x"]),
        (
            "out",
            "../../writers-outside/new.txt",
            "o/a.frag.txt",
            &["layout", "a.frag", "--out", "o"],
        ),
        ("deep", &away, "o/s", &["layout", ".", "--out", "o"]),
        (
            "emit",
            "../writers-outside/new.rs",
            "m.rs",
            &["emit", "a.frag", "--lang", "rust", "-o", "m.rs"],
        ),
        (
            "encode",
            &format!("{away}/kept"),
            "v.bin",
            &["encode", "a.frag", "v.json", "-o", "v.bin"],
        ),
        (
            "fix",
            &format!("{away}/far.frag"),
            "l.frag",
            &["check", "--fix", "-W", "unused-allow", "-W", "stale-comment"],
        ),
    ];
    let mut said = String::new();
    for (name, leads, link, command) in cases {
        let place = fresh(name);
        place.write("s/b.frag", CLEAN).write("v.json", "{}");
        let link = place.0.join(link);
        fs::create_dir_all(link.parent().unwrap()).unwrap();
        symlink(leads, link).unwrap();
        let ran = place.run(command);
        assert!(files(&outside.0) == before, "{name}: {command:?} wrote outside\n{}", ran.err);
        if name != "accept" {
            ran.code(2);
            said += &format!("{name}: {}{}", ran.err, ran.out);
        }
    }
    golden().eq(said, str![[r#"
locks: error[cannot-write]: `layouts/a.frag.json` leads through a symbolic link to `[TMP]/writers-outside/a.frag.json`, out of `[TMP]/writers-links-locks`
  |
  = help: remove the link, or name its target

error[cannot-write]: `layouts/s/b.frag.json` leads through a symbolic link to `[TMP]/writers-outside/s/b.frag.json`, out of `[TMP]/writers-links-locks`
  |
  = help: remove the link, or name its target

0 locks written, 0 unchanged
lock: error[cannot-write]: `layouts/a.frag.json` leads through a symbolic link to `[TMP]/writers-outside/new.json`, out of `[TMP]/writers-links-lock`
  |
  = help: remove the link, or name its target

1 lock written, 0 unchanged
out: error[cannot-write]: `o/a.frag.txt` leads through a symbolic link to `[TMP]/writers-outside/new.txt`, out of `[TMP]/writers-links-out/o`
  |
  = help: remove the link, or name its target

deep: error[cannot-write]: `o/s/b.frag.txt` leads through a symbolic link to `[TMP]/writers-outside/b.frag.txt`, out of `[TMP]/writers-links-deep/o`
  |
  = help: remove the link, or name its target

emit: error[cannot-write]: `m.rs` leads through a symbolic link to `[TMP]/writers-outside/new.rs`, out of `[TMP]/writers-links-emit`
  |
  = help: remove the link, or name its target

encode: error[cannot-write]: `v.bin` leads through a symbolic link to `[TMP]/writers-outside/kept`, out of `[TMP]/writers-links-encode`
  |
  = help: remove the link, or name its target

fix: checked 3 shaders: 1 error, 1 warning; 1 fixable with --fix
fixed 0 edits in 0 files
error[cannot-write]: `l.frag` leads through a symbolic link to `[TMP]/writers-outside/far.frag`, out of `[TMP]/writers-links-fix`
 --> l.frag
  |
  = help: remove the link, or name its target

warning[unused-allow]: `allow(stale-comment)` suppresses nothing in line 4
 --> l.frag:4:36
  |
4 |     vec4 color; // landfall: allow(stale-comment)
  |                                    ^^^^^^^^^^^^^ no such finding
  |
  = help: remove it

"#]]);
    // A cache is no more than a help: it is left out.
    let place = fresh("cache");
    symlink(&away, place.0.join("c")).unwrap();
    place.write("landfall.toml", "cache-dir = \"c\"\n");
    let ran = place.run(&["check"]);
    ran.code(0).stderr_eq(str![[r#"
the cache is not used: `c/check-[HASH].json` leads through a symbolic link to `[TMP]/writers-outside/check-[HASH].json`, out of `[TMP]/writers-links-cache`
help: remove the link, or name its target
checked 1 shader: no findings
laid out 1 of 1 shader, the rest is unchanged

"#]]);
    assert!(files(&outside.0) == before);
}
