//! `landfall lock` as it is run: what it writes, what it leaves alone, and what it refuses.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const LIGHTS: &str = "#version 330 core
layout(std140) uniform Lights { vec3 color; float range; int count; };
void main() {}
";

/// A tree with two shaders.
struct Tree(PathBuf);

impl Tree {
    fn new(name: &str) -> Tree {
        let root = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("cli-lock-{name}"));
        let _ = fs::remove_dir_all(&root);
        let tree = Tree(root);
        // The search for a configuration ends here.
        tree.write("landfall.toml", "");
        tree.write("shaders/lights/point.frag", LIGHTS);
        tree.write("shaders/view.vert", "#version 330 core\nuniform mat4 view;\nvoid main() {}\n");
        tree
    }

    fn write(&self, path: &str, text: &str) {
        let path = self.0.join(path);
        fs::create_dir_all(path.parent().expect("a folder")).unwrap();
        fs::write(path, text).unwrap();
    }

    fn read(&self, path: &str) -> String {
        fs::read_to_string(self.0.join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
    }

    fn landfall(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_landfall"))
            .args(arguments)
            .current_dir(&self.0)
            .output()
            .expect("the binary was built for this test")
    }

    /// The exit code and what was said.
    fn run(&self, arguments: &[&str]) -> (i32, String) {
        let output = self.landfall(arguments);
        assert!(output.stdout.is_empty(), "{}", String::from_utf8_lossy(&output.stdout));
        let said = String::from_utf8(output.stderr).unwrap();
        (output.status.code().expect("an exit code"), said)
    }
}

const POINT: &str = "layouts/shaders/lights/point.frag.json";

#[test]
fn locks_are_the_same_tree_as_the_shaders() {
    let tree = Tree::new("tree");
    assert_eq!(tree.run(&["lock", "shaders"]), (0, "2 locks written, 0 unchanged\n".into()));
    let text = tree.read(POINT);
    assert!(text.contains(
        "        {\"name\": \"range\", \"type\": \"float\", \"offset\": 12, \"size\": 4, \"align\": 4},\n"
    ));
    assert!(tree.read("layouts/shaders/view.vert.json").contains("\"address_space\": \"default\""));
    assert_eq!(tree.run(&["lock", "shaders"]), (0, "0 locks written, 2 unchanged\n".into()));
    assert_eq!(tree.run(&["lock", "shaders", "--check"]).0, 0);
}

#[test]
fn a_lock_changes_only_with_the_layout_and_only_where_it_does() {
    let tree = Tree::new("minimal");
    tree.run(&["lock", "shaders"]);
    let old = tree.read(POINT);
    let written = |path: &str| fs::metadata(tree.0.join(path)).unwrap().modified().unwrap();
    let (point, view) = (written(POINT), written("layouts/shaders/view.vert.json"));
    let commented = LIGHTS.replace("float range", "\n\n  // reach\n  float range");
    tree.write("shaders/lights/point.frag", &commented);
    assert_eq!(tree.run(&["lock", "shaders"]).1, "0 locks written, 2 unchanged\n");
    assert_eq!((written(POINT), written("layouts/shaders/view.vert.json")), (point, view));
    tree.write("shaders/lights/point.frag", &LIGHTS.replace("int count", "uint count"));
    assert_eq!(tree.run(&["lock", "shaders"]).1, "1 lock written, 1 unchanged\n");
    let new = tree.read(POINT);
    let changed = old.lines().zip(new.lines()).filter(|(a, b)| a != b).count();
    assert_eq!((changed, old.lines().count()), (1, new.lines().count()));
}

#[test]
fn check_writes_nothing_and_says_what_it_would() {
    let tree = Tree::new("check");
    let (code, said) = tree.run(&["lock", "shaders", "--check"]);
    assert_eq!(code, 1);
    assert!(
        said.contains("error[stale-lock]: `layouts/shaders/lights/point.frag.json` does not exist"),
        "{said}"
    );
    assert!(said.ends_with("2 locks would change, 0 unchanged\n"), "{said}");
    assert!(!tree.0.join("layouts").exists());
    tree.run(&["lock", "shaders"]);
    let old = tree.read(POINT);
    tree.write("shaders/lights/point.frag", &LIGHTS.replace("int count;", ""));
    let (code, said) = tree.run(&["lock", "shaders", "--check"]);
    assert_eq!(code, 1);
    assert!(said.contains("is out of date"), "{said}");
    assert_eq!(tree.read(POINT), old);
}

