//! Each command on two processors beside one: `cargo bench --features full --bench cores`.
//!
//! One processor is that of `taskset`, so that threads and drivers share it. The first row is what the
//! machine gives at most: two processes at once beside one after the other.

mod measure;
#[path = "../support/files.rs"]
mod support;
mod tree;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use measure::interleaved;

const LANDFALL: &str = env!("CARGO_BIN_EXE_landfall");

/// Pairs.
const ROUNDS: usize = 9;

fn main() {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("one processor : two, median (8 of 10 pairs); load {}\n", load.trim());
    let dir = std::env::temp_dir().join(format!("landfall-bench-cores-{}", std::process::id()));
    let (few, many) = (dir.join("few"), dir.join("many"));
    tree::write(&few, 2000);
    tree::write(&many, 16000);
    let text = |path: &Path| path.to_str().expect("a plain name").to_string();
    let (few, many) = (text(&few), text(&many));
    let shaders: Vec<String> = verified().iter().map(|path| text(path)).collect();
    let shaders: Vec<&str> = shaders.iter().map(String::as_str).collect();
    let layout = ["layout", &many, "--format", "json"];
    machine(&layout);
    row("layout, 2,000 files, a table", &["layout", &few]);
    row("layout, 16,000 files, a table", &["layout", &many]);
    row("layout, 16,000 files, JSON", &layout);
    row("check, 2,000 files", &["check", "--no-cache", &few]);
    row("check, 16,000 files", &["check", "--no-cache", &many]);
    row_in(&dir, "lock, 16,000 files", &["lock", "--locks", "locks", "many"]);
    for backends in ["cpu", "gl", "gpu", "cpu,gl,gpu"] {
        let what = format!("verify, {} shaders, {backends}", shaders.len());
        row(&what, &[&["verify", "--backend", backends], &shaders[..]].concat());
    }
    let scene = "shaders/scenes/six_lights.json";
    row("render, six lights, cpu", &["render", scene, "--size", "1280x720"]);
    let picture = text(&dir.join("picture.png"));
    row(
        "render, six lights, 3840x2160, a PNG",
        &["render", scene, "--size", "3840x2160", "-o", &picture],
    );
    row("render, six lights, f64", &["render", scene, "--size", "1280x720", "--reference"]);
    let stress = ["stress", "shaders/six_lights/phong_450.frag", "--fn", "CalcPointLight"];
    row(
        "stress, 400,000 samples",
        &[&stress[..], &["--samples", "400000", "--time", "600"]].concat(),
    );
    std::fs::remove_dir_all(&dir).expect("the bench's own directory");
}

/// The shaders of this repository, one of four.
fn verified() -> Vec<PathBuf> {
    support::shaders().into_iter().step_by(4).collect()
}

fn row(what: &str, arguments: &[&str]) {
    row_in(Path::new("."), what, arguments);
}

fn row_in(dir: &Path, what: &str, arguments: &[&str]) {
    let run = |command: &mut Command| end(start(command.args(arguments).current_dir(dir)));
    let one = || run(Command::new("taskset").args(["-c", "0", LANDFALL]));
    let two = || run(&mut Command::new(LANDFALL));
    println!("{what:44} {}", interleaved(ROUNDS, two, one));
}

/// Two processes of one thread at once, and one after the other.
fn machine(arguments: &[&str]) {
    let one = || start(Command::new(LANDFALL).args(arguments).args(["-j", "1"]));
    let both = || {
        let other = one();
        end(one());
        end(other);
    };
    let in_turn = || {
        end(one());
        end(one());
    };
    println!(
        "{:44} {}",
        "two processes, one after the other : at once",
        interleaved(ROUNDS, both, in_turn)
    );
}

fn start(command: &mut Command) -> Child {
    let quiet = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    quiet.spawn().expect("landfall and taskset start")
}

fn end(mut child: Child) {
    // 1 says that there are findings.
    let status = child.wait().expect("the process is waited for");
    assert!(matches!(status.code(), Some(0 | 1)), "{status}");
}
