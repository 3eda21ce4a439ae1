//! Errors of `f32` results against `f64` ones, and their distribution in constant memory.
//!
//! Reads results of [`PureFunction::call`](landfall_exec::harness::call::pure::PureFunction::call);
//! used by [`stress`](super::stress) and [`bench`](mod@super::bench).

mod json;

use serde::Serialize;

pub use json::JsonNumber;
pub(crate) use json::json_number;
use landfall_exec::harness::call::pure::{PureCallResult, PureFunction};
use landfall_layout::buffer::float::last_place;
use landfall_layout::shape::ScalarKind;

/// The worst component of the result: f32 against f64.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "OffObject"))]
pub struct SampleError {
    /// In units of the last place of an f32.
    // One near 0 beside a larger one is measured as if it were 2^-10 of that.
    #[serde(serialize_with = "json_number")]
    #[cfg_attr(feature = "schema", schemars(with = "crate::measure::JsonNumber"))]
    pub ulp: f64,
    /// Relative to the value, or to 2^-10 of full scale if larger.
    #[serde(serialize_with = "json_number")]
    #[cfg_attr(feature = "schema", schemars(with = "crate::measure::JsonNumber"))]
    pub relative: f64,
    /// In 1/255 of full scale, which is 1 or the largest component.
    #[serde(serialize_with = "json_number")]
    #[cfg_attr(feature = "schema", schemars(with = "crate::measure::JsonNumber"))]
    pub steps: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// The function executed `discard`.
    Discarded,
    /// A result is NaN in `f32`.
    NotANumber,
    Infinite,
    /// All results are finite: the error, and whether the worst is too large.
    Finite(SampleError, bool),
}

/// Returns the results that are `f32`: the index of the result and of the scalar in it.
pub(super) fn floats(pure: &PureFunction) -> Vec<(usize, usize)> {
    let mut all = Vec::new();
    for (nth, result) in pure.results.iter().enumerate() {
        for (at, scalar) in result.ty.scalars().iter().enumerate() {
            if scalar.kind == ScalarKind::Float && scalar.width <= 4 {
                all.push((nth, at));
            }
        }
    }
    all
}

pub(super) fn outcome(called: &PureCallResult, floats: &[(usize, usize)], lane: usize) -> Outcome {
    if called.called.discarded.get(lane).copied().unwrap_or(false) {
        return Outcome::Discarded;
    }
    let pair = |nth: usize| {
        let (result, at) = floats[nth];
        let numbers = &called.results[result];
        (f32::from_bits(numbers.words[at][lane] as u32), numbers.doubles[at][lane])
    };
    outcome_of(floats, pair)
}

/// Returns the outcome of a lane's `f32`, compared with the `f64` of a lane of another call.
pub(super) fn outcome_beside(
    (called, lane): (&PureCallResult, usize),
    (other, beside): (&PureCallResult, usize),
    floats: &[(usize, usize)],
) -> Outcome {
    let pair = |nth: usize| {
        let (result, at) = floats[nth];
        let single = f32::from_bits(called.results[result].words[at][lane] as u32);
        (single, other.results[result].doubles[at][beside])
    };
    outcome_of(floats, pair)
}

/// How many times smaller than the largest component of a result one near 0 is.
const NEAR_ZERO: f64 = 1024.0;

/// Returns the outcome of the floats of some results, each an `f32` and its expected value.
pub(super) fn outcome_of(floats: &[(usize, usize)], pair: impl Fn(usize) -> (f32, f64)) -> Outcome {
    let mut infinite = false;
    for nth in 0..floats.len() {
        let (single, _) = pair(nth);
        if single.is_nan() {
            return Outcome::NotANumber;
        }
        infinite |= single.is_infinite();
    }
    if infinite {
        return Outcome::Infinite;
    }
    // The scale of steps is the largest result of the call, and at least 1.
    let size = |nth: usize| Some(pair(nth).1.abs()).filter(|size| size.is_finite()).unwrap_or(0.0);
    let scale = (0..floats.len()).map(size).fold(1.0, f64::max);
    let mut worst = SampleError::default();
    let mut above = false;
    for (nth, (result, _)) in floats.iter().enumerate() {
        let (single, double) = pair(nth);
        // The reference follows the branches of the `f32`, where it may have no value of its own.
        if !double.is_finite() {
            continue;
        }
        let off = off(single, double, scale);
        above = if off.steps > worst.steps { f64::from(single) > double } else { above };
        // A component near 0 beside a large one, as in a normal of (1, 1e-9, 0), has few bits of
        // its own: measured by its own last place it would be off by millions, and no picture
        // shows it. It is measured as if it were a 1024th of the largest.
        if off.ulp > worst.ulp {
            let beside = (0..floats.len()).filter(|other| floats[*other].0 == *result).map(size);
            let near_zero = beside.fold(0.0, f64::max) / NEAR_ZERO;
            let ulp = match double.abs() < near_zero {
                true => off.ulp * last_place(double) / last_place(near_zero),
                false => off.ulp,
            };
            worst.ulp = worst.ulp.max(ulp);
        }
        worst.relative = worst.relative.max(off.relative);
        worst.steps = worst.steps.max(off.steps);
    }
    Outcome::Finite(worst, above)
}

