//! How far conformant devices may be apart at a sample: what tells an adapter that is wrong from
//! code that any of them may get wrong.
//!
//! Runs the sample with the bounds WGSL and Vulkan set to each operation. Feeds the report.

use super::input::Sample;
use super::measure::floats;
use super::sample::{Plan, columns, settings};
use crate::run::call::pure::Pure;
use crate::run::eval::{Precision, Settings};

/// What is permitted at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Permitted {
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
pub(super) fn permitted(pure: &Pure, sample: &Sample, plan: &Plan) -> Option<Permitted> {
    let columns = columns(std::slice::from_ref(sample));
    let both = pure.call(&columns, 1, &settings(plan, false)).ok()?;
    let around = Settings { precision: Precision::Permitted, ..settings(plan, false) };
    let called = pure.call(&columns, 1, &around).ok()?;
    let mut scale = 1.0f64;
    let mut far = 0.0f64;
    let mut own = 0.0f64;
    for (nth, at) in floats(pure) {
        let truth = both.results[nth].doubles[at][0];
        let single = f32::from_bits(both.results[nth].words[at][0] as u32);
        let [low, high] = called.results[nth].permitted.as_ref()?.get(at)?[0];
        scale = scale.max(truth.abs());
        own = own.max((f64::from(single) - truth).abs());
        let off = (truth - low).abs().max((high - truth).abs());
        far = far.max(if off.is_nan() { f64::INFINITY } else { off });
    }
    // A branch that may go the other way may lead anywhere.
    let unsure = called.called.unsure.first().copied().unwrap_or(false);
    let steps = 255.0 * far / scale;
    let any = unsure || own.is_nan() || far >= 0.5 * own;
    Some(Permitted { steps, any })
}
