//! `--baseline`, `--write-baseline` and `--add-allow`: what is there today, and what is new.

use snapbox::str;
use std::fs;

use crate::cli_check::place::CLEAN;
use crate::schema::{holds, validator};
use crate::support::command::{Place, Ran, golden};

const FLAGS: [&str; 6] = ["-A", "all", "-W", "stale-comment", "-D", "vec3-array"];

fn check(place: &Place, more: &[&str]) -> Ran {
    place.run(&[&["check", "-f", "short"], &FLAGS[..], more].concat())
}

/// A block with two findings: a comment with a wrong offset, and an array of `vec3`.
const BAD: &str = "#version 450
layout(std140, binding = 0) uniform Light {
    vec4 position;
    vec4 color; // offset 32
    vec3 table[4];
} light;
layout(location = 0) out vec4 color;
void main() {
    color = light.position + light.color + light.table[1].xyzz;
}
";

fn recorded(name: &str) -> Place {
    let place = Place::new(name);
    place.write("s/a.frag", BAD).write("s/b.frag", CLEAN);
    let found = check(&place, &[]);
    assert_eq!(found.code(1).out.lines().count(), 2, "{}", found.out);
    let written = check(&place, &["--write-baseline", "--baseline", "base.json"]);
    assert_eq!(
        (written.code(0).out.as_str(), written.err.lines().next()),
        ("", Some("recorded 2 findings in base.json"))
    );
    place
}

