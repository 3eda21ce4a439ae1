//! The sensitivity of a function to rounding of its inputs, which distinguishes an ill-conditioned
//! problem from an unstable formula.
//!
//! Changes each scalar by a unit of its last place and computes in `f64`. Used by the report.

use serde::Serialize;

use super::input::Sample;
use super::measure::{floats, json_number};
use super::plan::{SampleSearch, columns, neighbours, settings};

/// The effect of changing an input by a unit of its last place, in f64.
// Of the input for which it is worst.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "ConditionObject"))]
pub struct Condition {
    /// The input.
    pub path: String,
    /// The change of the result in 1/255 of full scale.
    #[serde(serialize_with = "json_number")]
    #[cfg_attr(feature = "schema", schemars(with = "crate::measure::JsonNumber"))]
    pub steps: f64,
    /// The condition number: the relative change of the result per relative change of the input.
    #[serde(serialize_with = "json_number")]
    #[cfg_attr(feature = "schema", schemars(with = "crate::measure::JsonNumber"))]
    pub number: f64,
}

/// Returns the condition of a function at a sample; `None` if its result is not finite, or after a
/// stop.
pub(super) fn condition(search: SampleSearch<'_>, sample: &Sample) -> Option<Condition> {
    let SampleSearch { pure, plan, .. } = search;
    if plan.until.is_stopped() {
        return None;
    }
    let samples = neighbours(sample, search.inputs());
    // One call for all neighbours: 2n + 1 lanes.
    let called = pure.call(&columns(&samples), samples.len(), &settings(plan, false)).ok()?;
    let floats = floats(pure);
    let value = |lane: usize, (nth, at): (usize, usize)| called.results[nth].doubles[at][lane];
    let scale = floats.iter().map(|&f| value(0, f).abs()).fold(1.0, f64::max);
    let size = floats.iter().map(|&f| value(0, f).abs()).fold(0.0, f64::max);
    let mut worst = Condition::default();
    for (lane, other) in samples.iter().enumerate().skip(1) {
        let moved = floats.iter().map(|&f| (value(lane, f) - value(0, f)).abs());
        let moved = moved.fold(0.0, f64::max);
        if !moved.is_finite() {
            continue;
        }
        let steps = 255.0 * moved / scale;
        if steps > worst.steps {
            let at = search.inputs().float_scalars().nth((lane - 1) / 2)?;
            let [old, new] =
                [sample[at], other[at]].map(|word| f64::from(f32::from_bits(word as u32)));
            // The condition number: relative change of the result by relative change of the input.
            let by = (new - old).abs() / old.abs().max(f64::from(f32::MIN_POSITIVE));
            let number = moved / size.max(f64::from(f32::MIN_POSITIVE)) / by;
            let path = pure
                .parameters
                .iter()
                .flat_map(|parameter| &parameter.scalars)
                .nth(at)
                .cloned()
                .unwrap_or_default();
            worst = Condition { steps, number, path };
        }
    }
    scale.is_finite().then_some(worst)
}
