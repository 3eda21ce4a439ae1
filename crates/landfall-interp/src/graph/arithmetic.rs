//! Operations on floats over enclosures of their operands, with the faults that are possible.

use super::super::code::{RealBinary, RealTernary, RealUnary};
use super::super::condition::{defined, undefined2, undefined3};
use super::super::interval::{ANY, Interval};
use super::super::machine::frexp;
use super::super::undefined::UndefinedKind as K;
use super::exact::{self, between, contains, hull, intersection, is_empty, point, size};
use super::fault::{Fault, Faults};
use super::value::{Applied, Arithmetic, without_fault};
use landfall_ir::analysis::undefined::condition::Defined;

const LIMIT: f64 = f32::MAX as f64;

/// The smallest positive `f32`.
const LEAST: f64 = 1.401_298_464_324_817e-45;

/// A sum that is this many times smaller than a rounded term has lost half of an `f32`'s digits.
const LOST: f64 = 4096.0;

/// More than any inverse hyperbolic function of an `f32`: their formulas lose all digits in places.
const UNKNOWN: f64 = 200.0;

/// More than any permitted relative error of an operation that can overflow.
const COARSE: f64 = 1.0 / 1024.0;

fn empty(kind: K) -> Applied {
    Applied { value: exact::EMPTY, faults: Faults::when(true, kind) }
}

/// Returns the result in an arithmetic, given the exact enclosure and the permitted one.
fn rounded_result(
    how: Arithmetic,
    exact: Interval,
    permitted: impl FnOnce() -> Interval,
) -> Applied {
    match how {
        Arithmetic::Exact => without_fault(exact),
        Arithmetic::Nearest => nearest(exact),
        Arithmetic::Permitted => match permitted() {
            // It may overflow, which is the fault; results that do not are close to the exact ones.
            any if any.is_any() => {
                let wide =
                    |x: f64, by: f64| x + by * (x.abs() * COARSE + f64::from(f32::MIN_POSITIVE));
                let value = between(wide(exact.low, -1.0), wide(exact.high, 1.0));
                let faults = Faults::when(true, K::BornInfinite);
                Applied { value: intersection(value, between(-LIMIT, LIMIT)), faults }
            }
            value => without_fault(value),
        },
    }
}

/// Rounds the middle of a narrow enclosure to the nearest `f32`.
fn nearest(exact: Interval) -> Applied {
    let single = f64::from((exact.low / 2.0 + exact.high / 2.0) as f32);
    let faults = Faults::when(!single.is_finite(), K::BornInfinite);
    Applied {
        value: point(if single.is_nan() { 0.0 } else { single.clamp(-LIMIT, LIMIT) }),
        faults,
    }
}

/// Returns the result of a function whose permitted values are bounded: without a permitted
/// enclosure, the exact one within an absolute error.
fn bounded(how: Arithmetic, exact: Interval, permitted: Interval, error: f64) -> Applied {
    rounded_result(how, exact, || match permitted {
        any if any.is_any() => between(exact.low - error, exact.high + error),
        value => value,
    })
}

