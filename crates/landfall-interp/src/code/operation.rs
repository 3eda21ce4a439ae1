//! The operations of arithmetic instructions.

use super::Class;

/// Float operations with one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RealUnary {
    Neg,
    Abs,
    Sign,
    Floor,
    Ceil,
    Round,
    Trunc,
    Fract,
    Saturate,
    Radians,
    Degrees,
    Sqrt,
    InverseSqrt,
    Quantize,
    Sin,
    Cos,
    Tan,
    Sinh,
    Cosh,
    Tanh,
    Asin,
    Acos,
    Atan,
    Asinh,
    Acosh,
    Atanh,
    Exp,
    Exp2,
    Log,
    Log2,
    FrexpFract,
}

/// Float operations with two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum RealBinary {
    Add,
    Sub,
    Mul,
    Div,
    Rem,
    Min,
    Max,
    Step,
    Pow,
    Atan2,
}

/// Float operations with three operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum RealTernary {
    Fma,
    Mix,
    Clamp,
    SmoothStep,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cmp {
    Eq,
    Ne,
    Lt,
    Le,
    Gt,
    Ge,
}

impl Cmp {
    #[inline(always)]
    pub fn holds<T: PartialOrd>(self, a: T, b: T) -> bool {
        // As IEEE 754 §5.11: of the comparisons with a NaN only `Ne` holds.
        match self {
            Cmp::Eq => a == b,
            Cmp::Ne => a != b,
            Cmp::Lt => a < b,
            Cmp::Le => a <= b,
            Cmp::Gt => a > b,
            Cmp::Ge => a >= b,
        }
    }
}

/// Tests of one float.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Test {
    IsNan,
    IsInf,
}

/// Integer operations with one operand; `Sint` where the sign matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum WordUnary {
    Neg,
    Not,
    /// Negates a bool.
    LogicalNot,
    AbsSint,
    SignSint,
    TrailingZeros,
    LeadingZeros,
    Ones,
    Reverse,
    FirstTrailing,
    FirstLeadingSint,
    FirstLeadingUint,
    /// Keeps the low 16 bits, extended by their sign or zeros.
    Narrow16Sint,
    Narrow16Uint,
}

/// Integer operations with two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum WordBinary {
    Add,
    Sub,
    Mul,
    DivSint,
    DivUint,
    RemSint,
    RemUint,
    And,
    Or,
    Xor,
    Shl,
    ShrSint,
    ShrUint,
    MinSint,
    MinUint,
    MaxSint,
    MaxUint,
    Dot4Sint,
    Dot4Uint,
}

/// Operations of two operands in the wide registers: of doubles, or of 64-bit integers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum WideBinary {
    Float(RealBinary),
    Int(WordBinary),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Cast {
    RealToSint,
    RealToUint,
    RealToBool,
    SintToReal,
    UintToReal,
    WordToBool,
    RealBits,
    BitsReal,
    RealToDouble,
    DoubleToReal,
    DoubleToSint,
    DoubleToUint,
    DoubleToSint64,
    DoubleToUint64,
    RealToSint64,
    RealToUint64,
    SintToWide,
    UintToWide,
    SintToDouble,
    UintToDouble,
    WideToWord,
    WideToBool,
    DoubleToBool,
    Sint64ToReal,
    Uint64ToReal,
    Sint64ToDouble,
    Uint64ToDouble,
    /// The exponent that `frexp` splits off.
    Exponent,
    /// Rounds to the nearest half; the result is a real.
    RoundHalf,
    /// The bits of a half.
    HalfToBits,
    /// The half in the lowest 16 bits of a word.
    LowHalf,
    /// The half in the highest 16 bits of a word.
    HighHalf,
}

impl Cast {
    /// Returns the classes that a conversion reads and writes.
    pub fn classes(self) -> (Class, Class) {
        use Class::{Real, Wide, Word};
        match self {
            Cast::RealToSint | Cast::RealToUint | Cast::RealToBool | Cast::RealBits => (Real, Word),
            Cast::Exponent | Cast::HalfToBits => (Real, Word),
            Cast::SintToReal | Cast::UintToReal | Cast::BitsReal => (Word, Real),
            Cast::LowHalf | Cast::HighHalf => (Word, Real),
            Cast::WordToBool => (Word, Word),
            Cast::RoundHalf => (Real, Real),
            Cast::RealToDouble | Cast::RealToSint64 | Cast::RealToUint64 => (Real, Wide),
            Cast::DoubleToReal | Cast::Sint64ToReal | Cast::Uint64ToReal => (Wide, Real),
            Cast::DoubleToSint | Cast::DoubleToUint | Cast::DoubleToBool => (Wide, Word),
            Cast::WideToWord | Cast::WideToBool => (Wide, Word),
            Cast::SintToWide | Cast::UintToWide => (Word, Wide),
            Cast::SintToDouble | Cast::UintToDouble => (Word, Wide),
            Cast::DoubleToSint64
            | Cast::DoubleToUint64
            | Cast::Sint64ToDouble
            | Cast::Uint64ToDouble => (Wide, Wide),
        }
    }
}
