//! The gain of the robust form of an operation, measured with the operands of a sample.
//!
//! Reads the trace of a finding's sample; used by the report.

use serde::Serialize;

use super::blame::Graph;
use super::classify::{Examined, HazardCandidate};
use super::measure::json_number;
use super::plan::SampleSearch;
use landfall_interp::{Operation, Source, TracedOperation};
use landfall_ir::analysis::hazard::Hazard;

// The error of the shader's form of one operation, and of a robust form with the same operands.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "GainObject"))]
pub struct Gain {
    // The name of the form and of the error.
    pub form: &'static str,
    #[serde(serialize_with = "json_number")]
    #[cfg_attr(feature = "schema", schemars(with = "crate::measure::JsonNumber"))]
    pub before: f64,
    #[serde(serialize_with = "json_number")]
    #[cfg_attr(feature = "schema", schemars(with = "crate::measure::JsonNumber"))]
    pub after: f64,
}

/// Returns the gain at the operation of a finding; `None` if the form does not apply.
pub(super) fn gain(
    search: SampleSearch<'_>,
    examined: &Examined,
    candidate: &HazardCandidate,
) -> Option<Gain> {
    let graph = Graph { pure: search.pure, trace: &examined.trace, inputs: search.inputs() };
    let operation = candidate.operation.as_ref()?;
    let result = operation.result;
    let off = |x: f32, truth: f64| (f64::from(x) - truth).abs();
    if candidate.hazard == Hazard::NarrowCone {
        // theta - outer, as (1 - outer) - |L - D|^2 / 2.
        let (theta, at) = operation
            .sources
            // The operand of the difference that is a cosine, by its place, and the other one.
            .iter()
            .enumerate()
            .find_map(|(at, source)| Some((dot(&graph, *source)?, at)))?;
        let outer = operation.operands.get(1 - at.min(1))?;
        let (half, turned) = chord(theta)?;
        let by_chord = (1.0 - outer.single) - half;
        let by_chord = if at == 0 { by_chord } else { -by_chord };
        if turned {
            return None;
        }
        let form = "absolute error of the comparison, if its cosine is computed from the difference of the vectors";
        let (before, after) = (off(result.single, result.double), off(by_chord, result.double));
        return Some(Gain { form, before, after });
    }
    let powers = [Hazard::LargeExponent, Hazard::BaseAboveOne];
    if powers.contains(&candidate.hazard) && operation.operation == Operation::Pow {
        let step = dot(&graph, operation.sources[0])?;
        let (half, turned) = chord(step)?;
        let exponent = f64::from(operation.operands[1].single);
        // (1 - m)^n with m = |a - b|^2 / 2.
        let by_chord = (exponent * f64::from(-half).ln_1p()).exp() as f32;
        if turned {
            return None;
        }
        let form = "absolute error of the power, if its base is computed from the difference of the vectors";
        let (before, after) = (off(result.single, result.double), off(by_chord, result.double));
        return Some(Gain { form, before, after });
    }
    None
}

/// Returns the dot product that a number is, clamped or not.
fn dot<'g>(graph: &Graph<'g>, source: Source) -> Option<&'g TracedOperation> {
    let (step, _) = graph.step(source)?;
    match step.operation {
        Operation::Dot => Some(step),
        Operation::Max | Operation::Min | Operation::Clamp => {
            step.operands.iter().find_map(|o| dot(graph, o.source))
        }
        _ => None,
    }
}

/// Returns half the squared chord between the vectors of a dot product, in `f32`, and whether they
/// point in opposite directions, where the form does not help.
fn chord(step: &TracedOperation) -> Option<(f32, bool)> {
    let half = step.operands.len() / 2;
    let (a, b) = step.operands.split_at(half);
    let square: f32 = a
        .iter()
        .zip(b)
        .map(|(x, y)| {
            let off = x.number.single - y.number.single;
            off * off
        })
        .sum();
    let chord = 0.5 * square;
    // 1 - cos and the chord agree for unit vectors; a given vector is one only up to rounding,
    // which the f64 does not correct.
    let cosine = step.results.first()?.double;
    let unit = ((1.0 - cosine) - f64::from(chord)).abs() < 1.0e-6;
    let given = step.operands.iter().any(|o| matches!(o.source, Source::Input { .. }));
    (unit && !given).then_some((chord, cosine < 0.0))
}
