//! Variants of one function, called with values like those of scenes.

use std::path::PathBuf;
use std::rc::Rc;

use landfall_exec::backend::Reader;
use landfall_exec::harness::call::Refusal;
use landfall_exec::harness::call::pure::{Pure, PureRequest};
use landfall_exec::interp::{Cpu, Floats};
use landfall_layout::source::Source;
use landfall_layout::{Error, Options};
use landfall_light::accuracy::bench::called::{Called, Variant};
use landfall_light::accuracy::bench::clock::Clock;
use landfall_light::accuracy::bench::driven::OnDriver;
use landfall_light::accuracy::bench::function::{Calls, Sampling};
use landfall_light::accuracy::bench::{Errors, Permitted, Runner, Size, Unit, Work};

use super::{About, Done, Entries, Entry, NO_HALF, Sources, distinct, measured, rounded, wrong};
use crate::args::{BenchArgs, ReaderName};
use crate::output::{Failure, FindingStyle, Streams};
use crate::run::textures;
use crate::{data, read, readers, write};

/// The name of the function the bench is of.
const FIRST: &str = "as it is";

/// A variant as it is asked for: `FILE#NAME:half`, any of which may be missing.
#[derive(Debug, PartialEq)]
struct What {
    file: PathBuf,
    function: String,
    floats: Floats,
}

/// A variant that can be called.
struct Made {
    name: String,
    floats: Floats,
    source: Source,
    /// As it is written, whatever its floats are rounded to: what truth is made of.
    exact: Pure,
    /// With its floats rounded, if they are.
    rounded: Option<Pure>,
}

impl Made {
    fn pure(&self) -> &Pure {
        self.rounded.as_ref().unwrap_or(&self.exact)
    }
}

/// A variant with what is known of it whoever calls it.
struct Known<'a> {
    made: &'a Made,
    variant: Variant<'a>,
    /// Errors and work of the evaluator, or why it gives nothing.
    evaluated: Result<(Errors, Work), String>,
    permitted: Option<Permitted>,
}

pub fn bench(
    args: &BenchArgs,
    name: &str,
    streams: &Streams,
    style: &FindingStyle,
) -> Result<Option<Done>, Failure> {
    distinct("--variant", &args.variants, Some(FIRST))?;
    let asked = asked(args, name);
    let truth = match &args.truth {
        None => 0,
        Some(truth) => asked.iter().position(|(name, _)| name == truth).ok_or_else(|| {
            let names: Vec<String> = asked.iter().map(|(name, _)| format!("`{name}`")).collect();
            Error::new(format!("--truth {truth}"), "is no variant")
                .with_help(format!("there are {}", names.join(", ")))
        })?,
    };
    let request = PureRequest {
        data: data::blocks(args.data.as_deref())?,
        textures: textures(&args.textures)?,
        ..PureRequest::default()
    };
    let options = read::options(&args.read);
    let (mut made, mut sources) = (Vec::new(), Sources::default());
    for (name, what) in asked {
        let source = sources.read(&what.file, &args.read)?;
        match make(name, what, source, &options, &request) {
            Ok(one) => made.push(one),
            Err(refusal) => return refused(&refusal, style, streams),
        }
    }
    notes(&made, streams);
    let domain = args.domain.as_deref().map(|text| data::file_or_value("--domain", text));
    let sampling = Sampling {
        domain: domain.transpose()?,
        seed: args.seed,
        calls: args.samples.get(),
        limit: args.limit,
    };
    let (first, exact) = (&made[0], &made[truth].exact);
    let all: Vec<&Pure> = made.iter().map(|one| &one.exact).collect();
    let calls = match Calls::new(&first.source, &first.exact, &all, exact, &sampling) {
        Ok(calls) => calls,
        Err(refusal) => return refused(&refusal, style, streams),
    };
    let mut variants = Vec::new();
    for one in &made {
        let variant = Variant::new(&calls, &first.exact, one.pure());
        let variant =
            variant.map_err(|reason| wrong(&one.name, format!("does not fit: {reason}")))?;
        variants.push(Known {
            made: one,
            evaluated: variant.judged(),
            permitted: variant.permitted(one.floats),
            variant,
        });
    }
    let mut entries = Entries::default();
    for reader in readers::asked(&args.reader) {
        match reader {
            ReaderName::Cpu => on_evaluator(&variants, &mut entries),
            ReaderName::Gl | ReaderName::Gpu => on_driver(args, reader, &variants, &mut entries),
        }
    }
    let whose = match truth {
        0 => "the function's own f64".to_string(),
        _ => format!("the f64 of {}", made[truth].name),
    };
    let about = About {
        subject: format!("{name} of {}, inputs of seed {}", args.subject.display(), args.seed),
        truth: whose,
        unit: Unit::Call,
        size: Size { fragments: calls.count() as u64, lights: 0 },
        files: made.iter().map(|one| write::files_of(&one.source, &options)).collect(),
    };
    Ok(Some(measured(about, entries, args, streams)))
}

