//! Branches under which values are computed, and what their conditions imply about values.
//!
//! A condition is turned into bounds of the numbers that it compares (`compared`), and through
//! sums, differences, roots and signs into bounds of what these were computed from (`narrow`):
//! after `if (x * x + y > 1.0)` the sum is above 1, and `y` above 1 less the greatest square.
//! Values that were computed from any of these before the branch are computed again for the code
//! within it (`affected`).

use super::super::code::{Cmp, RealBinary, RealUnary, WordBinary, WordUnary};
use super::super::interval::Interval;
use super::bounds::Bounds;
use super::exact::{self, intersection, is_empty};
use super::guard::{ALWAYS, Guard, Reached};
use super::node::{GuardId, NodeId, NodeOp};
use super::value::Arithmetic;
use super::{Graph, word};

/// Maximum depth of the operands that a condition narrows.
const DEPTH: u32 = 4;

/// Room for the roundings of an operation that is inverted: a root within 4.5 ULP, twice.
const SLACK: f64 = 1.0 / 262_144.0;

impl Graph {
    /// Whether a guard is another one, or within it.
    pub(super) fn is_within(&self, mut guard: GuardId, outer: GuardId) -> bool {
        // A guard is numbered after those around it.
        while guard > outer {
            guard = self.guards[guard as usize].parent;
        }
        guard == outer
    }

    /// Finds the values that each guard narrows for its own use.
    pub(super) fn find_affected(&mut self) {
        for guard in 1..self.guards.len() as GuardId {
            // A guard is numbered after those around it.
            let mut within = vec![false; self.guards.len()];
            within[guard as usize] = true;
            for inner in guard as usize + 1..within.len() {
                within[inner] = within[self.guards[inner].parent as usize];
            }
            let first = self.nodes.iter().position(|n| within[n.guard as usize]);
            let Some(first) = first else { continue };
            // Backwards: the values that the code under the guard is computed from.
            let mut used = vec![false; self.nodes.len()];
            for (at, node) in self.nodes.iter().enumerate().skip(first).rev() {
                if used[at] || within[node.guard as usize] {
                    used[at] = true;
                    self.operands(node).iter().for_each(|&id| used[id as usize] = true);
                }
            }
            for at in (0..first).rev() {
                if used[at] {
                    let operands = self.operands(&self.nodes[at]);
                    operands.iter().for_each(|&id| used[id as usize] = true);
                }
            }
            // Forwards: the values that are computed from what the condition narrows.
            let mut moved = vec![false; first];
            let cond = self.guards[guard as usize].cond;
            self.narrowable(cond, DEPTH + 4, &mut moved);
            let mut affected = Vec::new();
            for at in 0..first {
                let operands = self.operands(&self.nodes[at]);
                if operands.iter().any(|&id| moved[id as usize]) {
                    moved[at] = true;
                    if used[at] {
                        affected.push(at as NodeId);
                    }
                }
            }
            self.guards[guard as usize].affected = affected;
        }
    }

    fn narrowable(&self, id: NodeId, depth: u32, moved: &mut [bool]) {
        if let Some(moved) = moved.get_mut(id as usize) {
            *moved = true;
        }
        if depth > 0 {
            for &id in self.operands(&self.nodes[id as usize]) {
                self.narrowable(id, depth - 1, moved);
            }
        }
    }
}

impl Bounds {
    /// Returns the enclosure of a value as it is known under a guard.
    pub(super) fn enclosure_under(
        &self,
        graph: &Graph,
        mut guard: GuardId,
        id: NodeId,
    ) -> Interval {
        while guard != ALWAYS {
            let narrowed = &self.contexts[guard as usize].narrowed;
            // The last one is the narrowest.
            if let Some((_, value)) = narrowed.iter().rev().find(|(known, _)| *known == id) {
                return *value;
            }
            guard = graph.guards[guard as usize].parent;
        }
        self.values[id as usize]
    }

