//! Whether a bench ranks on a busy machine as on an idle one: `cargo bench --features full --bench load`.
//!
//! Four workloads whose costs are known, measured as `landfall bench` measures: as the machine
//! is, and again beside twice as many busy processes as it has threads. Exits with 1 if the ranks
//! differ.

use std::hint::black_box;
use std::process::{Child, Command, ExitCode};

use landfall::report::bench::text;
use landfall_accuracy::bench::clock::{Clock, Elapsed};
use landfall_accuracy::bench::{
    Bench, BenchRow, Errors, Machine, Part, Rounds, Runner, Size, Unit, Work, Workload, measure,
};
use landfall_layout::format::Paint;

/// Name, multiplications, and error: the second is beaten by the first, the last is exact.
const VARIANTS: [(&str, u32, f64); 4] = [
    ("rough", 200_000, 0.5),
    ("a tenth slower", 220_000, 0.5),
    ("half again", 300_000, 0.01),
    ("exact", 400_000, 0.0),
];

struct Multiply(u32);

impl Workload for Multiply {
    fn has(&self, part: Part) -> bool {
        part == Part::Whole
    }

    fn run(&mut self, _part: Part) -> Result<Option<Elapsed>, String> {
        let mut product = 1.000_001f64;
        for _ in 0..self.0 {
            product = black_box(product * 1.000_000_1);
        }
        black_box(product);
        Ok(None)
    }
}

fn main() -> ExitCode {
    let idle = bench("as the machine is");
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let mut busy: Vec<Child> = (0..2 * threads).filter_map(|_| spin().ok()).collect();
    let loaded = bench(&format!("beside {} busy processes", busy.len()));
    for child in &mut busy {
        child.kill().expect("a child of ours");
        child.wait().expect("a child of ours");
    }
    let ranks = |bench: &Bench| -> Vec<Vec<String>> {
        bench.rows.iter().map(|row| row.dominated_by.clone()).collect()
    };
    let same = ranks(&idle) == ranks(&loaded);
    println!("\n{}", if same { "both rank alike" } else { "they rank differently" });
    if same { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn spin() -> std::io::Result<Child> {
    Command::new("sh").args(["-c", "while :; do :; done"]).spawn()
}

fn bench(subject: &str) -> Bench {
    let machine = Machine::here();
    let mut workloads = VARIANTS.map(|(_, times, _)| Multiply(times));
    let mut each: Vec<&mut dyn Workload> =
        workloads.iter_mut().map(|workload| workload as &mut dyn Workload).collect();
    let samples = measure(&mut each, &Rounds::default(), &|| false, &mut |_| {});
    let runner = Runner {
        backend: "rust".to_string(),
        device: "this program".to_string(),
        clock: Clock::Processor,
    };
    let rows = VARIANTS.iter().zip(samples).filter_map(|((name, _, error), samples)| {
        let errors = Errors { max_steps: Some(*error), ..Errors::default() };
        let size = Size { fragments: 1000, lights: 0 };
        let samples = samples.expect("arithmetic does not fail");
        BenchRow::new(*name, runner.clone(), &samples, size, errors, Work::default())
    });
    let bench = Bench {
        subject: subject.to_string(),
        truth: "what is known of them".to_string(),
        unit: Unit::Fragment,
        fragments: 1000,
        lights: 0,
        inputs: None,
        rows: rows.collect(),
        machine: machine.after(),
        failed: Vec::new(),
    }
    .ranked();
    println!("{}", text(&bench, true, Paint::Plain));
    bench
}
