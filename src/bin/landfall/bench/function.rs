//! Benches variants of a function with inputs drawn from its domain.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::rc::Rc;

use landfall_accuracy::bench::called::{CallErrors, InterpreterVariant, Variant};
use landfall_accuracy::bench::clock::Clock;
use landfall_accuracy::bench::driver_calls::DriverVariant;
use landfall_accuracy::bench::function::{Calls, Sampling};
use landfall_accuracy::bench::{Permitted, Runner, Size, Unit, Work};
use landfall_exec::backend::Backend;
use landfall_exec::harness::call::Refusal;
use landfall_exec::harness::call::pure::{PureFunction, PureRequest};
use landfall_interp::{Cpu, Floats};
use landfall_layout::source::Source;
use landfall_layout::{Error, Options};

use super::{
    About, BenchEntry, Entries, FinishedBench, NO_HALF, ShaderSources, distinct, measured,
    print_notes, recorded, rounded, wrong,
};
use crate::args::{BackendName, BenchArgs};
use crate::output::{CommandFailure, FindingStyle, Streams};
use crate::{backends, data, read, write};

/// The variant name of the function itself.
const FIRST: &str = "as it is";

/// A parsed variant `FILE#NAME:half`, of which any part may be missing.
#[derive(Debug, PartialEq)]
struct VariantSpec {
    file: PathBuf,
    function: String,
    floats: Floats,
}

struct CompiledVariant {
    name: String,
    floats: Floats,
    source: Source,
    /// Without rounding, for the f64 results.
    exact: PureFunction,
    /// With rounded floats, if requested.
    rounded: Option<PureFunction>,
}

impl CompiledVariant {
    fn pure(&self) -> &PureFunction {
        self.rounded.as_ref().unwrap_or(&self.exact)
    }
}

/// A variant with the data that is independent of backends.
struct PreparedVariant<'a> {
    made: &'a CompiledVariant,
    variant: Variant<'a>,
    /// Errors and work on the interpreter, or the reason for its failure.
    evaluated: Result<(CallErrors, Work), String>,
    permitted: Option<Permitted>,
}

pub fn bench(
    args: &BenchArgs,
    name: &str,
    streams: &Streams,
    style: &FindingStyle,
) -> Result<FinishedBench, CommandFailure> {
    // The stages: parse the variants, lower each, draw inputs and truths, evaluate every variant
    // once on the interpreter, then measure on each backend.
    distinct("--variant", &args.variants, Some(FIRST))?;
    let variants = variants(args, name);
    let truth = match &args.truth {
        None => None,
        Some(truth) => {
            let named = variants.iter().position(|(name, _)| name == truth);
            Some(named.ok_or_else(|| {
                let names: Vec<String> =
                    variants.iter().map(|(name, _)| format!("`{name}`")).collect();
                Error::new(format!("--truth {truth}"), "is not a variant")
                    .with_help(format!("the variants are {}", names.join(", ")))
            })?)
        }
    };
    let request = PureRequest {
        data: data::blocks(args.data.as_deref())?,
        textures: data::textures(&args.textures)?,
        ..PureRequest::default()
    };
    let refused = |refusal: Box<Refusal>| style.failure(&refusal.found, &refusal.files);
    let options = read::options(&args.read);
    let (mut made, mut sources) = (Vec::new(), ShaderSources::default());
    for (name, what) in variants {
        let source = sources.read(&what.file, &args.read)?;
        made.push(make(name, what, source, &options, &request).map_err(refused)?);
    }
    let shaders = made.iter().map(|one| (one.name.as_str(), &one.source));
    let assumed = recorded(shaders, &options, streams, *style);
    notes(&made, streams);
    let sampling = Sampling {
        domain: data::domain(args.domain.as_deref())?,
        seed: args.seed,
        samples: args.samples.map(NonZeroUsize::get),
        limit: args.limit,
    };
    let first = &made[0];
    let all: Vec<&PureFunction> = made.iter().map(|one| &one.exact).collect();
    let calls = Calls::new(&first.source, &all, truth, &sampling).map_err(refused)?;
    // Errors on the interpreter and permitted errors do not depend on the backend.
    let mut variants = Vec::new();
    for one in &made {
        let variant = Variant::new(&calls, &first.exact, one.pure());
        let variant =
            variant.map_err(|reason| wrong(&one.name, format!("does not fit: {reason}")))?;
        variants.push(PreparedVariant {
            made: one,
            evaluated: variant.measure_errors(),
            permitted: variant.permitted(one.floats),
            variant,
        });
    }
    let mut entries = Entries::default();
    for backend in backends::requested(&args.backend) {
        match backend {
            BackendName::Cpu => on_interpreter(&variants, &mut entries),
            BackendName::Gl | BackendName::Gpu => on_driver(args, backend, &variants, &mut entries),
        }
    }
    let whose = match (calls.truth(), truth) {
        (0, _) => "the function's own f64".to_string(),
        (form, Some(_)) => format!("the f64 of {}", made[form].name),
        (form, None) => format!("the f64 of {}, the most accurate form", made[form].name),
    };
    let about = About {
        subject: format!("{name} of {}, inputs of seed {}", args.subject.display(), args.seed),
        truth: whose,
        unit: Unit::Call,
        size: Size { fragments: calls.count() as u64, lights: 0 },
        inputs: Some(calls.sampled()),
        assumed,
        files: made.iter().map(|one| write::files_of(&one.source, &options)).collect(),
    };
    Ok(measured(about, entries, args, streams))
}

