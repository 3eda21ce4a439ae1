//! Advice that is measured: the expression that loses digits in another form of the catalogue, as
//! code, if the function with that form is better at the failing sample and around it.
//!
//! Each form is put into the shader's text and run; its errors are against the `f64` of the
//! function as written. Used by the report.

mod branch;
mod catalogue;
mod formula;
mod guards;
mod names;
mod terms;

use std::sync::Arc;
use std::time::Duration;

use serde::Serialize;

use super::classify::HazardCandidate;
use super::input::Sample;
use super::measure::{Outcome, floats, json_number, outcome, outcome_beside};
use super::plan::{SampleSearch, columns, settings};
use super::random::Random;
use crate::prove::{BoundGoal, Measure, ProofLimits, Until, bound};
use catalogue::{Form, forms};
use formula::Formula;
use guards::{Broken, angle, guards};
use landfall_exec::harness::call::pure::{PureCallResult, PureFunction, PureRequest};
use landfall_interp::graph::Rounding;
use landfall_interp::{Number, UndefinedKind};
use landfall_ir::analysis::hazard::Hazard;
use landfall_layout::Options;
use landfall_layout::source::{Source, Span};
use names::Names;

// Another form of an expression, with what it was measured to gain.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "AdviceObject"))]
pub struct Advice {
    /// The name of the rewrite.
    #[serde(rename = "rewrite")]
    pub name: &'static str,
    #[serde(skip)]
    pub span: Span,
    /// The expression as it is.
    pub before: String,
    /// The form to write in its place.
    pub code: String,
    /// The largest error at the samples as it is; null where the result is not defined.
    #[serde(serialize_with = "json_number")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<crate::measure::JsonNumber>"))]
    pub ulp_before: Option<f64>,
    #[serde(serialize_with = "json_number")]
    #[cfg_attr(feature = "schema", schemars(with = "crate::measure::JsonNumber"))]
    pub ulp_after: f64,
    /// The samples that rounding sends into another branch, as it is and with the form; null
    /// without a branch.
    pub flipped: Option<[usize; 2]>,
    /// Whether results change where they were right, by no more than a rounding of the inputs does.
    #[serde(skip)]
    pub is_moved: bool,
    /// The samples measured.
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    pub samples: usize,
    /// A proved bound of the function with that form over the domain, on any conformant device;
    /// null without one.
    #[serde(rename = "proved_ulp", serialize_with = "json_number")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<crate::measure::JsonNumber>"))]
    pub proved: Option<f64>,
    /// Whether it gains only where a device rounds a product and a sum once.
    #[serde(skip)]
    pub is_fused: bool,
}

/// The function, its text and its inputs.
pub(super) struct Advised<'a> {
    pub source: &'a Source,
    pub options: &'a Options,
    pub request: &'a PureRequest,
    pub search: SampleSearch<'a>,
}

/// The samples around a failing one.
const AROUND: usize = 255;

/// The error must fall by this factor.
const GAIN: f64 = 8.0;

/// Errors within this factor count as equal, and the shorter form is taken.
const ALIKE: f64 = 1.5;

/// A difference that is at most so large a share of its operands is rounding alone.
const ROUNDING: f64 = 1.0 / 1_048_576.0;

/// What a divisor is kept at or above, where the catalogue of hazards has no threshold: far below
/// all but an underflow, and its inverse is a number.
const LEAST: f64 = 1.0e-30;

/// The parts of the domain, and the time, for a proof.
const PARTS: u64 = 256;
const TIME: Duration = Duration::from_millis(300);

