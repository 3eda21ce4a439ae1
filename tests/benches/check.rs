//! How fast a check of a whole tree is: cold against `layout` on the same tree, warm against
//! cold, and with one shader changed.
//!
//! `cargo bench --features full --bench check` writes two trees of 2,000 shaders and measures on both: one in
//! which every file declares `Lights` in its own way, so that every file is found fault with,
//! and one in which each file's blocks have names of their own.

mod measure;
mod tree;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use measure::interleaved;

const LANDFALL: &str = env!("CARGO_BIN_EXE_landfall");

/// Shaders of each tree.
const TREE: usize = 2_000;

/// Pairs of each measurement.
const PAIRS: usize = 9;

fn main() {
    println!("ratio: median (8 of 10 pairs lie within)\n");
    let dir = std::env::temp_dir().join(format!("landfall-check-bench-{}", std::process::id()));
    for (name, own_names) in
        [("blocks of one name that differ", false), ("names of their own", true)]
    {
        let _ = fs::remove_dir_all(&dir);
        let paths = tree::write(&dir.join("shaders"), TREE);
        if own_names {
            paths.iter().enumerate().for_each(|(i, path)| rename_blocks(path, i));
        }
        fs::write(dir.join("landfall.toml"), "paths = [\"shaders\"]\n").expect("a folder of ours");
        measure(name, &dir, &paths);
    }
    fs::remove_dir_all(&dir).expect("the bench's own directory");
}

/// Gives the blocks of a file names that no other file has.
fn rename_blocks(path: &Path, i: usize) {
    let text = fs::read_to_string(path).expect("a shader of ours");
    let text =
        text.replace("Lights", &format!("Lights{i}")).replace("Camera", &format!("Camera{i}"));
    fs::write(path, text).expect("a shader of ours");
}

fn measure(name: &str, dir: &Path, paths: &[PathBuf]) {
    let run = |arguments: &[&str]| {
        let mut command = Command::new(LANDFALL);
        command.args(arguments).current_dir(dir).stdout(Stdio::null()).stderr(Stdio::null());
        command.status().expect("the command of this package");
    };
    let table = || run(&["layout", "shaders"]);
    let naga = || run(&["layout", "shaders", "--naga"]);
    let json = || {
        // Files that are there already would not be written again.
        let _ = fs::remove_dir_all(dir.join("out"));
        run(&["layout", "shaders", "--format", "json", "--out", "out"]);
    };
    let cold = || run(&["check", "-f", "json=report.json"]);
    let remembering = || {
        let _ = fs::remove_dir_all(dir.join("cache"));
        run(&["check", "-f", "json=report.json", "--cache-dir", "cache"]);
    };
    let warm = || run(&["check", "-f", "json=report.json", "--cache-dir", "cache"]);
    let mut turn = 0;
    let one_changed = || {
        turn += 1;
        let path = &paths[turn % paths.len()];
        let text = fs::read_to_string(path).expect("a shader of ours");
        fs::write(path, format!("{text}\n// turn {turn}\n")).expect("a shader of ours");
        warm();
    };
    println!("{TREE} shaders, {name}");
    println!("  cold / layout --format json --out   {}", interleaved(PAIRS, json, cold));
    println!("  cold / layout --naga                {}", interleaved(PAIRS, naga, cold));
    println!("  cold / layout, naga not asked       {}", interleaved(PAIRS, table, cold));
    println!("  cold and remembering / cold         {}", interleaved(PAIRS, cold, remembering));
    remembering();
    println!("  cold / warm                         {}", interleaved(PAIRS, warm, cold));
    println!("  cold / one shader changed           {}\n", interleaved(PAIRS, one_changed, cold));
}
