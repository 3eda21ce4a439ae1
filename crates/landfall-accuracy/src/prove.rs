//! Shows that the operations of a function cannot break, or finds inputs at which they do.
//!
//! [`graph`](landfall_interp::graph) encloses the values of the function over boxes of its
//! inputs; `split` divides the box until nothing is possible in its parts, `points` tries corners,
//! axes, equal inputs and what a descent on the operands finds, and the interpreter confirms. Used
//! by [`stress`](mod@super::stress) and [`demand`](mod@super::demand).

mod errors;
mod points;
mod search;
mod space;
mod split;

pub use errors::ErrorBound;
pub(super) use errors::{BoundGoal, Measure, Until, bound};

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::inputs::domain::Domain;
use super::inputs::input::Sample;
use super::inputs::random::Random;
use super::inputs::{Inputs, columns, neighbours};
use super::measure::{Outcome, floats, outcome};
use landfall_exec::harness::call::pure::PureFunction;
use landfall_exec::processor::Stopwatch;
use landfall_interp::graph::{Arithmetic, Bounds, Fault, Graph};
use landfall_interp::{Precision, Settings, SourceLocation, UndefinedKind};
use points::Scratch;
use space::InputSpace;
use split::Split;

/// An operation that can break in one way, and the verdict on it.
#[derive(Clone, Debug)]
pub struct Goal {
    /// The way in which it can break.
    pub fault: Fault,
    /// The operation.
    pub place: SourceLocation,
    pub verdict: Verdict,
    /// The graph's sites: components of a vector, calls of a function, iterations of a loop.
    sites: Vec<usize>,
    /// The scalars of the inputs that it depends on.
    pub(super) inputs: Vec<usize>,
}

/// The verdict on an operation over the domain.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// It breaks at an input, on the interpreter.
    Found(Sample),
    /// It breaks nowhere in the domain, on any conformant device.
    Absent,
    /// Neither is known; for each scalar of the inputs, the smallest and largest value at which it
    /// may break.
    Open(Vec<[f64; 2]>),
}

/// The effect of a fault on the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    Undefined,
    /// Half of the digits are lost.
    Accuracy,
    /// Numbers are too large or too small for an `f32`.
    Magnitude,
}

/// Returns the effect of a fault.
pub(super) fn class(fault: Fault) -> Class {
    // That no operation breaks asks for the first class alone; that no result is NaN or infinite,
    // for magnitudes as well.
    use UndefinedKind as K;
    match fault {
        Fault::Cancellation => Class::Accuracy,
        Fault::Undefined(K::BornInfinite | K::SquaresTooLarge | K::SquaresTooSmall) => {
            Class::Magnitude
        }
        Fault::Undefined(_) | Fault::Endless | Fault::Unfollowed => Class::Undefined,
    }
}

impl Goal {
    pub fn is_found(&self) -> bool {
        matches!(self.verdict, Verdict::Found(_))
    }

    /// Whether only digits are lost, or numbers leave the range of an `f32`.
    fn is_minor(&self) -> bool {
        class(self.fault) != Class::Undefined
    }
}

/// The time that a search may take.
#[derive(Clone)]
pub(super) struct ProofLimits {
    /// The processor time.
    pub time: Duration,
    /// The most parts of the box that are examined.
    pub parts: u64,
    /// Set by the caller to give up.
    pub stop: Arc<AtomicBool>,
    pub seed: u64,
    /// Whether to run samples where nothing can break, for their errors.
    pub samples_always: bool,
    /// The threads of the search; what it finds does not depend on them.
    pub threads: usize,
}

impl ProofLimits {
    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn is_over(&self, began: &Stopwatch) -> bool {
        self.is_stopped() || began.elapsed() >= self.time
    }
}

/// The error in units of the last place from which a cancellation counts as found.
/// 12 of 24 bits.
const LOST: f64 = 4096.0;

