//! The demands on a function, and the report of whether they are met.
//!
//! [`prove`](mod@super::prove) finds what is known of its operations and errors; the report of
//! `landfall prove` prints the result.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use serde_json::Value;

use super::inputs::domain::Domain;
use super::inputs::{Input, Sample, matched};
use super::prove::{
    self, BoundGoal, Class, ErrorBound, Goal, Measure, ProofLimits, ProvedFunction, Until, Verdict,
    bound, class, goals,
};
use super::stress::{Case, CaseWriter, Operation, operations, simplest};
use landfall_exec::harness::call::Refusal;
use landfall_exec::harness::call::pure::{PureFunction, PureRequest};
use landfall_interp::graph::{Fault, Rounding};
use landfall_ir::threads;
use landfall_layout::Options;
use landfall_layout::source::{Files, Source, Target};

/// A function and the demands on it, with the limits of the search.
#[derive(Clone, Debug)]
pub struct ProveRequest {
    /// The function and its fixed bindings.
    pub pure: PureRequest,
    /// The domain of the inputs as JSON.
    pub domain: Option<Value>,
    /// The demands; if empty, that no operation has an undefined result.
    pub demands: Vec<Demand>,
    /// The roundings whose errors are bounded: where a limit of the error is demanded, and for
    /// those to `f64`.
    pub rounding: Rounding,
    /// The limit of processor time.
    pub time: Duration,
    /// The most parts of the domain that are examined.
    pub parts: u64,
    /// The seed of the random points.
    pub seed: u64,
    /// Set to stop early with what is shown so far.
    pub stop: Arc<AtomicBool>,
    /// The number of threads; 0 for all of the machine.
    pub threads: usize,
}

impl Default for ProveRequest {
    fn default() -> ProveRequest {
        ProveRequest {
            pure: PureRequest::default(),
            domain: None,
            demands: Vec::new(),
            rounding: Rounding::Permitted,
            time: Duration::from_secs(6),
            parts: u64::MAX,
            seed: 1,
            stop: Arc::default(),
            threads: 0,
        }
    }
}

/// The most loop iterations of one invocation of a counterexample.
const BUDGET: u32 = 4096;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Demand {
    /// No operation breaks.
    NoFault,
    /// No result is NaN.
    NoNan,
    /// No result is infinite.
    NoInfinity,
    /// No result is off by more units of the last place of an `f32`.
    MaxUlp(f64),
    /// No result is off by more steps of 1/255 of full scale.
    MaxStep(f64),
}

impl Demand {
    pub fn name(self) -> &'static str {
        match self {
            Demand::NoFault => "no-fault",
            Demand::NoNan => "no-nan",
            Demand::NoInfinity => "no-inf",
            Demand::MaxUlp(_) => "max-ulp",
            Demand::MaxStep(_) => "max-step",
        }
    }

    /// Returns the name in reports for people.
    pub fn label(self) -> &'static str {
        match self {
            Demand::NoFault => "no undefined result",
            other => other.name(),
        }
    }

    fn limit(self) -> Option<(Measure, f64)> {
        match self {
            Demand::MaxUlp(most) => Some((Measure::Ulp, most)),
            Demand::MaxStep(most) => Some((Measure::Steps, most)),
            Demand::NoFault | Demand::NoNan | Demand::NoInfinity => None,
        }
    }
}

#[derive(Clone, Debug)]
pub enum DemandVerdict {
    /// It is met on every conformant device.
    Shown,
    /// It is not met at this input.
    Broken(Box<Case>),
    /// Neither is known.
    Open,
}

/// The results of a proof, in the form of `landfall schema prove`.
#[derive(Debug)]
pub struct ProveReport {
    /// The path of the shader, as messages print it.
    pub path: String,
    /// The API assumed for a shader that names none, if its blocks depend on it.
    pub assumed_target: Option<Target>,
    /// The function with its parameter types.
    pub function: String,
    /// The inputs of the function, with their ranges.
    pub inputs: Vec<(Input, String)>,
    /// The operations that can break, in the order of the text.
    pub operations: Vec<Operation>,
    pub demands: Vec<(Demand, DemandVerdict)>,
    /// The roundings whose errors are bounded.
    pub rounding: Rounding,
    /// Whether results may be NaN, and infinite.
    pub non_finite: [DemandVerdict; 2],
    /// A bound of the error of every result; `None` if none is known, or results may be NaN or
    /// infinite.
    pub error: Option<ErrorBound>,
    /// The largest errors of samples: in units of the last place, and in steps.
    pub worst: [Option<f64>; 2],
    /// The parts of the domain that were examined.
    pub parts: u64,
    /// Whether the code was too large to follow.
    pub too_large: bool,
    /// The assumptions made for values not given.
    pub notes: Vec<String>,
    pub files: Files,
}