pub(super) fn f1(how: Arithmetic, f: RealUnary, x: Interval) -> Applied {
    if is_empty(x) {
        return without_fault(exact::EMPTY);
    }
    if let Some(of) = defined(f) {
        return match of.otherwise {
            K::ArcOutOfRange => arc(how, f, x, of),
            _ => positive(how, f, x, of),
        };
    }
    let e = |g: fn(f64) -> f64| exact::rising(x, g);
    match f {
        RealUnary::Neg => without_fault(exact::neg(x)),
        RealUnary::Abs => without_fault(exact::abs(x)),
        RealUnary::Sign => {
            without_fault(exact::step(x, |x| if x == 0.0 { 0.0 } else { x.signum() }))
        }
        RealUnary::Floor => without_fault(exact::step(x, f64::floor)),
        RealUnary::Ceil => without_fault(exact::step(x, f64::ceil)),
        RealUnary::Round => without_fault(exact::step(x, f64::round_ties_even)),
        RealUnary::Trunc => without_fault(exact::step(x, f64::trunc)),
        RealUnary::Fract => fraction(how, x),
        RealUnary::Saturate => without_fault(exact::step(x, |x| x.clamp(0.0, 1.0))),
        RealUnary::Radians | RealUnary::Degrees => {
            let factor =
                if f == RealUnary::Radians { 1f64.to_radians() } else { 1f64.to_degrees() };
            let by = exact::widened(point(factor));
            rounded_result(how, exact::mul(x, by), || x.mul(Interval::near(factor)))
        }
        // Left for `defined`.
        RealUnary::Sqrt | RealUnary::InverseSqrt | RealUnary::Log | RealUnary::Log2 => {
            without_fault(ANY)
        }
        RealUnary::Asin | RealUnary::Acos | RealUnary::Acosh | RealUnary::Atanh => {
            without_fault(ANY)
        }
        RealUnary::Sin => bounded(how, exact::sin(x), x.sin(), SINE),
        RealUnary::Cos => bounded(how, exact::cos(x), x.cos(), SINE),
        RealUnary::Tan => rounded_result(how, exact::tan(x), || x.sin().div(x.cos())),
        RealUnary::Sinh => rounded_result(how, e(f64::sinh), || x.sinh()),
        RealUnary::Cosh => {
            rounded_result(how, exact::rising(exact::abs(x), f64::cosh), || x.cosh())
        }
        RealUnary::Tanh => bounded(how, e(f64::tanh), x.tanh(), COARSE),
        RealUnary::Atan => rounded_result(how, e(f64::atan), || x.atan()),
        RealUnary::Asinh => bounded(how, e(f64::asinh), x.asinh(), UNKNOWN),
        RealUnary::Exp => rounded_result(how, not_below(e(f64::exp), 0.0), || x.exp()),
        RealUnary::Exp2 => rounded_result(how, not_below(e(f64::exp2), 0.0), || x.exp2()),
        RealUnary::FrexpFract => {
            without_fault(x.fraction(|x| frexp(x).0, |x| frexp(x).1)).or_any(between(-1.0, 1.0))
        }
        RealUnary::Quantize => half(x),
    }
}

/// The permitted absolute error of sine and cosine from -π to π, and taken beyond.
const SINE: f64 = 1.0 / 2048.0;

impl Applied {
    fn or_any(self, bounds: Interval) -> Applied {
        if self.value.is_any() { without_fault(bounds) } else { self }
    }

    fn with(self, faults: Faults) -> Applied {
        Applied { faults: self.faults.and(faults), ..self }
    }
}

fn not_below(x: Interval, least: f64) -> Interval {
    between(x.low.max(least), x.high)
}

/// Rounds to an `f16`.
pub(super) fn half(x: Interval) -> Applied {
    if is_empty(x) {
        return without_fault(x);
    }
    let most = 65504.0;
    let faults = Faults::when(size(x) > most, K::BornInfinite);
    let nearest = |x: f64| half::f16::from_f64(x.clamp(-most, most)).to_f64();
    Applied { value: exact::step(x, nearest), faults }
}

fn fraction(how: Arithmetic, x: Interval) -> Applied {
    let floor = exact::step(x, f64::floor);
    // Across a whole number the fraction starts again at 0.
    if floor.low != floor.high {
        return without_fault(between(0.0, 1.0));
    }
    let whole = rounded_result(how, exact::sub(x, floor), || x.sub(floor));
    Applied { value: intersection(whole.value, between(0.0, 1.0)), ..whole }
}

/// Roots and logarithms.
fn positive(how: Arithmetic, f: RealUnary, x: Interval, of: Defined) -> Applied {
    let Defined { has_ends: zero, otherwise: kind, .. } = of;
    let faults = Faults::any([of.undefined(x.into())]);
    if x.high < 0.0 || x.high == 0.0 && !zero {
        return empty(kind);
    }
    // The operands for which there is a result; the fault stands for the others.
    let least = if zero { 0.0 } else { LEAST };
    let x = not_below(x, if how == Arithmetic::Exact && !zero { f64::MIN_POSITIVE } else { least });
    let found = match f {
        RealUnary::Sqrt => rounded_result(how, exact::sqrt(x), || x.sqrt()),
        RealUnary::InverseSqrt => {
            let root = exact::sqrt(x);
            rounded_result(how, exact::div(point(1.0), root), || x.inverse_sqrt())
        }
        RealUnary::Log => rounded_result(how, exact::rising(x, f64::ln), || x.ln()),
        _ => rounded_result(how, exact::rising(x, f64::log2), || x.log2()),
    };
    found.with(faults)
}

