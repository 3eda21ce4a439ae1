//! Operations on whole vectors: products, lengths, directions.
//!
//! Vectors known to have length one bound the products that they are part of.

use super::super::code::RealUnary;
use super::super::interval::Interval;
use super::super::undefined::UndefinedKind as K;
use super::Graph;
use super::arithmetic;
use super::bounds::Bounds;
use super::exact::{self, between, contains, intersection, is_empty, size};
use super::fault::{Fault, Faults};
use super::node::{GuardId, Node, NodeId, NodeOp};
use super::value::{Applied, Arithmetic, without_fault};

/// The room for the roundings of a sum of four products of numbers up to one.
const PRODUCTS: f64 = 1.0 / 1_048_576.0;

/// Maximum error of the length of a unit vector among the inputs.
const UNIT_INPUT: f64 = 3e-7;

/// Maximum error of the length of a normalised vector on a device: its formula has an error of at
/// most 8 ULP.
const UNIT_COMPUTED: f64 = 1.0 / 524_288.0;

impl Graph {
    /// Returns the interval of a vector's length, if its components are those of a vector known to
    /// have length one, or some of them, in any order and with any signs.
    fn unit_size(&self, ids: &[NodeId], how: Arithmetic) -> Option<Interval> {
        // A component has the same size as its negative.
        let of = |id: NodeId| match self.nodes[id as usize] {
            Node { act: NodeOp::RealUnary(RealUnary::Neg), .. } => {
                self.operands(&self.nodes[id as usize])[0]
            }
            _ => id,
        };
        let first = of(*ids.first()?);
        let vectors = self.unit_of.get(&first)?;
        let within = |unit: &&usize| {
            let unit = &self.units[**unit];
            // Each component of the unit vector counts once.
            let mut left = unit.clone();
            ids.iter().all(|&id| {
                let found = left.iter().position(|&known| known == of(id));
                found.map(|at| left.swap_remove(at)).is_some()
            })
        };
        let unit = vectors.iter().find(within)?;
        let unit = &self.units[*unit];
        let is_input = matches!(self.nodes[unit[0] as usize].act, NodeOp::Input(_));
        let error = match (is_input, how) {
            (true, _) => UNIT_INPUT,
            (false, Arithmetic::Exact) => 1e-12,
            (false, _) => UNIT_COMPUTED,
        };
        // Some of its components alone may be short.
        let least = if ids.len() == unit.len() { 1.0 - error } else { 0.0 };
        Some(between(least, 1.0 + error))
    }
}

impl Bounds {
    /// Evaluates an operation on whole vectors; where the vectors have length one, it is bounded by
    /// that.
    pub(super) fn vector(&self, graph: &Graph, node: &Node, guard: GuardId) -> Applied {
        let how = self.arithmetic;
        let ids = graph.operands(node);
        let all: Vec<Interval> =
            ids.iter().map(|&id| self.enclosure_under(graph, guard, id)).collect();
        if all.iter().any(|x| is_empty(*x)) {
            return without_fault(exact::EMPTY);
        }
        let half = ids.len() / 2;
        let unit = |ids: &[NodeId]| graph.unit_size(ids, how);
        match node.act {
            NodeOp::Dot => {
                let same = ids[..half] == ids[half..];
                let product = |i: usize| {
                    arithmetic::product(how, all[i], all[i + half], ids[i] == ids[i + half])
                };
                let found = sum_of(how, (0..half).map(product));
                let Some(a) = unit(&ids[..half]) else { return found };
                let Some(b) = unit(&ids[half..]) else { return found };
                // The inequality of Cauchy and Schwarz: no more than the product of the lengths.
                let most = a.high * b.high + PRODUCTS;
                // A vector's product with itself is the square of its length.
                let least = if same { a.low * a.low - PRODUCTS } else { -most };
                let value = intersection(found.value, between(least, most));
                Applied { value: if is_empty(value) { found.value } else { value }, ..found }
            }
            NodeOp::Cross(i) => {
                let (j, k) = ((usize::from(i) + 1) % 3, (usize::from(i) + 2) % 3);
                let of =
                    |a: usize, b: usize| arithmetic::product(how, all[a], all[b], ids[a] == ids[b]);
                let (left, right) = (of(j, k + 3), of(k, j + 3));
                let found = arithmetic::difference(how, left.value, right.value, false);
                let faults = found.faults.and(left.faults).and(right.faults);
                let (Some(a), Some(b)) = (unit(&ids[..3]), unit(&ids[3..])) else {
                    return Applied { faults, ..found };
                };
                let most = a.high * b.high + PRODUCTS;
                Applied { value: intersection(found.value, between(-most, most)), faults }
            }
            NodeOp::Length | NodeOp::Distance => {
                let terms: Vec<Applied> = match node.act {
                    NodeOp::Length => all.iter().map(|x| square(how, *x)).collect(),
                    _ => (0..half)
                        .map(|i| {
                            let (a, b) = (all[i], all[i + half]);
                            let same = ids[i] == ids[i + half];
                            square(how, arithmetic::difference(how, a, b, same).value)
                        })
                        .collect(),
                };
                let (squares, faults) = lengths(how, terms, true);
                let root = arithmetic::f1(how, RealUnary::Sqrt, squares).value;
                // The difference of two vectors is no vector whose length is known.
                let known = match node.act {
                    NodeOp::Length => unit(ids),
                    _ => None,
                };
                let value = known.map_or(root, |unit| {
                    intersection(root, between(unit.low - UNIT_COMPUTED, unit.high + UNIT_COMPUTED))
                });
                Applied { value: if is_empty(value) { root } else { value }, faults }
            }
            _ => self.normalized(graph, node, &all),
        }
    }

