//! The conditions under which an operation has no defined value, over the numbers that its operands
//! may have.
//!
//! After GLSL 4.60, chapters 5 and 8, and WGSL 17.5; both leave undefined what is listed here
//! unless a function says otherwise. Runs and the reference ask at numbers, proofs over ranges, and
//! lints over what they know of a shader's values.

use std::ops::RangeInclusive;

use super::UndefinedKind::{self, *};

/// The numbers that an operand may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperandRange {
    /// The least.
    pub low: f64,
    /// The largest.
    pub high: f64,
    /// Whether 0 is not among them.
    pub nonzero: bool,
}

impl From<f64> for OperandRange {
    fn from(x: f64) -> OperandRange {
        OperandRange { low: x, high: x, nonzero: false }
    }
}

impl OperandRange {
    // Over a range the question is whether an undefined operand may occur; over one number whether
    // it does.
    fn has(self, x: f64) -> bool {
        self.low <= x && x <= self.high && !(x == 0.0 && self.nonzero)
    }
}

/// The numbers for which a function of one operand is defined.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Defined {
    /// The least.
    pub low: f64,
    /// The largest.
    pub high: f64,
    /// Whether the finite ends belong to them.
    pub has_ends: bool,
    /// What another number is.
    pub otherwise: UndefinedKind,
}

impl Defined {
    const fn within(low: f64, high: f64, has_ends: bool, otherwise: UndefinedKind) -> Defined {
        Defined { low, high, has_ends, otherwise }
    }

    /// Returns why the function is not defined for some of the numbers.
    pub fn undefined(self, x: OperandRange) -> Option<UndefinedKind> {
        // An infinite end is never reached by a defined operand; `x` being infinite is another
        // hazard.
        let at_end = x.has(self.low) || x.has(self.high) && self.high.is_finite();
        let is_left = x.low < self.low || x.high > self.high || !self.has_ends && at_end;
        is_left.then_some(self.otherwise)
    }
}

pub const ROOT: Defined = Defined::within(0.0, f64::INFINITY, true, RootOfNegative);
pub const INVERSE_ROOT: Defined = Defined::within(0.0, f64::INFINITY, false, RootOfNegative);
pub const LOGARITHM: Defined = Defined::within(0.0, f64::INFINITY, false, LogOfNonPositive);
/// `asin` and `acos`.
pub const ARC: Defined = Defined::within(-1.0, 1.0, true, ArcOutOfRange);
/// `acosh`.
pub const ARC_COSH: Defined = Defined::within(1.0, f64::INFINITY, true, ArcOutOfRange);
/// `atanh`.
pub const ARC_TANH: Defined = Defined::within(-1.0, 1.0, false, ArcOutOfRange);

/// Returns why a quotient or remainder of floats is undefined.
pub fn division(divisor: OperandRange) -> Option<UndefinedKind> {
    // A divisor of -0 is 0.
    divisor.has(0.0).then_some(DivisionByZero)
}

/// Returns why a power is undefined: at numbers, for at most one reason.
pub fn power(base: OperandRange, exponent: OperandRange) -> [Option<UndefinedKind>; 2] {
    [
        // GLSL 4.60 §8.2: undefined for x < 0, and for x = 0 with y <= 0. WGSL §17.5 has the same
        // domain.
        (base.low < 0.0).then_some(PowOfNegative),
        (base.has(0.0) && exponent.low <= 0.0).then_some(PowOfZero),
    ]
}

pub fn angle(y: OperandRange, x: OperandRange) -> Option<UndefinedKind> {
    // GLSL 4.60 §8.1: `atan(y, x)` is undefined if both are 0.
    (y.has(0.0) && x.has(0.0)).then_some(AtanOfZeros)
}

/// Returns why the direction of a vector of that length, or squared length, is undefined.
pub fn direction(length: OperandRange) -> Option<UndefinedKind> {
    length.has(0.0).then_some(NormalizeOfZero)
}

/// Returns why `smoothstep` is undefined for its edges.
pub fn smooth_step(first: OperandRange, second: OperandRange) -> Option<UndefinedKind> {
    // GLSL 4.60 §8.3: undefined for edge0 >= edge1.
    (first.high >= second.low).then_some(SmoothStepEdges)
}

/// Returns why `clamp` is undefined for its bounds.
pub fn clamp(low: OperandRange, high: OperandRange) -> Option<UndefinedKind> {
    // GLSL 4.60 §8.3: undefined for minVal > maxVal.
    (low.high > high.low).then_some(ClampBounds)
}

/// Returns why the conversion to integers from the least to the largest is undefined, which drops
/// the fraction.
pub fn conversion(x: OperandRange, least: f64, most: f64) -> Option<UndefinedKind> {
    // The fraction is dropped first: -0.5 is 0, and inside the range of an unsigned integer.
    let is_inside = x.low.trunc() >= least && x.high.trunc() <= most;
    (!is_inside).then_some(ConversionOutOfRange)
}

/// Returns why a quotient or remainder of integers is undefined; `least` is the least of their
/// type.
pub fn quotient(
    a: &RangeInclusive<i128>,
    b: &RangeInclusive<i128>,
    least: i128,
) -> [Option<UndefinedKind>; 2] {
    // -2^31 / -1 is 2^31, which the type does not have.
    let overflows = a.contains(&least) && b.contains(&-1);
    [b.contains(&0).then_some(IntegerDivisionByZero), overflows.then_some(IntegerOverflow)]
}

/// Returns why a remainder of integers is undefined beside its quotient: GLSL 4.60 5.9 leaves that
/// of a negative operand undefined, which WGSL 8.7 defines.
pub fn remainder(a: &RangeInclusive<i128>, b: &RangeInclusive<i128>) -> Option<UndefinedKind> {
    (*a.start() < 0 || *b.start() < 0).then_some(RemainderOfNegative)
}

/// Returns why a shift of so many bits is undefined.
pub fn shift(by: &RangeInclusive<i128>, bits: u32) -> Option<UndefinedKind> {
    // GLSL 4.60 §5.9: undefined for a count of the width or more.
    (*by.end() >= i128::from(bits)).then_some(ShiftTooFar)
}
