//! How fast layouts come: in process against naga's own front ends, as a
//! command against `glslangValidator` and `naga` run once a file, its start
//! against a program that prints a line, and its memory.
//!
//! `cargo bench --features full --bench layout [-- DIR…]` measures on the shaders of this
//! repository, on those in DIR…, and on a tree of 2,000 files it writes.

#[path = "../support/files.rs"]
mod files;
mod measure;
mod naga_parse;
mod tree;

use std::fs;
use std::hint::black_box;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use landfall_layout::source::kind_of_path;
use landfall_layout::{Options, Source, layout};
use measure::{geometric_mean, interleaved, median, round, seconds};
use naga_parse::parsed;

const LANDFALL: &str = env!("CARGO_BIN_EXE_landfall");

/// Files of the generated tree.
const TREE: usize = 2_000;

/// Files of it that the slow commands are run on; every one costs them the same.
const SAMPLE: usize = 40;

fn main() {
    let given: Vec<PathBuf> =
        std::env::args().skip(1).filter(|a| !a.starts_with('-')).map(PathBuf::from).collect();
    let dir = std::env::temp_dir().join(format!("landfall-bench-{}", std::process::id()));
    let tree = tree::write(&dir, TREE);
    println!("ratio: median (8 of 10 pairs lie within); larger is better unless said otherwise\n");

    against_naga("shaders of this repository", &files::shaders());
    for given in &given {
        against_naga(&given.display().to_string(), &shaders(given));
    }
    against_naga("200 files of the generated tree", &tree[..200]);
    commands(&dir, &tree);
    start();
    memory(&dir, &tree);
    fs::remove_dir_all(&dir).expect("the bench's own directory");
}

/// In process, one thread: layout against naga parsing the same text in full.
fn against_naga(name: &str, paths: &[PathBuf]) {
    let mut ratios = Vec::new();
    let mut slowest = (f64::INFINITY, String::new());
    let (mut bytes, mut time) = (0, 0.0);
    for path in paths {
        let Ok(source) = Source::read(path) else { continue };
        if !parsed(&source) {
            continue;
        }
        let options = Options::default();
        let ours = || {
            black_box(layout(black_box(&source), &options));
        };
        let naga = || {
            black_box(parsed(black_box(&source)));
        };
        // Short texts are read several times over, so that a pair outlasts the clock's steps.
        let times = (20_000 / source.text.len().max(1)).clamp(1, 40);
        let pair =
            interleaved(31, || (0..times).for_each(|_| ours()), || (0..times).for_each(|_| naga()));
        bytes += source.text.len() * times;
        time += median((0..9).map(|_| seconds(&mut || (0..times).for_each(|_| ours()))).collect());
        if pair.median() < slowest.0 {
            slowest = (pair.median(), path.display().to_string());
        }
        ratios.push(pair.median());
    }
    if ratios.is_empty() {
        return println!("{name}: naga takes none of {} files\n", paths.len());
    }
    ratios.sort_by(f64::total_cmp);
    let at = |part: f64| round(ratios[(part * (ratios.len() - 1) as f64) as usize]);
    println!("{name}: {} of {} files taken by naga", ratios.len(), paths.len());
    println!(
        "  naga's front end / landfall   {} geometric mean ({} to {} in 8 of 10 files)",
        round(geometric_mean(&ratios)),
        at(0.1),
        at(0.9)
    );
    println!("  closest file                  {} {}", round(slowest.0), slowest.1);
    println!("  landfall reads                {:.0} MB/s\n", bytes as f64 / time / 1e6);
}

/// As a command on the tree: against one process a file, and two cores against one.
fn commands(dir: &Path, tree: &[PathBuf]) {
    let landfall = |jobs: &str| {
        let mut command = Command::new(LANDFALL);
        command.args(["layout", "--format", "csv", "-j", jobs]).arg(dir);
        run(command)
    };
    println!("landfall layout on {} files, one process", tree.len());
    let jobs = interleaved(11, || landfall("2"), || landfall("1"));
    println!("  -j 1 / -j 2                   {jobs}");
    let whole = median((0..11).map(|_| seconds(&mut || landfall("2"))).collect());
    let glsl: Vec<_> = tree.iter().filter(|p| p.extension().is_some_and(|e| e != "wgsl")).collect();
    once_a_file("glslangValidator", &["-q", "-l"], &glsl, whole / tree.len() as f64);
    let naga: Vec<_> = tree.iter().enumerate().filter(|(i, _)| i % 8 < 5).map(|(_, p)| p).collect();
    once_a_file("naga", &[], &naga, whole / tree.len() as f64);
    println!();
}

