//! Assigns a hazard and an operation to a sample.
//!
//! Runs one sample with a trace of all operations, looks for operations without a defined value and
//! for the one that introduced the error, and classifies them by operation and by the roles of
//! their inputs. Used by [`find`](super::find).

mod hazard;

use std::time::Duration;

use super::blame::Graph;
use super::input::{Input, Sample};
use super::measure::{Outcome, SampleError, floats, outcome, outcome_beside};
use super::plan::{Plan, columns, settings};
use landfall_exec::backend::Failure;
use landfall_exec::harness::call::pure::{PureCallResult, PureFunction};
use landfall_exec::interp::{
    Number, Operation, Precision, Settings, Source, SourceLocation, Trace, TracedOperation,
    UndefinedKind,
};
use landfall_ir::analysis::hazard::Hazard;

use hazard::TracedSample;

/// A hazard found in a sample.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub hazard: Hazard,
    pub place: SourceLocation,
    /// The operation with its operands and result.
    pub operation: Option<Performed>,
    /// The indices of the inputs involved.
    pub about: Vec<usize>,
    /// The kind of undefined value; `None` for a loss of accuracy.
    pub kind: Option<UndefinedKind>,
}

/// An operation with its operands and result.
#[derive(Clone, Debug, PartialEq)]
pub struct Performed {
    /// The operation.
    pub operation: Operation,
    /// The operands.
    pub operands: Vec<Number>,
    /// The result, of the worst component.
    pub result: Number,
    pub(super) sources: Vec<Source>,
}