    /// Returns whether any execution may reach a guard, and narrows the values it uses.
    pub(super) fn is_reached(&mut self, graph: &Graph, guard: GuardId) -> bool {
        if guard == ALWAYS {
            return true;
        }
        match self.contexts[guard as usize].state {
            Reached::Maybe => return true,
            Reached::Never => return false,
            Reached::Unknown => {}
        }
        let Guard { parent, cond, truth, .. } = graph.guards[guard as usize];
        let reached = self.is_reached(graph, parent) && {
            self.contexts[guard as usize].state = Reached::Maybe;
            self.assume(graph, guard, cond, truth).is_some()
        };
        self.contexts[guard as usize].state = if reached { Reached::Maybe } else { Reached::Never };
        if reached && !self.contexts[guard as usize].narrowed.is_empty() {
            // In the order of the nodes: operands are narrowed before the values computed from
            // them.
            for &id in &graph.guards[guard as usize].affected {
                let before = self.enclosure_under(graph, guard, id);
                let after = intersection(self.apply(graph, id, guard).value, before);
                if !is_empty(after) && (after.low > before.low || after.high < before.high) {
                    self.contexts[guard as usize].narrowed.push((id, after));
                }
            }
        }
        reached
    }

    /// Narrows values under a guard by a condition; `None` if it cannot hold.
    fn assume(&mut self, graph: &Graph, guard: GuardId, cond: NodeId, truth: bool) -> Option<()> {
        let node = &graph.nodes[cond as usize];
        let known = self.enclosure_under(graph, guard, cond);
        if is_empty(known) || known == exact::point(f64::from(u8::from(!truth))) {
            return None;
        }
        let operands = graph.operands(node);
        match (node.act, truth) {
            (NodeOp::Compare(cmp), _) => {
                let (a, b) = (operands[0], operands[1]);
                let values =
                    [self.enclosure_under(graph, guard, a), self.enclosure_under(graph, guard, b)];
                // A float below another is at most the one before it; among the reals there is none
                // before.
                let next = match self.arithmetic {
                    Arithmetic::Exact => |x: f64| x,
                    Arithmetic::Permitted | Arithmetic::Nearest => after as fn(f64) -> f64,
                };
                let [x, y] = compared(if truth { cmp } else { opposite(cmp) }, values, next)?;
                self.narrow(graph, guard, a, x, DEPTH)?;
                self.narrow(graph, guard, b, y, DEPTH)
            }
            (NodeOp::CompareWords(cmp, signed), _) => {
                let (a, b) = (operands[0], operands[1]);
                let of = |id| word::signed(self.enclosure_under(graph, guard, id), signed);
                let values = [of(a), of(b)];
                let next = |x: f64| x + 1.0;
                let found = compared(if truth { cmp } else { opposite(cmp) }, values, next)?;
                for ((id, value), narrowed) in [a, b].into_iter().zip(values).zip(found) {
                    // Words known by numbers of the other sign stay as they are.
                    if self.enclosure_under(graph, guard, id) == value {
                        self.narrow(graph, guard, id, narrowed, 0)?;
                    }
                }
                Some(())
            }
            (NodeOp::WordUnary(WordUnary::LogicalNot), _) => {
                self.assume(graph, guard, operands[0], !truth)
            }
            // Of a true `and` and of a false `or` both operands are known.
            (NodeOp::WordBinary(WordBinary::And), true)
            | (NodeOp::WordBinary(WordBinary::Or), false) => {
                self.assume(graph, guard, operands[0], truth)?;
                self.assume(graph, guard, operands[1], truth)
            }
            // `c && a` is `c ? a : false`, and `c || b` is `c ? true : b`: where one side cannot
            // have this truth, the other has, and `c` is known too.
            (NodeOp::Select, _) => {
                let [c, a, b] = [operands[0], operands[1], operands[2]];
                let against = exact::point(f64::from(u8::from(!truth)));
                if self.enclosure_under(graph, guard, b) == against {
                    self.assume(graph, guard, c, true)?;
                    return self.assume(graph, guard, a, truth);
                }
                if self.enclosure_under(graph, guard, a) == against {
                    self.assume(graph, guard, c, false)?;
                    return self.assume(graph, guard, b, truth);
                }
                Some(())
            }
            _ => Some(()),
        }
    }