/// The variants by name; the first one is the function itself.
fn variants(args: &BenchArgs, name: &str) -> Vec<(String, VariantSpec)> {
    let one = |text: &str| what(text, args, name);
    let first = (FIRST.to_string(), one(""));
    let others = args.variants.iter().map(|(name, text)| (name.clone(), one(text)));
    std::iter::once(first).chain(others).collect()
}

// variant = [FILE] ["#" NAME] [":half" | ":mediump"]; what is missing is that of the subject.
fn what(text: &str, args: &BenchArgs, name: &str) -> VariantSpec {
    let (text, floats) = rounded(text);
    let (file, function) = match text.split_once('#') {
        Some((file, function)) => (file, function),
        None => (text, name),
    };
    let file = if file.is_empty() { args.subject.clone() } else { PathBuf::from(file) };
    VariantSpec { file, function: function.to_string(), floats }
}

fn make(
    name: String,
    what: VariantSpec,
    source: Source,
    options: &Options,
    request: &PureRequest,
) -> Result<CompiledVariant, Box<Refusal>> {
    let VariantSpec { function, floats, .. } = what;
    let request = PureRequest { function, ..request.clone() };
    let exact = PureFunction::new(&source, options, &request)?;
    let rounded = match floats {
        Floats::AsWritten => None,
        Floats::Half | Floats::Mediump => {
            Some(PureFunction::new(&source, options, &PureRequest { floats, ..request })?)
        }
    };
    Ok(CompiledVariant { name, floats, source, exact, rounded })
}

/// Notes the assumed inputs, without duplicates.
fn notes(made: &[CompiledVariant], streams: &Streams) {
    let own = made.iter().flat_map(|one| one.exact.notes.iter().map(String::as_str));
    print_notes(own.chain(made.iter().filter_map(|one| one.floats.note())), streams);
}

/// Adds the variants on a driver, which they share.
fn on_driver<'a>(
    args: &BenchArgs,
    name: BackendName,
    variants: &'a [PreparedVariant<'a>],
    entries: &mut Entries<'a>,
) {
    let Some(shared) = entries.open(args, name, "every function") else { return };
    let runner = Runner::new(shared.borrow().device(), Clock::Processor);
    for PreparedVariant { made, variant, evaluated, permitted } in variants {
        // Drivers have no switch that rounds every operation to 16 bits.
        if made.floats != Floats::AsWritten {
            entries.fail(&made.name, name.name(), NO_HALF);
            continue;
        }
        let ran = DriverVariant::new(variant, Rc::clone(&shared))
            .map_err(|failure| failure.summary())
            .and_then(|driven| Ok((driven.measure_errors()?, driven)));
        match ran {
            Ok((errors, driven)) => entries.measured.push(BenchEntry {
                variant: made.name.clone(),
                runner: runner.clone(),
                workload: Box::new(driven),
                errors: errors.drawn,
                ends: errors.ends,
                worst: errors.worst,
                permitted: *permitted,
                // Counted on the interpreter for every backend.
                work: evaluated.as_ref().map(|(_, work)| *work).unwrap_or_default(),
            }),
            Err(reason) => entries.fail(&made.name, name.name(), reason),
        }
    }
}

fn on_interpreter<'a>(variants: &'a [PreparedVariant<'a>], entries: &mut Entries<'a>) {
    let runner = Runner::new(Cpu::default().device(), Clock::Processor);
    for PreparedVariant { made, variant, evaluated, permitted } in variants {
        match evaluated {
            Ok((errors, work)) => entries.measured.push(BenchEntry {
                variant: made.name.clone(),
                runner: runner.clone(),
                workload: Box::new(InterpreterVariant::new(variant)),
                errors: errors.drawn,
                ends: errors.ends,
                worst: errors.worst.clone(),
                permitted: *permitted,
                work: *work,
            }),
            Err(reason) => entries.fail(&made.name, "cpu", reason.as_str()),
        }
    }
}
