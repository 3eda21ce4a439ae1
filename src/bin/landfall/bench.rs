//! `landfall bench`: variants on readers, time against error.

mod function;
mod scene;

use landfall::Error;
use landfall::accuracy::bench::clock::Clock;
use landfall::accuracy::bench::{
    Bench, BenchRow, Errors, Failed, Machine, Permitted, Rounds, Runner, Size, Unit, Work,
    Workload, drawing, measure,
};
use landfall::accuracy::plot::scatter;
use landfall::emit::bench as print;
use landfall::run::eval::Floats;

use crate::args::{BenchArgs, BenchFormat};
use crate::output::{Failure, Outcome, Streams};

pub fn run(args: &BenchArgs, streams: &Streams) -> Result<Outcome, Failure> {
    let bench = match &args.function {
        Some(name) => function::bench(args, name, streams)?,
        None => scene::bench(args, streams)?,
    };
    let Some(bench) = bench else { return Ok(Outcome::CouldNot) };
    if let Some(path) = &args.plot {
        landfall::file::write_whole(path, scatter(&drawing(&bench)))?;
    }
    streams.product(&match args.format {
        BenchFormat::Human => print::text(&bench, streams.paint),
        BenchFormat::Json => print::json(&bench),
        BenchFormat::Csv => print::csv(&bench),
    })?;
    if args.format == BenchFormat::Csv {
        for Failed { variant, reader, reason } in &bench.failed {
            streams.notes(&format!("note: {variant} on {reader}: {reason}\n"));
        }
    }
    Ok(if bench.rows.is_empty() { Outcome::CouldNot } else { Outcome::Clean })
}

/// Something to measure, and what is known of it already.
struct Entry<'a> {
    variant: String,
    runner: Runner,
    workload: Box<dyn Workload + 'a>,
    errors: Errors,
    permitted: Option<Permitted>,
    work: Work,
}

/// What can be measured, and what cannot.
#[derive(Default)]
struct Entries<'a> {
    measured: Vec<Entry<'a>>,
    failed: Vec<Failed>,
}

impl Entries<'_> {
    fn fail(&mut self, variant: &str, reader: &str, reason: impl Into<String>) {
        let (variant, reader) = (variant.to_string(), reader.to_string());
        self.failed.push(Failed { variant, reader, reason: reason.into() });
    }
}

/// What a bench is of.
struct About {
    subject: String,
    truth: String,
    unit: Unit,
    size: Size,
}

/// Measures in turns and ranks.
fn measured(about: About, entries: Entries<'_>, args: &BenchArgs, streams: &Streams) -> Bench {
    let Entries { measured: mut entries, mut failed } = entries;
    let machine = Machine::here();
    let rounds = Rounds { count: args.rounds, ..Rounds::default() };
    let shows = streams.shows_progress_first();
    let mut progress = |done: u32| {
        if shows {
            streams.progress(&format!("round {done} of {}", args.rounds));
        }
    };
    let mut workloads: Vec<&mut dyn Workload> =
        entries.iter_mut().map(|entry| &mut *entry.workload as &mut dyn Workload).collect();
    let samples = measure(&mut workloads, &rounds, &mut progress);
    let mut rows = Vec::new();
    for (entry, samples) in entries.into_iter().zip(samples) {
        let Entry { variant, runner, errors, permitted, work, .. } = entry;
        match samples {
            Ok(samples) => {
                let row = BenchRow::new(variant, runner, &samples, about.size, errors, work);
                rows.extend(row.map(|row| BenchRow { permitted, ..row }));
            }
            Err(reason) => failed.push(Failed { variant, reader: runner.reader, reason }),
        }
    }
    let About { subject, truth, unit, size: Size { fragments, lights } } = about;
    let machine = machine.after();
    Bench { subject, truth, unit, fragments, lights, machine, rows, failed }.ranked()
}

/// Why a driver has no such variant.
const NO_HALF: &str = "only the evaluator rounds floats to f16";

/// A variant's text without its ending, and what that says its floats are rounded to.
fn rounded(text: &str) -> (&str, Floats) {
    let endings = [(":half", Floats::Half), (":mediump", Floats::Mediump)];
    let found = endings.iter().find_map(|(e, floats)| Some((text.strip_suffix(e)?, *floats)));
    found.unwrap_or((text, Floats::AsWritten))
}

/// Who runs what is compiled into this program.
fn rust() -> Runner {
    let device =
        format!("this program, {} {}, one thread", std::env::consts::OS, std::env::consts::ARCH);
    Runner { reader: "rust".to_string(), device, clock: Clock::Processor }
}

fn wrong(variant: &str, what: impl Into<String>) -> Error {
    Error::new(format!("--variant {variant}"), what)
}
