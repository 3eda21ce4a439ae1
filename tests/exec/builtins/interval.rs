//! Which results a device may give: the accuracies of WGSL §15.7.4 ("Accuracy of concrete
//! floating point expressions") and of Vulkan's "Precision and Operation of SPIR-V
//! Instructions", as intervals of f64 that formulas inherit. Fed by the truth, feeds the cases.

use super::truth;

/// All numbers from `low` to `high`; both infinite where any result will do.
#[derive(Clone, Copy, Debug)]
pub struct Interval {
    pub low: f64,
    pub high: f64,
}

pub const ANY: Interval = Interval { low: f64::NEG_INFINITY, high: f64::INFINITY };
const SMALLEST_NORMAL: f64 = f32::MIN_POSITIVE as f64;

/// Distance of the two floats about `x`: Muller's ULP, that of the subnormals near zero.
pub fn ulp(x: f64) -> f64 {
    let exponent = if x == 0.0 { -149 } else { (x.abs().to_bits() >> 52) as i32 - 1023 - 23 };
    2f64.powi(exponent.max(-149))
}

fn down(x: f64) -> f64 {
    let near = x as f32;
    f64::from(if f64::from(near) > x { near.next_down() } else { near })
}

fn up(x: f64) -> f64 {
    -down(-x)
}

fn hull(values: &[f64]) -> Interval {
    if values.iter().any(|v| v.is_nan()) {
        return ANY;
    }
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    Interval { low, high: values.iter().copied().fold(f64::NEG_INFINITY, f64::max) }
}

impl Interval {
    /// An operand; one that is subnormal may be flushed to zero.
    pub fn of(x: f32) -> Interval {
        let x = f64::from(x);
        Interval { low: x, high: x }.flushed()
    }

    /// A number that is no float: a device has it rounded either way.
    pub fn constant(x: f64) -> Interval {
        Interval { low: x, high: x }.rounded()
    }

