//! Stressing functions: the hazards of seed forms are found at their lines and those of robust
//! forms are not there, errors are what analysis says, and every finding can be repeated.

mod advice;
mod branches;
mod classes;
mod figures;
mod hazards;
mod inputs;
mod refusals;
mod repeat;

use std::path::Path;
use std::time::Duration;

use landfall_accuracy::stress::{Report, Request, StressFinding, stress};
use landfall_exec::harness::call::Refusal;
use landfall_exec::harness::call::pure::PureRequest;
use landfall_layout::{Options, Source};
use serde_json::Value;

/// A request for a function with few samples.
fn request(function: &str) -> Request {
    Request {
        pure: PureRequest { function: function.to_string(), ..PureRequest::default() },
        samples: 40_000,
        time: Some(Duration::from_secs(10)),
        ..Request::default()
    }
}

fn try_run(source: &Source, request: &Request) -> Result<Report, Box<Refusal>> {
    stress(source, &Options::default(), request, &mut [], &|_| ())
}

fn run(source: &Source, request: &Request) -> Report {
    try_run(source, request).unwrap_or_else(|refusal| panic!("{:?}", refusal.found))
}

fn domain(json: &str) -> Option<Value> {
    Some(serde_json::from_str(json).expect("the test's domain is JSON"))
}

/// A shader of the repository.
fn shader(path: &str) -> Source {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    let read = Source::read(&file).unwrap_or_else(|error| panic!("{path}: {error:?}"));
    Source { path: path.to_string(), ..read }
}

/// The line of a finding.
fn line<'r>(report: &'r Report, found: &StressFinding) -> &'r str {
    let at = report.files.locate(found.place.span);
    let file = report.files.get(found.place.span.file).expect("it is in a file");
    file.text.lines().nth(at.line as usize - 1).unwrap_or_default()
}

/// What was found, for messages.
fn all(report: &Report) -> String {
    let each = report
        .findings
        .iter()
        .map(|found| format!("{} | {}\n", found.hazard.code(), line(report, found).trim()));
    each.collect()
}
