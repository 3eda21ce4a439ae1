//! Evaluates a [`Graph`] over a box of its inputs.

use super::super::code::{Class, Cmp, RealBinary, Test};
use super::super::interval::Interval;
use super::super::undefined::UndefinedKind as K;
use super::affine::Affine;
use super::arithmetic;
use super::cast::converted;
use super::exact::{self, between, hull, intersection, is_empty, point, size};
use super::fault::{Fault, Faults};
use super::guard::{GuardContext, Reached};
use super::node::{GuardId, Node, NodeId, NodeOp};
use super::value::{Applied, Arithmetic, without_fault};
use super::{Graph, Site, word};

/// The values of a graph over a box, and the faults that are possible there.
#[derive(Clone, Debug, Default)]
pub struct Bounds {
    pub(super) arithmetic: Arithmetic,
    pub(super) values: Vec<Interval>,
    faults: Vec<Faults>,
    pub(super) contexts: Vec<GuardContext>,
    /// By value: its affine form, where it has one.
    pub(super) forms: Vec<Option<Affine>>,
    /// Whether any input has more than one value.
    pub(super) is_wide: bool,
    inputs: Vec<Interval>,
}

impl Graph {
    /// Evaluates the graph over a box, into memory that is used again: one range for each input
    /// scalar, an empty one for those that are not read.
    pub fn bounds(&self, inputs: &[Interval], arithmetic: Arithmetic, into: &mut Bounds) {
        into.begin(inputs, arithmetic);
        into.contexts.iter_mut().for_each(|context| {
            context.state = Reached::Unknown;
            context.narrowed.clear();
        });
        into.contexts.resize_with(self.guards.len(), GuardContext::default);
        into.values.reserve(self.nodes.len());
        for id in 0..self.nodes.len() as NodeId {
            into.extend(self, id);
        }
    }
}

impl Graph {
    /// Whether a value is known not to be above another: both are one, or the smaller and the larger
    /// of two of which one is the same.
    fn is_in_order(&self, low: NodeId, high: NodeId) -> bool {
        let parts = |id: NodeId, of: RealBinary| match self.nodes[id as usize] {
            node @ Node { act: NodeOp::RealBinary(f), .. } if f == of => {
                self.operands(&node).to_vec()
            }
            _ => vec![id],
        };
        let (low, high) = (parts(low, RealBinary::Min), parts(high, RealBinary::Max));
        low.iter().any(|id| high.contains(id))
    }
}

impl Bounds {
    /// Forgets all values.
    pub(super) fn begin(&mut self, inputs: &[Interval], arithmetic: Arithmetic) {
        self.arithmetic = arithmetic;
        self.values.clear();
        self.faults.clear();
        self.forms.clear();
        self.is_wide = inputs.iter().any(|range| range.low < range.high);
        self.inputs.clear();
        self.inputs.extend(inputs);
    }

    /// Evaluates the next node.
    pub(super) fn extend(&mut self, graph: &Graph, id: NodeId) {
        // Where no execution arrives there are no numbers.
        let guard = graph.nodes[id as usize].guard;
        let found = match self.is_reached(graph, guard) {
            true => self.apply(graph, id, guard),
            false => without_fault(exact::EMPTY),
        };
        self.values.push(found.value);
        self.faults.push(found.faults);
        self.follow(graph, id);
        // The affine form may tell that a difference keeps its digits.
        let narrowed = self.values[id as usize];
        if narrowed != found.value && found.faults.has(Fault::Cancellation) {
            let largest = self.largest_operand(graph, id);
            if arithmetic::keeps_digits(narrowed, largest) {
                self.faults[id as usize] = found.faults.without(Fault::Cancellation);
            }
        }
    }

    /// Returns the largest absolute value of an operand.
    fn largest_operand(&self, graph: &Graph, id: NodeId) -> f64 {
        let node = &graph.nodes[id as usize];
        let sizes = graph
            .operands(node)
            .iter()
            .map(|&id| size(self.enclosure_under(graph, node.guard, id)));
        sizes.fold(0.0, f64::max)
    }

