//! The values of a [`Graph`](super::Graph).

use super::super::code::{
    Cast, Class, Cmp, RealBinary, RealTernary, RealUnary, Test, WordBinary, WordUnary,
};

/// The index of a node; operands come before the nodes that use them.
pub(super) type NodeId = u32;

/// The index of a guard: the branches under which a value is computed.
pub(super) type GuardId = u32;

/// A value: an operation on earlier values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub act: NodeOp,
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

/// The operation of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum NodeOp {
    /// A scalar of the inputs.
    Input(u32),
    /// A number, an `f64` by its bits; words are from -2^31 to 2^32, by theirs.
    Constant(u64),
    RealUnary(RealUnary),
    RealBinary(RealBinary),
    RealTernary(RealTernary),
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
    WordUnary(WordUnary),
    WordBinary(WordBinary),
    CompareWords(Cmp, bool),
    /// A field of bits, with its sign.
    Extract(bool),
    Cast(Cast),
    /// `[condition, accept, reject]`
    Select,
    /// An index of a run of elements: its fault alone.
    Index(u32),
    /// A value within known bounds that is not followed; each an `f64` by its bits.
    Within([u64; 2]),
    /// A loop left after the most iterations; its guard tells whether it is reached.
    Endless,
    /// An operation that is not followed; its fault alone.
    Unfollowed,
}

impl NodeOp {
    /// Returns a value within known bounds.
    pub fn within(low: f64, high: f64) -> NodeOp {
        NodeOp::Within([low, high].map(f64::to_bits))
    }

    /// Whether the result is exact if the operands are.
    pub fn keeps_exact(self) -> bool {
        match self {
            NodeOp::Input(_) | NodeOp::Constant(_) | NodeOp::Select => true,
            NodeOp::RealUnary(f) => matches!(
                f,
                RealUnary::Neg
                    | RealUnary::Abs
                    | RealUnary::Sign
                    | RealUnary::Floor
                    | RealUnary::Ceil
                    | RealUnary::Round
                    | RealUnary::Trunc
                    | RealUnary::Saturate
            ),
            NodeOp::RealBinary(f) => {
                matches!(f, RealBinary::Min | RealBinary::Max | RealBinary::Step)
            }
            NodeOp::RealTernary(f) => f == RealTernary::Clamp,
            NodeOp::Cast(cast) => !matches!(cast, Cast::RoundHalf),
            NodeOp::Within(..) => true,
            NodeOp::Compare(_)
            | NodeOp::Test(_)
            | NodeOp::Ldexp
            | NodeOp::Dot
            | NodeOp::Length
            | NodeOp::Distance
            | NodeOp::Normalize(_)
            | NodeOp::Cross(_)
            | NodeOp::WordUnary(_)
            | NodeOp::WordBinary(_)
            | NodeOp::CompareWords(..)
            | NodeOp::Extract(_)
            | NodeOp::Index(_)
            | NodeOp::Endless
            | NodeOp::Unfollowed => false,
        }
    }

    /// Whether equal operands give equal values.
    pub fn is_pure(self) -> bool {
        !matches!(self, NodeOp::Within(..) | NodeOp::Endless | NodeOp::Unfollowed)
    }
}
