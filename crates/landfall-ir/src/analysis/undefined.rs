//! The table of operations whose value no specification defines: the [`condition`]s of each, what
//! is said of it, what avoids it and which hazard of the catalogue it is.
//!
//! The interpreter's sanitizer and traces, proofs, the findings of `stress`, lints and the
//! reference use it.

pub mod condition;

use std::fmt;

use super::hazard::Hazard;
use landfall_layout::named;

named! {
    /// The kinds of operations without a defined value, or with a surprising one.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
    pub enum UndefinedKind {
        DivisionByZero = "division by zero",
        ZeroTimesInfinity = "zero times infinity",
        RootOfNegative = "root of a negative number",
        LogOfNonPositive = "logarithm of zero or less",
        PowOfNegative = "power of a negative number",
        PowOfZero = "zero to the power of zero or less",
        ArcOutOfRange = "inverse of a trigonometric function out of range",
        AtanOfZeros = "angle of the point (0, 0)",
        NormalizeOfZero = "normalised zero vector",
        SmoothStepEdges = "smoothstep with its first edge not below its second",
        ClampBounds = "clamp with its lower bound above its upper one",
        IntegerDivisionByZero = "integer division by zero",
        IntegerOverflow = "integer division that overflows",
        RemainderOfNegative = "remainder of a negative integer",
        ShiftTooFar = "shift by the width or more",
        BitsOutOfRange = "bit field past the end of the word",
        ConversionOutOfRange = "conversion of a number out of range",
        IndexOutOfBounds = "index out of bounds",
        PastEndOfBuffer = "access past the end of the buffer",
        Uninitialised = "variable read before it is written",
        NanFromBuffer = "the buffer holds NaN",
        NanCompared = "NaN into min, max, clamp or step",
        SquaresTooLarge = "length of a vector whose squares overflow",
        SquaresTooSmall = "length of a vector whose squares underflow",
        BornNan = "NaN from finite operands",
        BornInfinite = "infinity from finite operands",
    }
}

impl UndefinedKind {
    /// Returns what avoids it, as a clause without a full stop; empty where that depends on what
    /// the operands are.
    pub fn remedy(self) -> &'static str {
        use UndefinedKind as K;
        match self {
            K::DivisionByZero => "keep the divisor away from zero, or test it before",
            K::RootOfNegative => {
                "where the operand is negative by rounding alone, clamp it to 0; else test it before: \
                 a negative discriminant is a case of its own"
            }
            K::LogOfNonPositive => "keep the operand above zero: `log(max(x, 1.0e-30))`",
            K::PowOfNegative | K::PowOfZero => "guard the base: `x > 0.0 ? pow(x, n) : 0.0`",
            K::ArcOutOfRange => {
                "clamp the operand to -1..1; for the angle of two unit vectors, \
                 `2.0 * atan(length(a - b), length(a + b))`"
            }
            K::AtanOfZeros => "test for the point (0, 0) before",
            K::NormalizeOfZero | K::SquaresTooSmall => {
                "guard it: `v * inversesqrt(max(dot(v, v), 1.0e-30))`"
            }
            K::SmoothStepEdges => {
                "keep the second edge above the first, or write out the ramp with a guarded divisor"
            }
            K::ClampBounds => "sort the bounds",
            K::IntegerDivisionByZero => "keep the divisor at 1 or more: `max(n, 1)`",
            K::IntegerOverflow => "exclude the divisor -1",
            K::RemainderOfNegative => {
                "write `((i % n) + n) % n` in WGSL; in GLSL, where that is undefined too, \
                 `i & (n - 1)` for a power of two, or unsigned integers"
            }
            K::ShiftTooFar => "keep the count below the width: `s & 31`",
            K::BitsOutOfRange => "keep offset and count within the 32 bits",
            K::ConversionOutOfRange => "clamp the number to the range of the integer",
            K::IndexOutOfBounds => "clamp the index to the array: `clamp(i, 0, N - 1)`",
            K::PastEndOfBuffer => "clamp the index to the buffer's length",
            K::Uninitialised => "write the variable before it is read",
            K::SquaresTooLarge => "scale the vector before its squares are taken",
            K::BornInfinite => "bound the operands",
            K::ZeroTimesInfinity | K::NanFromBuffer | K::NanCompared | K::BornNan => "",
        }
    }

    /// Returns which of its operands decide that it is undefined.
    pub fn deciding<T>(self, operands: &[T]) -> &[T] {
        // Guards go to these operands, and origins are traced from them.
        use UndefinedKind as K;
        let range = match self {
            K::DivisionByZero | K::IntegerDivisionByZero | K::ShiftTooFar => 1..2,
            K::PowOfNegative | K::IndexOutOfBounds => 0..1,
            K::SmoothStepEdges => 0..2,
            K::ClampBounds => 1..3,
            _ => 0..operands.len(),
        };
        operands.get(range).unwrap_or(operands)
    }

    /// Returns the hazard that it is where nothing is known of its operands.
    pub fn hazard(self) -> Hazard {
        use UndefinedKind as K;
        match self {
            K::DivisionByZero | K::IntegerDivisionByZero => Hazard::DivisionByZero,
            K::PowOfNegative => Hazard::PowOfNegative,
            K::PowOfZero => Hazard::PowOfZero,
            K::NormalizeOfZero => Hazard::ZeroVector,
            K::SquaresTooLarge | K::BornInfinite | K::BornNan => Hazard::LargeValues,
            K::SquaresTooSmall => Hazard::Underflow,
            K::RemainderOfNegative => Hazard::NegativeRemainder,
            K::IndexOutOfBounds | K::PastEndOfBuffer => Hazard::IndexOutOfBounds,
            K::Uninitialised => Hazard::Uninitialised,
            K::ZeroTimesInfinity
            | K::RootOfNegative
            | K::LogOfNonPositive
            | K::ArcOutOfRange
            | K::AtanOfZeros
            | K::SmoothStepEdges
            | K::ClampBounds
            | K::IntegerOverflow
            | K::ShiftTooFar
            | K::BitsOutOfRange
            | K::ConversionOutOfRange
            | K::NanFromBuffer
            | K::NanCompared => Hazard::UndefinedOperation,
        }
    }
}

impl fmt::Display for UndefinedKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