/// Returns the error of a finite number; `scale` is the full scale, at least 1.
pub(super) fn off(single: f32, double: f64, scale: f64) -> SampleError {
    let apart = (f64::from(single) - double).abs();
    SampleError {
        ulp: apart / last_place(double),
        relative: apart / double.abs().max(scale / 1024.0),
        steps: 255.0 * apart / scale,
    }
}

/// The bins per power of two.
const FINE: f64 = 8.0;

/// The exponent of the smallest power of two with bins of its own.
const LOWEST: f64 = -40.0;
const BINS: usize = 220 * 8;

// A distribution of positive numbers: a histogram and the maximum.
#[derive(Clone, Debug, Serialize)]
#[serde(into = "SpreadObject")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "SpreadObject"))]
pub struct Spread {
    counts: Vec<u64>,
    zeros: u64,
    pub count: u64,
    pub max: f64,
}

impl Default for Spread {
    fn default() -> Spread {
        Spread { counts: vec![0; BINS], zeros: 0, count: 0, max: 0.0 }
    }
}

impl Spread {
    pub fn add(&mut self, x: f64) {
        self.count += 1;
        self.max = self.max.max(x);
        if x <= 0.0 {
            self.zeros += 1;
            return;
        }
        // A logarithmic histogram: 8 bins for each power of two from 2^-40 on, hence a quantile to
        // a factor of 2^(1/8).
        let bin = ((x.log2() - LOWEST) * FINE).clamp(0.0, BINS as f64 - 1.0);
        self.counts[bin as usize] += 1;
    }

    pub fn merge(&mut self, other: &Spread) {
        self.counts.iter_mut().zip(&other.counts).for_each(|(sum, n)| *sum += n);
        self.zeros += other.zeros;
        self.count += other.count;
        self.max = self.max.max(other.max);
    }

    /// Returns the 99.9 % quantile, to a twelfth of its value.
    pub fn p999(&self) -> f64 {
        // The rank of the quantile; zeros, which have no logarithm, come first.
        let mut rest = (self.count as f64 * 0.999).ceil() as u64;
        if rest <= self.zeros {
            return 0.0;
        }
        rest -= self.zeros;
        for (bin, &count) in self.counts.iter().enumerate() {
            if count >= rest {
                // The upper end of the bin, but never more than the maximum.
                return ((bin as f64 + 1.0) / FINE + LOWEST).exp2().min(self.max);
            }
            rest -= count;
        }
        self.max
    }
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct SpreadObject {
    max: JsonNumber,
    /// The 99.9 % quantile, accurate to one part in twelve.
    p999: JsonNumber,
}

impl From<Spread> for SpreadObject {
    fn from(spread: Spread) -> SpreadObject {
        SpreadObject { max: spread.max.into(), p999: spread.p999().into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thousandth_of_the_samples_is_beyond_the_quantile() {
        let mut spread = Spread::default();
        (1..=100_000).for_each(|i| spread.add(f64::from(i)));
        let found = spread.p999();
        assert!((99_900.0..=99_900.0 * 1.1).contains(&found), "{found}");
        assert_eq!(spread.max, 100_000.0);
    }

    #[test]
    fn a_step_is_a_255th_of_the_full_scale() {
        let one = off(0.5, 0.5 + 1.0 / 255.0, 1.0);
        assert!((one.steps - 1.0).abs() < 1e-12);
        // Far below full scale, the error is relative to 2^-10 of it.
        assert!((off(0.0, 2f64.powi(-20), 1.0).relative - 2f64.powi(-10)).abs() < 1e-15);
        // The next f32 above 1 is a unit away.
        assert_eq!(off(1.0 + f32::EPSILON, 1.0, 1.0).ulp, 1.0);
    }

    /// 1e-6 where 0 is right are 1e39 units of the last place of 0, and beside a component of 1 as
    /// many as of 2^-10; another result is not beside it.
    #[test]
    fn a_component_near_zero_is_measured_beside_the_largest() {
        let outcome = |floats: &[(usize, usize)]| {
            let pairs = [(1e-6f32, 0.0), (1.0, 1.0)];
            match outcome_of(floats, |nth| pairs[nth]) {
                Outcome::Finite(off, _) => off,
                other => panic!("{other:?}"),
            }
        };
        let beside = outcome(&[(0, 0), (0, 1)]);
        // 2^-33 is the last place from 2^-10 on.
        let expected = f64::from(1e-6f32) * 2f64.powi(33);
        assert!((beside.ulp / expected - 1.0).abs() < 1e-12, "{beside:?}");
        for alone in [outcome(&[(0, 0)]), outcome(&[(0, 0), (1, 0)])] {
            assert!(alone.ulp > 1e38, "{alone:?}");
            assert_eq!(alone.steps, beside.steps);
        }
    }
}
