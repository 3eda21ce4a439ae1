//! Affine forms: values as linear functions of the inputs, so that operands that depend on the same
//! inputs are not taken as independent.
//!
//! A form encloses the results of an operation on any device, as the interval of the value does;
//! the value lies in both. Its numbers are computed in `f64`, and their roundings are added to its
//! rest.
//! After Stolfi and de Figueiredo, Self-Validated Numerical Methods and Applications (1997), with
//! the mean value form for quotients and functions of one operand.

use super::super::interval::Interval;
use super::super::outward::Outward;
use super::exact::{self, between, point, size};

/// A number `middle + Σ share * e`, up to `rest`, for some `e` from -1 to 1 of each symbol.
#[derive(Clone, Debug, Default)]
pub(super) struct Affine {
    middle: f64,
    /// By symbol, in ascending order: its share.
    shares: Vec<(u32, f64)>,
    rest: f64,
}

/// Whether a value needs an affine form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Need {
    /// No operation uses it together with a value that depends on the same inputs.
    None,
    /// It is used once.
    Once,
    /// It is used more often, and has a symbol for what is not linear in it.
    Often,
}

/// The largest number of symbols of a form.
const MAX_SHARES: usize = 16;

/// Symbols of values rather than inputs.
pub(super) const VALUE: u32 = 1 << 31;

/// More than the relative error of three operations of `f64`.
const ROUNDED: f64 = 4.0 * f64::EPSILON;

/// Inputs and values beyond have no form.
const LIMIT: f64 = 1e30;

/// Rounds the sum of at most [`MAX_SHARES`] numbers that are not negative up.
fn up(x: f64) -> f64 {
    x * (1.0 + 64.0 * f64::EPSILON) + f64::MIN_POSITIVE
}

/// Returns a middle of an interval, and how far its ends are from there at most.
pub(super) fn halves(x: Interval) -> (f64, f64) {
    let middle = x.low / 2.0 + x.high / 2.0;
    (middle, up((x.high - middle).max(middle - x.low)))
}

impl Affine {
    pub fn constant(x: f64) -> Affine {
        Affine { middle: x, ..Affine::default() }
    }

    /// A value of which only an interval is known.
    pub fn symbol(symbol: u32, x: Interval) -> Option<Affine> {
        let (middle, half) = halves(x);
        let shares = if x.low == x.high { Vec::new() } else { vec![(symbol, half)] };
        (size(x) <= LIMIT).then_some(Affine { middle, shares, rest: 0.0 })
    }

    /// Returns how far it may be from its middle.
    pub fn radius(&self) -> f64 {
        up(self.shares.iter().map(|(_, share)| share.abs()).sum::<f64>() + self.rest)
    }

    pub fn interval(&self) -> Interval {
        // A test reverses the rounding.
        let rest = if Outward::Rest.is_reversed() { -2.0 * self.rest } else { 0.0 };
        let radius = self.radius() + rest;
        between((self.middle - radius).next_down(), (self.middle + radius).next_up())
    }

    /// Returns `x * self + y * other`.
    pub fn combined(&self, x: f64, other: &Affine, y: f64) -> Affine {
        let (a, b) = (x * self.middle, y * other.middle);
        // The sizes of all terms, which their roundings are relative to.
        let mut lost = a.abs() + b.abs();
        let mut shares = Vec::with_capacity(self.shares.len() + other.shares.len());
        // Both are in the order of the symbols, and so is the result: they are merged.
        let (mut mine, mut others) = (self.shares.iter(), other.shares.iter());
        let (mut one, mut two) = (mine.next(), others.next());
        loop {
            let (symbol, first, second) = match (one, two) {
                (None, None) => break,
                (Some(&(i, p)), Some(&(j, q))) if i == j => {
                    (one, two) = (mine.next(), others.next());
                    (i, x * p, y * q)
                }
                (Some(&(i, p)), second) if second.is_none_or(|&(j, _)| i < j) => {
                    one = mine.next();
                    (i, x * p, 0.0)
                }
                (_, Some(&(j, q))) => {
                    two = others.next();
                    (j, 0.0, y * q)
                }
                (Some(_), None) => unreachable!("the case before holds"),
            };
            lost += first.abs() + second.abs();
            if first + second != 0.0 {
                shares.push((symbol, first + second));
            }
        }
        let rest = x.abs() * self.rest + y.abs() * other.rest;
        Affine { middle: a + b, shares, rest: up(rest + ROUNDED * lost) }.limited()
    }

