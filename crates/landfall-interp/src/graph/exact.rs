//! Enclosures of real arithmetic: the exact results over intervals of operands, rounded outward in
//! `f64`.
//!
//! Sums, products, quotients and roots are rounded by the sign of their exact residual. Other
//! functions are those of the platform, which the widening by [`SLACK`] takes to be accurate to two
//! units of an `f64`'s last place.

use super::super::interval::Interval;
use super::super::outward::Outward;

/// Units of an `f64`'s last place by which a function of the platform may be off.
const SLACK: u32 = 2;

/// Below this size, the residual of a product or quotient may itself be rounded.
const TINY: f64 = 1e-280;

/// No number.
pub(super) const EMPTY: Interval = Interval { low: f64::INFINITY, high: f64::NEG_INFINITY };

/// Every real number.
pub(super) const ALL: Interval = Interval { low: f64::NEG_INFINITY, high: f64::INFINITY };

pub(super) fn point(x: f64) -> Interval {
    Interval { low: x, high: x }
}

pub(super) fn between(low: f64, high: f64) -> Interval {
    Interval { low, high }
}

pub(super) fn is_empty(x: Interval) -> bool {
    // NaN bounds count as empty: no operation returns them.
    x.low.is_nan() || x.high.is_nan() || x.low > x.high
}

pub(super) fn contains(x: Interval, number: f64) -> bool {
    x.low <= number && number <= x.high
}

pub(super) fn hull(a: Interval, b: Interval) -> Interval {
    match (is_empty(a), is_empty(b)) {
        (true, _) => b,
        (_, true) => a,
        (false, false) => between(a.low.min(b.low), a.high.max(b.high)),
    }
}

pub(super) fn intersection(a: Interval, b: Interval) -> Interval {
    between(a.low.max(b.low), a.high.min(b.high))
}

/// Returns the largest absolute value.
pub(super) fn size(x: Interval) -> f64 {
    x.high.max(-x.low)
}

/// Returns `a + b` rounded down.
fn sum_down(a: f64, b: f64) -> f64 {
    let sum = a + b;
    if !sum.is_finite() {
        // The sum of an infinite bound stays infinite; one that overflows is the largest number.
        let infinite = a.is_infinite() || b.is_infinite();
        return if sum.is_nan() {
            f64::NEG_INFINITY
        } else if sum > 0.0 && !infinite {
            f64::MAX
        } else {
            sum
        };
    }
    // The error of a sum is an `f64` itself: Knuth's two-sum.
    let part = sum - a;
    let lost = (a - (sum - part)) + (b - part);
    Outward::Sum.below(sum, lost)
}

/// Returns `a * b` rounded down; zero times infinity is zero.
fn product_down(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 {
        return 0.0;
    }
    let product = a * b;
    if !product.is_finite() {
        let infinite = a.is_infinite() || b.is_infinite();
        return if product > 0.0 && !infinite { f64::MAX } else { product };
    }
    if product.abs() < TINY {
        return product.next_down();
    }
    // As is the error of a product, which the fused operation gives.
    Outward::Product.below(product, a.mul_add(b, -product))
}

/// Returns `a / b` rounded down; the divisor is not zero.
fn quotient_down(a: f64, b: f64) -> f64 {
    if a == 0.0 || b.is_infinite() && a.is_finite() {
        return if a == 0.0 || a.signum() == b.signum() { 0.0 } else { (-0.0f64).next_down() };
    }
    let quotient = a / b;
    if !quotient.is_finite() || quotient.abs() < TINY || a.abs() < TINY {
        return if quotient == f64::INFINITY { f64::MAX } else { quotient.next_down() };
    }
    let rest = (-quotient).mul_add(b, a);
    Outward::Quotient.below(quotient, if b < 0.0 { -rest } else { rest })
}

/// Rounds up, by negating twice; of a function that is odd in its first operand.
fn up(down: impl Fn(f64, f64) -> f64, a: f64, b: f64) -> f64 {
    -down(-a, b)
}

pub(super) fn neg(x: Interval) -> Interval {
    between(-x.high, -x.low)
}

pub(super) fn abs(x: Interval) -> Interval {
    between(x.low.max(-x.high).max(0.0), size(x))
}

pub(super) fn add(a: Interval, b: Interval) -> Interval {
    between(sum_down(a.low, b.low), -sum_down(-a.high, -b.high))
}

pub(super) fn sub(a: Interval, b: Interval) -> Interval {
    add(a, neg(b))
}

pub(super) fn mul(a: Interval, b: Interval) -> Interval {
    let pairs = [(a.low, b.low), (a.low, b.high), (a.high, b.low), (a.high, b.high)];
    let low = pairs.map(|(a, b)| product_down(a, b)).into_iter().fold(f64::INFINITY, f64::min);
    let high = pairs.map(|(a, b)| up(product_down, a, b));
    between(low, high.into_iter().fold(f64::NEG_INFINITY, f64::max))
}

