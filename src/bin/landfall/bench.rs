//! `landfall bench`: measures time and error of variants on backends.

mod function;
mod scene;

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use landfall::report::bench as print;
use landfall_accuracy::bench::clock::Clock;
use landfall_accuracy::bench::shader::SharedBackend;
use landfall_accuracy::bench::{
    Bench, BenchRow, Errors, Failed, Machine, Permitted, Rounds, Runner, SampledInputs, Size, Unit,
    Work, Workload, WorstCall, drawing, measure,
};
use landfall_accuracy::plot::scatter;
use landfall_interp::Floats;
use landfall_layout::file::FileWriter;
use landfall_layout::source::{Files, Target};
use landfall_layout::{Error, Options, Source};

use crate::args::{BackendName, BenchArgs, BenchFormat, ReadArgs};
use crate::output::{CommandFailure, FindingForm, FindingStyle, Outcome, Streams};
use crate::{backends, read, shader, watch, without_effect, write};

pub fn run(args: &BenchArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    let style = streams.style(FindingForm::json_if(args.format == BenchFormat::Json));
    let done = match &args.function {
        Some(name) => function::bench(args, name, streams, &style),
        None => scene::bench(args, streams, &style),
    };
    let FinishedBench { bench, missing, files } = done.map_err(|failure| style.request(failure))?;
    files.iter().for_each(without_effect::record);
    // Files first: a plot that cannot be written must not follow a printed result.
    if let (Some(path), false) = (&args.plot, bench.rows.is_empty()) {
        inputs(args, files).write(path, scatter(&drawing(&bench)))?;
    }
    match args.format {
        BenchFormat::Human => streams.product(&print::text(&bench, args.details, streams.paint))?,
        BenchFormat::Json => streams.json(&print::json(&bench))?,
        BenchFormat::Csv => streams.product(&print::csv(&bench))?,
    }
    // CSV has no place for failures, so they go to standard error.
    if args.format == BenchFormat::Csv {
        for Failed { variant, backend, reason } in &bench.failed {
            streams.notes(&format!("note: {variant} on {backend}: {reason}\n"));
        }
    }
    // A requested backend is missing.
    let absent = missing.iter().any(|name| args.backend.contains(name));
    Ok(if absent || bench.rows.is_empty() { Outcome::CouldNot } else { Outcome::Clean })
}

/// A writer that does not overwrite inputs.
fn inputs(args: &BenchArgs, files: Vec<Files>) -> FileWriter {
    let of_function = [args.domain.as_deref(), args.data.as_deref()].into_iter().flatten();
    let named = of_function.chain(args.bind.iter().map(String::as_str)).map(Path::new);
    write::protecting(named.chain([args.subject.as_path()]), &files)
}

/// A finished bench, and the requested backends that are missing.
struct FinishedBench {
    bench: Bench,
    missing: Vec<BackendName>,
    files: Vec<Files>,
}

/// A variant on a backend to measure, with its errors and work.
struct BenchEntry<'a> {
    variant: String,
    runner: Runner,
    workload: Box<dyn Workload + 'a>,
    errors: Errors,
    /// Of a function, at ends of the ranges of its inputs.
    ends: Option<Errors>,
    worst: Vec<WorstCall>,
    permitted: Option<Permitted>,
    work: Work,
}

/// The entries to measure, and the failures.
#[derive(Default)]
struct Entries<'a> {
    measured: Vec<BenchEntry<'a>>,
    failed: Vec<Failed>,
    missing: Vec<BackendName>,
}

impl Entries<'_> {
    /// Opens a backend shared by entries; on failure, records it for `all`.
    fn open(&mut self, args: &BenchArgs, name: BackendName, all: &str) -> Option<SharedBackend> {
        match backends::timed(name, args.adapter.as_deref()) {
            Ok(opened) => Some(Rc::new(RefCell::new(opened))),
            Err(failure) => {
                self.missing.push(name);
                self.fail(all, name.name(), failure.summary());
                None
            }
        }
    }

    fn fail(&mut self, variant: &str, backend: &str, reason: impl Into<String>) {
        let (variant, backend) = (variant.to_string(), backend.to_string());
        self.failed.push(Failed { variant, backend, reason: reason.into() });
    }
}

struct About {
    subject: String,
    truth: String,
    unit: Unit,
    size: Size,
    /// The samples of a function's inputs.
    inputs: Option<SampledInputs>,
    /// The API assumed for the shader of each variant that names none.
    assumed: Vec<(String, Target)>,
    files: Vec<Files>,
}

/// Records the shaders of variants, each once; returns the APIs assumed, by variant.
fn recorded<'s>(
    shaders: impl Iterator<Item = (&'s str, &'s Source)>,
    options: &Options,
    streams: &Streams,
    style: FindingStyle,
) -> Vec<(String, Target)> {
    // Two variants may be of one file, whose findings are printed once.
    let mut known: Vec<(&str, Option<Target>)> = Vec::new();
    let mut assumed = Vec::new();
    for (variant, source) in shaders {
        let path = source.path.as_str();
        let target = match known.iter().find(|(other, _)| *other == path) {
            Some((_, target)) => *target,
            None => {
                let target = shader::record_function(source, options, streams, style);
                known.push((path, target));
                target
            }
        };
        assumed.extend(target.map(|target| (variant.to_string(), target)));
    }
    assumed
}

