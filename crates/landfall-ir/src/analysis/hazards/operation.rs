//! Why operations of the [`graph`](super::graph) have no defined value, by the table of
//! [`condition`]s and what is known of their operands.

use naga::{BinaryOperator as B, MathFunction as M};

use super::abstract_domain::Facts;
use super::graph::{Id, Op};
use super::walk::Walk;
use crate::analysis::undefined::UndefinedKind;
use crate::analysis::undefined::condition::{self, OperandRange};

impl From<Facts> for OperandRange {
    fn from(Facts { low, high, nonzero, .. }: Facts) -> OperandRange {
        OperandRange { low, high, nonzero }
    }
}

impl Walk<'_> {
    /// Returns why an operation may be undefined under the conditions that hold.
    pub fn undefined(&self, id: Id) -> Option<UndefinedKind> {
        let of = |nth: usize| self.facts(self.graph.args(id)[nth]).into();
        match self.graph.op(id) {
            Op::Binary(B::Divide) => condition::division(of(1)),
            Op::Math(M::Normalize) => condition::direction(of(0)),
            Op::Math(M::Sqrt) => condition::ROOT.undefined(of(0)),
            Op::Math(M::InverseSqrt) => condition::INVERSE_ROOT.undefined(of(0)),
            Op::Math(M::Asin | M::Acos) => condition::ARC.undefined(of(0)),
            Op::Math(M::SmoothStep) => condition::smooth_step(of(0), of(1)),
            Op::Math(M::Pow) => condition::power(of(0), of(1)).into_iter().flatten().next(),
            _ => None,
        }
    }
}
