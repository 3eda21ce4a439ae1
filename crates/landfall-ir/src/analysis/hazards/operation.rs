//! Why operations of the [`graph`](super::graph) have no defined value, by the table of
//! [`condition`]s and what is known of their operands; and those of them that have no hazard of
//! lighting to tell about.

use naga::{BinaryOperator as B, MathFunction as M};

use super::abstract_domain::Facts;
use super::graph::{GraphOp, Id, Origin};
use super::walk::Walk;
use super::{Certainty, Kind};
use crate::analysis::undefined::UndefinedKind;
use crate::analysis::undefined::condition::{self, OperandRange};
use landfall_layout::source::Span;

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
            GraphOp::Binary(B::Divide) => condition::division(of(1)),
            GraphOp::Math(M::Normalize) => condition::direction(of(0)),
            GraphOp::Math(M::Sqrt) => condition::ROOT.undefined(of(0)),
            GraphOp::Math(M::InverseSqrt) => condition::INVERSE_ROOT.undefined(of(0)),
            GraphOp::Math(M::Log | M::Log2) => condition::LOGARITHM.undefined(of(0)),
            GraphOp::Math(M::Asin | M::Acos) => condition::ARC.undefined(of(0)),
            GraphOp::Math(M::SmoothStep) => condition::smooth_step(of(0), of(1)),
            GraphOp::Math(M::Pow) => condition::power(of(0), of(1)).into_iter().flatten().next(),
            _ => None,
        }
    }
    /// Reports an operation that is undefined for operands which may occur, and is said to be so.
    pub fn report_undefined(&mut self, id: Id, said: UndefinedKind, sure: Certainty, span: Span) {
        // What depends on blocks alone is constant over a draw: the host is responsible for it.
        let Some(undefined) = self.undefined(id).filter(|_| self.varies(id)) else { return };
        let candidate = self.report(said.hazard(), sure, span, String::new());
        candidate.hazard.kind = Kind::UnguardedOperation;
        candidate.hazard.undefined = Some(said);
        candidate.undefined = Some((id, undefined));
    }

    /// Reports a function whose operand is known to leave its domain, by rounding at least; an
    /// angle also of any number.
    pub fn look_at_operand(&mut self, fun: M, args: &[Id], id: Id, span: Span) {
        let Some(undefined) = self.undefined(id) else { return };
        let first = self.facts(args[0]);
        // A function of which the operand has no lower bound is not told: every `sqrt(x)` would
        // be.
        let is_known = first.low.is_finite();
        let is_told = match fun {
            // `acos` and `asin` of a rounded cosine leave [-1, 1] by an ULP, whatever the operand.
            M::Asin | M::Acos => true,
            M::Sqrt | M::InverseSqrt | M::Log | M::Log2 => is_known || self.is_rest(args[0]),
            // Edges that are never in order, not those of which nothing is known.
            M::SmoothStep => first.low >= self.facts(args[1]).high,
            _ => false,
        };
        let is_sure = is_known && (fun == M::SmoothStep || first.low < 0.0);
        if is_told {
            let sure = if is_sure { Certainty::Likely } else { Certainty::Possible };
            self.report_undefined(id, undefined, sure, span);
        }
    }

    /// Whether a value depends on more than blocks: for these alone, the program is responsible.
    pub fn varies(&self, id: Id) -> bool {
        self.graph.contains(id, &mut |id| match self.graph.op(id) {
            GraphOp::Opaque(_) => true,
            _ => self.graph.as_leaf(id).is_some_and(|leaf| leaf.origin != Origin::Block),
        })
    }

    /// Whether a value is what a square leaves of a number: `1 - x * x`.
    fn is_rest(&self, id: Id) -> bool {
        // `sqrt(1 - x * x)` is negative by rounding where x is near 1.
        let parts = self.graph.binary(id, B::Subtract);
        parts.is_some_and(|(a, b)| self.graph.value(a).is_some() && self.is_square(b))
    }

    /// Whether a value is the square of a number.
    pub fn is_square(&self, id: Id) -> bool {
        match (self.graph.op(id), self.graph.args(id)) {
            (GraphOp::Binary(B::Multiply), &[a, b]) => a == b,
            (GraphOp::Math(M::Pow), &[_, n]) => self.graph.value(n) == Some(2.0),
            _ => false,
        }
    }

    /// Whether a vector is the sum or difference of two that are directions, or not computed.
    pub fn is_sum(&self, v: Id) -> bool {
        let v = self.graph.underlying_value(v);
        // Unit vectors, or inputs as they are, may well add up to zero; of other terms nothing
        // suggests it.
        let is_own = |id: &Id| self.facts(*id).unit || self.graph.bare_leaf(*id).is_some();
        let is_sum = matches!(self.graph.op(v), GraphOp::Binary(B::Add | B::Subtract));
        is_sum && self.graph.args(v).iter().all(is_own)
    }

    /// Returns a value without the factors that are not zero.
    pub fn without_factors(&self, mut id: Id) -> Id {
        // `4 pi d^2` is zero where `d^2` is.
        while let Some((a, b)) = self.graph.binary(id, B::Multiply) {
            id = match (self.facts(a).nonzero, self.facts(b).nonzero) {
                (true, false) => b,
                (false, true) => a,
                _ => break,
            };
        }
        id
    }
}
