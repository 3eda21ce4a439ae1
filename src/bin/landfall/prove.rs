//! `landfall prove`: shows that no operation of a function breaks, or finds an input at which one
//! does.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use landfall::report::prove as print;
use landfall_accuracy::demand::{Demand, ProveRequest, prove};
use landfall_interp::Floats;
use landfall_interp::graph::Rounding;
use landfall_layout::Error;

use crate::args::{ProveArgs, ProveFormat};
use crate::output::{CommandFailure, FindingForm, Outcome, Streams};
use crate::{data, read, shader, watch};

pub fn run(args: &ProveArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    let style = streams.style(FindingForm::json_if(args.format == ProveFormat::Json));
    let source = read::shader_text(&args.function.file, &args.read);
    let source = source.map_err(|error| style.request(error))?;
    let mut request = request(args).map_err(|error| style.request(error))?;
    // Ctrl-C stops the proof between two steps, and what was shown by then is printed.
    let stop = watch::flag();
    request.stop = Arc::clone(&stop);
    let options = read::options(&args.read);
    shader::record_function(&source, &options, streams, style);
    let proved = prove(&source, &options, &request)
        .map_err(|refusal| style.failure(&refusal.found, &refusal.files))?;
    let listed = if args.all { print::Listed::All } else { print::Listed::Few };
    match args.format {
        ProveFormat::Human => streams.product(&print::text(&proved, listed, streams.paint))?,
        ProveFormat::Json => streams.json(&print::json(&proved))?,
    }
    // A proof that was finished before the interrupt counts as one.
    Ok(match (proved.is_shown(), stop.load(Ordering::Relaxed)) {
        (true, _) => Outcome::Clean,
        (false, true) => Outcome::Interrupted,
        (false, false) => Outcome::Findings,
    })
}

fn request(args: &ProveArgs) -> Result<ProveRequest, Error> {
    let (pure, domain) = data::function(&args.function, Floats::AsWritten)?;
    let flags = [(args.no_nan, Demand::NoNan), (args.no_inf, Demand::NoInfinity)];
    let flags = flags.into_iter().filter(|(is, _)| *is).map(|(_, demand)| demand);
    let limits = [args.max_ulp.map(Demand::MaxUlp), args.max_step.map(Demand::MaxStep)];
    Ok(ProveRequest {
        pure,
        domain,
        demands: flags.chain(limits.into_iter().flatten()).collect(),
        // By default every result that the language permits counts; with `--f64`, that of doubles.
        rounding: if args.f64 { Rounding::Double } else { Rounding::Permitted },
        time: args.time,
        ..ProveRequest::default()
    })
}
