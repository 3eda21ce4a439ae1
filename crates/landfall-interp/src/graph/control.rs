//! Follows branches, loops, switches and calls: both sides where a condition is not decided.
//!
//! A path has the value of every register and the guard under which it is followed. Where paths
//! meet, each register in which they differ becomes a selection by the condition that parted them.

use super::super::code::{Class, Cmp, Op, WordBinary, WordUnary};
use super::MAX_ITERATIONS;
use super::exact;
use super::function::{CodeTooLarge, Followed, GraphBuilder};
use super::guard::Guard;
use super::node::{GuardId, NodeId, NodeOp};
use super::paths::{Exits, Path, State};

impl GraphBuilder<'_> {
    /// Follows a function's body to its end.
    pub fn body(&mut self, start: usize) -> Followed<()> {
        let mut exits = Exits::default();
        let outer = self.guard;
        self.block(start, &mut exits)?;
        exits.returns.extend(self.path.take());
        self.join(exits.returns, outer)
    }

    /// Follows instructions up to the end of their construct, and returns where that is.
    fn block(&mut self, mut pc: usize, exits: &mut Exits) -> Followed<usize> {
        let program = self.program;
        loop {
            let inst = program.code[pc];
            self.pc = pc;
            self.left = self.left.checked_sub(1).ok_or(CodeTooLarge)?;
            match inst.op {
                Op::Else(_)
                | Op::EndIf(_)
                | Op::Continuing(_)
                | Op::BreakIf
                | Op::LoopBack(_)
                | Op::LoopEnd(_)
                | Op::Case(_)
                | Op::CaseEnd
                | Op::SwitchEnd(_)
                | Op::End => return Ok(pc),
                // No path leads here. The construct is passed over as a whole, so that its end is
                // not taken for that of the one around it.
                Op::If(_) | Op::Loop | Op::Switch if self.path.is_none() => {
                    pc = self.skipped(pc);
                    continue;
                }
                _ if self.path.is_none() => {}
                Op::If(_) => {
                    pc = self.branch(pc, exits)?;
                    continue;
                }
                Op::Loop => {
                    pc = self.repeat(pc, exits)?;
                    continue;
                }
                Op::Switch => {
                    pc = self.switch(pc, exits)?;
                    continue;
                }
                Op::Break => exits.breaks.extend(self.path.take()),
                Op::Continue => exits.continues.extend(self.path.take()),
                Op::Return => exits.returns.extend(self.path.take()),
                // A discarded invocation has no result.
                Op::Kill => self.path = None,
                Op::Call(function) => self.body(program.starts[function as usize] as usize)?,
                Op::Nop | Op::Barrier | Op::CaseSkip(_) | Op::Inlined(_) | Op::Sampled => {}
                _ => self.instruction(inst)?,
            }
            pc += 1;
        }
    }

    /// Returns the instruction after a construct.
    fn skipped(&self, mut pc: usize) -> usize {
        let mut depth = 0usize;
        loop {
            match self.program.code[pc].op {
                Op::If(_) | Op::Loop | Op::Switch => depth += 1,
                Op::EndIf(_) | Op::LoopEnd(_) | Op::SwitchEnd(_) => depth -= 1,
                _ => {}
            }
            pc += 1;
            if depth == 0 {
                return pc;
            }
        }
    }

    /// Returns the value of a condition over the whole box, if it has only one.
    fn decided(&self, condition: NodeId) -> Option<bool> {
        let value = self.bounds.enclosure_under(&self.graph, self.guard, condition);
        match value {
            x if x == exact::point(0.0) => Some(false),
            x if x.low >= 1.0 && !exact::is_empty(x) => Some(true),
            _ => None,
        }
    }

    /// Narrows the path by a condition; `None` if it cannot hold.
    fn enter(&mut self, cond: NodeId, truth: bool) {
        match self.decided(cond) {
            Some(known) if known == truth => return,
            Some(_) => {
                self.path = None;
                return;
            }
            None => {}
        }
        // The same condition on the same path has one guard.
        let key = (self.guard, cond, truth);
        let next = self.graph.guards.len() as GuardId;
        let guard = *self.guards.entry(key).or_insert(next);
        if guard == next {
            let parent = self.guard;
            self.graph.guards.push(Guard { parent, cond, truth, affected: Vec::new() });
        }
        self.bounds.contexts.resize_with(self.graph.guards.len(), Default::default);
        // Together with the conditions before it, it may exclude the whole box.
        if self.bounds.is_reached(&self.graph, guard) {
            self.guard = guard;
            if let Some(path) = &mut self.path {
                path.guard = guard;
            }
        } else {
            self.path = None;
        }
    }

    /// Continues on a path.
    fn resume(&mut self, path: Option<Path>, outer: GuardId) {
        self.guard = path.as_ref().map_or(outer, |path| path.guard);
        self.path = path;
    }

    fn branch(&mut self, pc: usize, exits: &mut Exits) -> Followed<usize> {
        let program = self.program;
        let condition = self.get(Class::Word, program.pool[program.code[pc].at as usize]);
        let outer = self.guard;
        let before = self.path.clone();
        // Both sides start from the same registers; one that cannot be entered leaves no path.
        self.enter(condition, true);
        let mut end = self.block(pc + 1, exits)?;
        let first = self.path.take();
        self.resume(before, outer);
        self.enter(condition, false);
        if let Op::Else(_) = program.code[end].op {
            end = self.block(end + 1, exits)?;
        }
        let second = self.path.take();
        self.pc = pc;
        match (first, second) {
            (Some(a), Some(b)) => {
                self.resume(Some(Path { guard: outer, state: b.state.clone() }), outer);
                self.merge(condition, &a.state, &b.state)?;
            }
            (one, other) => self.resume(one.or(other), outer),
        }
        Ok(end + 1)
    }

    /// Selects each register that differs.
    fn merge(&mut self, condition: NodeId, yes: &State, no: &State) -> Followed<()> {
        for (class, reg) in yes.differences(no) {
            let sides = [condition, yes.get(class, reg), no.get(class, reg)];
            let id = self.node(NodeOp::Select, class, &sides)?;
            self.set(class, reg, id);
        }
        Ok(())
    }

    /// Returns the condition of a guard within another one.
    fn condition(&mut self, guard: GuardId, outer: GuardId) -> Followed<Option<NodeId>> {
        if guard == outer || !self.graph.is_within(guard, outer) {
            return Ok(None);
        }
        let Guard { parent, cond, truth, .. } = self.graph.guards[guard as usize];
        let own = match truth {
            true => cond,
            false => self.node(NodeOp::WordUnary(WordUnary::LogicalNot), Class::Word, &[cond])?,
        };
        Ok(Some(match self.condition(parent, outer)? {
            None => own,
            Some(before) => {
                self.node(NodeOp::WordBinary(WordBinary::And), Class::Word, &[before, own])?
            }
        }))
    }

    /// Continues on all paths together. Those that left first come first.
    fn join(&mut self, mut paths: Vec<Path>, outer: GuardId) -> Followed<()> {
        let Some(mut last) = paths.pop() else {
            self.resume(None, outer);
            return Ok(());
        };
        if paths.is_empty() {
            self.resume(Some(last), outer);
            return Ok(());
        }
        last.guard = outer;
        // From the last path to the first: where the condition of an earlier one holds, its
        // registers are taken, whatever the later ones hold.
        while let Some(path) = paths.pop() {
            self.resume(Some(last), outer);
            match self.condition(path.guard, outer)? {
                None => self.path = Some(Path { guard: outer, state: path.state }),
                Some(condition) => {
                    let state = self.path.as_ref().map(|path| path.state.clone());
                    if let Some(state) = state {
                        self.merge(condition, &path.state, &state)?;
                    }
                }
            }
            let Some(merged) = self.path.take() else { return Ok(()) };
            last = merged;
        }
        self.resume(Some(last), outer);
        Ok(())
    }

    fn repeat(&mut self, pc: usize, exits: &mut Exits) -> Followed<usize> {
        let program = self.program;
        let outer = self.guard;
        let end = self.skipped(pc);
        let mut breaks = Vec::new();
        let mut iterations = 0;
        // Unrolled: every iteration begins under the guard at which the one before ended, until no
        // path goes on.
        while self.path.is_some() {
            iterations += 1;
            if iterations > MAX_ITERATIONS {
                self.pc = pc;
                self.node(NodeOp::Endless, Class::Word, &[])?;
                break;
            }
            let start = self.guard;
            let mut inner = Exits::default();
            let mut at = self.block(pc + 1, &mut inner)?;
            exits.returns.append(&mut inner.returns);
            breaks.append(&mut inner.breaks);
            inner.continues.extend(self.path.take());
            self.join(inner.continues, start)?;
            let mut none = Exits::default();
            at = self.block(at + 1, &mut none)?;
            if let (Op::BreakIf, Some(path)) = (program.code[at].op, self.path.clone()) {
                let condition = self.get(Class::Word, program.pool[program.code[at].at as usize]);
                self.enter(condition, true);
                breaks.extend(self.path.take());
                let guard = path.guard;
                self.resume(Some(path), guard);
                self.enter(condition, false);
            }
        }
        self.guard = outer;
        self.join(breaks, outer)?;
        Ok(end)
    }

    fn switch(&mut self, pc: usize, exits: &mut Exits) -> Followed<usize> {
        let program = self.program;
        let outer = self.guard;
        let end = self.skipped(pc);
        let before = self.path.clone();
        let mut inner = Exits::default();
        let mut left = Vec::new();
        let mut falling: Option<Path> = None;
        let mut at = pc + 1;
        while let Op::Case(table) = program.code[at].op {
            let selector = program.pool[program.code[at].at as usize];
            self.resume(before.clone(), outer);
            self.pc = at;
            let values = program.values[table as usize].clone();
            let selector = self.get(Class::Word, selector);
            let mut taken = self.constant(Class::Word, 0.0)?;
            for bits in values.bits {
                let value = self.constant(Class::Word, f64::from(bits as i32))?;
                let equal = NodeOp::CompareWords(Cmp::Eq, true);
                let same = self.node(equal, Class::Word, &[selector, value])?;
                taken =
                    self.node(NodeOp::WordBinary(WordBinary::Or), Class::Word, &[taken, same])?;
            }
            // With the default, `values` are those of the other cases.
            self.enter(taken, !values.default);
            if let Some(more) = falling.take() {
                let paths = self.path.take().into_iter().chain([more]).collect();
                self.join(paths, outer)?;
            }
            at = self.block(at + 1, &mut inner)?;
            match program.code[at].op {
                Op::CaseEnd => {
                    left.extend(self.path.take());
                    at += 1;
                }
                _ => falling = self.path.take(),
            }
        }
        left.extend(falling);
        left.append(&mut inner.breaks);
        exits.returns.append(&mut inner.returns);
        exits.continues.append(&mut inner.continues);
        self.guard = outer;
        self.join(left, outer)?;
        Ok(end)
    }
}