    pub fn or(self, other: Interval) -> Interval {
        Interval { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    pub fn is_any(self) -> bool {
        self.low == f64::NEG_INFINITY && self.high == f64::INFINITY
    }

    pub fn has(self, x: f64) -> bool {
        self.is_any() || self.low <= x && x <= self.high
    }

    fn has_zero(self) -> bool {
        self.low <= 0.0 && 0.0 <= self.high
    }

    /// Subnormals may be zero.
    fn flushed(self) -> Interval {
        if self.low < SMALLEST_NORMAL && self.high > -SMALLEST_NORMAL {
            return Interval { low: self.low.min(0.0), high: self.high.max(0.0) };
        }
        self
    }

    /// Correctly rounded, in either direction. What may overflow may be anything.
    pub fn rounded(self) -> Interval {
        let most = f64::from(f32::MAX);
        if self.low < -most || self.high > most || self.low.is_nan() || self.high.is_nan() {
            return ANY;
        }
        Interval { low: down(self.low), high: up(self.high) }.flushed()
    }

    fn wider(self, low: f64, high: f64) -> Interval {
        Interval { low: self.low - low, high: self.high + high }.flushed()
    }

    pub fn ulps(self, count: f64) -> Interval {
        if self.is_any() {
            return self;
        }
        self.wider(count * ulp(self.low), count * ulp(self.high))
    }

    pub fn absolute(self, error: f64) -> Interval {
        self.wider(error, error)
    }

    pub fn neg(self) -> Interval {
        Interval { low: -self.high, high: -self.low }
    }

    pub fn add(self, other: Interval) -> Interval {
        hull(&[self.low + other.low, self.high + other.high]).rounded()
    }

    pub fn sub(self, other: Interval) -> Interval {
        self.add(other.neg())
    }

    pub fn mul(self, other: Interval) -> Interval {
        let (a, b) = (self, other);
        hull(&[a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high]).rounded()
    }

    /// 2.5 ULP where the divisor is of 2^-126 to 2^126.
    pub fn div(self, other: Interval) -> Interval {
        let (a, b) = (self, other);
        let most = 2f64.powi(126);
        if b.has_zero() || b.low.abs().max(b.high.abs()) > most {
            return ANY;
        }
        hull(&[a.low / b.low, a.low / b.high, a.high / b.low, a.high / b.high]).ulps(2.5)
    }

    /// What a rising function makes of it, each end with an error of its own.
    fn rising(self, f: impl Fn(f64) -> f64, error: impl Fn(f64, f64) -> f64) -> Interval {
        let (low, high) = (f(self.low), f(self.high));
        if low.is_nan() || high.is_nan() || self.is_any() {
            return ANY;
        }
        let wide =
            Interval { low: low - error(self.low, low), high: high + error(self.high, high) };
        wide.flushed()
    }

    /// 2 ULP.
    pub fn inverse_sqrt(self) -> Interval {
        if self.low <= 0.0 {
            return ANY;
        }
        hull(&[1.0 / self.low.sqrt(), 1.0 / self.high.sqrt()]).ulps(2.0)
    }

    /// `1 / inverseSqrt(x)`.
    pub fn sqrt(self) -> Interval {
        Interval::of(1.0).div(self.inverse_sqrt())
    }

    /// 3 + 2|x| ULP.
    pub fn exp(self) -> Interval {
        self.rising(truth::exp, |x, y| (3.0 + 2.0 * x.abs()) * ulp(y))
    }

    pub fn exp2(self) -> Interval {
        self.rising(truth::exp2, |x, y| (3.0 + 2.0 * x.abs()) * ulp(y))
    }

    fn of_logarithm(self, f: fn(f64) -> f64) -> Interval {
        if self.low <= 0.0 {
            return ANY;
        }
        self.rising(f, |x, y| if (0.5..=2.0).contains(&x) { 2f64.powi(-21) } else { 3.0 * ulp(y) })
    }

    /// 2^-21 from 0.5 to 2, else 3 ULP.
    pub fn ln(self) -> Interval {
        self.of_logarithm(truth::ln)
    }

    pub fn log2(self) -> Interval {
        self.of_logarithm(truth::log2)
    }

    /// `self` over `x`: 4096 ULP. It has a cut where `y` is zero and `x` below.
    pub fn atan2(self, x: Interval) -> Interval {
        let y = self;
        if x.has_zero() || x.high < 0.0 && y.has_zero() || y.is_any() {
            return ANY;
        }
        let at = truth::atan2;
        hull(&[at(y.low, x.low), at(y.low, x.high), at(y.high, x.low), at(y.high, x.high)])
            .ulps(4096.0)
    }

    pub fn min(self, other: Interval) -> Interval {
        Interval { low: self.low.min(other.low), high: self.high.min(other.high) }
    }

    pub fn max(self, other: Interval) -> Interval {
        Interval { low: self.low.max(other.low), high: self.high.max(other.high) }
    }

    /// One of them truncated: a whole number of the interval, or any between.
    pub fn whole(self, f: fn(f64) -> f64) -> Interval {
        Interval { low: f(self.low), high: f(self.high) }
    }
}

/// The sum in any order: an implementation may reassociate.
pub fn sum(terms: &[Interval]) -> Interval {
    match terms {
        [] => Interval { low: 0.0, high: 0.0 },
        [one] => *one,
        [a, b] => a.add(*b),
        [a, b, c] => a.add(*b).add(*c).or(a.add(*c).add(*b)).or(b.add(*c).add(*a)),
        _ => {
            let mut all: Option<Interval> = None;
            for last in 0..terms.len() {
                let rest: Vec<Interval> =
                    (0..terms.len()).filter(|i| *i != last).map(|i| terms[i]).collect();
                let one = sum(&rest).add(terms[last]);
                all = Some(all.map_or(one, |all| all.or(one)));
            }
            let (left, right) = (terms[0].add(terms[1]), terms[2].add(terms[3]));
            let across = terms[0].add(terms[2]).add(terms[1].add(terms[3]));
            let outer = terms[0].add(terms[3]).add(terms[1].add(terms[2]));
            left.add(right).or(across).or(outer).or(all.unwrap_or(ANY))
        }
    }
}

pub fn dot(a: &[Interval], b: &[Interval]) -> Interval {
    let products: Vec<Interval> = a.iter().zip(b).map(|(a, b)| a.mul(*b)).collect();
    sum(&products)
}

pub fn length(v: &[Interval]) -> Interval {
    let squares = dot(v, v);
    // The square root of what may be zero: zero, or as if it were not.
    if squares.low <= 0.0 && !squares.is_any() {
        let high = squares.high.max(SMALLEST_NORMAL);
        let top = Interval { low: high, high }.sqrt();
        return Interval { low: 0.0, high: top.high };
    }
    squares.sqrt()
}