fn print_notes<'n>(notes: impl Iterator<Item = &'n str>, streams: &Streams) {
    let mut printed: Vec<&str> = Vec::new();
    for note in notes {
        if !printed.contains(&note) {
            streams.notes(&format!("note: {note}\n"));
            printed.push(note);
        }
    }
}

/// Measures the entries in interleaved rounds and ranks them.
fn measured(
    about: About,
    entries: Entries<'_>,
    args: &BenchArgs,
    streams: &Streams,
) -> FinishedBench {
    let Entries { measured: mut entries, mut failed, missing } = entries;
    let machine = Machine::here();
    let rounds = Rounds { count: args.rounds, ..Rounds::default() };
    let shows = streams.shows_progress_first();
    let mut samples = Vec::new();
    // One backend after the other: times are compared within a backend only, and interleaving would
    // let one backend evict the caches of another.
    for group in entries.chunk_by_mut(|a, b| a.runner.backend == b.runner.backend) {
        let backend = group[0].runner.backend.clone();
        let mut progress = |done: u32| {
            if shows {
                streams.progress(&format!("{backend}: round {done} of {}", args.rounds));
            }
        };
        let mut workloads: Vec<&mut dyn Workload> =
            group.iter_mut().map(|entry| &mut *entry.workload as &mut dyn Workload).collect();
        samples.extend(measure(&mut workloads, &rounds, &watch::is_stopped, &mut progress));
    }
    let mut rows = Vec::new();
    for (entry, samples) in entries.into_iter().zip(samples) {
        let BenchEntry { variant, runner, errors, ends, worst, permitted, work, .. } = entry;
        // A workload that failed during the rounds has a reason instead of samples.
        match samples {
            Ok(samples) => {
                let of_variant = about.assumed.iter().find(|(name, _)| *name == variant);
                let assumed_target = of_variant.map(|(_, target)| *target);
                let row = BenchRow::new(variant, runner, &samples, about.size, errors, work);
                rows.extend(row.map(|row| BenchRow {
                    ends,
                    worst,
                    permitted,
                    assumed_target,
                    ..row
                }));
            }
            Err(reason) => failed.push(Failed { variant, backend: runner.backend, reason }),
        }
    }
    let About { subject, truth, unit, size, inputs, files, .. } = about;
    let Size { fragments, lights } = size;
    // The load average after the rounds, beside that before them.
    let machine = machine.after();
    let bench = Bench { subject, truth, unit, fragments, lights, inputs, machine, rows, failed };
    FinishedBench { bench: bench.ranked(), missing, files }
}

/// The reason that drivers have no rounded variants.
const NO_HALF: &str = "only backend cpu rounds floats to f16";

/// Splits a variant into its text and the precision of its suffix.
fn rounded(text: &str) -> (&str, Floats) {
    let endings = [(":half", Floats::Half), (":mediump", Floats::Mediump)];
    let found = endings.iter().find_map(|(e, floats)| Some((text.strip_suffix(e)?, *floats)));
    found.unwrap_or((text, Floats::AsWritten))
}

fn rust() -> Runner {
    let device =
        format!("this program, {} {}, one thread", std::env::consts::OS, std::env::consts::ARCH);
    Runner { backend: "rust".to_string(), device, clock: Clock::Processor }
}

/// Fails if names of an option repeat, or equal `taken`.
fn distinct(option: &str, given: &[(String, String)], taken: Option<&str>) -> Result<(), Error> {
    for (nth, (name, what)) in given.iter().enumerate() {
        // A name must tell rows apart, in tables and in `--model-of`.
        let about = || format!("{option} {name}={what}");
        if taken == Some(name) {
            return Err(Error::new(about(), "is the name of the original function")
                .with_help("choose another name"));
        }
        if let Some((_, other)) = given[..nth].iter().find(|(other, _)| other == name) {
            return Err(Error::new(
                about(),
                format!("repeats the name of `{option} {name}={other}`"),
            )
            .with_help("give each a distinct name"));
        }
    }
    Ok(())
}

/// Shaders by their files, each read once, since stdin cannot be read again.
#[derive(Default)]
struct ShaderSources(Vec<(PathBuf, Source)>);

impl ShaderSources {
    fn of(&self, file: &Path) -> Option<&Source> {
        self.0.iter().find(|(known, _)| known == file).map(|(_, source)| source)
    }

    fn all(&self) -> impl Iterator<Item = &Source> {
        self.0.iter().map(|(_, source)| source)
    }

    fn read(&mut self, file: &Path, args: &ReadArgs) -> Result<Source, Error> {
        if let Some(source) = self.of(file) {
            return Ok(source.clone());
        }
        let source = read::shader_text(file, args)?;
        self.0.push((file.to_path_buf(), source.clone()));
        Ok(source)
    }
}

fn wrong(variant: &str, what: impl Into<String>) -> Error {
    Error::new(format!("--variant {variant}"), what)
}