pub(super) fn squared(x: Interval) -> Interval {
    let x = abs(x);
    between(product_down(x.low, x.low), up(product_down, x.high, x.high))
}

/// Returns the quotient by a divisor of one sign.
pub(super) fn div(a: Interval, b: Interval) -> Interval {
    let pairs = [(a.low, b.low), (a.low, b.high), (a.high, b.low), (a.high, b.high)];
    let low = pairs.map(|(a, b)| quotient_down(a, b)).into_iter().fold(f64::INFINITY, f64::min);
    let high = pairs.map(|(a, b)| up(quotient_down, a, b));
    between(low, high.into_iter().fold(f64::NEG_INFINITY, f64::max))
}

/// Returns the root of numbers that are not negative.
pub(super) fn sqrt(x: Interval) -> Interval {
    let low = |x: f64| {
        let root = x.sqrt();
        let down = x < TINY || root.is_finite() && (-root).mul_add(root, x) < 0.0;
        if down && x > 0.0 { root.next_down() } else { root }
    };
    let high = |x: f64| {
        let root = x.sqrt();
        let up = x < TINY || root.is_finite() && (-root).mul_add(root, x) > 0.0;
        if up && x > 0.0 { root.next_up() } else { root }
    };
    between(low(x.low.max(0.0)), high(x.high.max(0.0)))
}

/// Widens by the error of a function of the platform.
pub(super) fn widened(x: Interval) -> Interval {
    let (mut low, mut high) = (x.low, x.high);
    for _ in 0..SLACK {
        (low, high) = (low.next_down(), high.next_up());
    }
    between(low, high)
}

/// Applies an increasing function of the platform.
pub(super) fn rising(x: Interval, f: impl Fn(f64) -> f64) -> Interval {
    widened(between(f(x.low), f(x.high)))
}

/// Applies an exact increasing function.
pub(super) fn step(x: Interval, f: impl Fn(f64) -> f64) -> Interval {
    between(f(x.low), f(x.high))
}

/// Returns the sine; `shift` a quarter turn makes it the cosine.
fn wave(x: Interval, f: impl Fn(f64) -> f64, shift: f64) -> Interval {
    use std::f64::consts::{PI, TAU};
    // Far out, the argument's own rounding and that of the extremes are not followed.
    if x.high - x.low >= TAU || size(x) > 1e9 {
        return between(-1.0, 1.0);
    }
    let mut all = widened(hull(point(f(x.low)), point(f(x.high))));
    // Extremes are at shift + PI / 2 + n * PI.
    // An extreme too many only widens.
    let first = ((x.low - shift - PI / 2.0) / PI - 1e-6).ceil();
    let last = ((x.high - shift - PI / 2.0) / PI + 1e-6).floor();
    let mut at = first;
    while at <= last {
        all = hull(all, point(if at.rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 }));
        at += 1.0;
    }
    intersection(all, between(-1.0, 1.0))
}

pub(super) fn sin(x: Interval) -> Interval {
    wave(x, f64::sin, 0.0)
}

pub(super) fn cos(x: Interval) -> Interval {
    wave(x, f64::cos, -std::f64::consts::FRAC_PI_2)
}

/// Returns the tangent; every number across a pole.
pub(super) fn tan(x: Interval) -> Interval {
    use std::f64::consts::PI;
    let turn = |x: f64, by: f64| (x / PI + 0.5 + by).floor();
    if size(x) > 1e9 || turn(x.low, -1e-9) != turn(x.high, 1e-9) {
        return ALL;
    }
    rising(x, f64::tan)
}

/// Returns `x` to the power of `y`, of a base that is not negative.
pub(super) fn pow(x: Interval, y: Interval) -> Interval {
    let corner = |x: f64, y: f64| if x == 0.0 && y == 0.0 { 1.0 } else { x.powf(y) };
    let pairs = [(x.low, y.low), (x.low, y.high), (x.high, y.low), (x.high, y.high)];
    let mut all = pairs.map(|(x, y)| point(corner(x, y))).into_iter().fold(EMPTY, hull);
    if contains(x, 1.0) || contains(y, 0.0) {
        all = hull(all, point(1.0));
    }
    let wide = widened(widened(all));
    between(wide.low.max(0.0), wide.high)
}

/// Returns the angle of the points `(x, y)`.
pub(super) fn atan2(y: Interval, x: Interval) -> Interval {
    use std::f64::consts::PI;
    if contains(y, 0.0) && x.low <= 0.0 {
        return widened(between(-PI, PI));
    }
    let corners = [(y.low, x.low), (y.low, x.high), (y.high, x.low), (y.high, x.high)];
    widened(corners.map(|(y, x)| point(y.atan2(x))).into_iter().fold(EMPTY, hull))
}
