//! Advice that is measured: the expression that loses digits in another form of the catalogue, as
//! code, if the function with that form is better at the failing sample and around it.
//!
//! Each form is put into the shader's text and run; its errors are against the `f64` of the function
//! as written. Used by the report.

mod catalogue;
mod formula;
mod names;
mod terms;

use std::sync::Arc;
use std::time::Duration;

use super::classify::Candidate;
use super::domain::Domain;
use super::input::{Inputs, Sample, float};
use super::measure::{Outcome, floats, outcome, outcome_beside};
use super::plan::{Plan, columns, settings};
use super::random::Random;
use crate::accuracy::prove::{Limits, Measure, bound};
use catalogue::{Form, clamps, forms};
use formula::Formula;
use landfall_exec::harness::call::pure::{PureFunction, PureRequest};
use landfall_exec::interp::graph::Rounding;
use landfall_layout::Options;
use landfall_layout::source::Source;
use names::Names;

/// Another form of an expression, with what it was measured to gain.
#[derive(Clone, Debug, PartialEq)]
pub struct Advice {
    /// The name of the rewrite.
    pub name: &'static str,
    /// The expression as it is.
    pub before: String,
    /// The form to write in its place.
    pub code: String,
    /// The largest error in units of the last place at the samples, as it is; `None` where the
    /// result is not defined.
    pub ulp_before: Option<f64>,
    /// The largest error of the form there.
    pub ulp_after: f64,
    /// The samples measured.
    pub samples: usize,
    /// A proved bound of the error of the function with the form over the whole domain, on any
    /// conformant device, in units of the last place.
    pub proved: Option<f64>,
    /// Whether it gains only where a device rounds a product and a sum once.
    pub is_fused: bool,
}

/// The function, its text and its inputs.
pub(super) struct Advised<'a> {
    pub source: &'a Source,
    pub options: &'a Options,
    pub request: &'a PureRequest,
    pub pure: &'a PureFunction,
    pub inputs: &'a Inputs,
    pub domain: &'a Domain,
    pub plan: &'a Plan,
}

/// The samples around a failing one.
const AROUND: usize = 255;

/// The error must fall by this factor.
const GAIN: f64 = 8.0;

/// Errors within this factor count as equal, and the shorter form is taken.
const ALIKE: f64 = 1.5;

/// The parts of the domain, and the time, for a proof.
const PARTS: u64 = 256;
const TIME: Duration = Duration::from_millis(300);

impl Advised<'_> {
    /// Returns the best form of a finding's expression; `None` if none of the catalogue is better.
    pub fn advice(&self, candidate: &Candidate, sample: &Sample) -> Option<Advice> {
        let span = candidate.place.span;
        let (start, end) = (span.start as usize, span.end as usize);
        let text = &self.source.text;
        let main = self.pure.files.get(span.file).is_some_and(|file| file.text == *text);
        if !main || self.plan.until.is_stopped() {
            return None;
        }
        let before = text.get(start..end)?;
        let formula = Formula::read(before)?;
        let all: Vec<Form> = match candidate.kind {
            None => forms(&formula, &Names::before(text, start), self.source.language),
            Some(kind) => clamps(&formula, kind),
        };
        if all.is_empty() {
            return None;
        }
        let samples = self.around(sample);
        let settings = settings(self.plan, false);
        let own = self.pure.call(&columns(&samples), samples.len(), &settings).ok()?;
        let floats = floats(self.pure);
        let errors = |lane: usize| match outcome(&own, &floats, lane) {
            Outcome::Finite(off, _) => Some(off.ulp),
            Outcome::Discarded | Outcome::NotANumber | Outcome::Infinite => None,
        };
        let is_undefined = candidate.kind.is_some();
        let mut best: Option<(Advice, PureFunction)> = None;
        for form in all {
            let mut changed = String::with_capacity(text.len() + form.code.len() + 2);
            changed.push_str(&text[..start]);
            changed.push_str(&format!("({})", form.code));
            changed.push_str(&text[end..]);
            let changed = Source { text: Arc::from(changed), ..self.source.clone() };
            let Ok(pure) = PureFunction::new(&changed, self.options, self.request) else {
                continue;
            };
            let Ok(called) = pure.call(&columns(&samples), samples.len(), &settings) else {
                continue;
            };
            let (mut most_before, mut most_after, mut fits) = (0.0f64, 0.0f64, true);
            for lane in 0..samples.len() {
                let after = match is_undefined && errors(lane).is_none() {
                    // Nothing to compare with: defined is enough.
                    true => outcome(&called, &floats, lane),
                    false => outcome_beside((&called, lane), (&own, lane), &floats),
                };
                match (errors(lane), after) {
                    (_, Outcome::Finite(off, _)) if lane == 0 || errors(lane).is_some() => {
                        most_before = most_before.max(errors(lane).unwrap_or(0.0));
                        let counted = !(is_undefined && errors(lane).is_none());
                        most_after = most_after.max(if counted { off.ulp } else { 0.0 });
                    }
                    (None, _) if lane > 0 => {}
                    (_, Outcome::Discarded) if lane > 0 => {}
                    _ => fits = false,
                }
            }
            let better = match is_undefined {
                true => most_after <= most_before,
                false => most_after * GAIN <= most_before,
            };
            let is_best = best.as_ref().is_none_or(|(known, _)| {
                let shorter = form.code.len() < known.code.len();
                let factor = if shorter { ALIKE } else { 1.0 / ALIKE };
                most_after < known.ulp_after * factor
            });
            // A device may round the product of a fused form, too.
            if !fits || !better || !is_best || form.is_fused && best.is_some() {
                continue;
            }
            let advice = Advice {
                name: form.name,
                before: before.to_string(),
                code: form.code,
                ulp_before: (!is_undefined).then_some(most_before),
                ulp_after: most_after,
                samples: samples.len(),
                proved: None,
                is_fused: form.is_fused,
            };
            best = Some((advice, pure));
        }
        let (advice, pure) = best?;
        let proved = advice
            .ulp_before
            .and_then(|before| self.proved(&pure).filter(|proved| *proved < before));
        Some(Advice { proved, ..advice })
    }

    /// Returns a sample and others around it, in the domain.
    fn around(&self, sample: &Sample) -> Vec<Sample> {
        let mut random = Random::new(23, 23);
        let scalars: Vec<usize> = self
            .inputs
            .iter()
            .filter(|input| input.is_float())
            .flat_map(|input| input.range())
            .collect();
        let mut all = vec![sample.clone()];
        for nth in 0..AROUND {
            let mut next = sample.clone();
            let far = 0.5f64.powi(nth as i32 % 24);
            for &at in &scalars {
                let x = f64::from(float(sample, at));
                let moved = x * (1.0 + random.between(-far, far));
                next[at] = u64::from((moved as f32).to_bits());
            }
            if self.domain.fit(&mut next, self.inputs, &mut random) {
                all.push(next);
            }
        }
        all
    }

    /// Returns a bound of the error over the whole domain, where the engine finds one.
    fn proved(&self, pure: &PureFunction) -> Option<f64> {
        let stop = self.plan.until.flag().unwrap_or_default();
        let limits = Limits { time: TIME, parts: PARTS, stop, seed: 1, threads: 1 };
        let enough = (Rounding::Permitted, Measure::Ulp, 1.0);
        let bound = bound(pure, self.inputs, self.domain, &limits, enough)?;
        Some(bound.ulp).filter(|ulp| ulp.is_finite())
    }
}