#[test]
fn locks_without_a_shader_are_reported_and_go_when_asked() {
    let tree = Tree::new("prune");
    tree.run(&["lock", "shaders"]);
    tree.write("layouts/notes.json", "{}");
    fs::remove_file(tree.0.join("shaders/view.vert")).unwrap();
    let (code, said) = tree.run(&["lock", "shaders"]);
    assert_eq!(code, 0);
    assert!(
        said.contains(
            "warning[lock-orphan]: `layouts/shaders/view.vert.json` is a lock without a shader"
        ),
        "{said}"
    );
    assert_eq!(tree.run(&["lock", "shaders", "--check", "--prune"]).0, 1);
    assert!(tree.0.join("layouts/shaders/view.vert.json").exists());
    let (code, said) = tree.run(&["lock", "shaders", "--prune"]);
    assert_eq!((code, said.as_str()), (0, "0 locks written, 1 unchanged, 1 removed\n"));
    assert!(!tree.0.join("layouts/shaders/view.vert.json").exists());
    // What is not named like a lock is somebody else's.
    assert!(tree.0.join("layouts/notes.json").exists());
}

#[test]
fn a_shader_that_does_not_parse_keeps_its_lock() {
    let tree = Tree::new("broken");
    tree.run(&["lock", "shaders"]);
    let old = tree.read(POINT);
    tree.write("shaders/lights/point.frag", "layout(std140) uniform Lights { vec3 color;\n");
    let (code, said) = tree.run(&["lock", "shaders", "--prune"]);
    assert_eq!(code, 2);
    assert!(said.contains("shaders/lights/point.frag:1:"), "{said}");
    assert_eq!(tree.read(POINT), old);
}

#[test]
fn a_lock_has_one_place_whatever_part_of_the_tree_is_named_and_from_wherever() {
    let tree = Tree::new("root");
    tree.run(&["lock", "shaders"]);
    for part in ["shaders/lights/point.frag", "./shaders/lights", "shaders/**/*.frag"] {
        let said = (0, "0 locks would change, 1 unchanged\n".to_string());
        assert_eq!(tree.run(&["lock", part, "--check"]), said, "{part}");
    }
    let below = Tree(tree.0.join("shaders/lights"));
    assert_eq!(below.run(&["lock", ".", "--check"]).1, "0 locks would change, 1 unchanged\n");
    assert_eq!(below.run(&["lock", "..", "--check"]).1, "0 locks would change, 2 unchanged\n");
    tree.write("shaders/lights/landfall.toml", "");
    let (code, said) =
        tree.run(&["lock", "shaders/view.vert", "--config", "shaders/lights/landfall.toml"]);
    assert_eq!(code, 2);
    assert!(said.contains("`shaders/view.vert` is not below shaders/lights"), "{said}");
}

/// Only so does `check` find nothing in what `lock` has just written.
#[test]
fn lock_and_check_read_the_same_configuration() {
    let tree = Tree::new("config");
    tree.write("shaders/vendor/a.frag", LIGHTS);
    tree.write("shaders/sized.frag", "#version 450\nlayout(std140) uniform B { vec4 b[N]; };\n");
    tree.write(
        "landfall.toml",
        "paths = [\"shaders\"]\nexclude = [\"vendor\"]\nlocks = \"kept\"\ndefine = [\"N=3\"]\n",
    );
    assert_eq!(tree.run(&["lock"]), (0, "3 locks written, 0 unchanged\n".into()));
    assert!(tree.read("kept/shaders/sized.frag.json").contains("vec4[3]"));
    let checked = tree.landfall(&["check"]);
    assert_eq!(checked.status.code(), Some(0), "{}", String::from_utf8_lossy(&checked.stdout));
    let (code, said) = tree.run(&["lock", "-D", "N=4", "--check"]);
    assert_eq!((code, said.lines().last()), (1, Some("1 lock would change, 2 unchanged")));
    tree.write("landfall.toml", "pats = [\"shaders\"]\n");
    let (code, said) = tree.run(&["lock"]);
    assert!(code == 2 && said.contains("did you mean `paths`?"), "{said}");
}

