//! `landfall stress`: searches for inputs at which a function is inaccurate, and the cause.

use landfall_layout::diagnostic::Code;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use landfall::report::prove::Listed;
use landfall::report::stress as print;
use landfall_accuracy::stress::{BackendReport, MapRequest, Report, Request, error_map, stress};
use landfall_exec::backend::Backend;
use landfall_exec::harness::call::Refusal;
use landfall_exec::harness::call::pure::PureRequest;
use landfall_interp::Floats;
use landfall_layout::file::FileWriter;
use landfall_layout::format::Paint;
use landfall_layout::format::phrases::{number, numbered};
use landfall_layout::{Diagnostic, Error, Options, Source};

use crate::args::{BackendName, StressArgs, StressFormat};
use crate::output::{CommandFailure, FindingForm, Outcome, Streams};
use crate::{backends, data, read, shader, watch, write};

pub fn run(args: &StressArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    let style = streams.style(FindingForm::json_if(args.format != StressFormat::Human));
    let source = read::shader_text(&args.function.file, &args.read);
    let source = source.map_err(|error| style.request(error))?;
    let mut request = request(args).map_err(|error| style.request(error))?;
    let began = Instant::now();
    let stop = watch::flag();
    request.stop = Arc::clone(&stop);
    let shows = streams.shows_progress_first();
    let all = numbered(request.samples, "sample");
    let progress = |samples: u64| {
        if shows {
            let seconds = began.elapsed().as_secs_f64();
            streams.progress(&format!("{} of {all}, {seconds:.1} s", number(samples)));
        }
    };
    let options = read::options(&args.read);
    shader::record_function(&source, &options, streams, style);
    let (mut backends, missing) = open(args);
    let refused = |refusal: Box<Refusal>| style.failure(&refusal.found, &refusal.files);
    let stressed = stress(&source, &options, &request, &mut backends, &progress);
    let mut report = stressed.map_err(refused)?;
    let absent = !missing.is_empty();
    report.backends.extend(missing);
    let is_stopped = || stop.load(Ordering::Relaxed);
    // After Ctrl-C no map is made, which takes a time of its own.
    if let (Some(file), Some(x), Some(y), false) =
        (&args.map, &args.map_x, &args.map_y, is_stopped())
    {
        let map = MapRequest { x: x.clone(), y: y.clone(), ..MapRequest::default() };
        let svg = error_map(&source, &options, &request, &report, &map).map_err(refused)?;
        let html = file.extension().is_some_and(|e| e == "html" || e == "htm");
        let text = if html { print::page(&report, &svg) } else { svg };
        inputs(args, &source, &options, &request).write(file, text.as_bytes())?;
    }
    match args.format {
        StressFormat::Human => streams.product(&human(args, &report, streams.paint))?,
        StressFormat::Json => streams.json(&print::json(&report))?,
        StressFormat::Sarif => streams.json(&print::sarif(&report))?,
    }
    for backend in &report.backends {
        let Some(why) = &backend.failure else { continue };
        let what = if backend.ran() { "stopped" } else { "did not run" };
        let mut error = Error::new(backend.backend.name(), format!("{what}: {why}"));
        if backend.device.is_none() {
            error = error.with_help("`landfall devices` lists the available backends");
        }
        streams.report(&style.one(Diagnostic { code: Code::CannotRun, ..error.into() }));
    }
    if is_stopped() {
        return Ok(Outcome::Interrupted);
    }
    // A requested backend did not run.
    // The interpreter's results are printed all the same.
    if absent || !report.backends.iter().all(BackendReport::ran) {
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

/// A writer that does not overwrite inputs.
fn inputs(args: &StressArgs, source: &Source, options: &Options, request: &Request) -> FileWriter {
    let against = args.against.as_deref().map(|text| text.split('#').next().unwrap_or(text));
    let function = &args.function;
    let named = [function.domain.as_deref(), function.data.as_deref(), against];
    let named = named.into_iter().flatten().map(Path::new).chain([function.file.as_path()]);
    let sources = request.against.iter().map(|(source, _)| source).chain([source]);
    let files: Vec<_> = sources.map(|source| write::files_of(source, options)).collect();
    write::protecting(named, &files)
}

/// Opens the requested drivers; also returns those that are missing.
fn open(args: &StressArgs) -> (Vec<Box<dyn Backend>>, Vec<BackendReport>) {
    let (mut here, mut missing) = (Vec::new(), Vec::new());
    for name in BackendName::ALL {
        // The interpreter always runs.
        if name == BackendName::Cpu || !args.backends.contains(&name) {
            continue;
        }
        match backends::open_one(name, args.adapter.as_deref()) {
            Ok(backend) => here.push(backend),
            Err(failure) => missing.push(BackendReport::missing(name.kind(), &failure)),
        }
    }
    (here, missing)
}

fn request(args: &StressArgs) -> Result<Request, Error> {
    let (pure, domain) = data::function(&args.function, args.floats.floats())?;
    let against = match &args.against {
        None => None,
        Some(text) => {
            let (file, name) = match text.split_once('#') {
                Some((file, name)) => (file, name.to_string()),
                None => (text.as_str(), pure.function.clone()),
            };
            let source = read::shader_text(Path::new(file), &args.read)?;
            let other = PureRequest { function: name, floats: Floats::AsWritten, ..pure.clone() };
            Some((source, other))
        }
    };
    // A limit below the default also lowers the number of steps from which inputs are reported.
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

/// The report for people, as long as it was asked for.
fn human(args: &StressArgs, report: &Report, paint: Paint) -> String {
    match (args.all, args.details) {
        (true, _) => print::text(report, Listed::All, paint),
        (false, true) => print::text(report, Listed::Few, paint),
        (false, false) => print::brief(report, paint),
    }
}
