//! `landfall diff` as it is run: shaders, locks, directories and git revisions; the three forms;
//! the exit codes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const OLD: &str = "#version 330 core
struct Light { vec3 pos; vec3 color; };
layout(std140) uniform Lights {
    Light all[2];
    float gamma;
};
void main() {}
";

struct Tree(PathBuf);

impl Tree {
    fn new(name: &str) -> Tree {
        let root = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("cli-diff-{name}"));
        let _ = fs::remove_dir_all(&root);
        fs::create_dir_all(&root).unwrap();
        // The search for a configuration ends here.
        fs::write(root.join("landfall.toml"), "").unwrap();
        Tree(root)
    }

    fn write(&self, path: &str, text: &str) {
        let path = self.0.join(path);
        fs::create_dir_all(path.parent().expect("a folder")).unwrap();
        fs::write(path, text).unwrap();
    }

    fn landfall(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_landfall"))
            .args(arguments)
            .current_dir(&self.0)
            .output()
            .expect("the binary was built for this test")
    }

    /// The exit code, stdout and stderr.
    fn run(&self, arguments: &[&str]) -> (i32, String, String) {
        let output = self.landfall(arguments);
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
        (output.status.code().expect("an exit code"), text(output.stdout), text(output.stderr))
    }

    fn git(&self, arguments: &[&str]) {
        let output = Command::new("git")
            .args([
                "-c",
                "user.name=t",
                "-c",
                "user.email=t@example.org",
                "-c",
                "commit.gpgsign=false",
            ])
            .args(arguments)
            .current_dir(&self.0)
            .env("GIT_CONFIG_GLOBAL", "/dev/null")
            .output()
            .expect("git is installed");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }

    /// Both sides of a change, compared.
    fn change(&self, from: &str, to: &str) -> (i32, String) {
        assert!(OLD.contains(from));
        self.write("old.frag", OLD);
        self.write("new.frag", &OLD.replacen(from, to, 1));
        let (code, out, err) = self.run(&["diff", "old.frag", "new.frag"]);
        assert_eq!(err, "");
        (code, out)
    }
}

/// Offsets by hand from OpenGL 4.6 §7.6.2.2: `Light` is 32 bytes, `gamma` at 64, the block 80.
#[test]
fn each_change_has_a_line_of_its_own_and_a_class() {
    let tree = Tree::new("words");
    for (from, to, lines) in [
        (
            "float gamma;",
            "vec4 first; float gamma;",
            &[
                "breaking   `gamma` moved from 64 to 80  [Lights::gamma]",
                "breaking   `first` (`vec4`) is inserted at 64, where old uploads have `gamma`  [Lights::first]",
                "compatible grew from 80 to 96 bytes: a buffer of 80 bytes is too small",
            ][..],
        ),
        (
            "float gamma;",
            "int gamma;",
            &["breaking   `gamma` changed from `float` to `int`  [Lights::gamma]"],
        ),
        (
            "float gamma;",
            "float gain;",
            &["cosmetic   `gamma` was renamed to `gain`, in the same place  [Lights::gamma]"],
        ),
        (
            "vec3 pos;",
            "vec3 at;",
            &["cosmetic   `all[].pos` was renamed to `at`, in the same place  [Light::pos]"],
        ),
        (
            "vec3 pos;",
            "vec3 pos; float range;",
            &["compatible `all[].range` (`float`) uses former padding at 12  [Light::range]"],
        ),
        (
            "float gamma;",
            "float gamma; vec4 more;",
            &[
                "compatible `more` (`vec4`) is appended at 80  [Lights::more]",
                "compatible grew from 80 to 96 bytes: a buffer of 80 bytes is too small",
            ],
        ),
        (
            "    float gamma;\n",
            "",
            &[
                "breaking   `gamma` (`float` at 64) was removed  [Lights::gamma]",
                "compatible shrank from 80 to 64 bytes",
            ],
        ),
        (
            "Light all[2];",
            "Light all[3];",
            &[
                "breaking   `all` grew from 2 to 3 elements, the new ones where old uploads have `gamma`  [Lights::all]",
                "breaking   `gamma` moved from 64 to 96  [Lights::gamma]",
                "compatible grew from 80 to 112 bytes: a buffer of 80 bytes is too small",
            ],
        ),
        (
            "Light all[2];",
            "Light all[1];",
            &[
                "breaking   `all` shrank from 2 to 1 elements: the last were removed  [Lights::all]",
                "breaking   `gamma` moved from 64 to 32  [Lights::gamma]",
                "compatible shrank from 80 to 48 bytes",
            ],
        ),
        (
            "vec3 pos; vec3 color;",
            "vec3 pos; vec3 color; float a, b;",
            &[
                "breaking   `all` changed its array stride from 32 to 48  [Lights::all]",
                "breaking   `gamma` moved from 64 to 96  [Lights::gamma]",
            ],
        ),
        (
            "uniform Lights {",
            "uniform Lamps {",
            &["cosmetic   block `Lights` was renamed to `Lamps`"],
        ),
        (
            "float gamma;",
            "float gamma[1];",
            &[
                "cosmetic   `gamma` is now `float[1]`, was `float`: its elements stay in place  [Lights::gamma]",
            ],
        ),
        (
            "layout(std140)",
            "layout(std140, binding = 3)",
            &["compatible binding 3 is now declared; before, the host chose it"],
        ),
    ] {
        let (code, out) = tree.change(from, to);
        assert_eq!(code, 1, "{out}");
        for line in lines {
            assert!(
                out.lines().any(|l| l.trim() == *line),
                "{from} -> {to}: no\n  {line}\nin\n{out}"
            );
        }
    }
    let (code, out) = tree.change("float gamma;", "float gamma; // comments are no layout");
    assert_eq!((code, out.as_str()), (0, "no layout changed\n"));
}

