//! Assigns a hazard and an operation to a sample.
//!
//! Runs one sample with a trace of all operations, looks for operations without a defined value and
//! for the one that introduced the error, and classifies them by operation and by the roles of
//! their inputs. Used by [`find`](super::find).

mod hazard;

use std::time::Duration;

use super::blame::Graph;
use super::input::Sample;
use super::measure::{Outcome, SampleError, floats, outcome, outcome_beside};
use super::plan::{SampleSearch, columns, settings};
use landfall_exec::backend::Failure;
use landfall_exec::harness::call::pure::{PureCallResult, PureFunction};
use landfall_exec::harness::origins::ReadValue;
use landfall_interp::{
    Number, Operation, Precision, Settings, Source, SourceLocation, Trace, UndefinedKind,
};
use landfall_ir::analysis::hazard::Hazard;

use hazard::TracedSample;

#[derive(Clone, Debug)]
pub(super) struct HazardCandidate {
    pub hazard: Hazard,
    pub place: SourceLocation,
    /// The operation with its operands and result.
    pub operation: Option<Performed>,
    pub about: Vec<usize>,
    /// The members of blocks with given contents that led to it.
    pub members: Vec<ReadValue>,
    /// The kind of undefined value; `None` for a loss of accuracy.
    pub kind: Option<UndefinedKind>,
    /// What happens, where how the operands came about says more than the hazard.
    pub what: Option<&'static str>,
}

/// An operation with its operands and result.
#[derive(Clone, Debug, PartialEq)]
pub struct Performed {
    pub operation: Operation,
    pub operands: Vec<Number>,
    /// The result, of the worst component.
    pub result: Number,
    pub(super) sources: Vec<Source>,
    /// The largest of the numbers that the first operand was computed from.
    pub(super) scale: f64,
}

impl HazardCandidate {
    /// Returns the key that distinguishes findings: the hazard and the line.
    pub fn key(&self, pure: &PureFunction) -> (&'static str, u32, u32) {
        // Inlined or repeated operations of one line are one finding for a reader.
        let at = pure.files.locate(self.place.span);
        (self.hazard.code(), self.place.span.file, at.line)
    }
}

/// A sample run with a trace.
pub(super) struct Examined {
    pub outcome: Outcome,
    /// How far the `f64` along its own branches is, if those are others.
    pub diverged: Option<SampleError>,
    pub called: PureCallResult,
    pub candidates: Vec<HazardCandidate>,
    pub trace: Box<Trace>,
}

impl Examined {
    /// Returns it without its trace, which takes much memory.
    pub fn without_trace(self) -> Examined {
        Examined { trace: Box::default(), ..self }
    }
}

/// The time that running one sample may always take.
const LONGEST: Duration = Duration::from_secs(1);

/// Runs a sample and returns the hazards it meets.
pub(super) fn examine(search: SampleSearch<'_>, sample: &Sample) -> Result<Examined, Failure> {
    let SampleSearch { pure, plan, .. } = search;
    // One that began in time may end after it.
    // At least a second, or nothing could be said of what was found at the end of the time.
    let deadline = Some(plan.until.end_with(LONGEST));
    let settings = Settings { trace: true, deadline, ..settings(plan, true) };
    let mut called = pure.call(&columns(std::slice::from_ref(sample)), 1, &settings)?;
    let trace = called.called.notes.trace.take().unwrap_or_default();
    let floats = floats(pure);
    let outcome = outcome(&called, &floats, 0);
    let graph = Graph { pure, trace: &trace, inputs: search.inputs() };
    let look = TracedSample { graph, sample };
    let mut candidates = Vec::new();
    // Every operation of the trace that is undefined by its own operands, in the order of
    // execution.
    for step in &trace.steps {
        if let Some(kind) = step.fault() {
            candidates.push(look.undefined(step, kind));
        }
    }
    // What the trace does not follow: doubles, buffers, variables.
    for seen in &called.called.notes.undefined {
        // Kinds that depend on values before them: the trace tells which operation made them.
        let is_of_trace = matches!(
            seen.kind,
            UndefinedKind::ZeroTimesInfinity
                | UndefinedKind::NanCompared
                | UndefinedKind::BornNan
                | UndefinedKind::BornInfinite
        );
        let is_known = candidates.iter().any(|known| known.place.span == seen.place.span);
        // A non-finite operand has an earlier cause.
        if !is_of_trace && !is_known && seen.operands.iter().all(|x| x.is_finite()) {
            candidates.push(HazardCandidate {
                hazard: seen.kind.hazard(),
                place: seen.place.clone(),
                operation: None,
                about: Vec::new(),
                members: Vec::new(),
                kind: Some(seen.kind),
                what: None,
            });
        }
    }
    let is_large = |off: &SampleError| plan.is_large(off);
    let mut diverged = None;
    // Losses of digits are looked for only in results that are wrong: intermediate errors may
    // cancel.
    if let Outcome::Finite(off, _) = outcome {
        if is_large(&off) {
            candidates.extend(look.inaccurate(&floats, &called));
        }
        // A comparison was decided within rounding: the result is compared with that of the other
        // branch.
        if called.called.unsure.first() == Some(&true) {
            let own =
                Settings { precision: Precision::Double, trace: false, watch: false, ..settings };
            let own = pure.call(&columns(std::slice::from_ref(sample)), 1, &own)?;
            match outcome_beside((&called, 0), (&own, 0), &floats) {
                Outcome::Finite(off, _) if !own.called.discarded[0] => diverged = Some(off),
                _ => {}
            }
        }
    }
    diverged = diverged.filter(is_large);
    candidates.extend(diverged.and_then(|_| look.diverged()));
    Ok(Examined { outcome, diverged, called, candidates, trace })
}