    /// Whether a fault is possible in the box.
    pub fn is_possible(&self, site: &Site) -> bool {
        self.faults[site.node as usize].has(site.fault)
    }

    /// Returns the values of an operation's operand.
    pub fn operand(&self, graph: &Graph, site: &Site, nth: usize) -> Option<Interval> {
        let node = &graph.nodes[site.node as usize];
        let id = graph.operands(node).get(nth)?;
        Some(self.enclosure_under(graph, node.guard, *id))
    }

    /// Whether all code that is reached in the box was followed.
    pub fn is_complete(&self, graph: &Graph) -> bool {
        let is_left = |site: &&Site| matches!(site.fault, Fault::Endless | Fault::Unfollowed);
        !graph.sites.iter().filter(is_left).any(|site| self.is_possible(site))
    }

    /// Returns the values of the scalars of the results; any, where some code was not followed.
    pub fn results<'a>(&'a self, graph: &'a Graph) -> impl Iterator<Item = Interval> + 'a {
        let is_complete = self.is_complete(graph);
        let value = move |&id: &NodeId| match is_complete {
            true => self.values[id as usize],
            false => exact::ALL,
        };
        graph.results.iter().map(value)
    }

    /// Computes a node from its operands as they are known under a guard.
    pub(super) fn apply(&mut self, graph: &Graph, id: NodeId, guard: GuardId) -> Applied {
        let node = &graph.nodes[id as usize];
        let ids = graph.operands(node);
        let how = self.arithmetic;
        let of = |nth: usize| self.enclosure_under(graph, guard, ids[nth]);
        let plain = without_fault;
        match node.act {
            NodeOp::Input(n) => plain(self.input(n as usize, node.class)),
            NodeOp::Constant(bits) => plain(point(f64::from_bits(bits))),
            NodeOp::RealUnary(f) => arithmetic::f1(how, f, of(0)),
            NodeOp::RealBinary(f) => {
                let rounded = [ids[0], ids[1]].map(|id| !graph.is_exact(id));
                let same = ids[0] == ids[1];
                // `if (abs(x) > e) { y / x }`: the condition narrows the absolute value, and that
                // bounds the divisor.
                if f == RealBinary::Div && !same {
                    return arithmetic::quotient(
                        how,
                        of(0),
                        of(1),
                        self.size_of(graph, guard, ids[1]),
                    );
                }
                arithmetic::f2(how, f, of(0), of(1), same, rounded)
            }
            NodeOp::RealTernary(f) => {
                let steady = graph.is_in_order(ids[1], ids[2]);
                arithmetic::f3(how, f, [of(0), of(1), of(2)], steady)
            }
            NodeOp::Compare(cmp) => plain(word::compare(cmp, of(0), of(1))),
            NodeOp::Test(test) => plain(match (test, is_empty(of(0))) {
                (_, true) => exact::EMPTY,
                // Numbers that are not finite are faults before.
                (Test::IsNan | Test::IsInf, false) => point(0.0),
            }),
            NodeOp::Ldexp => ldexp(how, of(0), word::signed(of(1), true)),
            NodeOp::Dot
            | NodeOp::Length
            | NodeOp::Distance
            | NodeOp::Normalize(_)
            | NodeOp::Cross(_) => self.vector(graph, node, guard),
            NodeOp::WordUnary(f) => plain(word::unary(f, of(0))),
            NodeOp::WordBinary(f) => word::binary(f, of(0), of(1)),
            NodeOp::CompareWords(cmp, signed) => {
                plain(word::compare(cmp, word::signed(of(0), signed), word::signed(of(1), signed)))
            }
            NodeOp::Extract(signed) => field(signed, of(1), of(2)),
            NodeOp::Cast(cast) => converted(how, cast, of(0)),
            NodeOp::Select => plain(self.select(graph, ids, guard)),
            NodeOp::Index(len) => {
                let past = word::signed(of(0), false).high >= f64::from(len);
                let past = past && !is_empty(of(0));
                Applied { value: of(0), faults: Faults::when(past, K::IndexOutOfBounds) }
            }
            NodeOp::Within([low, high]) => {
                plain(between(f64::from_bits(low), f64::from_bits(high)))
            }
            NodeOp::Endless => {
                Applied { value: point(0.0), faults: Faults::from_fault(Fault::Endless) }
            }
            NodeOp::Unfollowed => {
                Applied { value: point(0.0), faults: Faults::from_fault(Fault::Unfollowed) }
            }
        }
    }

