//! `check --watch`.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use snapbox::str;

use crate::support::command::{Place, golden};

/// Time for one check on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

const GOOD: &str = "#version 330 core
layout(std140) uniform Light { vec4 position; vec4 color; };
void main() {}
";

/// A command that watches, and the lines of its notes.
struct Watching {
    child: Child,
    notes: Receiver<String>,
}

impl Watching {
    fn start(tree: &Place, arguments: &[&str]) -> Watching {
        let mut child = tree
            .command(&["check", "--watch", "--format", "short"])
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let (send, notes) = channel();
        std::thread::spawn(move || {
            lines.map_while(Result::ok).try_for_each(|line| send.send(line))
        });
        Watching { child, notes }
    }

    /// Waits for a note that begins so.
    fn wait_for(&self, start: &str) -> String {
        loop {
            let note = self.notes.recv_timeout(PATIENCE);
            let note = note.unwrap_or_else(|_| panic!("no note `{start}`"));
            if note.contains(start) {
                return note;
            }
        }
    }

    /// Waits for the end of a check that a change of `name` causes.
    fn checks_again(&self, name: &str) {
        let note = self.wait_for("changed: checking again");
        assert!(note.contains(name), "{note}");
        self.wait_for("watching");
    }

    /// Ctrl-C: the exit code and what was printed.
    fn stop(mut self) -> (i32, String) {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        let mut out = String::new();
        self.child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
        (self.child.wait().unwrap().code().unwrap(), out)
    }
}

#[test]
fn each_kind_of_file_is_watched_and_the_last_check_gives_the_exit_code() {
    let tree = Place::new("check-watch");
    let include = "#version 330 core\n#include \"frame.glsl\"\nvoid main() {}\n";
    tree.write("shaders/light.frag", GOOD)
        .write("shaders/sky.frag", include)
        .write("shaders/frame.glsl", "layout(std140) uniform Frame { vec4 view; };\n")
        .write("landfall.toml", "paths = [\"shaders\"]\n");
    assert_eq!(tree.run(&["lock"]).code, 0);
    let watching = Watching::start(&tree, &[]);
    watching.wait_for("watching");
    // A shader: its layout is no longer that of its lock.
    tree.write("shaders/light.frag", GOOD.replace("vec4 position", "vec3 position; float range"));
    watching.checks_again("light.frag");
    tree.write("shaders/light.frag", GOOD);
    watching.checks_again("light.frag");
    // An include.
    tree.write("shaders/frame.glsl", "layout(std140) uniform Frame { vec4 eye; vec4 view; };\n");
    watching.checks_again("frame.glsl");
    // A lock.
    std::fs::remove_file(tree.0.join("layouts/shaders/light.frag.json")).unwrap();
    watching.checks_again("light.frag.json");
    // The configuration.
    tree.write("landfall.toml", "paths = [\"shaders\"]\n[levels]\nall = \"allow\"\n");
    watching.checks_again("landfall.toml");
    // A shader that was not there, with an error.
    tree.write("shaders/new/broken.frag", "#version 330 core\nlayout(std140) uniform {\n");
    watching.checks_again("broken.frag");
    let (code, out) = watching.stop();
    assert_eq!(code, 2, "{out}");
    let headings = out.lines().filter(|line| line.contains("[layout-drift]"));
    golden().eq(headings.map(|line| format!("{line}\n")).collect::<String>(), str![[r#"
shaders/light.frag:2:24: error[layout-drift] `Light` differs from its lock: `position` changed from `vec4` to `vec3`; buffers filled for the lock's layout are misread
shaders/frame.glsl:1:24: error[layout-drift] `Frame` differs from its lock: `view` moved from 0 to 16; buffers filled for the lock's layout are misread
shaders/frame.glsl:1:24: error[layout-drift] `Frame` differs from its lock: `view` moved from 0 to 16; buffers filled for the lock's layout are misread

"#]]);
    // Nothing is cleared where there is no terminal.
    assert!(!out.contains('\u{1b}'), "{out:?}");
}

#[test]
fn findings_and_none_give_their_exit_codes() {
    let tree = Place::new("check-watch-codes");
    tree.write("a.frag", GOOD);
    let watching = Watching::start(&tree, &["."]);
    watching.wait_for("watching");
    assert_eq!(watching.stop().0, 0);
    assert_eq!(tree.run(&["lock"]).code, 0);
    tree.write("a.frag", GOOD.replace("vec4 color", "mat4 color"));
    let watching = Watching::start(&tree, &["."]);
    watching.wait_for("watching");
    assert_eq!(watching.stop().0, 1);
}

#[test]
fn what_cannot_be_watched_is_refused() {
    let tree = Place::new("check-watch-refused");
    tree.write("a.frag", GOOD);
    for arguments in [
        &["check", "--watch", "-"][..],
        &["check", "--watch", "--diff", "a.frag"],
        &["check", "--watch", "--write-baseline", "a.frag"],
    ] {
        assert_eq!(tree.run(arguments).code, 2, "{arguments:?}");
    }
}

/// A mirror in Rust and a baseline are no shaders.
#[test]
fn mirrors_and_the_baseline_are_watched() {
    let tree = Place::new("check-watch-others");
    let mirror = "// landfall: mirror(Light)\n#[repr(C)]\npub struct Light {\n    pub position: [f32; 4],\n    pub color: [f32; 4],\n}\n";
    tree.write("a.frag", GOOD).write("mirror.rs", mirror);
    assert_eq!(tree.run(&["check", "--baseline", "known.json", "--write-baseline"]).code, 0);
    let watching = Watching::start(&tree, &["--baseline", "known.json"]);
    watching.wait_for("watching");
    tree.write("mirror.rs", mirror.replace("position: [f32; 4]", "position: [f32; 3]"));
    watching.checks_again("mirror.rs");
    tree.write("known.json", tree.read("known.json") + "\n");
    watching.checks_again("known.json");
    watching.stop();
}
