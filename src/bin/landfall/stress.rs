//! `landfall stress`: where a function breaks, how wrong it gets, and why.

use landfall_layout::diagnostic::Code;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use landfall::report::stress as print;
use landfall_exec::backend::Reader;
use landfall_exec::harness::call::pure::PureRequest;
use landfall_exec::interp::Floats;
use landfall_layout::file::FileWriter;
use landfall_layout::source::Files;
use landfall_layout::{Diagnostic, Error, Options, Source};
use landfall_light::accuracy::stress::{MapRequest, ReaderReport, Request, error_map, stress};

use crate::args::{ReaderName, StressArgs, StressFormat};
use crate::output::{Failure, FindingForm, Outcome, Streams, asked_wrongly};
use crate::run::textures;
use crate::{data, given, interrupt, read, readers, write};

pub fn run(args: &StressArgs, streams: &Streams) -> Result<Outcome, Failure> {
    let form = match args.format {
        StressFormat::Human => FindingForm::Human,
        StressFormat::Json | StressFormat::Sarif => FindingForm::Json,
    };
    let style = streams.style(form);
    let made = (|| Ok((read::source(&args.file, &args.read)?, request(args)?)))();
    let (source, mut request) = match made {
        Ok(made) => made,
        Err(error) => {
            streams.report(&style.text(&[asked_wrongly(error)], &Files::default()));
            return Ok(Outcome::CouldNot);
        }
    };
    let began = Instant::now();
    let stop = interrupt::watched();
    request.stop = Arc::clone(&stop);
    let shows = streams.shows_progress_first();
    let shown = Mutex::new(Instant::now());
    let all = request.samples;
    let progress = |samples: u64| {
        if shows {
            if let Ok(mut last) = shown.try_lock() {
                if last.elapsed().as_millis() > 200 {
                    *last = Instant::now();
                    let seconds = began.elapsed().as_secs_f64();
                    eprint!("\r{samples} of {all} samples, {seconds:.1} s\x1b[K");
                }
            }
        }
    };
    let options = read::options(&args.read);
    given::saw(&write::files_of(&source, &options));
    let (mut readers, missing) = open(args);
    let stressed = stress(&source, &options, &request, &mut readers, &progress);
    if shows {
        eprint!("\r\x1b[K");
    }
    let mut report = match stressed {
        Ok(report) => report,
        Err(refusal) => {
            streams.report(&style.text(&refusal.found, &refusal.files));
            return Ok(Outcome::CouldNot);
        }
    };
    let absent = !missing.is_empty();
    report.readers.extend(missing);
    let is_stopped = || stop.load(Ordering::Relaxed);
    if let (Some(file), Some(x), Some(y), false) =
        (&args.map, &args.map_x, &args.map_y, is_stopped())
    {
        let map = MapRequest { x: x.clone(), y: y.clone(), ..MapRequest::default() };
        match error_map(&source, &options, &request, &report, &map) {
            Ok(svg) => {
                let html = file.extension().is_some_and(|e| e == "html" || e == "htm");
                let text = if html { print::page(&report, &svg) } else { svg };
                inputs(args, &source, &options, &request).write(file, text.as_bytes())?;
            }
            Err(refusal) => {
                streams.report(&style.text(&refusal.found, &refusal.files));
                return Ok(Outcome::CouldNot);
            }
        }
    }
    match args.format {
        StressFormat::Human => streams.product(&print::text(&report, streams.paint))?,
        StressFormat::Json => streams.json(&print::json(&report))?,
        StressFormat::Sarif => streams.json(&print::sarif(&report))?,
    }
    for reader in &report.readers {
        let Some(why) = &reader.failure else { continue };
        let what = if reader.ran() { "stopped" } else { "did not run" };
        let found = Error::new(reader.reader.name(), format!("{what}: {why}"));
        let found = match reader.device {
            Some(_) => found,
            None => found.with_help("`landfall devices` lists what is here"),
        };
        let found = Diagnostic { code: Code::CannotRun, ..found.into() };
        streams.report(&style.text(&[found], &Files::default()));
    }
    if is_stopped() {
        return Ok(Outcome::Interrupted);
    }
    // Somebody asked for numbers that are not there.
    let none_ran = !report.readers.is_empty() && !report.readers.iter().any(ReaderReport::ran);
    if absent || none_ran {
        return Ok(Outcome::CouldNot);
    }
    let past = |most: Option<f64>, is: f64| most.is_some_and(|most| is > most);
    let too_far = past(args.max_ulp, report.max_ulp()) || past(args.max_step, report.max_steps());
    let denied = report.findings.iter().any(|f| f.level == landfall_layout::finding::Level::Deny);
    Ok(match too_far || denied || report.has_non_finite() {
        true => Outcome::Findings,
        false => Outcome::Clean,
    })
}

/// A writer that leaves all that is read alone.
fn inputs(args: &StressArgs, source: &Source, options: &Options, request: &Request) -> FileWriter {
    let against = args.against.as_deref().map(|text| text.split('#').next().unwrap_or(text));
    let named = [args.domain.as_deref(), args.data.as_deref(), against];
    let named = named.into_iter().flatten().map(Path::new).chain([args.file.as_path()]);
    let sources = request.against.iter().map(|(source, _)| source).chain([source]);
    let files: Vec<_> = sources.map(|source| write::files_of(source, options)).collect();
    write::protecting(named, &files)
}

/// The drivers that are asked for, and those of them that are not here.
fn open(args: &StressArgs) -> (Vec<Box<dyn Reader>>, Vec<ReaderReport>) {
    let (mut here, mut missing) = (Vec::new(), Vec::new());
    for name in ReaderName::ALL {
        // The evaluator runs in any case.
        if name == ReaderName::Cpu || !args.readers.contains(&name) {
            continue;
        }
        match readers::one(name, args.adapter.as_deref()) {
            Ok(reader) => here.push(reader),
            Err(failure) => missing.push(ReaderReport::missing(name.kind(), &failure)),
        }
    }
    (here, missing)
}

fn request(args: &StressArgs) -> Result<Request, Error> {
    let domain = match &args.domain {
        None => None,
        Some(text) => Some(data::file_or_value("--domain", text)?),
    };
    let pure = PureRequest {
        function: args.function.clone(),
        data: data::blocks(args.data.as_deref())?,
        textures: textures(&args.textures)?,
        floats: args.floats.floats(),
    };
    let against = match &args.against {
        None => None,
        Some(text) => {
            let (file, name) = match text.split_once('#') {
                Some((file, name)) => (file, name.to_string()),
                None => (text.as_str(), args.function.clone()),
            };
            let source = read::source(Path::new(file), &args.read)?;
            let other = PureRequest { function: name, floats: Floats::AsWritten, ..pure.clone() };
            Some((source, other))
        }
    };
    let half = Request::default().steps;
    Ok(Request {
        pure,
        against,
        domain,
        seed: args.seed,
        samples: args.samples.get(),
        time: Some(args.time),
        threads: args.jobs.map_or(0, usize::from),
        steps: args.max_step.map_or(half, |most| most.min(half)),
        ulp: args.max_ulp,
        ..Request::default()
    })
}
