//! What is permitted at one sample, and whether it is as much as was seen there.
//!
//! Runs the sample by [`permitted`](crate::accuracy::permitted). Feeds the report.

use super::input::Sample;
use super::measure::floats;
use super::sample::{Plan, columns, settings};
use crate::accuracy::permitted::farthest;
use landfall_exec::harness::call::pure::Pure;
use landfall_exec::interp::{Precision, Settings};

/// What is permitted at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PermittedAt {
    /// The farthest from the `f64` that a conformant device may be, in steps; infinite where it
    /// may give anything.
    pub steps: f64,
    /// Whether that is as far as the evaluator's `f32` is.
    pub any: bool,
}

/// Whether a driver may give what it gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Any conformant adapter may do this.
    Permitted,
    /// No conformant adapter may: this one is wrong.
    Wrong,
}

/// Whether the floats a driver gave lie within what is permitted at a sample; none where that is
/// not known.
pub(super) fn verdict(pure: &Pure, sample: &Sample, plan: &Plan, given: &[f32]) -> Option<Verdict> {
    let around = Settings { precision: Precision::Permitted, ..settings(plan, false) };
    let called = pure.call(&columns(std::slice::from_ref(sample)), 1, &around).ok()?;
    // A branch that may go the other way may lead anywhere.
    if called.called.unsure.first().copied().unwrap_or(false) {
        return Some(Verdict::Permitted);
    }
    for ((nth, at), single) in floats(pure).into_iter().zip(given) {
        let [low, high] = called.results[nth].permitted.as_ref()?.get(at)?[0];
        let any = low == f64::NEG_INFINITY && high == f64::INFINITY || low.is_nan();
        let single = f64::from(*single);
        // NaN is within nothing.
        let within = any || (low..=high).contains(&single);
        if !within {
            return Some(Verdict::Wrong);
        }
    }
    Some(Verdict::Permitted)
}

/// What is permitted at a sample; none where it is not known, as of `f16`.
pub(super) fn permitted(pure: &Pure, sample: &Sample, plan: &Plan) -> Option<PermittedAt> {
    let columns = columns(std::slice::from_ref(sample));
    let both = pure.call(&columns, 1, &settings(plan, false)).ok()?;
    let around = Settings { precision: Precision::Permitted, ..settings(plan, false) };
    let called = pure.call(&columns, 1, &around).ok()?;
    let floats = floats(pure);
    let truth: Vec<f64> =
        floats.iter().map(|&(nth, at)| both.results[nth].doubles[at][0]).collect();
    let single =
        |&(nth, at): &(usize, usize)| f32::from_bits(both.results[nth].words[at][0] as u32);
    let own = floats.iter().zip(&truth).map(|(at, truth)| (f64::from(single(at)) - truth).abs());
    let own: Vec<f64> = own.collect();
    let worst = own.iter().copied().fold(0.0, f64::max);
    let most = farthest(&called, &floats, 0, &truth)?;
    // A branch that may go the other way may lead anywhere.
    let any = most.unsure || own.iter().any(|off| off.is_nan()) || most.far >= 0.5 * worst;
    Some(PermittedAt { steps: most.steps, any })
}
