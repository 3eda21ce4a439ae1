//! Another form of what a comparison tests, if rounding then seldom decides it: the discriminant of
//! a ray and a sphere by the perpendicular component.
//!
//! After Haines et al., Precision Improvements for Ray/Sphere Intersection (Ray Tracing Gems,
//! 2019):
//! `dot(o, d)² - dot(o, o)` of a unit vector `d` is `-dot(p, p)` with `p = o - d * dot(o, d)`.

use std::ops::Range;

use landfall_exec::harness::call::pure::PureFunction;
use landfall_interp::{Precision, Settings};
use landfall_layout::source::Span;

use super::formula::Formula::{self, Call, Leaf};
use super::formula::{binary, call};
use super::names::{Names, declaration};
use super::terms::{Term, collected, sum, terms};
use super::{AROUND, Advice, Advised, GAIN, SAME};
use crate::stress::branches::flipped;
use crate::stress::input::Sample;
use crate::stress::plan::{columns, settings};
use crate::stress::random::Random;

/// The times that the inputs of a sample are moved by a rounding each.
const MOVES: usize = 16;

/// A result of another form may be so many times as far off as a rounding of the inputs moves it.
const MOVED: f64 = 8.0;

/// The least number of different results among those compared.
const RESULTS: usize = 8;

/// Returns the form by the perpendicular component.
fn perpendicular(formula: &Formula, names: &Names) -> Option<Formula> {
    // The terms of the discriminant: `+dot(o, d)^2`, `-dot(o, o)` and the rest, usually the
    // squared radius.
    let all = collected(terms(formula, Some(names)));
    let is_dot =
        |formula: &Formula| matches!(formula, Call(name, of) if name == "dot" && of.len() == 2);
    let (square, of) = all.iter().enumerate().find_map(|(at, term)| match term.root()? {
        Call(name, of) if term.by == 1.0 && name == "dot" && of.len() == 2 => Some((at, of)),
        _ => None,
    })?;
    let is_length = |term: &Term, v: &Formula| match &term.factors[..] {
        [one @ Call(_, both)] => is_dot(one) && term.by == -1.0 && both.iter().all(|of| of == v),
        _ => false,
    };
    // Either argument may be the direction; the other one is whose square is subtracted.
    let (length, o, d) = [(&of[0], &of[1]), (&of[1], &of[0])]
        .into_iter()
        .find_map(|(o, d)| Some((all.iter().position(|term| is_length(term, o))?, o, d)))?;
    // The name that the shader already has for it keeps the form short.
    let along = names.name_of(&call("dot", of.clone())).map_or(call("dot", of.clone()), Leaf);
    let p = binary('-', o.clone(), binary('*', d.clone(), along));
    let rest = all.iter().enumerate().filter(|(at, _)| *at != square && *at != length);
    let rest: Vec<Term> = rest.map(|(_, term)| term.clone()).collect();
    Some(binary('-', sum(&rest), call("dot", vec![p.clone(), p])))
}

