//! Where a shader function breaks, how wrong it gets, and why.
//!
//! [`Pure`] makes the function callable; `generate` makes inputs,
//! `sample` runs them in `f32` and `f64`, `classify` names what they meet, `find` makes
//! findings of it. the report of `landfall stress` prints the [`Report`].

mod blame;
mod case;
mod classify;
mod climb;
mod condition;
mod deadline;
mod drivers;
mod every;
mod find;
mod generate;
mod judge;
mod map;
mod mutations;
mod permitted;
mod readers;
mod report;
mod rewrite;
mod sample;
mod semantic;
mod shrink;
pub mod words;
mod worker;

use landfall_layout::diagnostic::Code;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use serde_json::Value;

pub use super::inputs::{Input, Sample, domain, role};
use super::inputs::{input, matched, random, scene};
use super::measure;
pub use super::measure::{Off, Outcome, Spread};

pub use case::{Case, ResultScalar, command};
pub use classify::Performed;
pub use condition::Condition;
pub use generate::Family;
pub use judge::Came;
pub use map::{MapRequest, error_map};
pub use permitted::{PermittedAt, Verdict};
pub use readers::{DriverCase, Odd, ReaderReport};
pub use report::{Against, Asked, Found, Report, Worst};
pub use rewrite::Gain;
pub use sample::Tally;

use climb::{Climbs, Whose};
use deadline::Deadline;
use drivers::Drivers;
use generate::Generator;
use landfall_exec::backend::Reader;
use landfall_exec::harness::call::Refusal;
use landfall_exec::harness::call::pure::{Pure, PureRequest};
use landfall_layout::source::Source;
use landfall_layout::{Diagnostic, Options};
use random::Random;
use sample::Plan;

