//! How fast the backends prove and compute: probes a second, the first answer of the command,
//! hundreds of shaders on one device, and the evaluator against a Vulkan driver on an image.
//!
//! `cargo bench --features full --bench backends`. Ratios are of things measured in turns in one run. Needs
//! drivers (Debian packages `mesa-vulkan-drivers`, `libvulkan1`, `libegl1`, `libgl1-mesa-dri`).

#[path = "../support/files.rs"]
mod files;
mod measure;
mod scene;

use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use landfall_exec::backend::gl::Gl;
use landfall_exec::backend::wgpu::{AdapterChoice, Gpu};
use landfall_exec::backend::{Backend, Device, Failure, Job, JobOutput};
use landfall_exec::harness::verify::{Outcome, Subject, VerifyOptions, verify};
use landfall_interp::{Cpu, Settings};
use landfall_layout::Source;
use measure::{interleaved, median, round, seconds};

const LANDFALL: &str = env!("CARGO_BIN_EXE_landfall");

/// Rounds of the images, each backend once in each.
const ROUNDS: usize = 5;

/// Shaders that are written to be many.
const MANY: usize = 300;

fn main() {
    println!("medians (least to most); processor time where a ratio is of one device to another\n");
    // `cargo bench --features full --bench backends -- probes` leaves the rest out.
    if !std::env::args().any(|argument| argument == "probes") {
        first_answer();
        image();
    }
    probes();
}

/// A backend that counts what it is asked.
struct Counting {
    inner: Box<dyn Backend>,
    jobs: Arc<AtomicUsize>,
}

impl Backend for Counting {
    fn device(&self) -> &Device {
        self.inner.device()
    }

    fn run(&mut self, job: &Job) -> Result<JobOutput, Failure> {
        self.jobs.fetch_add(1, Ordering::Relaxed);
        self.inner.run(job)
    }
}

/// A backend, opened once, and what it did.
struct Measured {
    backend: [Box<dyn Backend>; 1],
    name: &'static str,
    jobs: Arc<AtomicUsize>,
    /// Leaves that were read, in all ways, in one round.
    reads: usize,
    /// Blocks it did not confirm, in one round: those it does not take.
    others: usize,
    times: Vec<f64>,
}

fn backends() -> Vec<Measured> {
    let all: [Box<dyn Backend>; 3] = [
        Box::new(Cpu::new(Settings::default())),
        Box::new(Gl::open().unwrap_or_else(|failure| panic!("{failure}"))),
        Box::new(
            Gpu::open(&AdapterChoice::default()).unwrap_or_else(|failure| panic!("{failure}")),
        ),
    ];
    let measured = all.map(|inner| {
        let (name, jobs) = (inner.device().backend.name(), Arc::new(AtomicUsize::new(0)));
        let counting = Counting { inner, jobs: Arc::clone(&jobs) };
        let times = Vec::new();
        Measured { backend: [Box::new(counting)], name, jobs, reads: 0, others: 0, times }
    });
    measured.into()
}

fn probes() {
    let options = VerifyOptions::default();
    let subject = |source: &Source| Subject::new(source, &options).ok();
    let own: Vec<Subject> = files::shaders()
        .iter()
        .filter_map(|path| Source::read(path).ok())
        .filter_map(|source| subject(&source))
        .filter(|subject| !subject.layout().blocks.is_empty())
        .collect();
    let many: Vec<Subject> = (0..MANY).filter_map(|i| subject(&generated(i))).collect();
    assert_eq!(many.len(), MANY, "every generated shader is laid out");
    proven(&format!("{} shaders of this repository", own.len()), &own, &options, 3);
    proven(&format!("{MANY} generated shaders"), &many, &options, 1);
}

