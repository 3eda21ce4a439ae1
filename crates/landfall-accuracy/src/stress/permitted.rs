//! The error permitted at a sample, and whether it covers the observed one.
//!
//! Runs the sample with [`permitted`](crate::permitted). Used by the report.

use serde::Serialize;

use super::input::Sample;
use super::measure::{floats, json_number};
use super::plan::{SampleSearch, columns, settings};
use crate::permitted::farthest;
use landfall_interp::{Precision, Settings};

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "PermittedObject"))]
pub struct PermittedAt {
    // The largest error of a conformant device against the `f64`; infinite where results are
    // unbounded.
    #[serde(serialize_with = "json_number")]
    #[cfg_attr(feature = "schema", schemars(with = "crate::measure::JsonNumber"))]
    pub steps: f64,
    /// Whether the interpreter's error is within that of a conformant device.
    #[serde(rename = "any_adapter")]
    pub any: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Permitted on any conformant adapter.
    Permitted,
    /// Outside the permitted error: the driver is faulty.
    Wrong,
}

/// Returns whether a driver's floats are permitted at a sample; `None` where that is unknown.
pub(super) fn verdict(
    SampleSearch { pure, plan, .. }: SampleSearch<'_>,
    sample: &Sample,
    given: &[f32],
) -> Option<Verdict> {
    let around = Settings { precision: Precision::Permitted, ..settings(plan, false) };
    let called = pure.call(&columns(std::slice::from_ref(sample)), 1, &around).ok()?;
    // A branch that may go the other way has unbounded effect.
    if called.called.unsure.first().copied().unwrap_or(false) {
        return Some(Verdict::Permitted);
    }
    for ((nth, at), single) in floats(pure).into_iter().zip(given) {
        let [low, high] = called.results[nth].permitted.as_ref()?.get(at)?[0];
        // An interval of everything, or one that is not a number: any result is permitted, NaN as
        // well.
        let any = low == f64::NEG_INFINITY && high == f64::INFINITY || low.is_nan();
        let single = f64::from(*single);
        // NaN is in no interval.
        let within = any || (low..=high).contains(&single);
        if !within {
            return Some(Verdict::Wrong);
        }
    }
    Some(Verdict::Permitted)
}

/// Returns the error permitted at a sample; `None` where it is unknown, as for `f16`.
pub(super) fn permitted(
    SampleSearch { pure, plan, .. }: SampleSearch<'_>,
    sample: &Sample,
) -> Option<PermittedAt> {
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
    // A branch that may go the other way has unbounded effect.
    let any = most.unsure || own.iter().any(|off| off.is_nan()) || most.far >= 0.5 * worst;
    let steps = if most.unsure { f64::INFINITY } else { most.steps };
    Some(PermittedAt { steps, any })
}