/// Inverse functions that are defined on a part of the numbers.
fn arc(how: Arithmetic, f: RealUnary, x: Interval, of: Defined) -> Applied {
    // Where an end is outside, the last number of the precision before it.
    let last = |end: f64| match how {
        _ if of.has_ends => end,
        Arithmetic::Exact => end - end.signum() * f64::EPSILON / 2.0,
        Arithmetic::Nearest | Arithmetic::Permitted => {
            end - end.signum() * f64::from(f32::EPSILON) / 2.0
        }
    };
    let within = intersection(x, between(last(of.low), last(of.high)));
    let outside = of.undefined(x.into());
    if is_empty(within) {
        return empty(of.otherwise);
    }
    let x = within;
    let found = match f {
        RealUnary::Asin => rounded_result(how, exact::rising(x, f64::asin), || x.asin()),
        RealUnary::Acos => {
            let falling = exact::neg(exact::rising(x, |x| -x.acos()));
            rounded_result(how, falling, || x.acos())
        }
        RealUnary::Acosh => {
            let rising = not_below(exact::rising(x, f64::acosh), 0.0);
            let wide = exact::widened(exact::widened(rising));
            // Near 1, the formula of the permitted values takes the root of a difference.
            bounded(how, wide, x.acosh(), UNKNOWN)
        }
        _ => bounded(how, exact::rising(x, f64::atanh), x.atanh(), UNKNOWN),
    };
    found.with(Faults::any([outside]))
}

/// The arithmetic operations of two operands; `same` if they are one value, `rounded` whether each
/// was rounded before.
pub(super) fn f2(
    how: Arithmetic,
    f: RealBinary,
    a: Interval,
    b: Interval,
    same: bool,
    rounded: [bool; 2],
) -> Applied {
    if is_empty(a) || is_empty(b) {
        return without_fault(exact::EMPTY);
    }
    match f {
        RealBinary::Add => sum(how, a, b, rounded),
        RealBinary::Sub if same => without_fault(point(0.0)),
        RealBinary::Sub => sum(how, a, exact::neg(b), rounded),
        RealBinary::Mul if same => rounded_result(how, exact::squared(a), || a.squared()),
        RealBinary::Mul => rounded_result(how, exact::mul(a, b), || a.mul(b)),
        RealBinary::Div if same => ratio_of_one(how, b),
        RealBinary::Div => quotient(how, a, b, 0.0),
        RealBinary::Rem => remainder(how, a, b),
        RealBinary::Min => without_fault(between(a.low.min(b.low), a.high.min(b.high))),
        RealBinary::Max => without_fault(between(a.low.max(b.low), a.high.max(b.high))),
        // The first operand is the value, the second the edge.
        RealBinary::Step => {
            let bit = |x: bool| f64::from(u8::from(x));
            without_fault(between(bit(b.high <= a.low), bit(b.low <= a.high)))
        }
        RealBinary::Pow => power(how, a, b),
        RealBinary::Atan2 => {
            let exact = exact::atan2(a, b);
            let found = bounded(how, exact, a.atan2(b), COARSE * 4.0);
            found.with(Faults::any(undefined2(f, a, b)))
        }
    }
}

pub(super) fn product(how: Arithmetic, a: Interval, b: Interval, same: bool) -> Applied {
    f2(how, RealBinary::Mul, a, b, same, [false; 2])
}

/// Returns the difference of exact numbers.
pub(super) fn difference(how: Arithmetic, a: Interval, b: Interval, same: bool) -> Applied {
    f2(how, RealBinary::Sub, a, b, same, [false; 2])
}

