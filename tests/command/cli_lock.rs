//! `landfall lock` as it is run: what it writes, what it leaves alone, and what it refuses.

use std::fs;

use snapbox::str;

use crate::support::command::{Place, golden};

const LIGHTS: &str = "#version 330 core
layout(std140) uniform Lights { vec3 color; float range; int count; };
void main() {}
";

/// A folder with two shaders.
fn tree(name: &str) -> Place {
    let tree = Place::new(&format!("lock-{name}"));
    tree.write("shaders/lights/point.frag", LIGHTS);
    tree.write("shaders/view.vert", "#version 330 core\nuniform mat4 view;\nvoid main() {}\n");
    tree
}

/// The JSON of a lock.
fn lock_of(tree: &Place, file: &str) -> serde_json::Value {
    serde_json::from_str(&tree.read(file)).expect("a lock is JSON")
}

const POINT: &str = "layouts/shaders/lights/point.frag.json";

#[test]
fn locks_are_the_same_tree_as_the_shaders() {
    let tree = tree("tree");
    tree.run(&["lock", "shaders"]).code(0).stdout_eq("").stderr_eq(str![[r#"
2 locks written, 0 unchanged

"#]]);
    let text = tree.read(POINT);
    golden().eq(
        &text,
        str![[r#"
{
  "schema_version": 1,
  "language": "glsl",
  "blocks": [
    {
      "name": "Lights",
      "address_space": "uniform",
      "rules": "std140",
      "rules_declared": true,
      "size": 32,
      "data_size": 20,
      "align": 16,
      "members": [
        {"name": "color", "type": "vec3", "offset": 0, "size": 12, "align": 16},
        {"name": "range", "type": "float", "offset": 12, "size": 4, "align": 4},
        {"name": "count", "type": "int", "offset": 16, "size": 4, "align": 4}
      ]
    }
  ]
}

"#]],
    );
    assert_eq!(
        lock_of(&tree, "layouts/shaders/view.vert.json")["blocks"][0]["address_space"],
        "default"
    );
    tree.run(&["lock", "shaders"]).code(0).stdout_eq("").stderr_eq(str![[r#"
0 locks written, 2 unchanged

"#]]);
    assert_eq!(tree.run(&["lock", "shaders", "--check"]).code, 0);
}

#[test]
fn a_lock_changes_only_with_the_layout_and_only_where_it_does() {
    let tree = tree("minimal");
    tree.run(&["lock", "shaders"]);
    let old = tree.read(POINT);
    let written = |path: &str| fs::metadata(tree.0.join(path)).unwrap().modified().unwrap();
    let (point, view) = (written(POINT), written("layouts/shaders/view.vert.json"));
    let commented = LIGHTS.replace("float range", "\n\n  // reach\n  float range");
    tree.write("shaders/lights/point.frag", &commented);
    tree.run(&["lock", "shaders"]).code(0).stdout_eq("").stderr_eq(str![[r#"
0 locks written, 2 unchanged

"#]]);
    assert_eq!((written(POINT), written("layouts/shaders/view.vert.json")), (point, view));
    tree.write("shaders/lights/point.frag", LIGHTS.replace("int count", "uint count"));
    tree.run(&["lock", "shaders"]).code(0).stdout_eq("").stderr_eq(str![[r#"
1 lock written, 1 unchanged

"#]]);
    let new = tree.read(POINT);
    let changed = old.lines().zip(new.lines()).filter(|(a, b)| a != b).count();
    assert_eq!((changed, old.lines().count()), (1, new.lines().count()));
}

#[test]
fn check_writes_nothing_and_says_what_it_would() {
    let tree = tree("check");
    let ran = tree.run(&["lock", "shaders", "--check"]);
    ran.code(1).stdout_eq("").stderr_eq(str![[r#"
error[stale-lock]: `layouts/shaders/lights/point.frag.json` does not exist
  |
  = help: run the same command without `--check`, and commit what it writes

error[stale-lock]: `layouts/shaders/view.vert.json` does not exist
  |
  = help: run the same command without `--check`, and commit what it writes

2 locks would change, 0 unchanged

"#]]);
    assert!(!tree.0.join("layouts").exists());
    tree.run(&["lock", "shaders"]);
    let old = tree.read(POINT);
    tree.write("shaders/lights/point.frag", LIGHTS.replace("int count;", ""));
    let ran = tree.run(&["lock", "shaders", "--check"]);
    ran.code(1).stdout_eq("").stderr_eq(str![[r#"
error[stale-lock]: `layouts/shaders/lights/point.frag.json` is out of date
  |
  = help: run the same command without `--check`, and commit what it writes

1 lock would change, 1 unchanged

"#]]);
    assert_eq!(tree.read(POINT), old);
}

#[test]
fn locks_without_a_shader_are_reported_and_go_when_asked() {
    let tree = tree("prune");
    tree.run(&["lock", "shaders"]);
    tree.write("layouts/notes.json", "{}");
    fs::remove_file(tree.0.join("shaders/view.vert")).unwrap();
    let ran = tree.run(&["lock", "shaders"]);
    ran.code(0).stdout_eq("").stderr_eq(str![[r#"
warning[lock-orphan]: `layouts/shaders/view.vert.json` is a lock without a shader
  |
  = help: remove it with `landfall lock --prune`

0 locks written, 1 unchanged

"#]]);
    assert_eq!(tree.run(&["lock", "shaders", "--check", "--prune"]).code, 1);
    assert!(tree.0.join("layouts/shaders/view.vert.json").exists());
    let ran = tree.run(&["lock", "shaders", "--prune"]);
    ran.code(0).stdout_eq("").stderr_eq(str![[r#"
0 locks written, 1 unchanged, 1 removed

"#]]);
    assert!(!tree.0.join("layouts/shaders/view.vert.json").exists());
    // What is not named like a lock is somebody else's.
    assert!(tree.0.join("layouts/notes.json").exists());
}

#[test]
fn a_shader_that_does_not_parse_keeps_its_lock() {
    let tree = tree("broken");
    tree.run(&["lock", "shaders"]);
    let old = tree.read(POINT);
    tree.write("shaders/lights/point.frag", "layout(std140) uniform Lights { vec3 color;\n");
    let ran = tree.run(&["lock", "shaders", "--prune"]);
    ran.code(2).stdout_eq("").stderr_eq(str![[r#"
error[unclosed-brace]: `{` is never closed
 --> shaders/lights/point.frag:1:31
  |
1 | layout(std140) uniform Lights { vec3 color;
  |                               ^

0 locks written, 1 unchanged

"#]]);
    assert_eq!(tree.read(POINT), old);
}

#[test]
fn a_lock_has_one_place_whatever_part_of_the_tree_is_named_and_from_wherever() {
    let tree = tree("root");
    tree.run(&["lock", "shaders"]);
    for part in ["shaders/lights/point.frag", "./shaders/lights", "shaders/**/*.frag"] {
        let ran = tree.run(&["lock", part, "--check"]);
        ran.code(0).stdout_eq("").stderr_eq(str![[r#"
0 locks would change, 1 unchanged

"#]]);
    }
    let below = Place(tree.0.join("shaders/lights"));
    below.run(&["lock", ".", "--check"]).code(0).stdout_eq("").stderr_eq(str![[r#"
0 locks would change, 1 unchanged

"#]]);
    below.run(&["lock", "..", "--check"]).code(0).stdout_eq("").stderr_eq(str![[r#"
0 locks would change, 2 unchanged

"#]]);
    tree.write("shaders/lights/landfall.toml", "");
    let ran = tree.run(&["lock", "shaders/view.vert", "--config", "shaders/lights/landfall.toml"]);
    ran.code(2).stdout_eq("").stderr_eq(str![[r#"
error[no-input]: `shaders/view.vert` is not below shaders/lights, to which the paths of locks are relative
  |
  = help: run it in a directory above the shader, or put a `landfall.toml` there

0 locks written, 0 unchanged

"#]]);
}

/// Only so does `check` find nothing in what `lock` has just written.
#[test]
fn lock_and_check_read_the_same_configuration() {
    let tree = tree("config");
    tree.write("shaders/vendor/a.frag", LIGHTS);
    tree.write("shaders/sized.frag", "#version 450\nlayout(std140) uniform B { vec4 b[N]; };\n");
    tree.write(
        "landfall.toml",
        "paths = [\"shaders\"]\nexclude = [\"vendor\"]\nlocks = \"kept\"\ndefine = [\"N=3\"]\n",
    );
    tree.run(&["lock"]).code(0).stdout_eq("").stderr_eq(str![[r#"
3 locks written, 0 unchanged

"#]]);
    assert_eq!(
        lock_of(&tree, "kept/shaders/sized.frag.json")["blocks"][0]["members"][0]["type"],
        "vec4[3]"
    );
    tree.run(&["check"]).code(0);
    let ran = tree.run(&["lock", "-D", "N=4", "--check"]);
    ran.code(1).stdout_eq("").stderr_eq(str![[r#"
error[stale-lock]: `kept/shaders/sized.frag.json` is out of date
  |
  = help: run the same command without `--check`, and commit what it writes

1 lock would change, 2 unchanged

"#]]);
    tree.write("landfall.toml", "pats = [\"shaders\"]\n");
    let ran = tree.run(&["lock"]);
    ran.code(2).stdout_eq("").stderr_eq(str![[r#"
error[unknown-key]: the configuration has no key `pats`
 --> landfall.toml:1:1
  |
1 | pats = ["shaders"]
  | ^^^^
  |
  = help: did you mean `paths`?


"#]]);
}

#[test]
fn what_is_wrong_with_a_lock_is_mended_by_writing_it_again() {
    let tree = tree("mended");
    tree.run(&["lock", "shaders"]);
    let sound = tree.read(POINT);
    for (broken, said) in [
        (
            sound[..sound.len() / 2].to_string(),
            str![[r#"
error[cannot-run]: `layouts/shaders/lights/point.frag.json` is cut short: it ends in the middle, at line 13
  |
  = help: restore it from version control, or write it again with `landfall lock`


"#]],
        ),
        (
            sound.replacen("  \"blocks\"", "<<<<<<< HEAD\n  \"blocks\"", 1),
            str![[r#"
error[cannot-run]: `layouts/shaders/lights/point.frag.json` has a merge conflict at line 4: `<<<<<<< HEAD`
  |
  = help: resolve the conflicts in the shaders, then write the lock again with `landfall lock`


"#]],
        ),
        (
            sound.replacen("\"offset\": 12", "\"offset\": 8", 1),
            str![[r#"
error[cannot-run]: `layouts/shaders/lights/point.frag.json` contradicts itself at line 15: `range` at offset 8 overlaps `color`, which occupies 0 to 11
  |
  = help: locks are not edited by hand: write it again with `landfall lock`


"#]],
        ),
        (
            sound.replacen("\"offset\": 12", "\"offset\": \"12\"", 1),
            str![[r#"
error[cannot-run]: `layouts/shaders/lights/point.frag.json` has a string where `offset` must be a whole number, at line 15
  |
  = help: locks are not edited by hand: write it again with `landfall lock`


"#]],
        ),
    ] {
        tree.write(POINT, &broken);
        tree.run(&["diff", POINT, "shaders/lights/point.frag"]).code(2).stderr_eq(said);
        assert_eq!(tree.run(&["lock", "shaders"]).code, 0);
        assert_eq!(tree.read(POINT), sound);
    }
}

#[test]
fn what_is_no_lock_is_written_over_only_when_told() {
    let tree = tree("foreign");
    tree.run(&["lock", "shaders"]);
    let sound = tree.read(POINT);
    for (foreign, said) in [
        (
            "\u{7f}ELF",
            str![[r#"
error[cannot-run]: `layouts/shaders/lights/point.frag.json` is not JSON: line 1, column 1 has `\u{7f}` where a value should be
  |
  = help: locks are not edited by hand: write it again with `landfall lock`


"#]],
        ),
        (
            "{\"mine\": 1}",
            str![[r#"
error[cannot-run]: `layouts/shaders/lights/point.frag.json` is not a lock: it has no `schema_version`
  |
  = help: name a lock, or JSON that `landfall layout --format json` wrote


"#]],
        ),
    ] {
        tree.write(POINT, foreign);
        tree.run(&["diff", POINT, "shaders/lights/point.frag"]).code(2).stderr_eq(said);
        let ran = tree.run(&["lock", "shaders"]);
        ran.code(2).stdout_eq("").stderr_eq(str![[r#"
error[unreadable-file]: `layouts/shaders/lights/point.frag.json` has the name of a lock but is not a landfall lock
  |
  = help: move it away, keep locks elsewhere with `--locks DIR`, or overwrite it with `--force`

0 locks written, 1 unchanged

"#]]);
        assert_eq!(tree.read(POINT), foreign);
        assert_eq!(tree.run(&["lock", "shaders", "--force"]).code, 0);
        assert_eq!(tree.read(POINT), sound);
    }
}

#[test]
fn the_lock_of_a_newer_landfall_is_left_alone() {
    let tree = tree("newer");
    tree.run(&["lock", "shaders"]);
    let newer = tree.read(POINT).replace("\"schema_version\": 1", "\"schema_version\": 3");
    tree.write(POINT, &newer);
    let ran = tree.run(&["lock", "shaders"]);
    ran.code(2).stdout_eq("").stderr_eq(str![[r#"
error[unreadable-file]: `layouts/shaders/lights/point.frag.json` has schema version 3, but this landfall (0.2.0) reads up to 2, at line 2
  |
  = help: update landfall: a newer one wrote this file

0 locks written, 1 unchanged

"#]]);
    assert_eq!(tree.read(POINT), newer);
}

#[cfg(unix)]
#[test]
fn a_lock_that_cannot_be_written_is_not_lost() {
    use std::os::unix::fs::PermissionsExt;
    let tree = tree("read-only");
    tree.run(&["lock", "shaders"]);
    let old = tree.read(POINT);
    tree.write("shaders/lights/point.frag", LIGHTS.replace("int count", "uint count"));
    let folder = tree.0.join("layouts/shaders/lights");
    let mode = |mode| fs::set_permissions(&folder, fs::Permissions::from_mode(mode)).unwrap();
    mode(0o555);
    let probe = fs::write(folder.join("probe"), "");
    let ran = tree.run(&["lock", "shaders"]);
    mode(0o755);
    if probe.is_ok() {
        // Whoever runs this may write anywhere; a directory in the way stops even them.
        let _ = fs::remove_dir_all(&folder);
        fs::write(&folder, "in the way").unwrap();
        let ran = tree.run(&["lock", "shaders"]);
        ran.code(2).stdout_eq("").stderr_eq(str![[r#"
error[cannot-write]: `layouts/shaders/lights` cannot be created as a directory: file exists

0 locks written, 1 unchanged

"#]]);
        assert_eq!(fs::read_to_string(&folder).unwrap(), "in the way");
        return;
    }
    assert_eq!(ran.code, 2);
    assert!(ran.err.contains("cannot be written: permission denied"), "{}", ran.err);
    assert_eq!(tree.read(POINT), old);
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "nothing half-written is left");
}