#[test]
fn std430_on_the_same_members_says_rules_and_what_moved() {
    let tree = Tree::new("rules");
    tree.write(
        "a.comp",
        "#version 450\nlayout(std140) buffer B { float w[4]; vec4 v; };\nvoid main() {}\n",
    );
    tree.write(
        "b.comp",
        "#version 450\nlayout(std430) buffer B { float w[4]; vec4 v; };\nvoid main() {}\n",
    );
    let (code, out, _) = tree.run(&["diff", "a.comp", "b.comp"]);
    assert_eq!(code, 1);
    assert!(
        out.contains("breaking   `w` changed its array stride from 16 to 4  [B::w]\n"),
        "{out}"
    );
    assert!(out.contains("breaking   `v` moved from 64 to 16  [B::v]\n"), "{out}");
    assert!(out.contains("cosmetic   rules changed from std140 to std430\n"), "{out}");
    assert!(out.ends_with("1 block changed: 1 breaking\n"), "{out}");
}

#[test]
fn majorness_and_matrix_stride_are_told_apart() {
    let tree = Tree::new("matrix");
    let text = |layout: &str, rules: &str| {
        format!(
            "#version 450\nlayout({rules}) buffer B {{ {layout} mat2x3 m; }};\nvoid main() {{}}\n"
        )
    };
    tree.write("a.comp", &text("", "std430"));
    tree.write("b.comp", &text("layout(row_major)", "std430"));
    let (_, out, _) = tree.run(&["diff", "a.comp", "b.comp"]);
    assert!(out.contains("breaking   `m` is stored by rows, was by columns"), "{out}");
    assert!(out.contains("breaking   `m` changed its matrix stride from 16 to 8"), "{out}");
}