fn once_a_file(program: &str, args: &[&str], files: &[&PathBuf], ours: f64) {
    let found = Command::new(program).arg("--version").stdout(Stdio::null()).status().is_ok();
    if !found {
        return println!("  {program:<29} not here");
    }
    let step = files.len() / SAMPLE;
    let mut times: Vec<f64> = files
        .iter()
        .step_by(step)
        .map(|file| {
            let mut command = Command::new(program);
            command.args(args).arg(file);
            let start = std::time::Instant::now();
            run(command);
            start.elapsed().as_secs_f64() / ours
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let at = |part: f64| round(times[(part * (times.len() - 1) as f64) as usize]);
    println!(
        "  {:<29} {:>7} ({} to {})",
        format!("{program} a file / landfall"),
        at(0.5),
        at(0.1),
        at(0.9)
    );
}

fn run(mut command: Command) {
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command.status().expect("a command that was found");
}

/// From start to end on one small file, against a Rust program that prints a line.
fn start() {
    let dir = std::env::temp_dir().join(format!("landfall-hello-{}", std::process::id()));
    fs::create_dir_all(&dir).expect("a directory for the bench");
    let (source, hello) = (dir.join("hello.rs"), dir.join("hello"));
    fs::write(&source, "fn main() { println!(\"hello\"); }").expect("a program for the bench");
    let built = Command::new("rustc").arg("-O").arg(&source).arg("-o").arg(&hello).status();
    assert!(built.is_ok_and(|status| status.success()), "rustc builds a program of one line");
    let ours = || {
        let mut command = Command::new(LANDFALL);
        command.args(["layout", "shaders/ideas/vec3_then_float.frag"]);
        run(command);
    };
    let theirs = || run(Command::new(&hello));
    println!("start and end on one small file (smaller is better)");
    println!("  landfall / a line printed     {}\n", interleaved(201, theirs, ours));
    fs::remove_dir_all(&dir).expect("the bench's own directory");
}

/// Peak memory on the tree against peak memory on its largest file.
fn memory(dir: &Path, tree: &[PathBuf]) {
    let size = |p: &&PathBuf| fs::metadata(p).map_or(0, |m| m.len());
    let largest = tree.iter().max_by_key(size).expect("a tree of files");
    let whole: u64 = tree.iter().map(|p| size(&p)).sum();
    println!("peak memory (smaller is better)");
    let of_tree = peak(&[dir]);
    // One file alone is over before it can be watched, so a copy of it stands in for each file.
    let copies = dir.join("copies");
    fs::create_dir_all(&copies).expect("a folder for the bench");
    for i in 0..tree.len() {
        fs::copy(largest, copies.join(format!("{i}.frag"))).expect("a shader for the bench");
    }
    println!(
        "  {} copies of the largest file, {:>2} KB  {:>6} KB",
        tree.len(),
        size(&largest) / 1024,
        peak(&[&copies])
    );
    println!("  the tree of {} files, {:>9} KB  {:>6} KB", tree.len(), whole / 1024, of_tree);
}

/// Peak resident memory of a run in kilobytes, its output read slowly so that it can be watched.
fn peak(paths: &[&Path]) -> u64 {
    let mut command = Command::new(LANDFALL);
    command.args(["layout", "--format", "json", "-j", "2"]).args(paths);
    let mut child = command.stdout(Stdio::piped()).spawn().expect("the command of this package");
    let status = format!("/proc/{}/status", child.id());
    let mut output = child.stdout.take().expect("a pipe was asked for");
    let mut buffer = vec![0; 1 << 16];
    let mut peak = 0;
    loop {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find(|line| line.starts_with("VmHWM:"));
        let kilobytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok());
        peak = peak.max(kilobytes.unwrap_or(0));
        match output.read(&mut buffer) {
            Ok(0) | Err(_) => break,
            Ok(_) => std::thread::sleep(Duration::from_micros(200)),
        }
    }
    child.wait().expect("the command ends");
    peak
}

fn shaders(dir: &Path) -> Vec<PathBuf> {
    files::below([dir], |path| kind_of_path(path).is_some())
}
