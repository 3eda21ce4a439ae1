//! What values depend on: the light that is left out, the number of such lights, their loops. It is
//! the same for all lights of an array, so it is found once.

use naga::BinaryOperator as B;
use rustc_hash::{FxHashMap, FxHashSet};

use super::FalloffTerms;
use crate::analysis::hazards::graph::{GraphOp, Id, Leaf};
use crate::analysis::roles::Role;

/// An array of lights of which some are left out, and what else changes without them.
#[derive(Clone, Copy, Debug)]
pub struct LightArray<'a> {
    /// Its index among the lights followed.
    pub index: usize,
    /// The paths of the members that count such lights, and of the lengths of their arrays, that
    /// change: `pointCount`, `tiles[].count`, `lights.length()`.
    pub counts: &'a [String],
    /// The paths of the members that list the indices of such lights: `indices[]`.
    pub lists: &'a [String],
}

/// The dependence of values on the lights of an array.
#[derive(Debug)]
pub(super) struct Dependence<'t> {
    terms: &'t FalloffTerms,
    array: LightArray<'t>,
    known: FxHashMap<(Question, Id), bool>,
}

/// What is asked of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Question {
    Reaches,
    BelowCount,
    Loops,
    IsPath,
}

impl<'t> Dependence<'t> {
    pub fn new(terms: &'t FalloffTerms, array: LightArray<'t>) -> Dependence<'t> {
        Dependence { terms, array, known: FxHashMap::default() }
    }

    /// Answers a question once.
    fn is(&mut self, question: Question, id: Id) -> bool {
        // Questions over the graph are asked for many nodes and lights; each walks what is below a
        // node.
        if let Some(known) = self.known.get(&(question, id)) {
            return *known;
        }
        let found = match question {
            Question::Reaches => self.below(id, &|id| self.is_of_light(id)),
            Question::BelowCount => self.below(id, &|id| self.is_count(id)),
            Question::Loops => self.find_loop(id),
            Question::IsPath => self.find_path(id),
        };
        self.known.insert((question, id), found);
        found
    }

    /// Whether a value depends on the light.
    pub fn reaches(&mut self, id: Id) -> bool {
        self.is(Question::Reaches, id)
    }

    /// Whether a value depends on how many such lights there are.
    pub fn is_below_count(&mut self, id: Id) -> bool {
        self.is(Question::BelowCount, id)
    }

    /// Whether a value depends on the light or on how many there are.
    pub fn touches(&mut self, id: Id) -> bool {
        self.reaches(id) || self.is_below_count(id)
    }

    /// Whether a value depends on what a loop over such lights carries from one iteration to the
    /// next.
    pub fn loops(&mut self, id: Id) -> bool {
        self.is(Question::Loops, id)
    }

    // A node carries over iterations if it contains a variable of a counted loop, also by way of
    // what guards it, of what the variable becomes, or of how its loop ends.
    fn find_loop(&mut self, id: Id) -> bool {
        let (graph, control) = (&self.terms.graph, &self.terms.control);
        let mut seen = FxHashSet::default();
        let mut todo = vec![id];
        while let Some(id) = todo.pop() {
            if !seen.insert(id) {
                continue;
            }
            if matches!(graph.op(id), GraphOp::Looping(_)) && self.is_counted(id) {
                return true;
            }
            todo.extend(graph.args(id));
            for also in [&control.hidden, &control.guards, &control.next_values, &control.loops] {
                todo.extend(also.get(&id).into_iter().flatten());
            }
        }
        false
    }

    // Backwards along arguments, hidden operands and guards; `next_values` are left out, so this
    // is about one iteration.
    fn below(&self, id: Id, is: &dyn Fn(Id) -> bool) -> bool {
        let control = &self.terms.control;
        let mut seen = FxHashSet::default();
        let mut todo = vec![id];
        while let Some(id) = todo.pop() {
            if !seen.insert(id) {
                continue;
            }
            if is(id) {
                return true;
            }
            todo.extend(self.terms.graph.args(id));
            todo.extend(control.hidden.get(&id).into_iter().flatten());
            todo.extend(control.guards.get(&id).into_iter().flatten());
        }
        false
    }

    fn leaf(&self, id: Id) -> Option<&Leaf> {
        self.terms.graph.as_leaf(id)
    }

    pub fn is_of_light(&self, id: Id) -> bool {
        self.leaf(id).is_some_and(|leaf| {
            let own = leaf.light.as_ref().is_some_and(|(light, _)| *light == self.array.index);
            // An index from the list of a tile selects the light, so it belongs to it.
            own || self.array.lists.contains(&leaf.path)
        })
    }

    /// Whether a leaf counts or lists such lights.
    pub fn is_count(&self, id: Id) -> bool {
        self.leaf(id).is_some_and(|leaf| self.array.counts.contains(&leaf.path))
    }

    /// Whether the loop of a variable runs as often as there are such lights.
    pub fn is_counted(&mut self, id: Id) -> bool {
        let breaks = self.terms.control.loops.get(&id);
        breaks.is_some_and(|all| all.iter().any(|condition| self.touches(*condition)))
    }

    /// Whether a condition that ends a loop does not depend on the light: it compares the loop's
    /// counter with the number of lights, or something unrelated.
    pub fn ends_a_loop(&mut self, id: Id) -> bool {
        if self.reaches(id) {
            // Ending a loop by a light's numbers, as in `if (sum > 1.0) break`, affects the lights
            // after it.
            return false;
        }
        if !self.touches(id) {
            return true;
        }
        let graph = &self.terms.graph;
        let mut id = id;
        while let (GraphOp::Not | GraphOp::Convert, &[of]) = (graph.op(id), graph.args(id)) {
            id = of;
        }
        let orders = [B::Less, B::LessEqual, B::Greater, B::GreaterEqual];
        // `i < count`: without the light the same iterations run but its own. A count compared
        // with anything else is a different use.
        orders.into_iter().filter_map(|order| graph.binary(id, order)).any(|(a, b)| {
            let counter = |id: Id| match (graph.op(id), graph.args(id)) {
                (GraphOp::Convert, &[of]) => matches!(graph.op(of), GraphOp::Looping(_)),
                (op, _) => matches!(op, GraphOp::Looping(_)),
            };
            // The other side must not change from one iteration to the next.
            (counter(a) && !self.loops(b)) || (counter(b) && !self.loops(a))
        })
    }

    /// Whether a value is the path between the light and the fragment.
    pub fn is_path(&mut self, id: Id) -> bool {
        self.is(Question::IsPath, id)
    }

    fn find_path(&self, id: Id) -> bool {
        let graph = &self.terms.graph;
        // `light.position - position`, both as they are, so that its length is the distance. A
        // component, a sign or a permutation of one of them would have another length.
        let Some((a, b)) = graph.binary(id, B::Subtract) else { return false };
        let place = |id: Id| {
            let id = graph.underlying_value(id);
            self.is_of_light(id) && self.leaf(id).is_some_and(|l| l.role == Some(Role::Position))
        };
        let here = |id: Id| {
            let leaf = self.leaf(graph.underlying_value(id));
            leaf.is_some_and(|leaf| leaf.block.is_none() && leaf.name == self.terms.position)
        };
        // `bare` ignores signs, parts and other orders of the components.
        let turned = |id: Id| match graph.op(id) {
            GraphOp::Negate | GraphOp::Part(_) | GraphOp::Convert => true,
            GraphOp::Swizzle(way) => way[..3] != [0, 1, 2],
            _ => false,
        };
        let plain = |id: Id| !self.below(id, &turned);
        plain(a) && plain(b) && ((place(a) && here(b)) || (place(b) && here(a)))
    }
}