    /// Returns the least absolute value that is known of a value under a guard.
    fn size_of(&self, graph: &Graph, guard: GuardId, id: NodeId) -> f64 {
        // The absolute value may be computed later.
        let earlier = graph.absolute.get(&id).filter(|&&size| (size as usize) < self.values.len());
        let known = earlier.map(|&size| self.enclosure_under(graph, guard, size).low);
        known.filter(|size| size.is_finite()).unwrap_or(0.0).max(0.0)
    }

    fn input(&self, n: usize, class: Class) -> Interval {
        let all = match class {
            Class::Real => between(f64::from(f32::MIN), f64::from(f32::MAX)),
            Class::Word | Class::Wide => word::ANY_WORD,
        };
        self.inputs.get(n).copied().filter(|range| !is_empty(*range)).unwrap_or(all)
    }

    /// Returns the values of one side or both, each as its condition narrows it.
    fn select(&self, graph: &Graph, ids: &[NodeId], guard: GuardId) -> Interval {
        let condition = self.enclosure_under(graph, guard, ids[0]);
        let [yes, no] = [1, 2].map(|nth| self.enclosure_under(graph, guard, ids[nth]));
        if condition == point(0.0) {
            return no;
        }
        if condition.low >= 1.0 {
            return yes;
        }
        // A side that is one of the compared numbers: `x < 0 ? 0 : x`.
        let node = &graph.nodes[ids[0] as usize];
        let (NodeOp::Compare(cmp), [a, b]) = (node.act, graph.operands(node)) else {
            return hull(yes, no);
        };
        let side = |value: Interval, id: NodeId, truth: bool| {
            let (other, turned) = match (id == *a, id == *b) {
                (true, false) => (self.enclosure_under(graph, guard, *b), false),
                (false, true) => (self.enclosure_under(graph, guard, *a), true),
                _ => return value,
            };
            let low = match cmp {
                Cmp::Lt | Cmp::Le => turned == truth,
                Cmp::Gt | Cmp::Ge => turned != truth,
                Cmp::Eq | Cmp::Ne => return value,
            };
            match low {
                true => intersection(value, between(other.low, f64::INFINITY)),
                false => intersection(value, between(f64::NEG_INFINITY, other.high)),
            }
        };
        hull(side(yes, ids[1], true), side(no, ids[2], false))
    }
}

fn ldexp(how: Arithmetic, x: Interval, by: Interval) -> Applied {
    if is_empty(x) || is_empty(by) {
        return without_fault(exact::EMPTY);
    }
    // 2^300 times the least `f32` overflows, and the greatest divided by it vanishes.
    let by = between(by.low.clamp(-300.0, 300.0), by.high.clamp(-300.0, 300.0));
    let factor = exact::step(by, f64::exp2);
    arithmetic::total(how, &[exact::mul(x, factor)], exact::mul(x, factor)).checked()
}

impl Applied {
    /// Adds the fault of numbers beyond an `f32`.
    fn checked(self) -> Applied {
        let most = f64::from(f32::MAX);
        let over = Faults::when(size(self.value) > most, K::BornInfinite);
        let value = intersection(self.value, between(-most, most));
        Applied { value, faults: self.faults.and(over) }
    }
}

fn field(signed: bool, offset: Interval, count: Interval) -> Applied {
    let [offset, count] = [offset, count].map(|x| word::signed(x, false));
    if is_empty(offset) || is_empty(count) {
        return without_fault(exact::EMPTY);
    }
    let faults = Faults::when(offset.high + count.high > 32.0, K::BitsOutOfRange);
    let most = count.high.min(32.0).exp2() - 1.0;
    let value = if signed { between(-(most + 1.0) / 2.0, most / 2.0) } else { between(0.0, most) };
    Applied { value, faults }
}
