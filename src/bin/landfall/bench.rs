//! `landfall bench`: variants on readers, time against error.

mod function;
mod scene;

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use landfall::report::bench as print;
use landfall_exec::interp::Floats;
use landfall_layout::file::FileWriter;
use landfall_layout::source::Files;
use landfall_layout::{Error, Source};
use landfall_light::accuracy::bench::clock::Clock;
use landfall_light::accuracy::bench::shader::Shared;
use landfall_light::accuracy::bench::{
    Bench, BenchRow, Errors, Failed, Machine, Permitted, Rounds, Runner, Size, Unit, Work,
    Workload, drawing, measure,
};
use landfall_light::accuracy::plot::scatter;

use crate::args::{BenchArgs, BenchFormat, ReadArgs, ReaderName};
use crate::output::{Failure, FindingForm, Outcome, Streams, asked_wrongly};
use crate::{given, read, readers, write};

pub fn run(args: &BenchArgs, streams: &Streams) -> Result<Outcome, Failure> {
    let style = streams.style(match args.format {
        BenchFormat::Human | BenchFormat::Csv => FindingForm::Human,
        BenchFormat::Json => FindingForm::Json,
    });
    let done = match &args.function {
        Some(name) => function::bench(args, name, streams, &style),
        None => scene::bench(args, streams, &style),
    };
    let Done { bench, missing, files } = match done {
        Ok(Some(done)) => done,
        Ok(None) => return Ok(Outcome::CouldNot),
        Err(Failure::Error(error)) => {
            streams.report(&style.text(&[asked_wrongly(error)], &Files::default()));
            return Ok(Outcome::CouldNot);
        }
        Err(Failure::BrokenPipe) => return Err(Failure::BrokenPipe),
    };
    files.iter().for_each(given::saw);
    if let (Some(path), false) = (&args.plot, bench.rows.is_empty()) {
        inputs(args, files).write(path, scatter(&drawing(&bench)))?;
    }
    match args.format {
        BenchFormat::Human => streams.product(&print::text(&bench, streams.paint))?,
        BenchFormat::Json => streams.json(&print::json(&bench))?,
        BenchFormat::Csv => streams.product(&print::csv(&bench))?,
    }
    if args.format == BenchFormat::Csv {
        for Failed { variant, reader, reason } in &bench.failed {
            streams.notes(&format!("note: {variant} on {reader}: {reason}\n"));
        }
    }
    // Somebody asked for numbers that are not there.
    let absent = missing.iter().any(|name| args.reader.contains(name));
    Ok(if absent || bench.rows.is_empty() { Outcome::CouldNot } else { Outcome::Clean })
}

/// A writer that leaves all that was read alone.
fn inputs(args: &BenchArgs, files: Vec<Files>) -> FileWriter {
    let named = [args.domain.as_deref(), args.data.as_deref()];
    let named = named.into_iter().flatten().chain(args.bind.iter().map(String::as_str));
    let named = named.map(Path::new).chain([args.subject.as_path()]);
    write::protecting(named, &files)
}

/// A bench, and the readers it should have been on that could not be had.
struct Done {
    bench: Bench,
    missing: Vec<ReaderName>,
    /// What was read.
    files: Vec<Files>,
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
    missing: Vec<ReaderName>,
}

impl Entries<'_> {
    /// Opens a reader that takes turns; where that fails, `all` fail on it.
    fn open(&mut self, args: &BenchArgs, name: ReaderName, all: &str) -> Option<Shared> {
        match readers::timed(name, args.adapter.as_deref()) {
            Ok(opened) => Some(Rc::new(RefCell::new(opened))),
            Err(failure) => {
                self.missing.push(name);
                self.fail(all, name.name(), failure.brief());
                None
            }
        }
    }

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
    /// What was read.
    files: Vec<Files>,
}

/// Measures in turns and ranks.
fn measured(about: About, entries: Entries<'_>, args: &BenchArgs, streams: &Streams) -> Done {
    let Entries { measured: mut entries, mut failed, missing } = entries;
    let machine = Machine::here();
    let rounds = Rounds { count: args.rounds, ..Rounds::default() };
    let shows = streams.shows_progress_first();
    let mut samples = Vec::new();
    // One reader after the other: nobody is compared with another's, and who would run behind
    // another reader would pay for what that left in the caches.
    for group in entries.chunk_by_mut(|a, b| a.runner.reader == b.runner.reader) {
        let reader = group[0].runner.reader.clone();
        let mut progress = |done: u32| {
            if shows {
                streams.progress(&format!("{reader}: round {done} of {}", args.rounds));
            }
        };
        let mut workloads: Vec<&mut dyn Workload> =
            group.iter_mut().map(|entry| &mut *entry.workload as &mut dyn Workload).collect();
        samples.extend(measure(&mut workloads, &rounds, &mut progress));
    }
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
    let About { subject, truth, unit, size: Size { fragments, lights }, files } = about;
    let machine = machine.after();
    let bench = Bench { subject, truth, unit, fragments, lights, machine, rows, failed };
    Done { bench: bench.ranked(), missing, files }
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

/// Whether every one of the names that an option gives is another, and none is taken already.
fn distinct(option: &str, given: &[(String, String)], taken: Option<&str>) -> Result<(), Error> {
    for (nth, (name, what)) in given.iter().enumerate() {
        let about = || format!("{option} {name}={what}");
        if taken == Some(name) {
            return Err(Error::new(about(), "has the name of the function as it is written")
                .with_help("give it another name"));
        }
        if let Some((_, other)) = given[..nth].iter().find(|(other, _)| other == name) {
            return Err(Error::new(about(), format!("has the name of `{option} {name}={other}`"))
                .with_help("give each a name of its own"));
        }
    }
    Ok(())
}

/// Shaders by their files, each read once: of stdin there is nothing left to read again.
#[derive(Default)]
struct Sources(Vec<(PathBuf, Source)>);

impl Sources {
    fn all(&self) -> impl Iterator<Item = &Source> {
        self.0.iter().map(|(_, source)| source)
    }

    fn read(&mut self, file: &Path, args: &ReadArgs) -> Result<Source, Error> {
        if let Some((_, source)) = self.0.iter().find(|(known, _)| known == file) {
            return Ok(source.clone());
        }
        let source = read::source(file, args)?;
        self.0.push((file.to_path_buf(), source.clone()));
        Ok(source)
    }
}

fn wrong(variant: &str, what: impl Into<String>) -> Error {
    Error::new(format!("--variant {variant}"), what)
}