#[test]
fn both_listings_stand_beside_each_other_if_there_is_room() {
    let tree = Tree::new("beside");
    tree.change("float gamma;", "vec4 first; float gamma;");
    let (_, out, _) = tree.run(&["diff", "old.frag", "new.frag", "--width", "100"]);
    let row = |text: &str| out.lines().find(|line| line.contains(text)).map(str::trim_end);
    assert_eq!(
        row("vec4 first").map(|l| l.contains(" > 64 16    vec4 first")),
        Some(true),
        "{out}"
    );
    let gamma = out.lines().find(|line| line.matches("float gamma").count() == 2);
    assert!(gamma.is_some_and(|line| line.contains("64  4") && line.contains("| 80  4")), "{out}");
    assert!(out.lines().all(|line| line.chars().count() <= 100));
    let (_, narrow, _) = tree.run(&["diff", "old.frag", "new.frag", "--width", "40"]);
    assert!(narrow.contains("\n  - 64  4    float gamma\n"), "{narrow}");
    assert!(narrow.contains("\n  + 80  4    float gamma\n"), "{narrow}");
    assert!(!out.contains('\u{1b}'));
    let (_, colour, _) = tree.run(&["diff", "old.frag", "new.frag", "--color", "always"]);
    assert!(colour.contains("\u{1b}[31m"), "{colour}");
}

#[test]
fn only_breaking_changes_fail_when_asked() {
    let tree = Tree::new("exit");
    tree.change("float gamma;", "float gamma; vec4 more;");
    assert_eq!(tree.run(&["diff", "old.frag", "new.frag"]).0, 1);
    assert_eq!(tree.run(&["diff", "old.frag", "new.frag", "--breaking"]).0, 0);
    assert_eq!(tree.run(&["diff", "new.frag", "old.frag", "--breaking"]).0, 1);
    let (code, _, err) = tree.run(&["diff", "old.frag"]);
    assert_eq!(code, 2);
    assert!(err.contains("needs 2 sides to compare, not 1"), "{err}");
    let (code, _, err) = tree.run(&["diff", "old.frag", "gone.frag"]);
    assert_eq!(code, 2);
    assert!(err.contains("`gone.frag` does not exist"), "{err}");
    tree.write("bad.frag", "uniform B { float");
    assert_eq!(tree.run(&["diff", "old.frag", "bad.frag"]).0, 2);
}

#[test]
fn a_lock_is_compared_like_the_shader_it_was_written_from_and_renewed() {
    let tree = Tree::new("accept");
    tree.write("shaders/a.frag", OLD);
    assert_eq!(tree.run(&["lock", "shaders"]).0, 0);
    let lock = "layouts/shaders/a.frag.json";
    assert_eq!(tree.run(&["diff", lock, "shaders/a.frag"]).0, 0);
    assert_eq!(tree.run(&["diff", "layouts", "shaders"]).0, 0);
    tree.write("shaders/a.frag", &OLD.replace("gamma", "gain"));
    let (code, out, _) = tree.run(&["diff", lock, "shaders/a.frag"]);
    assert_eq!(code, 1);
    assert!(out.starts_with("shaders/a.frag: Lights: cosmetic\n"), "{out}");
    // Either way round: the lock is what is renewed.
    for sides in [[lock, "shaders/a.frag"], ["shaders/a.frag", lock], ["layouts", "shaders"]] {
        tree.write(lock, &fs::read_to_string(tree.0.join(lock)).unwrap().replace("gain", "gamma"));
        let (code, _, err) = tree.run(&["diff", sides[0], sides[1], "--accept"]);
        assert_eq!((code, err.as_str()), (0, "updated layouts/shaders/a.frag.json\n"));
        assert_eq!(tree.run(&["lock", "shaders", "--check"]).0, 0);
    }
    let (code, _, err) = tree.run(&["diff", "shaders/a.frag", "shaders/a.frag", "--accept"]);
    assert_eq!(code, 2);
    assert!(err.contains("has no lock to update"), "{err}");
    // The output of `layout` is read as well.
    let json = tree.run(&["layout", "shaders", "--format", "json"]).1;
    tree.write("all.json", &json);
    assert_eq!(tree.run(&["diff", "all.json", "shaders/a.frag"]).0, 0);
}

