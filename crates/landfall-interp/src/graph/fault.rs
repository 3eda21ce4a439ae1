//! The faults of operations, and sets of them.

use std::fmt;

use super::super::code::{Cast, RealBinary, RealTernary, RealUnary, WordBinary};
use super::super::undefined::UndefinedKind;
use super::node::NodeOp;

/// A fault: a way in which an operation can break.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Fault {
    /// The result is not defined, or not finite.
    Undefined(UndefinedKind),
    /// The difference of rounded numbers loses more than half of their digits.
    Cancellation,
    /// A loop that runs longer than is followed.
    Endless,
    /// Code that is not followed.
    Unfollowed,
}

impl Fault {
    /// Returns a short description.
    pub fn text(self) -> &'static str {
        match self {
            Fault::Undefined(UndefinedKind::BornInfinite) => "overflow",
            Fault::Undefined(kind) => kind.name(),
            Fault::Cancellation => "subtraction of nearly equal numbers",
            Fault::Endless => "loop of many iterations",
            Fault::Unfollowed => "code that the analysis cannot follow",
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text())
    }
}

/// A set of faults.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Faults(u32);

impl Faults {
    pub const NONE: Faults = Faults(0);

    pub fn from_fault(fault: Fault) -> Faults {
        Faults(
            // Kinds of undefined results have the bits below 29.
            1 << match fault {
                Fault::Undefined(kind) => kind as u32,
                Fault::Cancellation => 29,
                Fault::Endless => 30,
                Fault::Unfollowed => 31,
            },
        )
    }

    pub fn when(condition: bool, kind: UndefinedKind) -> Faults {
        if condition { Faults::from_fault(Fault::Undefined(kind)) } else { Faults::NONE }
    }

    pub fn any(kinds: impl IntoIterator<Item = Option<UndefinedKind>>) -> Faults {
        let each = kinds.into_iter().flatten();
        each.fold(Faults::NONE, |all, kind| all.and(Faults::from_fault(Fault::Undefined(kind))))
    }

    pub fn and(self, more: Faults) -> Faults {
        Faults(self.0 | more.0)
    }

    pub fn without(self, fault: Fault) -> Faults {
        Faults(self.0 & !Faults::from_fault(fault).0)
    }

    pub fn has(self, fault: Fault) -> bool {
        self.0 & Faults::from_fault(fault).0 != 0
    }
}

/// Returns the faults that an act can have.
pub(super) fn faults_of(act: NodeOp) -> &'static [Fault] {
    use Fault::Undefined as U;
    use UndefinedKind as K;
    const OVERFLOW: &[Fault] = &[U(K::BornInfinite)];
    const LOG: &[Fault] = &[U(K::LogOfNonPositive)];
    const ARC: &[Fault] = &[U(K::ArcOutOfRange)];
    const SQUARES: &[Fault] = &[U(K::SquaresTooLarge), U(K::SquaresTooSmall)];
    match act {
        NodeOp::RealUnary(f) => match f {
            RealUnary::Sqrt | RealUnary::InverseSqrt => &[U(K::RootOfNegative)],
            RealUnary::Log | RealUnary::Log2 => LOG,
            RealUnary::Asin | RealUnary::Acos | RealUnary::Acosh | RealUnary::Atanh => ARC,
            RealUnary::Sinh
            | RealUnary::Cosh
            | RealUnary::Exp
            | RealUnary::Exp2
            | RealUnary::Tan
            | RealUnary::Degrees => OVERFLOW,
            _ => &[],
        },
        NodeOp::RealBinary(f) => match f {
            RealBinary::Div | RealBinary::Rem => &[U(K::DivisionByZero), U(K::BornInfinite)],
            RealBinary::Pow => &[U(K::PowOfNegative), U(K::PowOfZero), U(K::BornInfinite)],
            RealBinary::Atan2 => &[U(K::AtanOfZeros)],
            RealBinary::Add | RealBinary::Sub => &[Fault::Cancellation, U(K::BornInfinite)],
            RealBinary::Mul => OVERFLOW,
            RealBinary::Min | RealBinary::Max | RealBinary::Step => &[],
        },
        NodeOp::RealTernary(f) => match f {
            RealTernary::SmoothStep => &[U(K::SmoothStepEdges), U(K::BornInfinite)],
            RealTernary::Clamp => &[U(K::ClampBounds)],
            RealTernary::Fma | RealTernary::Mix => OVERFLOW,
        },
        // The first component has the faults of the whole vector.
        NodeOp::Normalize(0) => {
            &[U(K::NormalizeOfZero), U(K::SquaresTooLarge), U(K::SquaresTooSmall)]
        }
        NodeOp::Length | NodeOp::Distance => SQUARES,
        NodeOp::Dot | NodeOp::Cross(_) | NodeOp::Ldexp => OVERFLOW,
        NodeOp::WordBinary(WordBinary::DivSint) => {
            &[U(K::IntegerDivisionByZero), U(K::IntegerOverflow)]
        }
        NodeOp::WordBinary(WordBinary::RemSint) => {
            &[U(K::IntegerDivisionByZero), U(K::IntegerOverflow), U(K::RemainderOfNegative)]
        }
        NodeOp::WordBinary(WordBinary::DivUint | WordBinary::RemUint) => {
            &[U(K::IntegerDivisionByZero)]
        }
        NodeOp::WordBinary(WordBinary::Shl | WordBinary::ShrSint | WordBinary::ShrUint) => {
            &[U(K::ShiftTooFar)]
        }
        NodeOp::Extract(_) => &[U(K::BitsOutOfRange)],
        NodeOp::Cast(Cast::RealToSint | Cast::RealToUint | Cast::HalfToBits) => {
            &[U(K::ConversionOutOfRange)]
        }
        NodeOp::Cast(Cast::BitsReal | Cast::LowHalf | Cast::HighHalf) => &[U(K::BornNan)],
        NodeOp::Cast(Cast::RoundHalf) => OVERFLOW,
        NodeOp::Index(_) => &[U(K::IndexOutOfBounds)],
        NodeOp::Endless => &[Fault::Endless],
        NodeOp::Unfollowed => &[Fault::Unfollowed],
        _ => &[],
    }
}
