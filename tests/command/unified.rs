//! What `--diff` prints is what `git apply` and `patch` take.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::{fs, io::Write};

use fastrand::Rng;
use landfall::report::unified::diff;
use landfall_layout::format::Paint;

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("unified-{name}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("the target directory can be written");
    folder
}

fn fed(mut command: Command, folder: &Path, text: &str) -> Output {
    let mut child = command
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("git is installed");
    child.stdin.take().expect("piped").write_all(text.as_bytes()).expect("it reads");
    child.wait_with_output().expect("it ends")
}

/// Applies the diff of two texts to the first with git and holds the outcome to the second.
fn applies(folder: &Path, path: &str, old: &str, new: &str) {
    let file = folder.join(path.trim_start_matches("./"));
    fs::create_dir_all(file.parent().expect("a folder")).expect("it can be made");
    fs::write(&file, old).expect("it can be written");
    let diff = diff(path, old, new, Paint::Plain);
    let mut git = Command::new("git");
    // Whatever repository or configuration is around has no say.
    git.args([
        "-c",
        "core.autocrlf=false",
        "apply",
        "--unidiff-zero",
        "--whitespace=nowarn",
        "-p1",
    ])
    .env("GIT_CEILING_DIRECTORIES", folder.parent().expect("a folder"))
    .env("GIT_CONFIG_GLOBAL", "/dev/null");
    let output = fed(git, folder, &diff);
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{told}\n{diff}\n{old:?}\n{new:?}");
    assert_eq!(fs::read_to_string(&file).expect("text"), new, "{diff}");
}

#[test]
fn a_change_is_shown_with_three_lines_around_it() {
    let old = "1\n2\n3\n4\n5\n6\n7\n8\n9\n";
    assert_eq!(
        diff("shaders/a.frag", old, &old.replace('5', "five"), Paint::Plain),
        "\
--- a/shaders/a.frag
+++ b/shaders/a.frag
@@ -2,7 +2,7 @@
 2
 3
 4
-5
+five
 6
 7
 8
"
    );
    assert_eq!(diff("a", old, old, Paint::Plain), "");
    assert!(diff("a", old, "", Paint::Ansi).contains("\u{1b}[31m-1\u{1b}[0m\n"));
}

#[test]
fn git_takes_texts_without_a_last_newline_and_with_other_line_ends() {
    let folder = folder("ends");
    for (old, new) in [
        ("a\nb", "a\nc"),
        ("a\nb", "a\nb\n"),
        ("a\nb\n", "a\nb"),
        ("a", "b"),
        ("a\r\nb\r\n", "a\r\nc\r\n"),
        ("a\r\nb\r\n", "a\nb\r\n"),
        ("a\rb\rc\n", "a\rb\rd\n"),
        ("a\u{b}b\u{c}c\u{85}d\u{2028}e\n", "a\u{b}b\u{c}x\u{85}d\u{2028}e\n"),
        ("-- a\n++ b\n@@ c\n", "-- a\n++ x\n@@ c\n"),
        ("\\ No newline\n", "\\ newline\n"),
        ("漢字\n🙂\n", "漢\n🙂🙂\n"),
        ("a\n\n\n\nb\n", "a\n\nb\n"),
    ] {
        applies(&folder, "a.frag", old, new);
    }
}

#[test]
fn git_takes_paths_as_people_have_them() {
    let folder = folder("paths");
    for path in [
        "a b.frag",
        "./shaders/my lights/漢字 é.frag",
        "a,b;c'd.frag",
        "with\"quote.frag",
        "back\\slash.frag",
        "tab\there.frag",
    ] {
        applies(&folder, path, "1\n2\n", "1\n3\n");
    }
}

#[test]
fn git_takes_the_diffs_of_random_texts() {
    let folder = folder("random");
    let mut rng = Rng::with_seed(6);
    let lines = ["a\n", "b\n", "\n", "c\r\n", " \n", "}\n"];
    for _ in 0..60 {
        let mut line = || rng.choice(lines).expect("there are some");
        let old: Vec<&str> = (0..40).map(|_| line()).collect();
        let new: Vec<&str> = old
            .iter()
            .flat_map(|keep| match line() {
                "a\n" => vec![line()],
                "b\n" => vec![],
                "c\r\n" => vec![*keep, line()],
                _ => vec![*keep],
            })
            .collect();
        let (mut old, mut new) = (old.concat(), new.concat());
        if rng.bool() {
            old.push_str("last");
        }
        if rng.bool() {
            new.push_str("last");
        }
        if old != new {
            applies(&folder, "a.frag", &old, &new);
        }
    }
}