#[test]
fn what_is_wrong_with_a_lock_is_mended_by_writing_it_again() {
    let tree = Tree::new("mended");
    tree.run(&["lock", "shaders"]);
    let sound = tree.read(POINT);
    for (broken, said) in [
        (sound[..sound.len() / 2].to_string(), "is cut short: it ends in the middle, at line"),
        (
            sound.replacen("  \"blocks\"", "<<<<<<< HEAD\n  \"blocks\"", 1),
            "has a merge conflict at line 4",
        ),
        (sound.replacen("\"offset\": 12", "\"offset\": 8", 1), "contradicts itself at line"),
        (
            sound.replacen("\"offset\": 12", "\"offset\": \"12\"", 1),
            "has a string where `offset` must be",
        ),
    ] {
        tree.write(POINT, &broken);
        let output = tree.landfall(&["diff", POINT, "shaders/lights/point.frag"]);
        assert_eq!(output.status.code(), Some(2));
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(stderr.contains(said) && stderr.contains("help: "), "{stderr}");
        assert!(stderr.contains("landfall lock"), "{stderr}");
        assert_eq!(tree.run(&["lock", "shaders"]).0, 0);
        assert_eq!(tree.read(POINT), sound);
    }
}

#[test]
fn what_is_no_lock_is_written_over_only_when_told() {
    let tree = Tree::new("foreign");
    tree.run(&["lock", "shaders"]);
    let sound = tree.read(POINT);
    for (foreign, said) in
        [("\u{7f}ELF", "is not JSON: line 1, column 1"), ("{\"mine\": 1}", "is not a lock")]
    {
        tree.write(POINT, foreign);
        let output = tree.landfall(&["diff", POINT, "shaders/lights/point.frag"]);
        assert_eq!(output.status.code(), Some(2));
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(stderr.contains(said) && stderr.contains("help: "), "{stderr}");
        let (code, said) = tree.run(&["lock", "shaders"]);
        assert!(code == 2 && said.contains("is not a landfall lock"), "{said}");
        assert_eq!(tree.read(POINT), foreign);
        assert_eq!(tree.run(&["lock", "shaders", "--force"]).0, 0);
        assert_eq!(tree.read(POINT), sound);
    }
}

#[test]
fn the_lock_of_a_newer_landfall_is_left_alone() {
    let tree = Tree::new("newer");
    tree.run(&["lock", "shaders"]);
    let newer = tree.read(POINT).replace("\"schema_version\": 1", "\"schema_version\": 2");
    tree.write(POINT, &newer);
    let (code, said) = tree.run(&["lock", "shaders"]);
    assert_eq!(code, 2);
    assert!(said.contains("has schema version 2, but this landfall"), "{said}");
    assert!(said.contains("help: update landfall"), "{said}");
    assert_eq!(tree.read(POINT), newer);
}

#[cfg(unix)]
#[test]
fn a_lock_that_cannot_be_written_is_not_lost() {
    use std::os::unix::fs::PermissionsExt;
    let tree = Tree::new("read-only");
    tree.run(&["lock", "shaders"]);
    let old = tree.read(POINT);
    tree.write("shaders/lights/point.frag", &LIGHTS.replace("int count", "uint count"));
    let folder = tree.0.join("layouts/shaders/lights");
    let mode = |mode| fs::set_permissions(&folder, fs::Permissions::from_mode(mode)).unwrap();
    mode(0o555);
    let probe = fs::write(folder.join("probe"), "");
    let (code, said) = tree.run(&["lock", "shaders"]);
    mode(0o755);
    if probe.is_ok() {
        // Whoever runs this may write anywhere; a directory in the way stops even them.
        let _ = fs::remove_dir_all(&folder);
        fs::write(&folder, "in the way").unwrap();
        let (code, said) = tree.run(&["lock", "shaders"]);
        assert_eq!(code, 2);
        assert!(said.contains("layouts/shaders/lights"), "{said}");
        assert_eq!(fs::read_to_string(&folder).unwrap(), "in the way");
        return;
    }
    assert_eq!(code, 2);
    assert!(said.contains("cannot be written: permission denied"), "{said}");
    assert_eq!(tree.read(POINT), old);
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "nothing half-written is left");
}
