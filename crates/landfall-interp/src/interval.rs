//! The values that any conformant device may give: intervals of `f64` by the accuracies that WGSL
//! §15.7.4 and Vulkan's "Precision and Operation of SPIR-V Instructions" permit for `f32`.
//!
//! Used by [`permitted`](super::permitted). If a specification defines a function by a formula, its
//! interval is that formula's; if it defines no value, every value is permitted.

use std::f64::consts::PI;

use super::outward::Outward;

/// The numbers from `low` to `high`.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Interval {
    pub low: f64,
    pub high: f64,
}

/// Any value, NaN included; it propagates through every operation.
pub(super) const ANY: Interval = Interval { low: f64::NEG_INFINITY, high: f64::INFINITY };

const SMALLEST_NORMAL: f64 = f32::MIN_POSITIVE as f64;

/// Returns the distance of the two floats about `x`, near zero that of the subnormals (Muller's
/// ULP).
fn ulp(x: f64) -> f64 {
    // The exponent of an `f64` has a bias of 1023; an `f32` has 23 digits behind the first.
    let exponent = (x.abs().to_bits() >> 52) as i32 - 1023 - 23;
    2f64.powi(exponent.max(-149))
}

/// Returns the largest `f32` not above `x`.
fn down(x: f64) -> f64 {
    let near = x as f32;
    f64::from(if f64::from(near) > x { near.next_down() } else { near })
}

fn up(x: f64) -> f64 {
    -down(-x)
}

/// Returns `a + b`, rounded down if it exceeds the exact sum, so that `down` is a bound of that.
fn sum(a: f64, b: f64) -> f64 {
    // What the sum has lost is a number itself (Knuth's two-sum).
    let sum = a + b;
    let part = sum - a;
    let lost = (a - (sum - part)) + (b - part);
    if lost < 0.0 { sum.next_down() } else { sum }
}

/// Returns the least interval that contains all values; any value if one is NaN.
fn hull<const N: usize>(values: [f64; N]) -> Interval {
    if values.iter().any(|v| v.is_nan()) {
        return ANY;
    }
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    Interval { low, high: values.iter().copied().fold(f64::NEG_INFINITY, f64::max) }
}

impl Interval {
    /// Returns the interval of a value; a subnormal may be flushed to zero.
    pub(super) fn new(x: f32) -> Interval {
        if x.is_finite() { Interval::exactly(f64::from(x)).flushed() } else { ANY }
    }

    /// Returns the interval of a number between two floats, rounded either way.
    pub(super) fn near(x: f64) -> Interval {
        Interval::exactly(x).rounded()
    }

    fn exactly(x: f64) -> Interval {
        Interval { low: x, high: x }
    }