impl Advised<'_> {
    /// Returns the best form of a finding's expression; `None` if none of the catalogue is better.
    pub fn advice(&self, candidate: &HazardCandidate, sample: &Sample) -> Option<Advice> {
        let span = candidate.place.span;
        let (start, end) = (span.start as usize, span.end as usize);
        let main =
            self.search.pure.files.get(span.file).is_some_and(|f| f.text == self.source.text);
        // Rewrites edit the main text; an included file would have to be written elsewhere.
        if !main || self.search.plan.until.is_stopped() {
            return None;
        }
        let before = self.source.text.get(start..end)?;
        // A hazard with a kind is an undefined operation; one without is a loss of digits.
        match candidate.kind {
            Some(kind) => self.guard(candidate, kind, sample, before),
            None if candidate.hazard == Hazard::BranchDivergence => self.steady(span, sample),
            None => self.better_form(candidate, sample, before),
        }
    }

    /// Returns the function with other code in place of an expression.
    fn changed(&self, span: Span, code: &str) -> Option<PureFunction> {
        let text = &self.source.text;
        let (start, end) = (span.start as usize, span.end as usize);
        // In parentheses, whatever stands around it. The rewritten shader is parsed and lowered
        // anew.
        let changed = format!("{}({code}){}", text.get(..start)?, text.get(end..)?);
        let changed = Source { text: Arc::from(changed), ..self.source.clone() };
        PureFunction::new(&changed, self.options, self.request).ok()
    }

    /// Returns a form of an undefined expression that is defined at all samples, the failing one
    /// among them, and has the same results where the expression is defined.
    fn guard(
        &self,
        candidate: &HazardCandidate,
        kind: UndefinedKind,
        sample: &Sample,
        before: &str,
    ) -> Option<Advice> {
        let span = candidate.place.span;
        // A vector without a direction has none of another form.
        if candidate.hazard == Hazard::ParallelVectors {
            return None;
        }
        let operands = candidate.operation.as_ref().map_or(&[][..], |found| &found.operands);
        let scale = candidate.operation.as_ref().map_or(0.0, |found| found.scale);
        // Negative by rounding of the numbers it was computed from, in contrast to a negative
        // discriminant.
        let rounded = |n: &Number| n.double >= -ROUNDING * scale;
        let broken = Broken {
            text: before,
            kind,
            least: match candidate.hazard.is_arithmetic() {
                true => LEAST,
                false => candidate.hazard.info().threshold.map_or(LEAST, |found| found.value),
            },
            operands: operands.iter().map(|n| f64::from(n.single)).collect(),
            is_rounding: operands.first().is_some_and(rounded),
            language: self.source.language,
        };
        let angle = angle(&broken);
        let forms = angle.iter().map(|form| (form, true));
        let guards = guards(&broken);
        let forms: Vec<(&Form, bool)> =
            forms.chain(guards.iter().map(|form| (form, false))).collect();
        if forms.is_empty() {
            return None;
        }
        let mut samples = self.around(sample);
        // Half of the samples are near the failing one, half anywhere in the domain: a guard that
        // changes results elsewhere is none.
        samples.truncate(AROUND / 2);
        let sampler = self.search.generator.sampler;
        samples.extend(sampler.all_drawn(29, AROUND / 2));
        let settings = settings(self.search.plan, true);
        let own = self.search.pure.call(&columns(&samples), samples.len(), &settings).ok()?;
        let undefined = undefined_lanes(&own, samples.len());
        let floats = floats(self.search.pure);
        let is_right = |lane: usize| {
            !undefined[lane] && matches!(outcome(&own, &floats, lane), Outcome::Finite(..))
        };
        for (form, is_moved) in forms {
            let Some(pure) = self.changed(span, &form.code) else { continue };
            let Ok(called) = pure.call(&columns(&samples), samples.len(), &settings) else {
                continue;
            };
            // The place of the form in the changed text, with its parentheses.
            let last = span.start + form.code.len() as u32 + 2;
            let is_inside =
                |at: Span| at.file == span.file && at.end > span.start && at.start < last;
            // The operation itself may still be undefined in its new form.
            let remains = called.called.notes.undefined.iter().any(|n| is_inside(n.place.span));
            // What is undefined elsewhere is a finding of its own.
            let is_finite = matches!(outcome(&called, &floats, 0), Outcome::Finite(..));
            let is_defined = is_finite || undefined_lanes(&called, samples.len())[0];
            let mut most = 0.0f64;
            let is_same = (0..samples.len()).filter(|lane| is_right(*lane)).all(|lane| {
                if let Outcome::Finite(off, _) = outcome(&called, &floats, lane) {
                    most = most.max(off.ulp);
                }
                is_moved || is_same_result((&own, &called), self.search.pure, lane)
            });
            // A form that moves results by a rounding has to stay within what a rounding of the
            // inputs does.
            let is_same = is_same && (!is_moved || self.is_alike(&pure, &samples));
            if !remains && is_defined && is_same {
                return Some(Advice {
                    name: form.name,
                    span,
                    before: before.to_string(),
                    code: form.code.clone(),
                    ulp_before: None,
                    ulp_after: most,
                    flipped: None,
                    is_moved,
                    samples: samples.len(),
                    proved: None,
                    is_fused: false,
                });
            }
        }
        None
    }

    /// Returns the form of an expression that loses the fewest digits.
    fn better_form(
        &self,
        candidate: &HazardCandidate,
        // Each form is tried as code; whether it is better is measured, never assumed.
        sample: &Sample,
        before: &str,
    ) -> Option<Advice> {
        let span = candidate.place.span;
        let formula = Formula::read(before)?;
        let names = Names::before(&self.source.text, span.start as usize);
        let all: Vec<Form> = forms(&formula, &names, self.source.language);
        if all.is_empty() {
            return None;
        }
        let samples = self.around(sample);
        let settings = settings(self.search.plan, false);
        let own = self.search.pure.call(&columns(&samples), samples.len(), &settings).ok()?;
        let floats = floats(self.search.pure);
        let errors = |lane: usize| match outcome(&own, &floats, lane) {
            Outcome::Finite(off, _) => Some(off.ulp),
            Outcome::Discarded | Outcome::NotANumber | Outcome::Infinite => None,
        };
        let mut best: Option<(Advice, PureFunction)> = None;
        for form in all {
            let Some(pure) = self.changed(span, &form.code) else { continue };
            let Ok(called) = pure.call(&columns(&samples), samples.len(), &settings) else {
                continue;
            };
            let (mut most_before, mut most_after, mut fits) = (0.0f64, 0.0f64, true);
            for lane in 0..samples.len() {
                // The truth is the `f64` of the function as written, not of the form: a form that
                // computes something else fails here.
                let after = outcome_beside((&called, lane), (&own, lane), &floats);
                match (errors(lane), after) {
                    (Some(before), Outcome::Finite(off, _)) => {
                        most_before = most_before.max(before);
                        most_after = most_after.max(off.ulp);
                    }
                    // Around the failing sample (lane 0) the function may break for other reasons.
                    (None, _) if lane > 0 => {}
                    (_, Outcome::Discarded) if lane > 0 => {}
                    _ => fits = false,
                }
            }
            // Of forms about equally accurate the shorter one; of others the more accurate.
            let is_best = best.as_ref().is_none_or(|(known, _)| {
                let shorter = form.code.len() < known.code.len();
                let factor = if shorter { ALIKE } else { 1.0 / ALIKE };
                most_after < known.ulp_after * factor
            });
            // A device may round the product of a fused form, too.
            let is_better = most_after * GAIN <= most_before;
            // A fused form depends on the device, and is the last resort.
            if !fits || !is_better || !is_best || form.is_fused && best.is_some() {
                continue;
            }
            let advice = Advice {
                name: form.name,
                span,
                before: before.to_string(),
                code: form.code,
                ulp_before: Some(most_before),
                ulp_after: most_after,
                flipped: None,
                is_moved: false,
                samples: samples.len(),
                proved: None,
                is_fused: form.is_fused,
            };
            best = Some((advice, pure));
        }
        let (advice, pure) = best?;
        // The proved bound is of interest only below the error that was measured before.
        let proved = advice
            .ulp_before
            .and_then(|before| self.proved(&pure).filter(|proved| *proved < before));
        Some(Advice { proved, ..advice })
    }

    /// Returns a sample and others around it, in the domain.
    fn around(&self, sample: &Sample) -> Vec<Sample> {
        let mut random = Random::new(23, 23);
        let mut all = vec![sample.clone()];
        for nth in 0..AROUND {
            // Relative distances of 1, 1/2, ... 2^-23: the neighbourhood at all scales down to the
            // last place.
            let far = 0.5f64.powi(nth as i32 % 24);
            let inputs = self.search.inputs();
            let mut next = inputs.with_floats(sample, |x| x * (1.0 + random.between(-far, far)));
            if self.search.domain().fit(&mut next, inputs, &mut random) {
                all.push(next);
            }
        }
        all
    }

    /// Returns a bound of the error over the whole domain, where the engine finds one.
    fn proved(&self, pure: &PureFunction) -> Option<f64> {
        let stop = self.search.plan.until.flag().unwrap_or_default();
        let limits = ProofLimits {
            time: TIME,
            parts: PARTS,
            stop,
            seed: 1,
            threads: 1,
            samples_always: false,
        };
        let (rounding, measure, until) = (Rounding::Permitted, Measure::Ulp, Until::Below(1.0));
        let goal = BoundGoal { rounding, measure, until };
        let bound = bound(pure, self.search.inputs(), self.search.domain(), &limits, goal)?;
        Some(bound.ulp).filter(|ulp| ulp.is_finite())
    }
}

/// Returns for each lane whether an operation in it has no defined value.
fn undefined_lanes(called: &PureCallResult, lanes: usize) -> Vec<bool> {
    let mut all = vec![false; lanes];
    for lane in called.called.notes.undefined.iter().flat_map(|note| &note.lanes) {
        if let Some(is) = all.get_mut(*lane) {
            *is = true;
        }
    }
    all
}

/// Results that differ by more than this share, in `f64`, are others.
const SAME: f64 = 1.0e-6;

/// Whether the results of a lane are the same: floats up to rounding, all else exactly.
fn is_same_result(
    (own, changed): (&PureCallResult, &PureCallResult),
    pure: &PureFunction,
    lane: usize,
) -> bool {
    pure.results.iter().enumerate().all(|(nth, result)| {
        let [a, b] = [own, changed].map(|called| &called.results[nth]);
        result.ty.scalars().iter().enumerate().all(|(at, scalar)| match scalar.kind.is_float() {
            true => {
                let [x, y] = [a, b].map(|numbers| numbers.doubles[at][lane]);
                // NaN of the function as written may become any number.
                x == y || (x - y).abs() <= SAME * x.abs() || x.is_nan()
            }
            false => a.words[at][lane] == b.words[at][lane],
        })
    })
}
