//! Searches the inputs of a shader function for the largest errors and for undefined results.
//!
//! [`PureFunction`] makes the function callable; `generate` makes inputs, `sample` runs them in
//! `f32` and `f64`, `classify` assigns hazards, `find` makes findings. The report of `landfall
//! stress` prints the [`Report`].

mod advice;
mod backends;
mod batch;
mod blame;
mod branches;
mod case;
mod classify;
mod climb;
mod condition;
mod deadline;
mod drivers;
mod exhaustive;
mod find;
mod found;
mod generate;
mod kept;
mod map;
pub mod messages;
mod mutations;
mod operation;
mod permitted;
mod plan;
mod proof;
mod report;
mod rewrite;
mod sample;
mod semantic;
mod shrink;
mod verdict;
mod worker;

use landfall_layout::diagnostic::Code;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::Value;

pub use super::inputs::{DistributedInput, Input, Sample, domain, role};
use super::inputs::{input, matched, random, sampler, scene};
use super::measure;
pub use super::measure::{JsonNumber, Outcome, SampleError, Spread};
use landfall_ir::threads;

pub use advice::Advice;
pub use backends::{BackendReport, Disagreement, DriverCase};
pub use branches::FlippedBranch;
pub(crate) use case::CaseWriter;
pub use case::{Case, ResultScalar, command};
pub use classify::Performed;
pub use condition::Condition;
pub use found::{BackendResult, OtherFunction, StressFinding, Worst};
pub use generate::Family;
pub use kept::Tally;
pub use map::{MapRequest, error_map};
pub use operation::{Operation, OperationVerdict, count_lines, counts};
pub(crate) use operation::{operations, simplest};
pub use permitted::{PermittedAt, Verdict};
pub use report::Report;
pub use rewrite::Gain;
pub use verdict::DriverOutcome;

use climb::{ClimbTarget, Climbs};
use deadline::Deadline;
use drivers::Drivers;
use generate::Generator;
use landfall_exec::backend::Backend;
use landfall_exec::harness::call::Refusal;
use landfall_exec::harness::call::pure::{PureFunction, PureRequest};
use landfall_layout::source::Source;
use landfall_layout::{Diagnostic, Options};
use plan::{Plan, SampleSearch};
use random::Random;

/// A function to stress, with the limits of the search.
#[derive(Clone, Debug)]
pub struct Request {
    /// The function and its fixed bindings.
    pub pure: PureRequest,
    /// The domain of the inputs as JSON.
    pub domain: Option<Value>,
    pub seed: u64,
    /// The number of samples; a domain with no more inputs is run completely, each input once.
    pub samples: u64,
    /// The time limit for sampling; examining the findings takes up to half as much again.
    pub time: Option<Duration>,
    /// Set to stop early with the results so far, which the report states.
    pub stop: Arc<AtomicBool>,
    /// The number of threads; 0 for all of the machine.
    pub threads: usize,
    /// The error from which a sample is a finding, in steps of 1/255 of full scale.
    pub steps: f64,
    /// The error from which a sample is a finding, in units of the last place.
    pub ulp: Option<f64>,
    /// A function to compare each finding with, and its shader.
    pub against: Option<(Source, PureRequest)>,
    /// The most loop iterations of one invocation.
    pub budget: u32,
}

impl Default for Request {
    fn default() -> Request {
        Request {
            pure: PureRequest::default(),
            domain: None,
            seed: 1,
            samples: 100_000,
            time: Some(Duration::from_secs(8)),
            stop: Arc::default(),
            threads: 0,
            steps: 0.5,
            ulp: None,
            against: None,
            budget: 4096,
        }
    }
}

/// The time to examine findings after a stop.
const GRACE: Duration = Duration::from_millis(200);

const MAX_THREADS: usize = 256;

