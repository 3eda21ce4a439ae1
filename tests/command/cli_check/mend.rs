//! `--fix` and `--diff`.

use std::fs;

use snapbox::str;

use crate::cli_check::place::CLEAN;
use crate::support::command::{Place, Ran};

const FLAGS: [&str; 8] =
    ["-A", "all", "-W", "unused-allow", "-W", "stale-comment", "-W", "mat3-padding"];

fn check(place: &Place, more: &[&str]) -> Ran {
    place.run(&[&["check", "-f", "short"], &FLAGS[..], more].concat())
}

/// A shader with two idle comments, one with two codes; and as it is once mended.
fn twins(newline: &str) -> (String, String) {
    let bad = CLEAN
        .replace("    vec4 color;", "    vec4 color; // landfall: allow(stale-comment)")
        .replace("void", "/* é */ // landfall: allow(stale-comment, mat3-padding)\nvoid");
    let good = CLEAN.replace("void", "/* é */\nvoid");
    (bad.replace('\n', newline), good.replace('\n', newline))
}

#[test]
fn fix_changes_the_edited_bytes_only_and_does_so_once() {
    for (name, newline, mark) in [("lf", "\n", ""), ("crlf", "\r\n", ""), ("bom", "\n", "\u{feff}")]
    {
        let place = Place::new(&format!("check-fix-{name}"));
        let (bad, good) = twins(newline);
        place.write("a.frag", format!("{mark}{bad}")).write("b.frag", CLEAN);
        let stamp = || fs::metadata(place.0.join("b.frag")).unwrap().modified().unwrap();
        let before = stamp();
        let ran = check(&place, &["--fix"]);
        let begins =
            "a.frag:1:1: warning[byte-order-mark] the file begins with a byte-order mark\n";
        ran.code(0).stdout_eq(if mark.is_empty() { "" } else { begins }).stderr_eq(str![[r#"
checked 2 shaders: [..]
fixed 3 edits in 1 file

"#]]);
        assert_eq!(place.read("a.frag"), format!("{mark}{good}"), "{name}");
        let again = check(&place, &["--fix"]);
        again.stderr_eq(str![[r#"
checked 2 shaders: [..]
fixed 0 edits in 0 files

"#]]);
        assert_eq!(place.read("a.frag"), format!("{mark}{good}"), "{name}");
        assert_eq!(stamp(), before);
    }
}

#[test]
fn diff_shows_what_fix_would_do_and_changes_nothing() {
    let place = Place::new("check-diff");
    let (bad, good) = twins("\n");
    place.write("s/a.frag", &bad).write("s/b.frag", CLEAN);
    let ran = check(&place, &["--diff"]);
    assert_eq!(ran.code, 1, "{}", ran.err);
    assert_eq!(place.read("s/a.frag"), bad);
    ran.stdout_eq(str![[r#"
--- a/s/a.frag
+++ b/s/a.frag
@@ -1,10 +1,10 @@
 #version 450
 layout(std140, binding = 0) uniform Light {
     vec4 position;
-    vec4 color; // landfall: allow(stale-comment)
+    vec4 color;
 } light;
 layout(location = 0) out vec4 color;
-/* é */ // landfall: allow(stale-comment, mat3-padding)
+/* é */
 void main() {
     color = light.position + light.color;
 }

"#]]);
    // The patch, applied by hand: its context and added lines are all in the mended text.
    let kept = ran.out.lines().skip(2).filter_map(|line| line.strip_prefix([' ', '+']));
    kept.for_each(|line| assert!(good.contains(line), "{line}"));
    let gone = ran.out.lines().skip(2).filter(|line| line.starts_with('-')).count();
    assert_eq!(gone, 2);
    check(&place, &["--fix"]);
    let ran = check(&place, &["--diff"]);
    assert_eq!((ran.code, ran.out.as_str()), (0, ""));
}

#[test]
fn a_file_that_is_read_only_is_could_not_and_the_others_are_mended() {
    let place = Place::new("check-fix-read-only");
    let (bad, good) = twins("\n");
    place.write("a.frag", &bad).write("b.frag", &bad);
    let file = place.0.join("a.frag");
    let mut permissions = fs::metadata(&file).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&file, permissions.clone()).unwrap();
    let ran = check(&place, &["--fix"]);
    assert_eq!(ran.code, 2, "{}", ran.err);
    ran.stdout_eq(str![[r#"
a.frag: error[cannot-write] `a.frag` cannot be fixed: it is read-only
a.frag:4:36: warning[unused-allow] `allow(stale-comment)` suppresses nothing in line 4
a.frag:7:28: warning[unused-allow] `allow(stale-comment)` suppresses nothing in line 7
a.frag:7:43: warning[unused-allow] `allow(mat3-padding)` suppresses nothing in line 7

"#]])
        .stderr_eq(str![[r#"
checked 2 shaders: 1 error, 3 warnings; 3 fixable with --fix
fixed 3 edits in 1 file

"#]]);
    assert_eq!((place.read("a.frag"), place.read("b.frag")), (bad, good));
    let left: Vec<_> = fs::read_dir(&place.0).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 3, "nothing half-written: {left:?}");
    #[allow(clippy::permissions_set_readonly_false, reason = "a file of this test's own")]
    permissions.set_readonly(false);
    fs::set_permissions(&file, permissions).unwrap();
}

#[cfg(unix)]
#[test]
fn fix_keeps_who_may_read_and_run_a_file() {
    use std::os::unix::fs::PermissionsExt;
    let place = Place::new("check-fix-mode");
    place.write("a.frag", twins("\n").0);
    let file = place.0.join("a.frag");
    fs::set_permissions(&file, fs::Permissions::from_mode(0o750)).unwrap();
    assert_eq!(check(&place, &["--fix"]).code, 0);
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o750);
}

#[test]
fn a_misspelt_code_becomes_the_one_it_is_nearest_to() {
    let place = Place::new("check-fix-misspelt");
    let text = CLEAN.replace("450", "450 // landfall: allow(mat3-paddng)");
    place.write("a.frag", text);
    assert_eq!(check(&place, &["--fix"]).code, 0);
    // Spelt right, it is seen to be idle, and goes in the next round.
    assert_eq!(place.read("a.frag"), CLEAN);
}

#[test]
fn includes_are_mended_once_for_all() {
    let place = Place::new("check-fix-include");
    let with = "#version 450\n#include \"b.inc\"\nvoid main() {}\n";
    place.write("a.frag", with).write("c.frag", with);
    place.write("b.inc", "struct S { vec4 a; }; // landfall: allow(stale-comment)\n");
    let shown = check(&place, &["--diff"]);
    assert_eq!((shown.code, shown.out.matches("--- a/b.inc").count()), (1, 1), "{}", shown.out);
    assert_eq!(check(&place, &["--fix"]).code, 0);
    assert_eq!(place.read("b.inc"), "struct S { vec4 a; };\n");
    assert_eq!(place.read("a.frag"), with);
}
