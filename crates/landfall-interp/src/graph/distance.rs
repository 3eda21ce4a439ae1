//! The distance of an operation's operands from a fault, at a point.

use super::super::code::{Cast, RealBinary, RealTernary, RealUnary, WordBinary};
use super::super::undefined::UndefinedKind as K;
use super::bounds::Bounds;
use super::exact::is_empty;
use super::fault::Fault;
use super::node::NodeOp;
use super::{Graph, Site, word};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distance {
    /// The fault is at zero; the number is signed.
    Zero(f64),
    /// The fault is below zero, or at zero.
    Below(f64),
}

impl Distance {
    /// Returns the distance without its sign; zero where it breaks.
    pub fn size(self) -> f64 {
        match self {
            Distance::Zero(x) => x.abs(),
            Distance::Below(x) => x.max(0.0),
        }
    }

    /// Returns the number whose sign changes where it breaks.
    pub fn signed(self) -> f64 {
        match self {
            Distance::Zero(x) | Distance::Below(x) => x,
        }
    }
}

impl Bounds {
    /// Returns how far an operation is from breaking at the point that was evaluated; `None` if it
    /// is not reached there or has no such measure.
    pub fn distance(&self, graph: &Graph, site: &Site) -> Option<Distance> {
        let node = &graph.nodes[site.node as usize];
        let ids = graph.operands(node);
        let of = |nth: usize| {
            let value = self.enclosure_under(graph, node.guard, ids[nth]);
            (!is_empty(value)).then_some(value.low / 2.0 + value.high / 2.0)
        };
        let result = self.values[site.node as usize];
        let most = f64::from(f32::MAX);
        if matches!(site.fault, Fault::Endless | Fault::Unfollowed) {
            return None;
        }
        let Fault::Undefined(kind) = site.fault else {
            // The result in terms of its larger operand: at zero nothing is left of it.
            let middle = result.low / 2.0 + result.high / 2.0;
            let terms = of(0)?.abs().max(of(1).unwrap_or(0.0).abs());
            return Some(Distance::Zero(middle / terms.max(f64::from(f32::MIN_POSITIVE))));
        };
        Some(match (kind, node.act) {
            (K::DivisionByZero, _) => Distance::Zero(of(1)?),
            (K::BornInfinite, NodeOp::RealBinary(RealBinary::Div)) => {
                // Without the quotient itself, which is infinite near a divisor of zero.
                Distance::Below(of(1)?.abs() - of(0)?.abs() / most)
            }
            (K::BornInfinite, _) => Distance::Below(most - result.low.abs().max(result.high.abs())),
            (K::ArcOutOfRange, NodeOp::RealUnary(RealUnary::Acosh)) => {
                Distance::Below(of(0)? - 1.0)
            }
            (K::ArcOutOfRange, _) => Distance::Below(1.0 - of(0)?.abs()),
            (K::RootOfNegative | K::LogOfNonPositive | K::PowOfNegative, _) => {
                Distance::Below(of(0)?)
            }
            (K::PowOfZero, _) => Distance::Zero(of(0)?.abs() + of(1)?.max(0.0)),
            (K::AtanOfZeros, _) => Distance::Zero(of(0)?.abs() + of(1)?.abs()),
            (K::NormalizeOfZero | K::SquaresTooSmall, NodeOp::Distance) => {
                let half = ids.len() / 2;
                let mut all = 0.0;
                for nth in 0..half {
                    all += (of(nth)? - of(nth + half)?).abs();
                }
                Distance::Zero(all)
            }
            (K::NormalizeOfZero | K::SquaresTooSmall, _) => {
                let mut all = 0.0;
                for nth in 0..ids.len() {
                    all += of(nth)?.abs();
                }
                Distance::Zero(all)
            }
            (K::SmoothStepEdges, NodeOp::RealTernary(RealTernary::SmoothStep)) => {
                Distance::Below(of(1)? - of(0)?)
            }
            (K::ClampBounds, _) => Distance::Below(of(2)? - of(1)?),
            (K::IntegerDivisionByZero, _) => Distance::Zero(of(1)?),
            (K::RemainderOfNegative, _) => Distance::Below(of(0)?.min(of(1)?) + 1.0),
            (K::IndexOutOfBounds, NodeOp::Index(len)) => {
                let index =
                    word::signed(self.enclosure_under(graph, node.guard, ids[0]), false).high;
                Distance::Below(f64::from(len) - 1.0 - index)
            }
            (
                K::ShiftTooFar,
                NodeOp::WordBinary(WordBinary::Shl | WordBinary::ShrSint | WordBinary::ShrUint),
            ) => Distance::Below(31.0 - of(1)?),
            (K::ConversionOutOfRange, NodeOp::Cast(cast)) => Distance::Below(match cast {
                Cast::RealToUint => of(0)? + 1.0,
                Cast::HalfToBits => 65520.0 - of(0)?.abs(),
                _ => 2_147_483_647.0 - of(0)?.abs(),
            }),
            (K::SquaresTooLarge, _) => {
                // Beyond the root of the largest `f32`, the square of a component overflows.
                let largest =
                    (0..ids.len()).filter_map(of).fold(0.0f64, |most, x| most.max(x.abs()));
                Distance::Below(most.sqrt() - largest)
            }
            _ => return None,
        })
    }
}