/// Stresses a function; `progress` receives the number of samples run.
///
/// The interpreter runs every sample in `f32` and `f64`; each driver among the backends runs it
/// too, and its result is compared with that `f64`. A driver that fails runs no further samples,
/// and the report states why.
///
/// The stages: samples of all families on all cores; climbs from the worst samples beside the
/// proof; branches that rounding decides; findings from what was kept, simplified; rules over pairs
/// of samples; then the same inputs on the drivers. Each stage has a share of the time, and works
/// on what the ones before it kept.
///
/// # Errors
/// A shader that does not run; a function that does not exist or cannot be called on its own; a
/// domain that is empty or names other inputs.
pub fn stress(
    source: &Source,
    options: &Options,
    request: &Request,
    backends: &mut [Box<dyn Backend>],
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Report, Box<Refusal>> {
    let began = Instant::now();
    let pure = PureFunction::new(source, options, &request.pure)?;
    let refused =
        |found: Diagnostic| Box::new(Refusal { found: vec![found], files: pure.files.clone() });
    let against = match &request.against {
        Some((source, other)) => Some(PureFunction::new(source, options, other)?),
        None => None,
    };
    let others: Vec<&PureFunction> = against.iter().collect();
    let inputs = matched::shared(&pure, &others);
    let against = match &against {
        Some(other) => Some((other, order(&pure, &inputs, other).map_err(&refused)?)),
        None => None,
    };
    let domain =
        super::inputs::domain(source, &pure, &inputs, request.domain.as_ref()).map_err(&refused)?;
    let generator = Generator::new(&inputs, &domain, request.seed).or_every(request.samples);
    let threads = threads::number(request.threads).min(MAX_THREADS);
    let plan = Plan {
        samples: generator.all().unwrap_or(request.samples),
        until: Deadline::after(request.time, &request.stop),
        threads,
        steps: request.steps,
        ulp: request.ulp.unwrap_or(f64::INFINITY),
        least_steps: 0.0,
        budget: request.budget,
    };
    let failed = |failure: landfall_exec::backend::Failure| {
        refused(Diagnostic::about(Code::CannotRun, failure.message, None, &source.path))
    };
    let mut drivers = Drivers::new(&pure, (&inputs, &domain), backends, &plan);
    let started = Instant::now();
    let search = SampleSearch { pure: &pure, generator: &generator, plan: &plan };
    let sampled = sample::run(search, &mut drivers, progress);
    let mut sampled = sampled.map_err(&failed)?;
    let sampling = started.elapsed();
    let ran: u64 = sampled.families.iter().map(|(_, tally)| tally.samples).sum();
    if let Some(found) = too_slow(request, ran, sampled.stopped) {
        return Err(refused(found));
    }
    let more = request.time.map_or(Duration::from_secs(60), |time| time / 2);
    let until = Deadline::after(Some(more), &request.stop).with_grace(GRACE);
    let after = Plan { until: until.clone(), ..plan.clone() };
    drivers.set_until(&until);
    let every = generator.all().filter(|_| !sampled.stopped);
    let mut climbs =
        Climbs { tally: Tally::default(), drivers: &mut drivers, over: every.is_some() };
    let endless = sampled.endless();
    let climbing =
        || Plan { until: until.shortened_to(until.left().unwrap_or(more) / 4), ..plan.clone() };
    let climb = || {
        let worst = worst(SampleSearch { plan: &climbing(), ..search }, &sampled, &mut climbs);
        worst_on_drivers(SampleSearch { plan: &climbing(), ..search }, &mut climbs);
        worst
    };
    let later = SampleSearch { plan: &after, ..search };
    // A climb takes one step after the other.
    let prove = || proof::proof(later, request);
    let (worst, proof) = threads::both(threads, climb, prove);
    let mut exemplars = std::mem::take(&mut sampled.exemplars);
    let plan_of_branches = &climbing();
    let edges = branches::search(SampleSearch { plan: plan_of_branches, ..search }, &mut exemplars);
    let mut raws = proof::findings(later, exemplars, &mut climbs, &proof.goals);
    raws.extend(semantic::findings(later, request.seed));
    if let Some((_, tally)) =
        sampled.families.iter_mut().find(|(family, _)| *family == Family::Climbed)
    {
        tally.merge(&climbs.tally);
    }
    drivers.flush();
    // Reported samples are run again one by one, regardless of limits.
    let until = Deadline::after(None, &request.stop).with_grace(Duration::MAX);
    let writing = Plan { until, ..plan.clone() };
    Ok(report::report(report::ReportParts {
        source,
        options,
        request,
        search: SampleSearch { plan: &writing, ..search },
        against,
        families: sampled.families,
        raws,
        edges,
        proof,
        worst,
        drivers,
        endless,
        every,
        stopped: sampled.stopped || plan.until.is_stopped(),
        rate: ran as f64 / sampling.as_secs_f64().max(1.0e-9),
        threads,
        seconds: began.elapsed().as_secs_f64(),
    }))
}

/// Returns an error if the time limit passed before any sample ended.
fn too_slow(request: &Request, ran: u64, late: bool) -> Option<Diagnostic> {
    let interrupted = request.stop.load(Ordering::Relaxed);
    let seconds = request.time.filter(|_| ran == 0 && late && !interrupted)?.as_secs_f64();
    let message = format!("no sample ended within the time limit of {seconds} s");
    let help = "raise the limit, or call the function with fewer calls and iterations";
    Some(Diagnostic::about(Code::CannotRun, message, Some(help.to_string()), "--time"))
}

/// Returns the worst finite samples: by units of the last place, and by steps.
fn worst(
    search: SampleSearch<'_>,
    sampled: &kept::SampledResults,
    climbs: &mut Climbs<'_, '_>,
) -> Vec<(Sample, SampleError)> {
    let mut random = Random::new(11, 11);
    let mut all = Vec::new();
    let heights: [fn(&SampleError) -> f64; 2] = [|off| off.ulp, |off| off.steps];
    for (which, height) in heights.into_iter().enumerate() {
        let mut best: Option<(Sample, SampleError)> = None;
        for start in sampled.climb_starts(which) {
            let up = (height, ClimbTarget::Interpreter);
            let found = climb::climb(search, start, up, &mut random, climbs);
            if best.as_ref().is_none_or(|(_, off)| height(&found.1) > height(off)) {
                best = Some(found);
            }
        }
        all.extend(best);
    }
    all
}

/// Returns for each scalar of the compared function the matching one of the stressed function.
fn order(
    pure: &PureFunction,
    inputs: &super::inputs::Inputs,
    other: &PureFunction,
) -> Result<Vec<Option<usize>>, Diagnostic> {
    let [own, others] = [pure, other].map(|pure| measure::floats(pure).len());
    let order = matched::matched(pure, inputs, other).and_then(|order| match own == others {
        true => Ok(order),
        false => Err(format!("it returns {others} floats, but `{}` returns {own}", pure.shown)),
    });
    order.map_err(|reason| {
        let message = format!("`{}` cannot be compared: {reason}", other.shown);
        Diagnostic::about(Code::CannotCompare, message, None, "--against")
    })
}

/// Climbs from the worst samples of each driver, which records the results.
fn worst_on_drivers(search: SampleSearch<'_>, climbs: &mut Climbs<'_, '_>) {
    climbs.drivers.flush();
    let mut random = Random::new(13, 13);
    let height = |why: verdict::DriverKeepReason| {
        move |off: &SampleError| {
            if why == verdict::DriverKeepReason::Ulp { off.ulp } else { off.steps }
        }
    };
    for driver in 0..climbs.drivers.len() {
        for why in [verdict::DriverKeepReason::Ulp, verdict::DriverKeepReason::Steps] {
            for (start, from) in climbs.drivers.climb_starts(driver, why) {
                let up = (height(why), ClimbTarget::Driver(driver, from));
                climb::climb(search, &start, up, &mut random, climbs);
            }
        }
    }
}