/// A cancellation counts as found only if the error exceeds this many times the change of the
/// result, both in units of the last place, when an input changes by one unit.
/// The condition of the problem is not the fault of the code: where a change of an input by its
/// last bit moves the exact result that far, any code loses these digits.
const BEYOND: f64 = 64.0;

/// The parts examined between two checks of the time limit.
const EACH: usize = 64;

/// The result of a search over a function.
#[derive(Clone, Debug, Default)]
pub(super) struct ProvedFunction {
    /// The operations that can break.
    pub goals: Vec<Goal>,
    /// Inputs whose results are NaN, and infinite.
    pub nan: Option<Sample>,
    pub infinite: Option<Sample>,
    /// The inputs with the largest errors seen: in units of the last place, and in steps.
    pub worst: [Option<(f64, Sample)>; 2],
    /// The parts of the box that were examined.
    pub parts: u64,
}

/// Returns what is known of each operation of a function that can break; `None` if its code is too
/// large to follow.
pub(super) fn goals(
    pure: &PureFunction,
    inputs: &Inputs,
    domain: &Domain,
    limits: &ProofLimits,
) -> Option<ProvedFunction> {
    // The stages: enclose all operations over the whole box; run points that are likely to break
    // one; descend from the nearest of them; then divide the box, and descend again from parts
    // that stay open, at 512, 2048, 8192 ... parts.
    let began = Stopwatch::start();
    let space = InputSpace::new(inputs, domain);
    let graph = pure.graph(&space.root, &space.units)?;
    let over = || limits.is_over(&began);
    let (space, graph) = (&space, &graph);
    let confirm = Confirm { pure, inputs, space, graph, limits, began: &began };
    let mut proof =
        ProvedFunction { goals: grouped(graph, pure, space), ..ProvedFunction::default() };
    let mut split = Split::new(space, graph, &proof.goals);
    let mut scratch: Vec<Scratch> =
        (0..limits.threads.max(1)).map(|_| Scratch::new(&limits.stop)).collect();
    // One step examines the whole box: goals that are impossible there are done.
    let is_open = split.step(&proof.goals, 1, &mut scratch) > 0;
    let mut random = Random::new(limits.seed, 17);
    let mut first = Vec::new();
    if is_open || limits.samples_always {
        first = points::first(space, &mut random, &limits.stop);
        confirm.points(&first, &mut proof, &mut scratch[0]);
    }
    // A fault that is impossible over the whole box needs no search.
    if !is_open {
        return Some(with_verdicts(proof, &split));
    }
    confirm.near_all(&first, &split, &random, &mut proof, &mut scratch);
    let mut again = 512;
    loop {
        let examined = split.step(&proof.goals, EACH, &mut scratch);
        // The last attempt to take one counts as well.
        // `step` returns fewer than asked once nothing is left.
        proof.parts += examined as u64 + u64::from(examined < EACH);
        if limits.is_stopped() || examined < EACH || proof.parts >= limits.parts || over() {
            break;
        }
        // The parts that are left tell where to search once more.
        // At growing intervals, so that the searches stay a fixed share of the time.
        if proof.parts >= again {
            again *= 4;
            confirm.near_parts(&split, &random, &mut proof, &mut scratch);
        }
    }
    Some(with_verdicts(proof, &split))
}