/// What is to be found out, and how long it may take.
#[derive(Clone, Debug)]
pub struct Request {
    /// The function, and what of its surroundings stays fixed.
    pub pure: PureRequest,
    /// What its inputs may be, in JSON.
    pub domain: Option<Value>,
    /// What random numbers start from.
    pub seed: u64,
    /// Samples to run; a domain of no more inputs is run whole, each input once.
    pub samples: u64,
    /// Time for sampling; what is found is looked at in half as much again.
    pub time: Option<Duration>,
    /// Set by anybody, it ends with what it has: the report says so.
    pub stop: Arc<AtomicBool>,
    /// Threads; 0 for as many as there are.
    pub threads: usize,
    /// Errors from which on a finding is made, in steps of 1/255 of full scale.
    pub steps: f64,
    /// And in units of the last place.
    pub ulp: Option<f64>,
    /// A function that each finding is held against, and the shader it is in.
    pub against: Option<(Source, PureRequest)>,
    /// Iterations of loops one invocation may take.
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

/// What is found when it is told to stop is still looked at, for so long.
const GRACE: Duration = Duration::from_secs(1);

/// Threads at most.
const MOST_THREADS: usize = 256;

/// Stresses a function; `progress` is told how many samples ran.
///
/// The evaluator runs every sample in `f32` and `f64`, and each driver among the readers runs it
/// too and is held against that `f64`. A driver that fails is left out from there on, and the
/// report says why.
///
/// # Errors
/// A shader that does not run; a function it does not have or that cannot be called by itself; a
/// domain that is empty or about something else.
pub fn stress(
    source: &Source,
    options: &Options,
    request: &Request,
    readers: &mut [Box<dyn Reader>],
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Report, Box<Refusal>> {
    let began = Instant::now();
    let pure = Pure::new(source, options, &request.pure)?;
    let refused =
        |found: Diagnostic| Box::new(Refusal { found: vec![found], files: pure.files.clone() });
    let against = match &request.against {
        Some((source, other)) => Some(Pure::new(source, options, other)?),
        None => None,
    };
    let others: Vec<&Pure> = against.iter().collect();
    let inputs = matched::shared(&pure, &others);
    let against = match &against {
        Some(other) => Some((other, order(&pure, &inputs, other).map_err(&refused)?)),
        None => None,
    };
    let domain =
        super::inputs::domain(source, &pure, &inputs, request.domain.as_ref()).map_err(&refused)?;
    let generator = Generator::new(&inputs, &domain, request.seed).or_every(request.samples);
    let threads = match request.threads {
        0 => std::thread::available_parallelism().map_or(1, |n| n.get()),
        given => given.min(MOST_THREADS),
    };
    let plan = Plan {
        samples: generator.all().unwrap_or(request.samples),
        until: Deadline::after(request.time, &request.stop),
        threads,
        steps: request.steps,
        ulp: request.ulp.unwrap_or(f64::INFINITY),
        budget: request.budget,
    };
    let failed = |failure: landfall_exec::backend::Failure| {
        refused(Diagnostic::about(Code::CannotRun, failure.message, None, &source.path))
    };
    let mut drivers = Drivers::new(&pure, &inputs, readers, &plan);
    let started = Instant::now();
    let sampled = sample::run(&pure, &generator, &plan, &mut drivers, progress);
    let mut sampled = sampled.map_err(&failed)?;
    let sampling = started.elapsed();
    let ran: u64 = sampled.families.iter().map(|(_, tally)| tally.samples).sum();
    let more = request.time.map_or(Duration::from_secs(60), |time| time / 2);
    let until = Deadline::after(Some(more), &request.stop).with_grace(GRACE);
    let after = Plan { until: until.clone(), ..plan.clone() };
    drivers.set_until(&until);
    let every = generator.all().filter(|_| !sampled.stopped);
    let mut climbs =
        Climbs { tally: Tally::default(), drivers: &mut drivers, over: every.is_some() };
    let endless: Vec<Sample> = sampled
        .exemplars
        .iter()
        .filter(|((_, why), _)| *why == sample::Why::Endless)
        .map(|(_, kept)| kept.sample.clone())
        .collect();
    let climbing =
        || Plan { until: until.sooner(until.left().unwrap_or(more) / 4), ..plan.clone() };
    let worst = worst(&pure, &generator, &climbing(), &sampled, &mut climbs);
    worst_on_drivers(&pure, &generator, &climbing(), &mut climbs);
    let exemplars = std::mem::take(&mut sampled.exemplars);
    let mut raws = find::findings(&pure, &generator, &after, exemplars, &mut climbs);
    raws.extend(semantic::findings(&pure, &generator, &after, request.seed));
    if let Some((_, tally)) =
        sampled.families.iter_mut().find(|(family, _)| *family == Family::Climbed)
    {
        tally.merge(&climbs.tally);
    }
    drivers.flush();
    // What is written up is run again, each a sample, whatever the time is.
    let writing = Plan { until: Deadline::default(), ..plan.clone() };
    Ok(report::report(report::Made {
        source,
        options,
        request,
        pure: &pure,
        inputs: &inputs,
        domain: &domain,
        plan: &writing,
        against,
        families: sampled.families,
        raws,
        worst,
        drivers,
        endless,
        every,
        stopped: sampled.stopped || until.is_stopped(),
        rate: ran as f64 / sampling.as_secs_f64().max(1.0e-9),
        threads,
        seconds: began.elapsed().as_secs_f64(),
    }))
}

/// The worst finite samples: the largest error in units of the last place, and in steps.
fn worst(
    pure: &Pure,
    generator: &Generator<'_>,
    plan: &Plan,
    sampled: &sample::Sampled,
    climbs: &mut Climbs<'_, '_>,
) -> Vec<(Sample, Off)> {
    let mut random = Random::new(11, 11);
    let mut all = Vec::new();
    let heights: [fn(&Off) -> f64; 2] = [|off| off.ulp, |off| off.steps];
    for (which, height) in heights.into_iter().enumerate() {
        let mut best: Option<(Sample, Off)> = None;
        for start in sampled.starts(which) {
            let found = climb::climb(
                pure,
                generator,
                plan,
                start,
                (height, Whose::Evaluator),
                &mut random,
                climbs,
            );
            if best.as_ref().is_none_or(|(_, off)| height(&found.1) > height(off)) {
                best = Some(found);
            }
        }
        all.extend(best);
    }
    all
}

/// What the scalars of a function that is held against another are given of its samples.
fn order(
    pure: &Pure,
    inputs: &super::inputs::Inputs,
    other: &Pure,
) -> Result<Vec<Option<usize>>, Diagnostic> {
    let [own, others] = [pure, other].map(|pure| measure::floats(pure).len());
    let order = matched::matched(pure, inputs, other).and_then(|order| match own == others {
        true => Ok(order),
        false => Err(format!("it gives {others} floats, and `{}` {own}", pure.shown)),
    });
    order.map_err(|reason| {
        let message = format!("`{}` does not fit: {reason}", other.shown);
        Diagnostic::about(Code::CannotCompare, message, None, "--against")
    })
}

/// Climbs from the worst samples of each driver, which keeps what it finds there.
fn worst_on_drivers(
    pure: &Pure,
    generator: &Generator<'_>,
    plan: &Plan,
    climbs: &mut Climbs<'_, '_>,
) {
    climbs.drivers.flush();
    let mut random = Random::new(13, 13);
    let height =
        |why: judge::Why| move |off: &Off| if why == judge::Why::Ulp { off.ulp } else { off.steps };
    for driver in 0..climbs.drivers.len() {
        for why in [judge::Why::Ulp, judge::Why::Steps] {
            for (start, from) in climbs.drivers.starts(driver, why) {
                let up = (height(why), Whose::Driver(driver, from));
                climb::climb(pure, generator, plan, &start, up, &mut random, climbs);
            }
        }
    }
}
