//! The conditions under which an operation has no defined value: one table, which a run and its
//! trace evaluate at numbers, and a proof over ranges of them.
//!
//! After GLSL 4.60, chapters 5 and 8, and WGSL 17.5; both leave undefined what is listed here unless
//! an arm says otherwise.

use super::code::{Cast, Class, F1, F2, F3, I2};
use super::interval::Interval;
use super::undefined::UndefinedKind as K;

/// The numbers for which a function of one operand is defined.
#[derive(Clone, Copy, Debug)]
pub(super) struct Defined {
    pub low: f64,
    pub high: f64,
    /// Whether the finite ends belong to them.
    pub has_ends: bool,
    pub otherwise: K,
}

impl Defined {
    /// Whether a range has a number for which the function is not defined.
    pub fn is_left(self, x: Interval) -> bool {
        let at_end = x.low <= self.low || x.high >= self.high && self.high.is_finite();
        x.low < self.low || x.high > self.high || !self.has_ends && at_end
    }
}

/// Returns the numbers for which a function is defined; `None` if it is for all.
pub(super) fn defined(f: F1) -> Option<Defined> {
    let of = |low, high, has_ends, otherwise| Some(Defined { low, high, has_ends, otherwise });
    match f {
        F1::Sqrt => of(0.0, f64::INFINITY, true, K::RootOfNegative),
        F1::InverseSqrt => of(0.0, f64::INFINITY, false, K::RootOfNegative),
        F1::Log | F1::Log2 => of(0.0, f64::INFINITY, false, K::LogOfNonPositive),
        F1::Asin | F1::Acos => of(-1.0, 1.0, true, K::ArcOutOfRange),
        F1::Acosh => of(1.0, f64::INFINITY, true, K::ArcOutOfRange),
        F1::Atanh => of(-1.0, 1.0, false, K::ArcOutOfRange),
        _ => None,
    }
}

fn has_zero(x: Interval) -> bool {
    x.low <= 0.0 && x.high >= 0.0
}

/// Returns the ways in which a function of two operands may be undefined over their ranges: at
/// numbers, at most one.
pub(super) fn undefined2(f: F2, a: Interval, b: Interval) -> [Option<K>; 2] {
    let when = |condition: bool, kind: K| condition.then_some(kind);
    match f {
        F2::Div | F2::Rem => [when(has_zero(b), K::DivisionByZero), None],
        F2::Pow => {
            [when(a.low < 0.0, K::PowOfNegative), when(has_zero(a) && b.low <= 0.0, K::PowOfZero)]
        }
        F2::Atan2 => [when(has_zero(a) && has_zero(b), K::AtanOfZeros), None],
        F2::Add | F2::Sub | F2::Mul | F2::Min | F2::Max | F2::Step => [None; 2],
    }
}

/// Returns the way in which a function of three operands may be undefined over their ranges.
pub(super) fn undefined3(f: F3, [a, b, c]: [Interval; 3]) -> Option<K> {
    match f {
        F3::SmoothStep => (a.high >= b.low).then_some(K::SmoothStepEdges),
        F3::Clamp => (b.high > c.low).then_some(K::ClampBounds),
        F3::Fma | F3::Mix => None,
    }
}

/// Returns why a function is undefined at numbers, NaN and infinity among them.
pub(super) fn undefined1_at(f: F1, x: f64) -> Option<K> {
    match f {
        F1::Saturate if x.is_nan() => Some(K::NanCompared),
        _ => defined(f).filter(|of| of.is_left(point(x))).map(|of| of.otherwise),
    }
}

pub(super) fn undefined2_at(f: F2, a: f64, b: f64) -> Option<K> {
    match f {
        F2::Mul if a == 0.0 && b.is_infinite() || a.is_infinite() && b == 0.0 => {
            Some(K::ZeroTimesInfinity)
        }
        F2::Min | F2::Max | F2::Step if a.is_nan() || b.is_nan() => Some(K::NanCompared),
        _ => undefined2(f, point(a), point(b)).into_iter().flatten().next(),
    }
}

pub(super) fn undefined3_at(f: F3, operands: [f64; 3]) -> Option<K> {
    match f {
        F3::Clamp if operands.iter().any(|x| x.is_nan()) => Some(K::NanCompared),
        _ => undefined3(f, operands.map(point)),
    }
}

fn point(x: f64) -> Interval {
    Interval { low: x, high: x }
}

/// Returns why an integer operation of a width is undefined. GLSL 4.60 5.9 leaves the remainder of
/// a negative operand undefined, which WGSL 8.7 defines: `has_negative_remainder`.
pub(super) fn undefined_integer(
    f: I2,
    a: u64,
    b: u64,
    bits: u32,
    has_negative_remainder: bool,
) -> Option<K> {
    let (lowest, ones) = (1 << (bits - 1), u64::MAX >> (64 - bits));
    match f {
        I2::DivSint | I2::DivUint | I2::RemSint | I2::RemUint if b == 0 => {
            Some(K::IntegerDivisionByZero)
        }
        I2::DivSint | I2::RemSint if a == lowest && b == ones => Some(K::IntegerOverflow),
        I2::RemSint if !has_negative_remainder && (a >= lowest || b >= lowest) => {
            Some(K::RemainderOfNegative)
        }
        I2::Shl | I2::ShrSint | I2::ShrUint if b >= u64::from(bits) => Some(K::ShiftTooFar),
        _ => None,
    }
}

/// Returns the class that a conversion to integers reads, and the least and largest result.
pub(super) fn whole_range(cast: Cast) -> Option<(Class, f64, f64)> {
    let sint = (f64::from(i32::MIN), f64::from(i32::MAX));
    let uint = (0.0, f64::from(u32::MAX));
    let sint64 = (i64::MIN as f64, i64::MAX as f64);
    let uint64 = (0.0, u64::MAX as f64);
    let (class, (low, high)) = match cast {
        Cast::RealToSint => (Class::Real, sint),
        Cast::RealToUint => (Class::Real, uint),
        Cast::RealToSint64 => (Class::Real, sint64),
        Cast::RealToUint64 => (Class::Real, uint64),
        Cast::DoubleToSint => (Class::Wide, sint),
        Cast::DoubleToUint => (Class::Wide, uint),
        Cast::DoubleToSint64 => (Class::Wide, sint64),
        Cast::DoubleToUint64 => (Class::Wide, uint64),
        _ => return None,
    };
    Some((class, low, high))
}
