//! Branches, cases and loops: the values of variables where control flow joins.

use naga::{Block, Expression, Handle};

use super::abstract_domain::Facts;
use super::graph::{GraphOp, Id};
use super::walk::{Flow, Walk, WalkFrame};

impl<'m> Walk<'m> {
    pub fn branches(
        &mut self,
        frame: &mut WalkFrame<'m>,
        condition: Id,
        accept: &'m Block,
        reject: &'m Block,
    ) -> Flow {
        // Both sides start from the same variables; facts and relations learned inside of a side
        // end with it.
        let mark = self.mark();
        let before = self.copied_cells();
        self.control.conditions.push(condition);
        self.assume(condition, true);
        let accepts = self.block(frame, accept);
        let when_true = self.forget(mark);
        let accepted = std::mem::replace(&mut self.cells, before);
        self.assume(condition, false);
        let rejects = self.block(frame, reject);
        let when_false = self.forget(mark);
        self.control.conditions.pop();
        match (accepts, rejects) {
            // Both go on: a variable that they left with different values is chosen by the
            // condition. Its facts are those of each value under the assumptions of its own side,
            // which a later query could not recover.
            (Flow::Falls, Flow::Falls) => {
                for (cell, &yes) in accepted.iter().enumerate() {
                    let no = self.cells[cell];
                    if yes == no {
                        continue;
                    }
                    let facts = self.facts_with(yes, &when_true);
                    let facts = facts.or(self.facts_with(no, &when_false));
                    let chosen = self.graph.add(GraphOp::Chosen, &[condition, yes, no]);
                    self.settled.insert(chosen, facts);
                    self.cells[cell] = chosen;
                }
                Flow::Falls
            }
            // `if (d <= 0.0) return;`: after it the condition of the side that goes on holds to
            // the end of the block.
            (Flow::Falls, _) => {
                self.cells = accepted;
                self.restore(&when_true);
                Flow::Falls
            }
            (_, Flow::Falls) => {
                self.restore(&when_false);
                Flow::Falls
            }
            // A `break` of one side may reach the end of a `switch`, hence it wins over `Leaves`.
            (Flow::Breaks, _) | (_, Flow::Breaks) => Flow::Breaks,
            (Flow::Leaves, Flow::Leaves) => Flow::Leaves,
        }
    }

    pub fn switch(
        &mut self,
        frame: &mut WalkFrame<'m>,
        selector: Id,
        cases: &'m [naga::SwitchCase],
    ) -> Flow {
        self.control.conditions.push(selector);
        let flow = self.cases(frame, selector, cases);
        self.control.conditions.pop();
        flow
    }

    fn cases(
        &mut self,
        frame: &mut WalkFrame<'m>,
        selector: Id,
        cases: &'m [naga::SwitchCase],
    ) -> Flow {
        let before = self.copied_cells();
        let mut ends: Vec<Vec<Id>> = Vec::new();
        let mut falls_on = false;
        for case in cases {
            // A case that falls through starts with the variables of the case before it.
            if !falls_on {
                self.cells = before.clone();
            }
            let flow = self.block(frame, &case.body);
            falls_on = case.fall_through && flow == Flow::Falls;
            if !falls_on && flow != Flow::Leaves {
                ends.push(self.copied_cells());
            }
        }
        // All cases return or continue: nothing follows the switch.
        if ends.is_empty() && !cases.is_empty() {
            return Flow::Leaves;
        }
        // Every switch of the IR has a default case, so the values before it are not among those
        // after it.
        self.cells = before;
        self.join(&ends, &[selector]);
        Flow::Falls
    }

    /// Joins the values that each variable has in several states, of which `guards` select one.
    fn join(&mut self, states: &[Vec<Id>], guards: &[Id]) {
        for cell in 0..self.cells.len() {
            let mut values: Vec<Id> =
                states.iter().filter_map(|state| state.get(cell).copied()).collect();
            values.dedup();
            if !values.is_empty() {
                let joined = self.joined(&values);
                self.cells[cell] = joined;
                self.guard(joined, guards);
            }
        }
    }

    pub fn run_loop(
        &mut self,
        frame: &mut WalkFrame<'m>,
        body: &'m Block,
        continuing: &'m Block,
        break_if: Option<Handle<Expression>>,
    ) {
        // A loop is walked twice. The first turn finds the variables that it changes; the second
        // has them as `Looping` nodes of which only what holds in every iteration is known. Two
        // turns are enough, since nothing depends on the number of iterations; nested loops cost
        // 2^depth turns, which `MAX_STEPS` bounds.
        let before = self.copied_cells();
        let outer = std::mem::take(&mut self.left);
        let outer_guards = std::mem::take(&mut self.control.left);
        // Once to see what it changes, once more with that unknown.
        // Findings of the first turn are dropped: they are about the first iteration alone.
        let (candidates, accesses, powers) =
            (self.candidates.len(), self.accesses.len(), self.powers.len());
        let breaks = self.control.breaks.len();
        self.turn(frame, body, continuing, break_if);
        self.control.breaks.truncate(breaks);
        self.candidates.truncate(candidates);
        self.accesses.truncate(accesses);
        self.powers.truncate(powers);
        let after = std::mem::replace(&mut self.cells, before.clone());
        let mut states = std::mem::take(&mut self.left);
        states.push(after);
        for (cell, &first) in before.iter().enumerate() {
            // Changed in any of the ways a turn ends: at its end, at a `continue` or a `break`.
            let Some(changed) = states.iter().find_map(|s| Some(s[cell]).filter(|&v| v != first))
            else {
                continue;
            };
            let fresh = self.graph.next();
            let looping = self.graph.add(GraphOp::Looping(fresh), &[first]);
            let mut facts = Facts::NOTHING;
            // `i = i + 1` keeps the lower bound that the counter had before the loop.
            if self.counts_up(first, changed) {
                facts.low = self.facts(first).low;
            }
            self.settled.insert(looping, facts);
            self.cells[cell] = looping;
        }
        let top = self.copied_cells();
        self.turn(frame, body, continuing, break_if);
        let breaks = self.control.breaks[breaks..].to_vec();
        // The states after the second turn are the values of the next iteration, by which
        // `falloff` argues by induction.
        let mut states = std::mem::replace(&mut self.left, outer);
        states.push(std::mem::replace(&mut self.cells, top.clone()));
        for (cell, &looping) in top.iter().enumerate() {
            if matches!(self.graph.op(looping), GraphOp::Looping(_)) {
                let after = states.iter().filter_map(|state| state.get(cell));
                self.control.next_values.entry(looping).or_default().extend(after);
                self.control.loops.entry(looping).or_default().extend(&breaks);
            }
        }
        // The loop may end before its first iteration as well.
        states.push(top);
        let guards = std::mem::replace(&mut self.control.left, outer_guards);
        self.join(&states, &guards);
    }

    fn turn(
        &mut self,
        frame: &mut WalkFrame<'m>,
        body: &'m Block,
        continuing: &'m Block,
        break_if: Option<Handle<Expression>>,
    ) {
        self.block(frame, body);
        self.block(frame, continuing);
        if let Some(condition) = break_if {
            let condition = self.value(frame, condition);
            self.control.breaks.push(condition);
        }
    }

    fn counts_up(&self, first: Id, after: Id) -> bool {
        let sum = self.graph.binary(after, naga::BinaryOperator::Add);
        sum.is_some_and(|(a, b)| {
            let up = |id: Id| self.graph.value(id).is_some_and(|number| number > 0.0);
            // Only constant steps: those of unknown sign give no bound.
            (a == first && up(b)) || (b == first && up(a))
        })
    }
}