#[test]
fn directories_are_compared_shader_by_shader() {
    let tree = Tree::new("folders");
    tree.write("one/a.frag", OLD);
    tree.write("one/gone.frag", &OLD.replace("Lights", "Gone"));
    tree.write("two/a.frag", OLD);
    tree.write("two/new/b.frag", &OLD.replace("Lights", "Fresh"));
    let (code, out, _) = tree.run(&["diff", "one", "two"]);
    assert_eq!(code, 1);
    assert!(
        out.contains(
            "two/new/b.frag: Fresh: compatible\n  compatible block `Fresh` is new, 80 bytes\n"
        ),
        "{out}"
    );
    assert!(
        out.contains("one/gone.frag: Gone: breaking\n  breaking   block `Gone` was removed\n"),
        "{out}"
    );
    assert!(out.ends_with("2 blocks changed: 1 breaking, 1 compatible\n"), "{out}");
    let (code, _, err) = tree.run(&["diff", "one", "two/a.frag"]);
    assert_eq!(code, 2);
    assert!(err.contains("is one shader, but the other side is a directory"), "{err}");
}

#[test]
fn revisions_are_read_as_git_spells_them_with_their_includes() {
    let tree = Tree::new("git");
    tree.git(&["init", "-q"]);
    let shader = "#version 450\n#include \"common/light.glsl\"\n\
                  layout(std140) uniform Lights { Light all[2]; float gamma; };\nvoid main() {}\n";
    tree.write("shaders/a.frag", shader);
    tree.write("shaders/common/light.glsl", "struct Light { vec3 pos; };\n");
    tree.run(&["lock", "shaders"]);
    tree.git(&["add", "."]);
    tree.git(&["commit", "-q", "-m", "one"]);
    tree.write("shaders/common/light.glsl", "struct Light { vec3 pos; vec3 color; };\n");
    tree.write("shaders/b.frag", OLD);
    // The include of that revision, not the one in the work tree: the stride was 16.
    let said = "breaking   `all` changed its array stride from 16 to 32";
    for arguments in [
        &["diff", "HEAD:shaders/a.frag", "shaders/a.frag"][..],
        &["diff", "HEAD:layouts/shaders/a.frag.json", "shaders/a.frag"],
        &["diff", "HEAD:./shaders", "shaders"],
        &["diff", "HEAD:layouts", "shaders"],
        &["diff", "HEAD:layouts/shaders", "shaders"],
        &["diff", "layouts", "shaders"],
        &["diff", "--rev", "HEAD"],
        &["diff", "--rev", "HEAD", "shaders"],
        &["diff", "--rev", "HEAD", "shaders/a.frag"],
    ] {
        let (code, out, err) = tree.run(arguments);
        assert_eq!((code, err.as_str()), (1, ""), "{arguments:?}");
        assert!(out.contains(said), "{arguments:?}\n{out}");
    }
    tree.git(&["add", "."]);
    tree.git(&["commit", "-q", "-m", "two"]);
    assert_eq!(tree.run(&["diff", "--rev", "HEAD", "shaders"]).0, 0);
    let (code, out, _) = tree.run(&["diff", "HEAD~1:shaders", "HEAD:shaders"]);
    assert_eq!(code, 1);
    assert!(out.contains("HEAD:shaders/a.frag: Lights: breaking\n"), "{out}");
    assert!(out.contains("HEAD:shaders/b.frag: Lights: compatible\n"), "{out}");
    let leftovers = fs::read_dir(std::env::temp_dir()).unwrap().flatten().filter(|entry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        name.starts_with("landfall-") && entry.path().join("shaders/common/light.glsl").exists()
    });
    assert_eq!(leftovers.count(), 0);
}