impl Candidate {
    /// Returns the key that distinguishes findings: the hazard and the line.
    pub fn key(&self, pure: &PureFunction) -> (&'static str, u32, u32) {
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
    pub candidates: Vec<Candidate>,
    pub trace: Box<Trace>,
}

/// The time that running one sample may always take.
const LONGEST: Duration = Duration::from_secs(1);

/// Runs a sample and returns the hazards it meets.
pub(super) fn examine(
    pure: &PureFunction,
    inputs: &[Input],
    sample: &Sample,
    plan: &Plan,
) -> Result<Examined, Failure> {
    // One that began in time may end after it.
    let deadline = Some(plan.until.end_with(LONGEST));
    let settings = Settings { trace: true, deadline, ..settings(plan, true) };
    let mut called = pure.call(&columns(std::slice::from_ref(sample)), 1, &settings)?;
    let trace = called.called.notes.trace.take().unwrap_or_default();
    let floats = floats(pure);
    let outcome = outcome(&called, &floats, 0);
    let graph = Graph { pure, trace: &trace, inputs };
    let look = TracedSample { graph, sample };
    let mut candidates = Vec::new();
    for step in &trace.steps {
        if let Some(kind) = undefined(step) {
            candidates.push(look.undefined(step, kind));
        }
    }
    for seen in &called.called.notes.undefined {
        let kind = seen.kind;
        let hazard = match kind {
            UndefinedKind::Uninitialised => Hazard::Uninitialised,
            UndefinedKind::IndexOutOfBounds | UndefinedKind::PastEndOfBuffer => {
                Hazard::CountPastArray
            }
            UndefinedKind::IntegerDivisionByZero
            | UndefinedKind::IntegerOverflow
            | UndefinedKind::RemainderOfNegative
            | UndefinedKind::ShiftTooFar
            | UndefinedKind::BitsOutOfRange
            | UndefinedKind::ConversionOutOfRange
            | UndefinedKind::NanFromBuffer => Hazard::UndefinedOperation,
            // The trace shows these with the origin of their operands.
            UndefinedKind::DivisionByZero
            | UndefinedKind::ZeroTimesInfinity
            | UndefinedKind::RootOfNegative
            | UndefinedKind::LogOfNonPositive
            | UndefinedKind::PowOfNegative
            | UndefinedKind::PowOfZero
            | UndefinedKind::ArcOutOfRange
            | UndefinedKind::AtanOfZeros
            | UndefinedKind::NormalizeOfZero
            | UndefinedKind::SmoothStepEdges
            | UndefinedKind::ClampBounds
            | UndefinedKind::SquaresTooLarge
            | UndefinedKind::SquaresTooSmall
            | UndefinedKind::NanCompared
            | UndefinedKind::BornNan
            | UndefinedKind::BornInfinite => continue,
        };
        let place = seen.place.clone();
        // A non-finite operand has an earlier cause.
        if seen.operands.iter().all(|x| x.is_finite()) {
            let about = Vec::new();
            candidates.push(Candidate { hazard, place, operation: None, about, kind: Some(kind) });
        }
    }
    let is_large = |off: &SampleError| off.steps > plan.steps || off.ulp > plan.ulp;
    let mut diverged = None;
    if let Outcome::Finite(off, _) = outcome {
        if is_large(&off) {
            candidates.extend(look.inaccurate(&floats, &called));
        }
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

/// Returns why an operation with finite operands has no defined value.
fn undefined(step: &TracedOperation) -> Option<UndefinedKind> {
    use UndefinedKind as U;
    // The reference follows the branches of the `f32`, which alone decide what is defined.
    let finite = |n: &Number| n.single.is_finite();
    let compares = matches!(
        step.operation,
        Operation::Min | Operation::Max | Operation::Clamp | Operation::Edge
    );
    // A NaN that goes on is a finding where it arises; one that is hidden is on other devices not.
    let hides = || step.operands.iter().any(|o| o.number.single.is_nan());
    if compares && step.results.iter().all(finite) && hides() {
        return Some(U::NanCompared);
    }
    if !step.operands.iter().all(|o| finite(&o.number)) {
        return None;
    }
    let x = |i: usize| f64::from(step.operands[i].number.single);
    let found = match step.operation {
        Operation::Div | Operation::Rem if x(1) == 0.0 => Some(U::DivisionByZero),
        Operation::Pow if x(0) < 0.0 => Some(U::PowOfNegative),
        Operation::Pow if x(0) == 0.0 && x(1) <= 0.0 => Some(U::PowOfZero),
        Operation::Root if x(0) < 0.0 => Some(U::RootOfNegative),
        Operation::InverseRoot if x(0) <= 0.0 => Some(U::RootOfNegative),
        Operation::Log if x(0) <= 0.0 => Some(U::LogOfNonPositive),
        Operation::SmoothStep if x(0) >= x(1) => Some(U::SmoothStepEdges),
        Operation::Clamp if step.operands.len() == 3 && x(1) > x(2) => Some(U::ClampBounds),
        Operation::Normalize if step.operands.iter().all(|o| o.number.single == 0.0) => {
            Some(U::NormalizeOfZero)
        }
        _ => None,
    };
    let found = found.or_else(|| squares(step));
    found.or_else(|| {
        let odd = step.results.iter().find(|n| !finite(n))?;
        Some(if odd.single.is_nan() { U::BornNan } else { U::BornInfinite })
    })
}

/// Returns what is undefined in the squares summed up for a length.
fn squares(step: &TracedOperation) -> Option<UndefinedKind> {
    if !matches!(step.operation, Operation::Normalize | Operation::Length | Operation::Distance) {
        return None;
    }
    let of = |i: usize| step.operands[i].number.double;
    let half = step.operands.len() / 2;
    let square: f64 = match step.operation {
        Operation::Distance => (0..half).map(|i| (of(i) - of(i + half)).powi(2)).sum(),
        _ => (0..step.operands.len()).map(|i| of(i).powi(2)).sum(),
    };
    // The length of a scalar takes no root.
    if step.operands.len() == 1 || square == 0.0 {
        None
    } else if square > f64::from(f32::MAX) {
        Some(UndefinedKind::SquaresTooLarge)
    } else if square < f64::from(f32::MIN_POSITIVE) {
        Some(UndefinedKind::SquaresTooSmall)
    } else {
        None
    }
}