    /// Narrows a value and the operands that determine it; `None` if nothing is left.
    fn narrow(
        &mut self,
        graph: &Graph,
        guard: GuardId,
        id: NodeId,
        to: Interval,
        depth: u32,
    ) -> Option<()> {
        let before = self.enclosure_under(graph, guard, id);
        let after = intersection(before, to);
        if is_empty(after) {
            return None;
        }
        if after.low <= before.low && after.high >= before.high {
            return Some(());
        }
        self.contexts[guard as usize].narrowed.push((id, after));
        if depth == 0 {
            return Some(());
        }
        let node = &graph.nodes[id as usize];
        let operands = graph.operands(node);
        let slack = |x: Interval| {
            let error = exact::size(x) * SLACK + f64::from(f32::MIN_POSITIVE);
            exact::between(x.low - error, x.high + error)
        };
        match node.act {
            NodeOp::RealUnary(RealUnary::Neg) => {
                self.narrow(graph, guard, operands[0], exact::neg(after), depth - 1)
            }
            NodeOp::RealUnary(RealUnary::Sqrt) => {
                let square = slack(exact::squared(exact::between(after.low.max(0.0), after.high)));
                self.narrow(graph, guard, operands[0], square, depth - 1)
            }
            NodeOp::RealBinary(f @ (RealBinary::Add | RealBinary::Sub))
                if operands[0] != operands[1] =>
            {
                let [a, b] = [0, 1].map(|i| self.enclosure_under(graph, guard, operands[i]));
                // An error of the sum is relative to the sum.
                let sum = slack(after);
                let (x, y) = match f {
                    RealBinary::Add => (exact::sub(sum, b), exact::sub(sum, a)),
                    _ => (exact::add(sum, b), exact::sub(a, sum)),
                };
                self.narrow(graph, guard, operands[0], x, depth - 1)?;
                self.narrow(graph, guard, operands[1], y, depth - 1)
            }
            _ => Some(()),
        }
    }
}

/// Returns the next `f32` above a number.
fn after(x: f64) -> f64 {
    let near = x as f32;
    let near = if f64::from(near) > x { near.next_down() } else { near };
    f64::from(near.next_up()).min(f64::from(f32::MAX).max(x))
}

fn opposite(cmp: Cmp) -> Cmp {
    match cmp {
        Cmp::Eq => Cmp::Ne,
        Cmp::Ne => Cmp::Eq,
        Cmp::Lt => Cmp::Ge,
        Cmp::Le => Cmp::Gt,
        Cmp::Gt => Cmp::Le,
        Cmp::Ge => Cmp::Lt,
    }
}

/// Returns the operands for which a comparison may hold; `None` if it cannot.
fn compared(
    cmp: Cmp,
    [a, b]: [Interval; 2],
    next: impl Fn(f64) -> f64 + Copy,
) -> Option<[Interval; 2]> {
    let previous = |x: f64| -next(-x);
    let below = |a: Interval, b: Interval, high: f64, low: f64| {
        [
            intersection(a, exact::between(f64::NEG_INFINITY, high)),
            intersection(b, exact::between(low, f64::INFINITY)),
        ]
    };
    let all = match cmp {
        Cmp::Eq => [intersection(a, b), intersection(a, b)],
        Cmp::Ne => {
            // Only an end can be taken away from an interval.
            let without = |x: Interval, y: Interval| match y.low == y.high {
                true if x.low == y.low => exact::between(next(x.low), x.high),
                true if x.high == y.low => exact::between(x.low, previous(x.high)),
                _ => x,
            };
            if a == b && a.low == a.high {
                return None;
            }
            [without(a, b), without(b, a)]
        }
        Cmp::Le => below(a, b, b.high, a.low),
        Cmp::Lt => below(a, b, previous(b.high), next(a.low)),
        Cmp::Ge | Cmp::Gt => {
            let turned = if cmp == Cmp::Ge { Cmp::Le } else { Cmp::Lt };
            let [b, a] = compared(turned, [b, a], next)?;
            [a, b]
        }
    };
    all.iter().all(|x| !is_empty(*x)).then_some(all)
}