/// Every shader by every backend, the backends in turns.
fn proven(name: &str, subjects: &[Subject], options: &VerifyOptions, rounds: usize) {
    println!("{name}, one device for all; rounds: {rounds}");
    let mut backends = backends();
    for _ in 0..rounds {
        for one in &mut backends {
            one.jobs.store(0, Ordering::Relaxed);
            let (mut reads, mut others) = (0, 0);
            let time = seconds(&mut || {
                for subject in subjects {
                    let report = verify(subject, options, &mut one.backend);
                    for block in report.blocks.iter().flat_map(|block| &block.backends) {
                        others += usize::from(block.outcome != Outcome::Confirmed);
                        reads += block.reads.len();
                    }
                }
            });
            (one.reads, one.others) = (reads, others);
            one.times.push(time);
        }
    }
    let cpu = backends[0].times.clone();
    for one in &backends {
        let time = median(one.times.clone());
        let jobs = one.jobs.load(Ordering::Relaxed);
        let mut ratios: Vec<f64> = one.times.iter().zip(&cpu).map(|(a, b)| a / b).collect();
        ratios.sort_by(f64::total_cmp);
        println!(
            "  {:3}  {:6.0} jobs/s  {:8.0} reads/s  {:6.2} ms a shader ({:.2} to {:.2})  \
             {} times the evaluator's time ({} to {})  {} blocks not taken",
            one.name,
            jobs as f64 / time,
            one.reads as f64 / time,
            1e3 * time / subjects.len() as f64,
            1e3 * one.times.iter().copied().fold(f64::INFINITY, f64::min) / subjects.len() as f64,
            1e3 * one.times.iter().copied().fold(0.0, f64::max) / subjects.len() as f64,
            round(ratios[ratios.len() / 2]),
            round(ratios[0]),
            round(ratios[ratios.len() - 1]),
            one.others,
        );
    }
    println!();
}

/// A shader whose block is like no other's: some members of a few types.
fn generated(number: usize) -> Source {
    const TYPES: [&str; 7] = ["float", "vec3", "mat3", "vec2", "Light", "int", "mat4"];
    let mut text = String::from(
        "#version 450\nstruct Light { vec3 position; float power; mat2 turn; };\n\
         layout(std140, binding = 0) uniform Block {\n",
    );
    for member in 0..2 {
        let ty = TYPES[(number / 7usize.pow(member) + member as usize) % TYPES.len()];
        let count = if number.is_multiple_of(10) { 2 } else { 1 };
        let array = if count > 1 { format!("[{count}]") } else { String::new() };
        text += &format!("  {ty} m{member}{array};\n");
    }
    text += "};\nvoid main() {}\n";
    Source::new(format!("generated_{number}.frag"), text)
}

/// From the start of the command to its end, against the start of the command that only says
/// its version.
fn first_answer() {
    let run = |arguments: &[&str]| {
        let status = Command::new(LANDFALL)
            .args(arguments)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status();
        assert!(status.expect("the command starts").success(), "{arguments:?}");
    };
    println!("the command, from its start to its end");
    for file in ["shaders/six_lights/phong_450.frag", "shaders/six_lights/phong.wgsl"] {
        let verify = || run(&["verify", "--backend", "cpu", file]);
        let ratio = interleaved(31, || run(&["--version"]), verify);
        let before = processor_of_children();
        let times: Vec<f64> = (0..31).map(|_| seconds(&mut || verify())).collect();
        let processor = (processor_of_children() - before) / 31.0;
        let least = times.iter().copied().fold(f64::INFINITY, f64::min);
        println!(
            "  verify --backend cpu {file}: {:.1} ms, {:.1} at least, {:.1} of the processor; \
             {ratio} times --version",
            1e3 * median(times),
            1e3 * least,
            1e3 * processor,
        );
    }
    println!();
}

/// Seconds of processor time of all threads of this process, those that ended too.
fn processor() -> f64 {
    stat(11)
}

/// The same of the commands that it ran.
fn processor_of_children() -> f64 {
    stat(13)
}