    fn normalized(&self, graph: &Graph, node: &Node, all: &[Interval]) -> Applied {
        let how = self.arithmetic;
        let NodeOp::Normalize(nth) = node.act else {
            unreachable!("the other operations on vectors are done before")
        };
        let terms = all.iter().map(|x| square(how, *x)).collect();
        let (squares, mut faults) = lengths(how, terms, false);
        let unit = graph.unit_size(graph.operands(node), how);
        // A device may flush a subnormal sum to zero.
        let least = if how == Arithmetic::Permitted { f64::from(f32::MIN_POSITIVE) } else { 0.0 };
        let zero = squares.low <= least && all.iter().all(|x| contains(*x, 0.0));
        let is_unit = unit.is_some_and(|unit| unit.low > 0.5);
        faults =
            if is_unit { Faults::NONE } else { faults.and(Faults::when(zero, K::NormalizeOfZero)) };
        // Only the zero vector is left, and it has no direction.
        if squares.high <= 0.0 {
            return Applied { value: exact::EMPTY, faults };
        }
        let x = all[usize::from(nth)];
        // No component is longer than the vector.
        let one = between(-1.0 - UNIT_COMPUTED, 1.0 + UNIT_COMPUTED);
        let inverse = RealUnary::InverseSqrt;
        let positive = between(squares.low.max(f64::from(f32::MIN_POSITIVE)), squares.high);
        let value = match is_empty(positive) {
            true => one,
            false => {
                let over = arithmetic::f1(how, inverse, positive).value;
                let product = arithmetic::product(how, x, over, false).value;
                let slack = size(product) * UNIT_COMPUTED;
                intersection(between(product.low - slack, product.high + slack), one)
            }
        };
        Applied { value: if is_empty(value) { one } else { value }, faults }
    }
}

fn square(how: Arithmetic, x: Interval) -> Applied {
    arithmetic::product(how, x, x, true)
}

/// Returns the sum of one to four terms, with the faults of all.
fn sum_of(how: Arithmetic, terms: impl Iterator<Item = Applied>) -> Applied {
    let terms: Vec<Applied> = terms.collect();
    let values: Vec<Interval> = terms.iter().map(|term| term.value).collect();
    let exact = values.iter().copied().reduce(exact::add).unwrap_or_default();
    let found = arithmetic::total(how, &values, exact);
    let faults = terms.iter().fold(found.faults, |all, term| all.and(term.faults));
    Applied { value: found.value, faults }
}

/// Returns the sum of squares for a length, and the faults of squares out of range.
fn lengths(how: Arithmetic, terms: Vec<Applied>, zero_is_fine: bool) -> (Interval, Faults) {
    let sum = sum_of(how, terms.into_iter());
    let over = Faults::when(sum.faults.has(Fault::Undefined(K::BornInfinite)), K::SquaresTooLarge);
    let least = f64::from(f32::MIN_POSITIVE);
    let value = between(sum.value.low.max(0.0), sum.value.high);
    // Zero itself has a length; only a value between is lost.
    let under = how != Arithmetic::Exact
        && value.low < least
        && value.high > 0.0
        && (!zero_is_fine || value.low > 0.0 || value.high > least);
    (value, over.and(Faults::when(under, K::SquaresTooSmall)))
}