fn sum(how: Arithmetic, a: Interval, b: Interval, rounded: [bool; 2]) -> Applied {
    let exact = exact::add(a, b);
    let found = rounded_result(how, exact, || a.add(b));
    // Terms of one sign do not cancel. Those that are exact lose nothing: their small difference is
    // what was asked for.
    let apart = a.low >= 0.0 && b.low >= 0.0 || a.high <= 0.0 && b.high <= 0.0;
    let [a, b] = [(a, rounded[0]), (b, rounded[1])].map(|(x, r)| if r { size(x) } else { 0.0 });
    let lost = how == Arithmetic::Permitted && !apart && !keeps_digits(exact, a.max(b));
    found.with(if lost { Faults::from_fault(Fault::Cancellation) } else { Faults::NONE })
}

/// Whether a sum keeps half of the digits of its larger term.
pub(super) fn keeps_digits(sum: Interval, largest: f64) -> bool {
    let least = if contains(sum, 0.0) { 0.0 } else { sum.low.abs().min(sum.high.abs()) };
    least * LOST >= largest
}

/// Returns the quotient of a value by itself.
fn ratio_of_one(how: Arithmetic, b: Interval) -> Applied {
    let zero = Faults::any(undefined2(RealBinary::Div, b, flushed(how, b)));
    // More than 2.5 ULP of a quotient close to 1.
    let error = 2f64.powi(-21);
    let value = match how {
        // Beyond 2^126 a divisor has no permitted error, but no fault either.
        Arithmetic::Permitted if size(b) > 2f64.powi(126) => between(-LIMIT, LIMIT),
        Arithmetic::Permitted => between(1.0 - error, 1.0 + error),
        Arithmetic::Exact | Arithmetic::Nearest => point(1.0),
    };
    Applied { value, faults: zero }
}

/// Returns an operand as devices may take it: subnormal numbers may be zero.
fn flushed(how: Arithmetic, x: Interval) -> Interval {
    if how == Arithmetic::Permitted { x.flushed() } else { x }
}

/// Returns the quotient by a divisor of at least an absolute size.
pub(super) fn quotient(how: Arithmetic, a: Interval, b: Interval, size_of_b: f64) -> Applied {
    if is_empty(a) || is_empty(b) {
        return without_fault(exact::EMPTY);
    }
    let least = if how == Arithmetic::Exact { f64::MIN_POSITIVE } else { LEAST };
    let normal = size_of_b >= f64::from(f32::MIN_POSITIVE);
    let zero = match normal {
        true => Faults::NONE,
        false => Faults::any(undefined2(RealBinary::Div, a, flushed(how, b))),
    };
    let least = least.max(size_of_b);
    // On both sides of zero, which is the fault.
    let parts = [between(b.low.max(least), b.high), between(b.low, b.high.min(-least))];
    let mut all = Applied { value: exact::EMPTY, faults: zero };
    for part in parts {
        if is_empty(part) {
            continue;
        }
        let exact = exact::div(a, part);
        // Beyond 2^126 a divisor has no permitted error, but no fault either.
        let far = size(part) > 2f64.powi(126) && size(exact) < 2f64.powi(100);
        let found = rounded_result(how, exact, || match a.div(part) {
            any if any.is_any() && far => between(-LIMIT, LIMIT),
            value => value,
        });
        all = Applied { value: hull(all.value, found.value), faults: all.faults.and(found.faults) };
    }
    all
}

fn remainder(how: Arithmetic, a: Interval, b: Interval) -> Applied {
    let most = size(b);
    let faults = Faults::any(undefined2(RealBinary::Rem, a, flushed(how, b)));
    // It has the dividend's sign, and is smaller than the divisor.
    let sign =
        between(if a.low < 0.0 { -most } else { 0.0 }, if a.high > 0.0 { most } else { 0.0 });
    let value = match how {
        Arithmetic::Exact | Arithmetic::Nearest if a.low == a.high && b.low == b.high => {
            if b.low == 0.0 { exact::EMPTY } else { point(a.low % b.low) }
        }
        Arithmetic::Exact | Arithmetic::Nearest => sign,
        Arithmetic::Permitted => match a.rem(b) {
            any if any.is_any() => {
                let wide = 2.0 * most + size(a) * COARSE;
                intersection(between(-wide, wide), between(-LIMIT, LIMIT))
            }
            value => value,
        },
    };
    Applied { value, faults }
}