/// Groups the sites of a graph by their place in the text; those of constants only where they
/// break.
fn grouped(graph: &Graph, pure: &PureFunction, space: &InputSpace<'_>) -> Vec<Goal> {
    let mut goals: Vec<Goal> = Vec::new();
    let mut bounds = Bounds::default();
    graph.bounds(&space.root, Arithmetic::Permitted, &mut bounds);
    for (nth, site) in graph.sites().iter().enumerate() {
        // A constant operand breaks everywhere or nowhere: one evaluation decides.
        if site.inputs.is_empty() && !bounds.is_possible(site) {
            continue;
        }
        // Naga's expansion of a built-in has no place in the text: it is the function's.
        let place = if site.place.shown.is_empty() { pure.place() } else { site.place.clone() };
        let same = |goal: &&mut Goal| goal.fault == site.fault && goal.place.span == place.span;
        match goals.iter_mut().find(same) {
            Some(goal) => {
                goal.sites.push(nth);
                goal.inputs.extend(&site.inputs);
                goal.inputs.sort_unstable();
                goal.inputs.dedup();
            }
            None => goals.push(Goal {
                fault: site.fault,
                place,
                verdict: Verdict::Absent,
                sites: vec![nth],
                inputs: site.inputs.clone(),
            }),
        }
    }
    goals
}

/// Gives each goal without an input its verdict.
fn with_verdicts(mut proof: ProvedFunction, split: &Split<'_>) -> ProvedFunction {
    let open = split.open(proof.goals.len());
    for (goal, open) in proof.goals.iter_mut().zip(open) {
        // Without an open part the initial verdict, absent, stands.
        if let (false, Some(open)) = (goal.is_found(), open) {
            goal.verdict = Verdict::Open(open.iter().map(|r| [r.low, r.high]).collect());
        }
    }
    proof
}

const LANES: usize = 256;

/// Runs points on the interpreter.
struct Confirm<'c> {
    pure: &'c PureFunction,
    inputs: &'c Inputs,
    space: &'c InputSpace<'c>,
    graph: &'c Graph,
    limits: &'c ProofLimits,
    began: &'c Stopwatch,
}

impl Confirm<'_> {
    /// Runs points and notes the goals that they meet.
    fn points(&self, points: &[Sample], proof: &mut ProvedFunction, scratch: &mut Scratch) {
        for some in points.chunks(LANES) {
            if self.limits.is_over(self.began) {
                return;
            }
            self.undefined(some, proof);
            self.lost(some, proof, scratch);
        }
    }

    fn settings(&self) -> Settings {
        // The interpreter checks the time within a call.
        let deadline = Instant::now().checked_add(self.limits.time);
        let stop = Some(Arc::clone(&self.limits.stop));
        Settings { threads: 1, budget: TURNS, deadline, stop, ..Settings::default() }
    }

    /// Notes operations without a defined value, as an `f32` execution meets them.
    fn undefined(&self, some: &[Sample], proof: &mut ProvedFunction) {
        let settings = Settings { watch: true, ..self.settings() };
        let Ok(called) = self.pure.call(&columns(some), some.len(), &settings) else { return };
        for seen in &called.called.notes.undefined {
            let span = match seen.place.shown.is_empty() {
                true => self.pure.place().span,
                false => seen.place.span,
            };
            // Not a consequence of numbers that were not finite before.
            let first = seen.lanes.first().filter(|_| seen.operands.iter().all(|x| x.is_finite()));
            let Some(sample) = first.and_then(|&lane| some.get(lane)) else { continue };
            let fault = Fault::Undefined(seen.kind);
            let met = |goal: &&mut Goal| {
                !goal.is_found() && goal.fault == fault && goal.place.span == span
            };
            for goal in proof.goals.iter_mut().filter(met) {
                goal.verdict = Verdict::Found(sample.clone());
            }
        }
        for (nth, at) in floats(self.pure) {
            for (lane, &word) in called.results[nth].words[at].iter().enumerate() {
                let single = f32::from_bits(word as u32);
                // A discarded fragment has no result.
                if called.called.discarded[lane] || single.is_finite() {
                    continue;
                }
                let seen = if single.is_nan() { &mut proof.nan } else { &mut proof.infinite };
                seen.get_or_insert_with(|| some[lane].clone());
            }
        }
    }

    /// Notes the largest errors, and cancellations with a large error in the result that the
    /// inputs' own rounding does not explain.
    fn lost(&self, some: &[Sample], proof: &mut ProvedFunction, scratch: &mut Scratch) {
        let settings = Settings { precision: Precision::Both, ..self.settings() };
        let Ok(called) = self.pure.call(&columns(some), some.len(), &settings) else { return };
        let floats = floats(self.pure);
        for (lane, sample) in some.iter().enumerate() {
            let Outcome::Finite(off, _) = outcome(&called, &floats, lane) else { continue };
            for (worst, by) in proof.worst.iter_mut().zip([off.ulp, off.steps]) {
                if worst.as_ref().is_none_or(|(most, _)| by > *most) {
                    *worst = Some((by, sample.clone()));
                }
            }
            // Less than half of the digits.
            if off.ulp <= LOST || self.limits.is_stopped() {
                continue;
            }
            // The graph is evaluated at this point to see which cancellations can be at fault
            // here.
            self.space.point(sample, &mut scratch.point);
            self.graph.bounds(&scratch.point, Arithmetic::Permitted, &mut scratch.bounds);
            let possible = |site: &usize| scratch.bounds.is_possible(&self.graph.sites()[*site]);
            let mut lost: Vec<&mut Goal> = proof
                .goals
                .iter_mut()
                .filter(|goal| goal.fault == Fault::Cancellation && !goal.is_found())
                .filter(|goal| goal.sites.iter().any(possible))
                .collect();
            // Computed only where a goal is left, since it runs the function 2n + 1 times.
            let explained = || BEYOND * (1.0 + moved(self.pure, self.inputs, sample));
            if !lost.is_empty() && off.ulp > explained() {
                lost.iter_mut().for_each(|goal| goal.verdict = Verdict::Found(sample.clone()));
            }
        }
    }
}