/// The sum of two times of the process, which Linux counts in hundredths: from 11 utime and
/// stime, from 13 cutime and cstime (`man 5 proc_pid_stat`, counted after the name).
fn stat(first: usize) -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name = stat.rsplit(')').next().unwrap_or("");
    let ticks = |i: usize| -> f64 {
        after_name.split_whitespace().nth(i).and_then(|x| x.parse().ok()).unwrap_or(0.0)
    };
    (ticks(first) + ticks(first + 1)) / 100.0
}

/// What a fragment of the image of six lights costs in processor time: the rest of a job
/// (upload, pipeline, read-back) is what a small image costs.
fn image() {
    let module = Arc::new(scene::module());
    let mut cpu = Cpu::new(Settings::default());
    let mut single = Cpu::new(Settings { threads: 1, ..Settings::default() });
    let mut gpu =
        Gpu::open(&AdapterChoice::default()).unwrap_or_else(|failure| panic!("{failure}"));
    let mut backends: [(&str, &mut dyn Backend, Vec<[f64; 4]>); 3] = [
        ("evaluator, all threads", &mut cpu, Vec::new()),
        ("evaluator, one thread", &mut single, Vec::new()),
        ("lavapipe", &mut gpu, Vec::new()),
    ];
    let sizes = [256, 1024].map(|size| (size, scene::job(&module, size)));
    let mut reds = [Vec::new(), Vec::new()];
    for turn in 0..=ROUNDS {
        for (_, backend, figures) in &mut backends {
            let mut all = [0.0; 4];
            for (at, (size, job)) in sizes.iter().enumerate() {
                // As many small images as have the pixels of a large one, for the clock's sake.
                let times = (1024 / size) * (1024 / size);
                let before = processor();
                let wall = seconds(&mut || {
                    for _ in 0..times {
                        let answer = backend.run(job).expect("the job runs");
                        if turn == 0 {
                            let red = answer.pixels.iter().map(|p| f64::from(f32::from_bits(p[0])));
                            reds[at].push(red.sum::<f64>() / answer.pixels.len() as f64);
                        }
                    }
                });
                let fragments = f64::from(1024 * 1024);
                all[2 * at] = 1e9 * (processor() - before) / fragments;
                all[2 * at + 1] = 1e9 * wall / fragments;
            }
            // The first round compiles.
            if turn > 0 {
                figures.push(all);
            }
        }
    }
    for reds in &reds {
        let same = reds.iter().all(|red: &f64| (red - reds[0]).abs() < 1e-3 * reds[0]);
        assert!(same, "all see the same image: {reds:?}");
    }
    println!("a fragment lit by six lights, ns: processor time, and elapsed");
    for (name, _, figures) in &backends {
        let of = |i: usize| median(figures.iter().map(|all| all[i]).collect());
        println!(
            "  {name:22}  256x256: {:6.0} {:6.0}   1024x1024: {:6.0} {:6.0}",
            of(0),
            of(1),
            of(2),
            of(3),
        );
    }
    for (name, _, figures) in &backends[..2] {
        let lavapipe = &backends[2].2;
        for (at, size) in [(0, 256), (2, 1024)] {
            let mut ratios: Vec<f64> =
                figures.iter().zip(lavapipe).map(|(a, b)| a[at] / b[at]).collect();
            ratios.sort_by(f64::total_cmp);
            println!(
                "  {name}: {} times lavapipe's processor time ({} to {}) at {size}x{size}",
                round(ratios[ratios.len() / 2]),
                round(ratios[0]),
                round(ratios[ratios.len() - 1]),
            );
        }
    }
    let ns = median(backends[1].2.iter().map(|all| all[2]).collect());
    let operations = single.notes.counts.operations() as f64 / f64::from(1024 * 1024);
    println!(
        "  {operations:.0} operations a fragment; one thread: {:.0} million operations a second",
        1e3 * operations / ns,
    );
}