#[test]
fn what_a_baseline_records_is_permitted_wherever_its_line_moves() {
    let place = recorded("check-baseline");
    let base = ["--baseline", "base.json"];
    let ran = check(&place, &base);
    ran.code(0).stderr_eq(str![[r#"
checked 2 shaders: no findings; 2 in the baseline

"#]]);
    // Without it, all is reported as before.
    check(&place, &[]).code(1);
    let moved = BAD
        .replace("#version 450\n", "#version 450\n\n// above\n\n")
        .replace("    vec4 color; //", "\t vec4  color;  //");
    place.write("s/a.frag", &moved);
    assert_eq!(check(&place, &base).code(0).out, "");
    // The same member with another comment is still the same finding, and so is a new name.
    place.write("s/a.frag", BAD.replace("offset 32", "offset 64"));
    assert_eq!(check(&place, &base).code(0).out, "");
    place.write("s/a.frag", BAD.replace("uniform Light", "uniform Lamp"));
    assert_eq!(check(&place, &base).code(0).out, "");
    // From another directory, the entries are the same.
    let mut below = place
        .command(&[&["check", "-f", "short", "--baseline", "../base.json"], &FLAGS[..]].concat());
    let below = Ran::of(below.current_dir(place.0.join("s")).output().unwrap());
    assert_eq!(below.code(0).out, "", "{}", below.err);
    // In the configuration it needs no option.
    place.write("landfall.toml", "baseline = \"base.json\"\n");
    check(&place, &[]).code(0);
    check(&place, &["--no-config"]).code(1);
}

#[test]
fn lines_that_end_with_a_lone_cr_are_recorded_as_others_are() {
    let place = Place::new("check-baseline-cr");
    place.write("a.frag", BAD.replace('\n', "\r"));
    check(&place, &["--write-baseline", "--baseline", "base.json"]).code(0);
    let recorded = place.read("base.json");
    assert!(recorded.contains("\"text\":\"vec3 table[4];\""), "{recorded}");
}

#[test]
fn a_new_finding_fails_also_at_level_warn() {
    let place = recorded("check-baseline-new");
    let base = ["--baseline", "base.json"];
    // A second copy of a permitted line is new.
    let second = BAD.replace("} light;", "} light;\nlayout(std140, binding = 1) uniform Other {\n    vec4 position;\n    vec4 color; // offset 32\n} other;");
    place.write("s/a.frag", second);
    let ran = check(&place, &base);
    ran.code(1).stdout_eq(str![[r#"
s/a.frag:9:27: warning[stale-comment] comment puts `color` at offset 32, but it is at 16

"#]]);
    // The same line in another file is new, too.
    place.write("s/a.frag", BAD).write("s/c.frag", BAD);
    assert_eq!(check(&place, &base).code(1).out.lines().count(), 2);
    fs::remove_file(place.0.join("s/c.frag")).unwrap();
    // An error of a shader is never permitted.
    place.write("s/b.frag", "#version 450\nuniform B {");
    let failed = check(&place, &[&base[..], &["--write-baseline"]].concat());
    failed.code(2).stdout_eq(str![[r#"
s/a.frag:4:27: warning[stale-comment] comment puts `color` at offset 32, but it is at 16
s/a.frag:5:10: error[vec3-array] elements of `table` are 16 bytes apart: packed `vec3`s are 12 apart, and only the first is read correctly
s/b.frag:2:11: error[unclosed-brace] `{` is never closed

"#]]).stderr_eq(str![[r#"
base.json is not written: not every shader was checked
checked 2 shaders: 2 errors, 1 warning; 1 fixable with --fix

"#]]);
}

#[test]
fn entries_that_match_nothing_are_reported_and_renewed() {
    let place = recorded("check-baseline-stale");
    let base = ["--baseline", "base.json"];
    place.write("s/a.frag", BAD.replace(" // offset 32", " // offset 16"));
    let ran = check(&place, &base);
    let row =
        place.read("base.json").lines().position(|line| line.contains("stale-comment")).unwrap()
            + 1;
    let expected = format!(
        "base.json:{row}:1: warning[stale-baseline] `s/a.frag`: it has no `stale-comment` in the line `vec4 color; // offset 32`\n"
    );
    assert_eq!(ran.code(0).out, expected);
    // A check of other files, or without the lint, knows nothing of it.
    assert_eq!(check(&place, &[&base[..], &["s/b.frag"]].concat()).code(0).out, "");
    assert_eq!(check(&place, &[&base[..], &["-A", "stale-comment"]].concat()).code(0).out, "");
    let before = place.read("base.json");
    check(&place, &[&base[..], &["--write-baseline", "s/b.frag"]].concat()).code(0);
    assert_eq!(place.read("base.json"), before, "entries of other files are kept");
    check(&place, &[&base[..], &["--write-baseline"]].concat()).code(0);
    assert!(!place.read("base.json").contains("stale-comment"));
    assert_eq!(check(&place, &base).code(0).out, "");
}

#[test]
fn a_drift_is_permitted_as_it_is_and_no_other() {
    let place = Place::new("check-baseline-drift");
    place.write("a.frag", CLEAN).run(&["lock"]).code(0);
    let drifted =
        |by: &str| CLEAN.replace("    vec4 color;", &format!("    {by} hole; vec4 color;"));
    place.write("a.frag", drifted("vec4"));
    let base = ["check", "--baseline", "b.json"];
    place.run(&[&base[..], &["--write-baseline"]].concat()).code(0);
    place.run(&base).code(0);
    place.write("a.frag", drifted("mat4"));
    place.run(&base).code(1);
}

#[test]
fn a_file_that_is_no_baseline_is_an_error_and_kept() {
    let place = recorded("check-baseline-faults");
    let rows = [
        ("{\"name\": \"x\"}", "is not a baseline: unknown field `name`"),
        ("[", "is not a baseline: EOF"),
        ("{\"schema_version\": 9, \"findings\": []}", "has schema version 9"),
        (
            "{\"schema_version\": 1, \"findings\": [{\"path\": \"a\", \"code\": \"b\", \"count\": -1}]}",
            "is not a baseline: invalid value",
        ),
    ];
    for (text, message) in rows {
        place.write("base.json", text);
        for more in [&[][..], &["--write-baseline"]] {
            let ran = check(&place, &[&["--baseline", "base.json"], more].concat());
            assert!(ran.code(2).err.contains(message), "{}", ran.err);
            assert_eq!(place.read("base.json"), text);
        }
    }
    let gone = check(&place, &["--baseline", "gone.json"]);
    gone.code(2).stderr_eq(str![[r#"
error[unreadable-file]: `gone.json` cannot be read: no such file or directory
  |
  = help: write it with `landfall check --write-baseline`


"#]]);
    // Nor is a shader or a lock overwritten.
    let shader = check(&place, &["--baseline", "s/b.frag", "--write-baseline"]);
    assert_eq!((shader.code(2).out.as_str(), place.read("s/b.frag").as_str()), ("", CLEAN));
}

/// The text without the comments that allow.
fn without_allows(text: &str) -> String {
    text.split_inclusive('\n').filter(|line| !line.contains("// landfall: allow")).collect()
}

#[test]
fn add_allow_writes_comments_after_which_nothing_is_found() {
    for (name, newline, mark) in [("lf", "\n", ""), ("crlf", "\r\n", ""), ("bom", "\n", "\u{feff}")]
    {
        let place = Place::new(&format!("check-add-allow-{name}"));
        // One finding in a block comment, where no comment for its line has an effect.
        let text = BAD
            .replace("    vec3 table[4];", "    /* two lines,\n       offset 4 */ vec3 table[4];");
        let text = format!("{mark}{}", text.replace('\n', newline));
        place.write("s/a.frag", &text).write("s/b.frag", CLEAN);
        let ran = check(&place, &["--add-allow"]);
        let left: Vec<&str> =
            ran.out.lines().filter(|line| !line.contains("byte-order-mark")).collect();
        assert!(left.is_empty(), "{left:?}\n{}", ran.err);
        let after = place.read("s/a.frag");
        assert_ne!(after, text);
        assert_eq!(without_allows(&after), text, "no other byte differs");
        assert_eq!(place.read("s/b.frag"), CLEAN);
        check(&place, &["-W", "unused-allow"]).code(0);
        let again = check(&place, &["--add-allow"]);
        let added = again.code(0).err.lines().nth(1);
        assert_eq!(added, Some("added 0 comments in 0 files"), "{}", again.err);
        // What is new is found.
        place.write("s/b.frag", BAD);
        let found = check(&place, &[]);
        let in_b = found.code(1).out.lines().filter(|line| line.starts_with("s/b.frag:"));
        golden().eq(in_b.collect::<Vec<_>>().join("\n"), str![[r#"
s/b.frag:4:27: warning[stale-comment] comment puts `color` at offset 32, but it is at 16
s/b.frag:5:10: error[vec3-array] elements of `table` are 16 bytes apart: packed `vec3`s are 12 apart, and only the first is read correctly
"#]]);
    }
}

#[test]
fn add_allow_does_not_change_macros_or_what_it_cannot_write() {
    let place = Place::new("check-add-allow-macro");
    let text = BAD.replace("    vec4 color; // offset 32\n", "    vec4 color;\n").replace(
        "layout(std140",
        "#define MEMBERS vec4 a; \\\n    vec3 b[3];\nlayout(std140, binding = 1) uniform M { MEMBERS } m;\nlayout(std140",
    );
    place.write("s/a.frag", &text);
    let ran = check(&place, &["--add-allow"]);
    assert_eq!(ran.code(0).out, "", "{}", ran.err);
    assert_eq!(without_allows(&place.read("s/a.frag")), text);
    let mut permissions = fs::metadata(place.0.join("s/a.frag")).unwrap().permissions();
    permissions.set_readonly(true);
    place.write("s/a.frag", BAD);
    fs::set_permissions(place.0.join("s/a.frag"), permissions).unwrap();
    let ran = check(&place, &["--add-allow"]);
    ran.code(2).stdout_eq(str![[r#"
s/a.frag: error[cannot-write] `s/a.frag` cannot be fixed: it is read-only
s/a.frag:4:27: warning[stale-comment] comment puts `color` at offset 32, but it is at 16
s/a.frag:5:10: error[vec3-array] elements of `table` are 16 bytes apart: packed `vec3`s are 12 apart, and only the first is read correctly

"#]]);
    assert_eq!(place.read("s/a.frag"), BAD);
}

#[test]
fn a_baseline_keeps_to_its_schema() {
    let place = recorded("check-baseline-schema");
    let schema = validator("baseline");
    let text = holds(&schema, &place.read("base.json"), "baseline");
    for (path, value) in [("/schema_version", 2), ("/findings/0/path", 3), ("/findings", 4)] {
        let mut wrong = text.clone();
        *wrong.pointer_mut(path).unwrap() = value.into();
        assert!(!schema.is_valid(&wrong), "{wrong}");
    }
}