/// Returns whether a goal's operation breaks at a sample.
pub(super) fn breaks(pure: &PureFunction, goal: &Goal, sample: &Sample) -> bool {
    let settings = Settings { watch: true, threads: 1, budget: TURNS, ..Settings::default() };
    let called = pure.call(&columns(std::slice::from_ref(sample)), 1, &settings);
    let met = |seen: &landfall_interp::Undefined| {
        let finite = seen.operands.iter().all(|x| x.is_finite());
        Fault::Undefined(seen.kind) == goal.fault && seen.place.span == goal.place.span && finite
    };
    called.is_ok_and(|called| called.called.notes.undefined.iter().any(met))
}

/// Returns whether `is` holds for some result at a sample.
pub(super) fn any_result(pure: &PureFunction, sample: &Sample, is: fn(f32) -> bool) -> bool {
    let settings = Settings { threads: 1, budget: TURNS, ..Settings::default() };
    let called = pure.call(&columns(std::slice::from_ref(sample)), 1, &settings);
    called.is_ok_and(|called| {
        let single = |(nth, at): (usize, usize)| {
            f32::from_bits(called.results[nth].words[at].first().copied().unwrap_or(0) as u32)
        };
        floats(pure).into_iter().any(|at| is(single(at)))
    })
}

/// The most iterations of a loop that are run.
const TURNS: u32 = 4096;

/// Returns by how many units of the last place the exact result moves if an input moves by one.
fn moved(pure: &PureFunction, inputs: &Inputs, sample: &Sample) -> f64 {
    let samples = neighbours(sample, inputs);
    let settings = Settings { precision: Precision::Double, threads: 1, ..Settings::default() };
    let Ok(called) = pure.call(&columns(&samples), samples.len(), &settings) else {
        return f64::INFINITY;
    };
    let mut most = 0.0f64;
    for (nth, at) in floats(pure) {
        let doubles = &called.results[nth].doubles[at];
        let unit = landfall_layout::buffer::float::last_place(doubles[0]);
        for double in &doubles[1..] {
            let by = (double - doubles[0]).abs() / unit;
            most = most.max(if by.is_nan() { f64::INFINITY } else { by });
        }
    }
    most
}
