//! The values of a [`Graph`](super::Graph).

use super::super::code::{Cast, Class, Cmp, F1, F2, F3, I1, I2, Test};

/// The index of a node; operands come before the nodes that use them.
pub(super) type NodeId = u32;

/// The index of a guard: the branches under which a value is computed.
pub(super) type GuardId = u32;

/// A value: an operation on earlier values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub act: Act,
    pub class: Class,
    /// The operands: `count` words of the pool from `first`.
    pub first: u32,
    pub count: u32,
    /// The branches under which it is computed.
    pub guard: GuardId,
    /// The instruction.
    pub pc: u32,
    /// Whether it is an input, a constant or chosen among such: not rounded.
    pub exact: bool,
}

/// What a node computes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Act {
    /// A scalar of the inputs.
    Input(u32),
    /// A number; words are from -2^31 to 2^32, by their bits.
    Constant(f64),
    F1(F1),
    F2(F2),
    F3(F3),
    Compare(Cmp),
    Test(Test),
    Ldexp,
    Dot,
    Length,
    Distance,
    /// One component of a normalised vector.
    Normalize(u8),
    /// One component of a cross product.
    Cross(u8),
    I1(I1),
    I2(I2),
    CompareWords(Cmp, bool),
    /// A field of bits, with its sign.
    Extract(bool),
    Cast(Cast),
    /// `[condition, accept, reject]`
    Select,
    /// An index of a run of elements: its fault alone.
    Index(u32),
    /// A value within known bounds that is not followed.
    Within(f64, f64),
    /// A loop left after the most iterations; its guard tells whether it is reached.
    Endless,
    /// An operation that is not followed; its fault alone.
    Unfollowed,
}

impl Act {
    /// Returns a key equal for equal acts.
    pub fn key(self) -> (u64, u64, u64) {
        let of = |tag: u64, more: u64| (tag, more, 0);
        match self {
            Act::Input(n) => of(0, u64::from(n)),
            Act::Constant(x) => of(1, x.to_bits()),
            Act::F1(f) => of(2, f as u64),
            Act::F2(f) => of(3, f as u64),
            Act::F3(f) => of(4, f as u64),
            Act::Compare(c) => of(5, c as u64),
            Act::Test(t) => of(6, t as u64),
            Act::Ldexp => of(7, 0),
            Act::Dot => of(8, 0),
            Act::Length => of(9, 0),
            Act::Distance => of(10, 0),
            Act::Normalize(i) => of(11, u64::from(i)),
            Act::Cross(i) => of(12, u64::from(i)),
            Act::I1(f) => of(13, f as u64),
            Act::I2(f) => of(14, f as u64),
            Act::CompareWords(c, s) => of(15, c as u64 * 2 + u64::from(s)),
            Act::Extract(s) => of(16, u64::from(s)),
            Act::Cast(c) => of(17, c as u64),
            Act::Select => of(18, 0),
            Act::Index(len) => of(20, u64::from(len)),
            Act::Within(low, high) => (21, low.to_bits(), high.to_bits()),
            Act::Endless => of(22, 0),
            Act::Unfollowed => of(23, 0),
        }
    }

    /// Whether the result is exact if the operands are.
    pub fn keeps_exact(self) -> bool {
        match self {
            Act::Input(_) | Act::Constant(_) | Act::Select => true,
            Act::F1(f) => matches!(
                f,
                F1::Neg
                    | F1::Abs
                    | F1::Sign
                    | F1::Floor
                    | F1::Ceil
                    | F1::Round
                    | F1::Trunc
                    | F1::Saturate
            ),
            Act::F2(f) => matches!(f, F2::Min | F2::Max | F2::Step),
            Act::F3(f) => f == F3::Clamp,
            Act::Cast(cast) => !matches!(cast, Cast::RoundHalf),
            Act::Within(..) => true,
            Act::Compare(_)
            | Act::Test(_)
            | Act::Ldexp
            | Act::Dot
            | Act::Length
            | Act::Distance
            | Act::Normalize(_)
            | Act::Cross(_)
            | Act::I1(_)
            | Act::I2(_)
            | Act::CompareWords(..)
            | Act::Extract(_)
            | Act::Index(_)
            | Act::Endless
            | Act::Unfollowed => false,
        }
    }

    /// Whether equal operands give equal values.
    pub fn is_pure(self) -> bool {
        !matches!(self, Act::Within(..) | Act::Endless | Act::Unfollowed)
    }
}