impl Advised<'_> {
    /// Returns a form of what a comparison tests that rounding seldom sends to another side, with
    /// the same results up to the rounding of the inputs.
    pub(super) fn steady(&self, comparison: Span, sample: &Sample) -> Option<Advice> {
        let place = self.tested(comparison)?;
        let before = self.source.text.get(place.clone())?.trim();
        let names = Names::before(&self.source.text, place.start);
        let code = perpendicular(&Formula::read(before)?, &names)?.to_string();
        let span = Span { start: place.start as u32, end: place.end as u32, ..comparison };
        let pure = self.changed(span, &code)?;
        let near = self.around(sample);
        // Samples around the failing one that rounding sends to the wrong side, as it is and with
        // the form.
        let [own, form] =
            [self.search.pure, &pure].map(|of| flipped(of, self.search.plan, &near).len());
        if own == 0 || form as f64 * GAIN > own as f64 || !self.is_alike(&pure, &near) {
            return None;
        }
        Some(Advice {
            name: "perpendicular component",
            span,
            before: before.to_string(),
            code,
            ulp_before: None,
            ulp_after: 0.0,
            flipped: Some([own, form]),
            is_moved: true,
            samples: near.len(),
            proved: None,
            is_fused: false,
        })
    }

    /// Returns the place of the expression that a comparison tests, where its name is declared.
    fn tested(&self, comparison: Span) -> Option<Range<usize>> {
        let text = &self.source.text;
        let (start, end) = (comparison.start as usize, comparison.end as usize);
        // One side of the comparison must be a name, whose declaration has the expression.
        let sides = text.get(start..end)?.split(['<', '>', '=']).map(str::trim);
        let mut names = sides.filter(|side| matches!(Formula::read(side), Some(Leaf(_))));
        names.find_map(|name| declaration(text, start, name))
    }

    /// Whether a changed function has the same results in `f64`, up to what a rounding of the
    /// inputs does to them: the form is that of a vector whose length is 1 up to rounding.
    pub(super) fn is_alike(&self, changed: &PureFunction, near: &[Sample]) -> bool {
        let mut samples = self.search.generator.sampler.all_drawn(29, AROUND / 2);
        // Samples come nearer with their number; the first ten of each 24 are about 2^-9 and more
        // apart. Those that are not at the edge itself.
        samples.extend(
            near.iter().skip(1).enumerate().filter(|(n, _)| n % 24 < 10).map(|(_, s)| s.clone()),
        );
        let settings =
            Settings { precision: Precision::Double, ..settings(self.search.plan, false) };
        let results = |pure: &PureFunction, samples: &[Sample]| -> Option<Vec<Vec<f64>>> {
            let called = pure.call(&columns(samples), samples.len(), &settings).ok()?;
            let lanes = called.results.iter().flat_map(|result| &result.doubles);
            Some(lanes.map(|lanes| lanes.to_vec()).collect())
        };
        let mut random = Random::new(37, 37);
        let mut moved = |sample: &Sample| {
            self.search.inputs().with_floats(sample, |x| {
                x * (1.0 + random.between(-1.0, 1.0) * f64::from(f32::EPSILON))
            })
        };
        let all_moved: Vec<Vec<Sample>> =
            (0..MOVES).map(|_| samples.iter().map(&mut moved).collect()).collect();
        let (Some(own), Some(form)) =
            (results(self.search.pure, &samples), results(changed, &samples))
        else {
            return false;
        };
        let all_moved: Option<Vec<_>> =
            all_moved.iter().map(|s| results(self.search.pure, s)).collect();
        let Some(all_moved) = all_moved else { return false };
        // Too few different results, such as one colour for hit and one for miss, would agree by
        // accident.
        let mut different: Vec<u64> = own.iter().flatten().map(|x| x.to_bits()).collect();
        different.sort_unstable();
        different.dedup();
        let is_same = |scalar: usize, lane: usize| {
            let of = |all: &[Vec<f64>]| all[scalar][lane];
            let x = of(&own);
            // As far as the function as written is moved by rounding its inputs.
            let by_moves = all_moved.iter().map(|all| (of(all) - x).abs()).fold(0.0, f64::max);
            let off = (of(&form) - x).abs();
            !x.is_finite() || off <= (SAME * x.abs()).max(MOVED * by_moves)
        };
        let lanes = 0..samples.len();
        different.len() >= RESULTS
            && (0..own.len()).all(|s| lanes.clone().all(|lane| is_same(s, lane)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand, from the paper: a ray from `o` along `d`, a sphere of radius `r` at the origin.
    #[test]
    fn the_square_of_a_projection_less_the_square_of_a_length_is_a_perpendicular() {
        let form = |text: &str| {
            let (before, last) = text.rsplit_once("return ").expect("a statement returns");
            let names = Names::before(text, before.len());
            let formula = Formula::read(last).expect("it is an expression");
            perpendicular(&formula, &names).map(|form| form.to_string())
        };
        let wanted = Some("r * r - dot(o - d * b, o - d * b)".to_string());
        let b = "float b = dot(o, d); ";
        assert_eq!(form(&format!("{b}return b * b - dot(o, o) + r * r")), wanted);
        assert_eq!(form(&format!("{b}float c = dot(o, o) - r * r; return b * b - c")), wanted);
        assert_eq!(form("return b * b - c"), None);
        assert_eq!(form(&format!("{b}return b * b - dot(d, o)")), None);
        assert_eq!(form(&format!("{b}return b * b - 2.0 * dot(o, o)")), None);
    }
}
