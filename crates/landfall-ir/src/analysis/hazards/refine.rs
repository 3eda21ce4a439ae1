//! Facts about values that follow from a condition.

use naga::{BinaryOperator as B, MathFunction as M};

use super::abstract_domain::{Facts, Query};
use super::graph::{GraphOp, Id};
use super::walk::Walk;

/// The depth to which conditions are decomposed.
const DEEPEST: u32 = 16;

/// The number of assumptions at some point.
#[derive(Clone, Copy, Debug)]
pub struct AssumptionMark {
    facts: usize,
    relations: usize,
}

/// The assumptions since that point.
#[derive(Clone, Debug, Default)]
pub struct Tail {
    facts: Vec<(Id, Facts)>,
    relations: Vec<(Id, Id)>,
}

impl Walk<'_> {
    pub fn facts(&self, id: Id) -> Facts {
        Query::new(&self.graph, &self.assumed, &self.settled).facts_of(id)
    }

    pub fn mark(&self) -> AssumptionMark {
        AssumptionMark { facts: self.assumed.len(), relations: self.relations.len() }
    }

    // Assumptions are a stack: the end of a block cuts it back to where the block began.
    pub fn forget(&mut self, mark: AssumptionMark) -> Tail {
        Tail {
            facts: self.assumed.split_off(mark.facts.min(self.assumed.len())),
            relations: self.relations.split_off(mark.relations.min(self.relations.len())),
        }
    }

    pub fn restore(&mut self, tail: &Tail) {
        self.assumed.extend(&tail.facts);
        self.relations.extend(&tail.relations);
    }

    /// Returns the facts about a value under additional assumptions.
    pub fn facts_with(&mut self, id: Id, tail: &Tail) -> Facts {
        // Assumed, asked, and cut back.
        let mark = self.mark();
        self.restore(tail);
        let facts = self.facts(id);
        self.forget(mark);
        facts
    }

    /// Assumes that a condition is true, or false, from here on.
    pub fn assume(&mut self, condition: Id, truth: bool) {
        self.assume_deep(condition, truth, 0);
    }

    fn assume_deep(&mut self, condition: Id, truth: bool, depth: u32) {
        if depth > DEEPEST {
            return;
        }
        let args = self.graph.args(condition).to_vec();
        match (self.graph.op(condition), &args[..]) {
            (GraphOp::Not, &[of]) => self.assume_deep(of, !truth, depth + 1),
            // `any` and `all` of comparisons constrain the vector as its components do.
            (GraphOp::Convert, &[of]) => self.assume_deep(of, truth, depth + 1),
            (GraphOp::Chosen, &[first, accept, reject]) => {
                // `a && b` runs `b` only where `a` holds, `a || b` only where it does not.
                // Naga lowers `a && b` to a selection whose other side is the constant.
                if truth && self.graph.value(reject) == Some(0.0) {
                    self.assume_deep(first, true, depth + 1);
                    self.assume_deep(accept, true, depth + 1);
                } else if !truth && self.graph.value(accept) == Some(1.0) {
                    self.assume_deep(first, false, depth + 1);
                    self.assume_deep(reject, false, depth + 1);
                }
            }
            (GraphOp::Binary(op), &[a, b]) => match (op, truth) {
                (B::LogicalAnd, true)
                | (B::LogicalOr, false)
                | (B::And, true)
                | (B::InclusiveOr, false) => {
                    self.assume_deep(a, truth, depth + 1);
                    self.assume_deep(b, truth, depth + 1);
                }
                // Each comparison and its negation is one of `a < b`, `a <= b`, `b < a`, `b <= a`.
                // NaN, for which neither holds, is not followed.
                (B::Less, true) | (B::GreaterEqual, false) => self.below(a, b, true),
                (B::LessEqual, true) | (B::Greater, false) => self.below(a, b, false),
                (B::Greater, true) | (B::LessEqual, false) => self.below(b, a, true),
                (B::GreaterEqual, true) | (B::Less, false) => self.below(b, a, false),
                (B::NotEqual, true) | (B::Equal, false) => {
                    if self.graph.value(b) == Some(0.0) {
                        self.learn(a, Facts { nonzero: true, ..Facts::NOTHING });
                    }
                    if self.graph.value(a) == Some(0.0) {
                        self.learn(b, Facts { nonzero: true, ..Facts::NOTHING });
                    }
                    // Two points apart: their difference is not zero.
                    for (a, b) in [(a, b), (b, a)] {
                        let apart = self.graph.add(GraphOp::Binary(B::Subtract), &[a, b]);
                        self.learn(apart, Facts { nonzero: true, ..Facts::NOTHING });
                    }
                }
                (B::Equal, true) | (B::NotEqual, false) => {
                    // Equal numbers share their range.
                    let (x, y) = (self.facts(a), self.facts(b));
                    self.learn(a, Facts { unit: false, ..y });
                    self.learn(b, Facts { unit: false, ..x });
                    self.relations.push((a, b));
                }
                _ => {}
            },
            _ => {}
        }
    }

    /// Assumes `a < b`, or `a <= b` if not strict.
    fn below(&mut self, a: Id, b: Id, strictly: bool) {
        let (x, y) = (self.facts(a), self.facts(b));
        self.relations.push((a, b));
        // `a < b <= 0` makes `a` negative; `0 <= a < b` makes `b` positive.
        let nonzero = strictly && y.high <= 0.0;
        self.learn(a, Facts { high: y.high, nonzero, ..Facts::NOTHING });
        let nonzero = strictly && x.low >= 0.0;
        self.learn(b, Facts { low: x.low, nonzero, ..Facts::NOTHING });
    }

    /// Records facts, and those that follow for the operands.
    fn learn(&mut self, id: Id, facts: Facts) {
        if facts == Facts::NOTHING {
            return;
        }
        self.assumed.push((id, facts));
        // From a result back to its operands. `assumed.push` instead of `learn` where the rule
        // would lead back to the node itself.
        let nonzero = facts.nonzero || facts.low > 0.0;
        let args = self.graph.args(id).to_vec();
        let known_nonzero = Facts { nonzero: true, ..Facts::NOTHING };
        match (self.graph.op(id), &args[..]) {
            (GraphOp::Math(M::Length | M::Abs | M::Sqrt), &[of]) if nonzero => {
                self.learn(of, known_nonzero);
                // Lengths, absolute values and roots are zero exactly where the operand is; so is
                // `dot(v, v)`, and a guard may be written by any of them.
                let square = self.graph.add(GraphOp::Math(M::Dot), &[of, of]);
                self.assumed.push((square, known_nonzero));
            }
            (GraphOp::Math(M::Dot), &[a, b]) if nonzero && a == b => {
                self.assumed.push((a, known_nonzero));
                let length = self.graph.add(GraphOp::Math(M::Length), &[a]);
                self.assumed.push((length, known_nonzero));
            }
            (GraphOp::Math(M::Distance), &[a, b]) if nonzero => {
                for (a, b) in [(a, b), (b, a)] {
                    let apart = self.graph.add(GraphOp::Binary(B::Subtract), &[a, b]);
                    self.assumed.push((apart, known_nonzero));
                }
            }
            // A product that is not zero has no zero factor.
            (GraphOp::Binary(B::Multiply), &[a, b]) if nonzero => {
                self.assumed.push((a, known_nonzero));
                self.assumed.push((b, known_nonzero));
            }
            // The larger of two is above a bound that the second never reaches.
            (GraphOp::Math(M::Max), &[a, b]) => {
                for (one, other) in [(a, b), (b, a)] {
                    let most = self.facts(other).high;
                    if most < facts.low || (most <= facts.low && facts.nonzero) {
                        self.learn(one, Facts { low: facts.low, nonzero, ..Facts::NOTHING });
                    }
                }
            }
            (GraphOp::Math(M::Clamp), &[x, low, _]) => {
                let most = self.facts(low).high;
                if most < facts.low || (most <= facts.low && facts.nonzero) {
                    self.learn(x, Facts { low: facts.low, nonzero, ..Facts::NOTHING });
                }
            }
            (GraphOp::Convert, &[of]) => self.assumed.push((of, facts)),
            _ => {}
        }
    }
}
