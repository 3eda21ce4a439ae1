//! The conditions of [`landfall_ir`]'s table for the interpreter's operations: which one of them an
//! operation has, and what only runs meet, NaN and infinity.

use std::ops::RangeInclusive;

use super::code::{Cast, Class, RealBinary, RealTernary, RealUnary, WordBinary};
use super::interval::Interval;
use super::undefined::UndefinedKind as K;
use landfall_ir::analysis::undefined::condition::{self, Defined, OperandRange};

impl From<Interval> for OperandRange {
    fn from(Interval { low, high }: Interval) -> OperandRange {
        OperandRange { low, high, nonzero: false }
    }
}

/// Returns the numbers for which a function is defined; `None` if it is for all.
pub(super) fn defined(f: RealUnary) -> Option<Defined> {
    match f {
        RealUnary::Sqrt => Some(condition::ROOT),
        RealUnary::InverseSqrt => Some(condition::INVERSE_ROOT),
        RealUnary::Log | RealUnary::Log2 => Some(condition::LOGARITHM),
        RealUnary::Asin | RealUnary::Acos => Some(condition::ARC),
        RealUnary::Acosh => Some(condition::ARC_COSH),
        RealUnary::Atanh => Some(condition::ARC_TANH),
        _ => None,
    }
}

/// Returns the ways in which a function of two operands may be undefined: at numbers, at most one.
pub(super) fn undefined2(
    f: RealBinary,
    a: impl Into<OperandRange>,
    b: impl Into<OperandRange>,
) -> [Option<K>; 2] {
    let (a, b) = (a.into(), b.into());
    match f {
        RealBinary::Div | RealBinary::Rem => [condition::division(b), None],
        RealBinary::Pow => condition::power(a, b),
        RealBinary::Atan2 => [condition::angle(a, b), None],
        RealBinary::Add
        | RealBinary::Sub
        | RealBinary::Mul
        | RealBinary::Min
        | RealBinary::Max
        | RealBinary::Step => [None; 2],
    }
}

/// Returns the way in which a function of three operands may be undefined.
pub(super) fn undefined3(f: RealTernary, operands: [impl Into<OperandRange>; 3]) -> Option<K> {
    let [a, b, c] = operands.map(Into::into);
    match f {
        RealTernary::SmoothStep => condition::smooth_step(a, b),
        RealTernary::Clamp => condition::clamp(b, c),
        RealTernary::Fma | RealTernary::Mix => None,
    }
}

/// Returns why a function is undefined at numbers, NaN and infinity among them.
pub(super) fn undefined1_at(f: RealUnary, x: f64) -> Option<K> {
    match f {
        RealUnary::Saturate if x.is_nan() => Some(K::NanCompared),
        _ => defined(f)?.undefined(x.into()),
    }
}

pub(super) fn undefined2_at(f: RealBinary, a: f64, b: f64) -> Option<K> {
    match f {
        RealBinary::Mul if a == 0.0 && b.is_infinite() || a.is_infinite() && b == 0.0 => {
            Some(K::ZeroTimesInfinity)
        }
        RealBinary::Min | RealBinary::Max | RealBinary::Step if a.is_nan() || b.is_nan() => {
            Some(K::NanCompared)
        }
        _ => undefined2(f, a, b).into_iter().flatten().next(),
    }
}

pub(super) fn undefined3_at(f: RealTernary, operands: [f64; 3]) -> Option<K> {
    match f {
        RealTernary::Clamp if operands.iter().any(|x| x.is_nan()) => Some(K::NanCompared),
        _ => undefined3(f, operands),
    }
}

/// Returns the ways in which an integer operation of a width may be undefined, by the numbers that
/// its operands stand for.
pub(super) fn undefined_integer(
    f: WordBinary,
    a: RangeInclusive<i128>,
    b: RangeInclusive<i128>,
    bits: u32,
) -> [Option<K>; 3] {
    let least = -(1 << (bits - 1));
    let [zero, overflow] = condition::quotient(&a, &b, least);
    match f {
        WordBinary::DivUint | WordBinary::RemUint => [zero, None, None],
        WordBinary::DivSint => [zero, overflow, None],
        WordBinary::RemSint => [zero, overflow, condition::remainder(&a, &b)],
        WordBinary::Shl | WordBinary::ShrSint | WordBinary::ShrUint => {
            [condition::shift(&b, bits), None, None]
        }
        _ => [None; 3],
    }
}

/// Returns why an integer operation is undefined at two words.
pub(super) fn undefined_integer_at(
    f: WordBinary,
    words: [u64; 2],
    bits: u32,
    has_negative_remainder: bool,
) -> Option<K> {
    // The lowest bits of each word, extended by the sign where the operation looks at it.
    let unused = 64 - bits;
    let [a, b] = words.map(|x| match f {
        WordBinary::DivSint | WordBinary::RemSint => i128::from((x << unused) as i64 >> unused),
        _ => i128::from(x),
    });
    let mut kinds = undefined_integer(f, a..=a, b..=b, bits).into_iter().flatten();
    kinds.find(|kind| *kind != K::RemainderOfNegative || !has_negative_remainder)
}

/// Returns the class that a conversion to integers reads, and the least and largest result.
pub(super) fn whole_range(cast: Cast) -> Option<(Class, f64, f64)> {
    let sint = (f64::from(i32::MIN), f64::from(i32::MAX));
    let uint = (0.0, f64::from(u32::MAX));
    // The largest 64-bit integers are rounded up, to 2^63 and 2^64.
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