#[test]
fn what_git_cannot_give_is_said_in_its_words() {
    let tree = Tree::new("git-bad");
    tree.git(&["init", "-q"]);
    tree.write("a.frag", OLD);
    tree.git(&["add", "."]);
    tree.git(&["commit", "-q", "-m", "one"]);
    for (side, said) in [
        ("HEAD:b.frag", "`HEAD:b.frag` does not exist at that revision"),
        ("HEAD~7:a.frag", "`HEAD~7:a.frag` cannot be read by git: not a valid object name head~7"),
        ("--help:a.frag", "unexpected argument"),
        ("HEAD:../../a.frag", "is outside the repository"),
    ] {
        let (code, _, err) = tree.run(&["diff", side, "a.frag"]);
        assert_eq!(code, 2, "{err}");
        assert!(err.contains(said), "{err}");
    }
    tree.write("bad.frag", "#version 330\nuniform B { vec33 x; };\n");
    tree.git(&["add", "."]);
    tree.git(&["commit", "-q", "-m", "bad"]);
    let (code, _, err) = tree.run(&["diff", "HEAD:bad.frag", "a.frag"]);
    assert_eq!(code, 2);
    assert!(err.contains("HEAD:bad.frag:2:"), "{err}");
}

#[test]
fn json_and_markdown_carry_the_same_changes() {
    let tree = Tree::new("forms");
    tree.change("float gamma;", "vec4 first; float gamma;");
    let (code, out, _) = tree.run(&["diff", "old.frag", "new.frag", "--format", "json"]);
    assert_eq!(code, 1);
    let json: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!(json["class"], "breaking");
    let change = &json["shaders"][0]["blocks"][0]["changes"][0];
    assert_eq!(change["kind"], "moved");
    assert_eq!((&change["old"], &change["new"]), (&"64".into(), &"80".into()));
    assert_eq!(change["rust"], "Lights::gamma");
    let (_, out, _) = tree.run(&["diff", "old.frag", "new.frag", "--format", "md"]);
    assert!(out.starts_with("### Layouts: 1 block changed: 1 breaking\n"), "{out}");
    assert!(
        out.contains("| breaking | `gamma` moved from 64 to 80 | `Lights::gamma` |\n"),
        "{out}"
    );
    assert!(out.contains("````diff\n"), "{out}");
}

#[test]
fn loose_uniforms_are_judged_by_their_names() {
    let tree = Tree::new("loose");
    let text = |uniforms: &str| format!("#version 330\n{uniforms}\nvoid main() {{}}\n");
    tree.write("a.frag", &text("uniform vec3 eye; uniform float w[4]; uniform int n;"));
    tree.write("b.frag", &text("uniform vec4 eye; uniform float w[2]; uniform int m;"));
    let (code, out, _) = tree.run(&["diff", "a.frag", "b.frag"]);
    assert_eq!(code, 1);
    for line in [
        "breaking   `eye` changed from `vec3` to `vec4`",
        "breaking   `w[]` has fewer elements: `[2]`, was `[4]`",
        "breaking   `n` was removed: values set by that name have no effect",
        "compatible `m` (`int`) is new, and not set yet",
    ] {
        assert!(out.contains(line), "{line}\n{out}");
    }
}

/// A killed process leaves the files of its revision; the next one removes them.
#[cfg(target_os = "linux")]
#[test]
fn files_of_killed_processes_are_removed() {
    let tree = Tree::new("swept");
    tree.git(&["init", "-q"]);
    tree.write("a.frag", OLD);
    tree.git(&["add", "."]);
    tree.git(&["commit", "-q", "-m", "one"]);
    let mut ended = Command::new("true").spawn().expect("true runs");
    ended.wait().expect("it ends");
    let (dead, alive) = (ended.id(), std::process::id());
    let temporary = tree.0.join("tmp");
    let kept = [
        format!("landfall-diff-{alive}-0"),
        format!("landfall-diff-{dead}"),
        format!("landfall-diff-{dead}-x"),
        format!("my-landfall-diff-{dead}-0"),
    ];
    for name in kept.iter().chain([&format!("landfall-diff-{dead}-0")]) {
        tree.write(&format!("tmp/{name}/shaders/a.frag"), OLD);
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_landfall"));
    command.args(["diff", "--rev", "HEAD", "a.frag"]).current_dir(&tree.0);
    let output = command.env("TMPDIR", &temporary).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let names = fs::read_dir(&temporary).unwrap().flatten();
    let mut names: Vec<String> =
        names.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    let mut kept = kept.to_vec();
    kept.sort();
    assert_eq!(names, kept);
}