/// The variants and their names, the first of which is the function itself.
fn asked(args: &BenchArgs, name: &str) -> Vec<(String, What)> {
    let one = |text: &str| what(text, args, name);
    let first = (FIRST.to_string(), one(""));
    let others = args.variants.iter().map(|(name, text)| (name.clone(), one(text)));
    std::iter::once(first).chain(others).collect()
}

fn what(text: &str, args: &BenchArgs, name: &str) -> What {
    let (text, floats) = rounded(text);
    let (file, function) = match text.split_once('#') {
        Some((file, function)) => (file, function),
        None => (text, name),
    };
    let file = if file.is_empty() { args.subject.clone() } else { PathBuf::from(file) };
    What { file, function: function.to_string(), floats }
}

fn make(
    name: String,
    what: What,
    source: Source,
    options: &Options,
    request: &PureRequest,
) -> Result<Made, Box<Refusal>> {
    let What { function, floats, .. } = what;
    let request = PureRequest { function, ..request.clone() };
    let exact = Pure::new(&source, options, &request)?;
    let rounded = match floats {
        Floats::AsWritten => None,
        Floats::Half | Floats::Mediump => {
            Some(Pure::new(&source, options, &PureRequest { floats, ..request })?)
        }
    };
    Ok(Made { name, floats, source, exact, rounded })
}

fn refused(
    refusal: &Refusal,
    style: &FindingStyle,
    streams: &Streams,
) -> Result<Option<Done>, Failure> {
    streams.report(&style.text(&refusal.found, &refusal.files));
    Ok(None)
}

/// What was taken for what nobody gave, once each.
fn notes(made: &[Made], streams: &Streams) {
    let mut said: Vec<&String> = Vec::new();
    for note in made.iter().flat_map(|one| &one.exact.notes) {
        if !said.contains(&note) {
            streams.notes(&format!("note: {note}\n"));
            said.push(note);
        }
    }
}

/// The variants by a driver, which they take turns with.
fn on_driver<'a>(
    args: &BenchArgs,
    name: ReaderName,
    variants: &'a [Known<'a>],
    entries: &mut Entries<'a>,
) {
    let Some(shared) = entries.open(args, name, "every function") else { return };
    let runner = Runner::of(shared.borrow().device(), Clock::Processor);
    for Known { made, variant, evaluated, permitted } in variants {
        if made.floats != Floats::AsWritten {
            entries.fail(&made.name, name.name(), NO_HALF);
            continue;
        }
        let ran = OnDriver::new(variant, Rc::clone(&shared))
            .map_err(|failure| failure.brief())
            .and_then(|driven| Ok((driven.judged()?, driven)));
        match ran {
            Ok((errors, driven)) => entries.measured.push(Entry {
                variant: made.name.clone(),
                runner: runner.clone(),
                workload: Box::new(driven),
                errors,
                permitted: *permitted,
                // Counted by the evaluator, whoever is measured.
                work: evaluated.as_ref().map(|(_, work)| *work).unwrap_or_default(),
            }),
            Err(reason) => entries.fail(&made.name, name.name(), reason),
        }
    }
}

/// The variants by the evaluator.
fn on_evaluator<'a>(variants: &'a [Known<'a>], entries: &mut Entries<'a>) {
    let runner = Runner::of(Cpu::default().device(), Clock::Processor);
    for Known { made, variant, evaluated, permitted } in variants {
        match evaluated {
            Ok((errors, work)) => entries.measured.push(Entry {
                variant: made.name.clone(),
                runner: runner.clone(),
                workload: Box::new(Called::new(variant)),
                errors: *errors,
                permitted: *permitted,
                work: *work,
            }),
            Err(reason) => entries.fail(&made.name, "cpu", reason.as_str()),
        }
    }
}