    pub(super) fn or(self, other: Interval) -> Interval {
        Interval { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    pub(super) fn is_any(self) -> bool {
        self.low == f64::NEG_INFINITY && self.high == f64::INFINITY
    }

    /// Returns `f(self)`, or any value if an operand may have any value.
    fn unless_any(self, f: impl FnOnce(Interval) -> Interval) -> Interval {
        if self.is_any() { ANY } else { f(self) }
    }

    pub(super) fn flushed(self) -> Interval {
        if self.low < SMALLEST_NORMAL && self.high > -SMALLEST_NORMAL {
            return Interval { low: self.low.min(0.0), high: self.high.max(0.0) };
        }
        self
    }

    /// Returns the interval rounded in either direction; any value if it may overflow.
    pub(super) fn rounded(self) -> Interval {
        let most = f64::from(f32::MAX);
        // Written so that NaN fails as well.
        if !(self.low >= -most && self.high <= most) {
            return ANY;
        }
        // Tests reverse a rounding to see that bounds do not hold without it.
        let low = if Outward::SingleLow.is_reversed() { up(self.low) } else { down(self.low) };
        let high = if Outward::SingleHigh.is_reversed() { down(self.high) } else { up(self.high) };
        Interval { low, high }.flushed()
    }

    fn within(self, low: f64, high: f64) -> Interval {
        let most = f64::from(f32::MAX);
        let low = if Outward::PermittedLow.is_reversed() { -low } else { low };
        let wide = Interval { low: self.low - low, high: self.high + high };
        if wide.low >= -most && wide.high <= most { wide.flushed() } else { ANY }
    }

    /// Widens the interval by a number of ULP. Above a power of two an ULP is twice as much as
    /// below: from there an error may reach farther down than from the low end.
    fn ulps(self, count: f64) -> Interval {
        let lowest = |low: f64, high: f64| {
            let power = 2f64.powi(low.log2().ceil() as i32);
            let from = if low > 0.0 && power <= high { power } else { low };
            (low - count * ulp(low)).min(from - count * ulp(from))
        };
        let (low, high) = (self.low, self.high);
        self.within(low - lowest(low, high), -lowest(-high, -low) - high)
    }

    fn absolute(self, error: f64) -> Interval {
        self.within(error, error)
    }

    pub(super) fn neg(self) -> Interval {
        Interval { low: -self.high, high: -self.low }
    }

    pub(super) fn abs(self) -> Interval {
        self.unless_any(|x| Interval { low: x.low.max(-x.high).max(0.0), high: x.size() })
    }

    pub(super) fn add(self, other: Interval) -> Interval {
        let high = -sum(-self.high, -other.high);
        Interval { low: sum(self.low, other.low), high }.rounded()
    }

    pub(super) fn sub(self, other: Interval) -> Interval {
        self.add(other.neg())
    }

    pub(super) fn mul(self, other: Interval) -> Interval {
        let (a, b) = (self, other);
        if a.is_any() || b.is_any() {
            return ANY;
        }
        // The extremes of a product are at the ends of its factors.
        hull([a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high]).rounded()
    }

    /// Returns the interval of a value times itself, never negative.
    pub(super) fn squared(self) -> Interval {
        self.abs().unless_any(|x| hull([x.low * x.low, x.high * x.high]).rounded())
    }

    /// Returns the quotient, within 2.5 ULP if the divisor is between 2^-126 and 2^126.
    pub(super) fn div(self, other: Interval) -> Interval {
        let (a, b) = (self, other);
        let most = 2f64.powi(126);
        if a.is_any() || b.low <= 0.0 && b.high >= 0.0 || !(b.low >= -most && b.high <= most) {
            return ANY;
        }
        hull([a.low / b.low, a.low / b.high, a.high / b.low, a.high / b.high]).ulps(2.5)
    }

    /// Returns `a - b * trunc(a / b)`.
    pub(super) fn rem(self, other: Interval) -> Interval {
        // By the formula, with the errors of its operations.
        let quotient = self.div(other);
        self.sub(other.mul(quotient.monotone(f64::trunc)))
    }

    /// Applies an exact increasing function.
    pub(super) fn monotone(self, f: impl Fn(f64) -> f64) -> Interval {
        self.unless_any(|x| hull([f(x.low), f(x.high)]))
    }

    /// Applies an increasing function with an error of `count` ULP.
    fn rising(self, f: impl Fn(f64) -> f64, count: f64) -> Interval {
        self.monotone(f).unless_any(|y| y.ulps(count))
    }

    /// Returns the largest absolute value.
    fn size(self) -> f64 {
        self.high.max(-self.low)
    }

    /// Returns `1 / sqrt(x)`, within 2 ULP.
    pub(super) fn inverse_sqrt(self) -> Interval {
        if self.low <= 0.0 {
            return ANY;
        }
        hull([1.0 / self.low.sqrt(), 1.0 / self.high.sqrt()]).ulps(2.0)
    }

    /// Returns `1 / inverseSqrt(x)`; zero for zero.
    pub(super) fn sqrt(self) -> Interval {
        let one = Interval::exactly(1.0);
        match self.low {
            low if low < 0.0 || self.is_any() => ANY,
            0.0 => {
                // The root of zero is zero; those of other numbers are below that of the largest.
                let high = self.high.max(SMALLEST_NORMAL);
                let top = one.div(Interval::exactly(high).inverse_sqrt()).high;
                Interval { low: 0.0, high: if self.high == 0.0 { 0.0 } else { top } }
            }
            _ => one.div(self.inverse_sqrt()),
        }
    }

    /// Returns the exponential, within 3 + 2|x| ULP.
    pub(super) fn exp(self) -> Interval {
        self.rising(f64::exp, 3.0 + 2.0 * self.size()).not_below(0.0)
    }

    /// Returns the power of two, within 3 + 2|x| ULP.
    pub(super) fn exp2(self) -> Interval {
        self.rising(f64::exp2, 3.0 + 2.0 * self.size()).not_below(0.0)
    }

    /// Cuts off the part of an error below the function's range.
    fn not_below(self, least: f64) -> Interval {
        self.unless_any(|x| Interval { low: x.low.max(least), ..x })
    }

    /// Returns a logarithm, within 2^-21 for 0.5 to 2, else 3 ULP.
    fn logarithm(self, f: fn(f64) -> f64) -> Interval {
        if self.low <= 0.0 {
            return ANY;
        }
        let near = |x: Interval| x.monotone(f).absolute(2f64.powi(-21));
        let far = |x: Interval| x.rising(f, 3.0);
        if self.low > 2.0 || self.high < 0.5 {
            return far(self);
        }
        let mut all = near(Interval { low: self.low.max(0.5), high: self.high.min(2.0) });
        if self.low < 0.5 {
            all = all.or(far(Interval { high: 0.5, ..self }));
        }
        if self.high > 2.0 {
            all = all.or(far(Interval { low: 2.0, ..self }));
        }
        all
    }

    pub(super) fn ln(self) -> Interval {
        self.logarithm(f64::ln)
    }

    pub(super) fn log2(self) -> Interval {
        self.logarithm(f64::log2)
    }

    /// Returns `exp2(y * log2(x))`; zero for zero to a positive power.
    pub(super) fn pow(self, y: Interval) -> Interval {
        let positive = |x: Interval| y.mul(x.log2()).exp2();
        match self.low {
            0.0 if self.high == 0.0 && y.low > 0.0 => self,
            0.0 if y.low > 0.0 => {
                Interval { low: 0.0, ..positive(Interval::exactly(self.high)) }.or_any()
            }
            _ => positive(self),
        }
    }

    /// Returns any value if one end is infinite.
    fn or_any(self) -> Interval {
        if self.high == f64::INFINITY || self.low == f64::NEG_INFINITY { ANY } else { self }
    }

    /// Returns the cosine, within 2^-11 from -π to π; no accuracy is specified beyond.
    pub(super) fn cos(self) -> Interval {
        if !(self.low >= -PI && self.high <= PI) {
            return ANY;
        }
        let mut all = hull([self.low.cos(), self.high.cos()]);
        // The greatest value is inside.
        if self.low <= 0.0 && self.high >= 0.0 {
            all.high = 1.0;
        }
        all.absolute(2f64.powi(-11))
    }

    /// Returns the sine, within 2^-11 from -π to π; no accuracy is specified beyond.
    pub(super) fn sin(self) -> Interval {
        if !(self.low >= -PI && self.high <= PI) {
            return ANY;
        }
        let mut all = hull([self.low.sin(), self.high.sin()]);
        // The extremes that are inside.
        for (at, extreme) in [(-PI / 2.0, -1.0), (PI / 2.0, 1.0)] {
            if self.low <= at && self.high >= at {
                all = all.or(Interval::exactly(extreme));
            }
        }
        all.absolute(2f64.powi(-11))
    }

    /// Returns the arc tangent, within 4096 ULP.
    pub(super) fn atan(self) -> Interval {
        self.rising(f64::atan, 4096.0)
    }

    /// Returns the angle of `(x, self)`: within 4096 ULP, except across its cut and at its pole.
    pub(super) fn atan2(self, x: Interval) -> Interval {
        let y = self;
        let zero = |i: Interval| i.low <= 0.0 && i.high >= 0.0;
        if y.is_any() || x.is_any() || zero(x) || x.high < 0.0 && zero(y) {
            return ANY;
        }
        // With one operand fixed the angle is monotonic in the other, so that the corners have the
        // extremes.
        let corners = [(y.low, x.low), (y.low, x.high), (y.high, x.low), (y.high, x.high)];
        hull(corners.map(|(y, x)| y.atan2(x))).ulps(4096.0)
    }

    /// Within 6.81e-5, or `atan2(x, sqrt(1 - x * x))`.
    pub(super) fn asin(self) -> Interval {
        self.arc(f64::asin, 6.81e-5, |x, side| x.atan2(side))
    }

    /// Within 6.77e-5, or `atan2(sqrt(1 - x * x), x)`.
    pub(super) fn acos(self) -> Interval {
        self.arc(f64::acos, 6.77e-5, |x, side| side.atan2(x))
    }

    fn arc(
        self,
        f: fn(f64) -> f64,
        error: f64,
        formula: impl Fn(Interval, Interval) -> Interval,
    ) -> Interval {
        if !(self.low >= -1.0 && self.high <= 1.0) {
            return ANY;
        }
        let inherited = formula(self, Interval::exactly(1.0).sub(self.squared()).sqrt());
        let direct = hull([f(self.low), f(self.high)]).absolute(error);
        // Where the formula has no value, the function's own bound holds.
        if inherited.is_any() { direct } else { direct.or(inherited) }
    }

    pub(super) fn sinh(self) -> Interval {
        self.exp().sub(self.neg().exp()).mul(Interval::exactly(0.5))
    }

    pub(super) fn cosh(self) -> Interval {
        self.exp().add(self.neg().exp()).mul(Interval::exactly(0.5))
    }

    /// Within 1e-5, or `sinh(x) / cosh(x)`.
    pub(super) fn tanh(self) -> Interval {
        let direct = self.unless_any(|x| hull([x.low.tanh(), x.high.tanh()]).absolute(1e-5));
        let inherited = self.sinh().div(self.cosh());
        if inherited.is_any() { direct } else { direct.or(inherited) }
    }

    pub(super) fn asinh(self) -> Interval {
        let root = self.squared().add(Interval::exactly(1.0)).sqrt();
        self.add(root).ln()
    }

    pub(super) fn acosh(self) -> Interval {
        let root = self.squared().sub(Interval::exactly(1.0)).sqrt();
        self.add(root).ln()
    }

    pub(super) fn atanh(self) -> Interval {
        let one = Interval::exactly(1.0);
        one.add(self).div(one.sub(self)).ln().mul(Interval::exactly(0.5))
    }

    pub(super) fn min(self, other: Interval) -> Interval {
        if self.is_any() || other.is_any() {
            return ANY;
        }
        Interval { low: self.low.min(other.low), high: self.high.min(other.high) }
    }

    pub(super) fn max(self, other: Interval) -> Interval {
        self.neg().min(other.neg()).neg()
    }

    /// Returns 1 if it is not below the edge, else 0.
    pub(super) fn step(self, edge: Interval) -> Interval {
        if self.is_any() || edge.is_any() {
            return ANY;
        }
        let bit = |x: bool| f64::from(u8::from(x));
        Interval { low: bit(edge.high <= self.low), high: bit(edge.low <= self.high) }
    }

    pub(super) fn sign(self) -> Interval {
        let sign = |x: f64| if x == 0.0 { 0.0 } else { x.signum() };
        self.monotone(sign)
    }

    /// Returns the fraction of `frexp`.
    pub(super) fn fraction(
        self,
        f: impl Fn(f64) -> f64,
        exponent: impl Fn(f64) -> i32,
    ) -> Interval {
        let one_sign = self.low > 0.0 || self.high < 0.0;
        match self {
            _ if self.is_any() => ANY,
            _ if self.low == self.high => Interval::exactly(f(self.low)),
            // With one exponent the fraction grows with the number; with several it may be any.
            _ if one_sign && exponent(self.low) == exponent(self.high) => self.monotone(f),
            _ => Interval { low: if self.low < 0.0 { -1.0 } else { 0.0 }, high: 1.0 },
        }
    }
}

/// Returns the sum in any order: the order of a built-in function's sum is unspecified.
pub(super) fn sum_in_any_order(terms: &[Interval]) -> Interval {
    match *terms {
        [] => Interval::default(),
        [one] => one,
        [a, b] => a.add(b),
        [a, b, c] => a.add(b).add(c).or(a.add(c).add(b)).or(b.add(c).add(a)),
        [a, b, c, ref rest @ ..] => {
            // Four terms: sequentially with any of them last, or in pairs.
            let d = sum_in_any_order(rest);
            let last = |x, y, z, last: Interval| sum_in_any_order(&[x, y, z]).add(last);
            let one_by_one =
                last(a, b, c, d).or(last(a, b, d, c)).or(last(a, c, d, b)).or(last(b, c, d, a));
            let pairs = |a: Interval, b, c: Interval, d| a.add(b).add(c.add(d));
            one_by_one.or(pairs(a, b, c, d)).or(pairs(a, c, b, d)).or(pairs(a, d, b, c))
        }
    }
}