fn power(how: Arithmetic, x: Interval, y: Interval) -> Applied {
    if x.high < 0.0 {
        return empty(K::PowOfNegative);
    }
    let faults = Faults::any(undefined2(RealBinary::Pow, x, y));
    let mut base = not_below(x, 0.0);
    // Zero to a power above zero is zero, beside powers of zero that are undefined.
    let has_zero = base.low == 0.0 && y.high > 0.0;
    if base.low == 0.0 && y.low <= 0.0 {
        if base.high == 0.0 && y.high <= 0.0 {
            return empty(K::PowOfZero);
        }
        base.low = if how == Arithmetic::Exact { f64::MIN_POSITIVE } else { LEAST };
        base.high = base.high.max(base.low);
    }
    let found = rounded_result(how, exact::pow(base, y), || base.pow(y)).with(faults);
    let value = if has_zero { hull(found.value, point(0.0)) } else { found.value };
    Applied { value, ..found }
}

pub(super) fn f3(
    how: Arithmetic,
    f: RealTernary,
    [a, b, c]: [Interval; 3],
    steady: bool,
) -> Applied {
    if is_empty(a) || is_empty(b) || is_empty(c) {
        return without_fault(exact::EMPTY);
    }
    match f {
        RealTernary::Fma => {
            rounded_result(how, exact::add(exact::mul(a, b), c), || a.mul(b).add(c))
        }
        RealTernary::Clamp => {
            let above = between(a.low.max(b.low), a.high.max(b.high));
            let value = between(above.low.min(c.low), above.high.min(c.high));
            let crossed = undefined3(f, [a, b, c]).filter(|_| !steady);
            Applied { value, faults: Faults::any([crossed]) }
        }
        RealTernary::Mix => {
            let one = point(1.0);
            let sum = exact::add(exact::mul(a, exact::sub(one, c)), exact::mul(b, c));
            let found = rounded_result(how, sum, || a.mul(one.sub(c)).add(b.mul(c)));
            // Between the ends, the result is too, up to the roundings of four operations.
            let ends = hull(a, b);
            let error = size(ends) * 2f64.powi(-20) + f64::from(f32::MIN_POSITIVE);
            let inside = between(ends.low - error, ends.high + error);
            match c.low >= 0.0 && c.high <= 1.0 && !found.faults.has(OVERFLOW) {
                true => Applied { value: intersection(found.value, inside), ..found },
                false => found,
            }
        }
        RealTernary::SmoothStep => smoothstep(how, a, b, c),
    }
}

const OVERFLOW: Fault = Fault::Undefined(K::BornInfinite);

fn smoothstep(how: Arithmetic, low: Interval, high: Interval, x: Interval) -> Applied {
    let faults = Faults::any([undefined3(RealTernary::SmoothStep, [low, high, x])]);
    if low.low >= high.high {
        return empty(K::SmoothStepEdges);
    }
    let [past, width] = match how {
        Arithmetic::Permitted => [x.sub(low), high.sub(low)],
        Arithmetic::Exact | Arithmetic::Nearest => [exact::sub(x, low), exact::sub(high, low)],
    };
    let finite = |x: Interval| if x == ANY { between(-LIMIT, LIMIT) } else { x };
    // The edges are in order, or the fault is certain: their distance is positive.
    let width = not_below(finite(width), LEAST);
    let t = quotient(how, finite(past), width, 0.0).value;
    let t = exact::step(t, |t| t.clamp(0.0, 1.0));
    let curve = |t: f64| t * t * (3.0 - 2.0 * t);
    // Four roundings of numbers up to 3.
    let error = if how == Arithmetic::Permitted { 2f64.powi(-20) } else { 1e-15 };
    let wide = between(curve(t.low) - error, curve(t.high) + error);
    let least = if t.low == 0.0 { 0.0 } else { wide.low.max(0.0) };
    let found = match how {
        Arithmetic::Nearest => nearest(between(curve(t.low), curve(t.high))),
        Arithmetic::Exact | Arithmetic::Permitted => without_fault(between(least, wide.high)),
    };
    found.with(faults)
}

/// Returns the sum of terms in any order, and whether it may overflow.
pub(super) fn total(how: Arithmetic, terms: &[Interval], exact: Interval) -> Applied {
    rounded_result(how, exact, || super::super::interval::sum_in_any_order(terms))
}