impl ProveReport {
    /// Whether no demand was made: that results are defined is asked of every function.
    pub fn is_without_demand(&self) -> bool {
        matches!(self.demands[..], [(Demand::NoFault, _)])
    }

    /// Whether the search for a bound ended where a demand was met: a lower bound may be known
    /// later.
    pub fn is_cut_short(&self) -> bool {
        let is_met = |(demand, verdict): &(Demand, DemandVerdict)| {
            demand.limit().is_some() && matches!(verdict, DemandVerdict::Shown)
        };
        self.demands.iter().any(is_met)
    }

    pub fn is_shown(&self) -> bool {
        self.demands.iter().all(|(_, shown)| matches!(shown, DemandVerdict::Shown))
    }
}

/// Shows that the operations of a function do not break, or finds inputs at which they do.
///
/// # Errors
/// A shader that does not run; a function that does not exist or cannot be called on its own; a
/// domain that is empty or names other inputs.
pub fn prove(
    source: &Source,
    options: &Options,
    request: &ProveRequest,
) -> Result<ProveReport, Box<Refusal>> {
    let pure = PureFunction::new(source, options, &request.pure)?;
    let refused = |found| Box::new(Refusal { found: vec![found], files: pure.files.clone() });
    let inputs = matched::shared(&pure, &[]);
    let json = request.domain.as_ref();
    let domain = super::inputs::domain(source, &pure, &inputs, json).map_err(refused)?;
    // Each gets an equal share of the time: the search for faults, and one search for each limit
    // or settled bound. The search and each bound of an error take turns.
    let bounds = request.demands.iter().filter(|demand| demand.limit().is_some()).count();
    // Without a demand the report has the best known bound in both measures; with one, only that
    // bound is sought. `f64` has no steps or units of `f32`, so its bound is absolute.
    let settled: &[Measure] = match (request.rounding, request.demands.is_empty()) {
        (Rounding::Permitted, true) => &[Measure::Steps, Measure::Ulp],
        (Rounding::Double, _) => &[Measure::Absolute],
        (Rounding::Permitted, false) => &[],
    };
    let turns = (1 + bounds + settled.len()) as u32;
    let limits = ProofLimits {
        time: request.time / turns,
        samples_always: true,
        parts: request.parts,
        stop: Arc::clone(&request.stop),
        seed: request.seed,
        threads: threads::number(request.threads),
    };
    let found = goals(&pure, &inputs, &domain, &limits);
    let writer = CaseWriter::new(source, options, &request.pure, &pure, &inputs, BUDGET);
    // Code too large to follow leaves every demand open.
    let too_large = found.is_none();
    let mut proof = found.unwrap_or_default();
    // Inputs are simplified before they are printed: zeros and ones instead of random digits.
    simplify(&mut proof, &pure, &inputs, &domain, &request.stop);
    let wanted = match request.demands.as_slice() {
        [] => vec![Demand::NoFault],
        demands => demands.to_vec(),
    };
    let non_finite = [Demand::NoNan, Demand::NoInfinity];
    let non_finite = non_finite.map(|demand| match too_large {
        true => DemandVerdict::Open,
        false => demand_verdict(demand, &proof, &writer),
    });
    // A bound of finite results says nothing of inputs where the result may be NaN or infinite.
    let is_finite = matches!(non_finite[0], DemandVerdict::Shown);
    let bounded = |measure, until| {
        let goal = BoundGoal { rounding: request.rounding, measure, until };
        bound(&pure, &inputs, &domain, &limits, goal)
    };
    let lower =
        // Every bound holds, so the lower of them in each measure does.
        |error: Option<ErrorBound>, other| error.into_iter().chain(other).reduce(ErrorBound::and);
    let mut error: Option<ErrorBound> = None;
    for &measure in settled.iter().filter(|_| is_finite) {
        let until = match request.rounding {
            Rounding::Permitted => Until::Settled,
            Rounding::Double => Until::Below(0.0),
        };
        error = lower(error, bounded(measure, until));
    }
    let mut demands = Vec::new();
    // In the order in which they were made.
    for demand in wanted {
        let shown = match demand.limit() {
            _ if too_large => DemandVerdict::Open,
            None => demand_verdict(demand, &proof, &writer),
            Some((measure, most)) => {
                let found = bounded(measure, Until::Below(most));
                error = lower(error, found);
                limited(measure, most, found, &proof, request, &writer)
            }
        };
        demands.push((demand, shown));
    }
    let within = inputs.iter().enumerate().map(|(at, input)| domain.text(at, input));
    let within: Vec<String> = within.collect();
    Ok(ProveReport {
        path: source.path.clone(),
        assumed_target: landfall_layout::layout(source, options).assumed_target,
        function: pure.shown.clone(),
        inputs: inputs.iter().cloned().zip(within).collect(),
        demands,
        rounding: request.rounding,
        non_finite,
        error: error.filter(|_| is_finite),
        worst: [0, 1].map(|nth: usize| proof.worst[nth].as_ref().map(|(by, _)| *by)),
        operations: operations(&proof.goals, &inputs, &writer),
        parts: proof.parts,
        too_large,
        notes: pure.notes.clone(),
        files: pure.files.clone(),
    })
}