    pub fn scaled(&self, by: f64) -> Affine {
        self.combined(by, &Affine::default(), 0.0)
    }

    fn plus(&self, x: f64) -> Affine {
        self.combined(1.0, &Affine::constant(x), 1.0)
    }

    pub fn widened(mut self, by: f64) -> Affine {
        self.rest = up(self.rest + by);
        self
    }

    /// Adds the smallest shares to the rest where there are too many.
    fn limited(mut self) -> Affine {
        while self.shares.len() > MAX_SHARES {
            let sizes = self.shares.iter().map(|(_, share)| share.abs()).enumerate();
            let Some((at, share)) = sizes.min_by(|a, b| a.1.total_cmp(&b.1)) else { break };
            self.shares.remove(at);
            self.rest = up(self.rest + share);
        }
        self
    }

    pub fn product(&self, other: &Affine) -> Affine {
        // (a + A) * (b + B) = a * b + a * B + b * A + A * B, and the last is no more than the
        // radii's product.
        let (a, b) = (self.middle, other.middle);
        let mut linear = self.combined(b, other, a);
        linear.middle = a * b;
        linear.widened(self.radius() * other.radius() + ROUNDED * (a * b).abs())
    }

    pub fn squared(&self) -> Affine {
        // (m + d)^2 = m^2 + 2 * m * d + d^2, where d^2 is from 0 to the square of the radius: half
        // of that, give or take the same.
        let half = self.radius() * self.radius() / 2.0;
        let square = self.middle * self.middle;
        let mut linear = self.scaled(2.0 * self.middle);
        linear.middle = square + half;
        linear.widened(half + ROUNDED * (square + half))
    }

    /// Returns the quotient by a divisor of one sign: `q + (self - q * by) / by` for a number `q`.
    pub fn quotient(&self, by: &Affine, divisor: Interval) -> Option<Affine> {
        let q = self.middle / by.middle;
        if !q.is_finite() {
            return None;
        }
        let off = self.combined(1.0, by, -q);
        let most = off.middle.abs() + off.radius();
        let (inverse, half) = halves(exact::div(point(1.0), divisor));
        Some(off.scaled(inverse).plus(q).widened(up(most * half)))
    }

    /// Returns a function of it, whose operand is in an interval, by its value at a number there
    /// and its slope over the interval: the mean value theorem.
    pub fn applied(
        &self,
        x: Interval,
        slope: Interval,
        f: impl Fn(f64) -> Interval,
    ) -> Option<Affine> {
        let at = self.middle.clamp(x.low, x.high);
        let there = f(at);
        let (slope, steeper) = halves(slope);
        let (start, off) = halves(there);
        let far = up((x.high - at).max(at - x.low));
        let known = [slope, steeper, start, off].iter().all(|x| x.is_finite());
        known.then(|| self.plus(-at).scaled(slope).plus(start).widened(up(off + steeper * far)))
    }

    /// Whether its numbers are usable.
    pub fn is_finite(&self) -> bool {
        self.middle.abs() <= LIMIT && self.radius() <= LIMIT
    }

    /// Replaces its rest by a symbol, which cancels where the value is used again.
    pub fn named(mut self, symbol: u32) -> Affine {
        if self.rest > 0.0 {
            self.shares.push((symbol, self.rest));
            self.rest = 0.0;
            self.shares.sort_unstable_by_key(|(symbol, _)| *symbol);
        }
        self.limited()
    }
}