/// Simplifies the inputs that were found, until the caller stops it.
fn simplify(
    proof: &mut ProvedFunction,
    pure: &PureFunction,
    inputs: &[Input],
    domain: &Domain,
    stop: &Arc<AtomicBool>,
) {
    for nth in 0..proof.goals.len() {
        let goal = &proof.goals[nth];
        if let (Verdict::Found(sample), Fault::Undefined(_)) = (&goal.verdict, goal.fault) {
            let breaks = |sample: &Sample| prove::breaks(pure, goal, sample);
            let simple = simplest(sample, inputs, domain, stop, breaks);
            proof.goals[nth].verdict = Verdict::Found(simple);
        }
    }
    let simple = |sample: &mut Sample, is: fn(f32) -> bool| {
        let breaks = |sample: &Sample| prove::any_result(pure, sample, is);
        *sample = simplest(sample, inputs, domain, stop, breaks);
    };
    if let Some(sample) = &mut proof.nan {
        simple(sample, f32::is_nan);
    }
    if let Some(sample) = &mut proof.infinite {
        simple(sample, f32::is_infinite);
    }
}

fn demand_verdict(
    demand: Demand,
    proof: &ProvedFunction,
    writer: &CaseWriter<'_>,
) -> DemandVerdict {
    // The code after a fault is followed as if it had not occurred: a result may be NaN or infinite
    // only after one.
    let matters = |goal: &&Goal| match demand {
        Demand::NoFault => class(goal.fault) == Class::Undefined,
        Demand::NoNan | Demand::NoInfinity | Demand::MaxUlp(_) | Demand::MaxStep(_) => {
            class(goal.fault) != Class::Accuracy
        }
    };
    let broken = match demand {
        Demand::NoFault => {
            proof.goals.iter().filter(matters).find_map(|goal| match &goal.verdict {
                Verdict::Found(sample) => Some(sample),
                Verdict::Absent | Verdict::Open(_) => None,
            })
        }
        Demand::NoNan => proof.nan.as_ref(),
        Demand::NoInfinity => proof.infinite.as_ref(),
        Demand::MaxUlp(_) | Demand::MaxStep(_) => None,
    };
    if let Some(sample) = broken {
        return DemandVerdict::Broken(Box::new(writer.case(sample)));
    }
    // Shown only if every operation that matters is absent; one open is enough for `Open`.
    match proof.goals.iter().filter(matters).all(|goal| goal.verdict == Verdict::Absent) {
        true => DemandVerdict::Shown,
        false => DemandVerdict::Open,
    }
}

/// Returns whether the error is within a limit. Without faults the bound holds for every input.
fn limited(
    measure: Measure,
    most: f64,
    bounded: Option<ErrorBound>,
    proof: &ProvedFunction,
    request: &ProveRequest,
    writer: &CaseWriter<'_>,
) -> DemandVerdict {
    // Samples are run in `f32`.
    // Found by running samples: an error above the limit is a counterexample.
    let worst = match measure {
        Measure::Ulp => proof.worst[0].as_ref(),
        Measure::Steps | Measure::Absolute => proof.worst[1].as_ref(),
    };
    let broken = worst.filter(|(by, _)| *by > most && request.rounding == Rounding::Permitted);
    let broken =
        broken.map(|(_, sample)| sample).or(proof.nan.as_ref()).or(proof.infinite.as_ref());
    if let Some(sample) = broken {
        return DemandVerdict::Broken(Box::new(writer.case(sample)));
    }
    // Without a proof that results are numbers the bound is about finite ones only.
    let defined = demand_verdict(Demand::NoNan, proof, writer);
    match (bounded, defined) {
        (Some(bound), DemandVerdict::Shown) if bound.in_measure(measure) <= most => {
            DemandVerdict::Shown
        }
        _ => DemandVerdict::Open,
    }
}
