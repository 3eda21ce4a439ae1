//! Control flow of many invocations, by masks of active lanes.
//!
//! A lane that leaves a block is active no longer. One that broke out or continues waits in the
//! frame of its loop or switch, and one that returned in the frame of its call, whatever is open
//! between: the end of an inner construct joins its own masks only, and so leaves such a lane
//! alone. One that was discarded waits nowhere. Blocks in which no lane is left are jumped over. A
//! case that falls through leaves its lanes active for the next.

use std::sync::atomic::Ordering;
use std::time::Instant;

use super::super::code::{LANES, Op};
use super::super::lanes::lanes_of;
use super::super::real::Real;
use super::{CALLS_PER_STEP, CHECKED_EVERY, Machine, Stopped, column};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BlockKind {
    If,
    Loop,
    Switch,
    Call,
}

/// An open control-flow construct.
#[derive(Clone, Copy, Debug)]
pub(super) struct ControlFrame {
    kind: BlockKind,
    /// `if`: lanes of the else branch. Loop, switch: lanes that left it. Call: all lanes.
    first: u64,
    /// `if`: lanes that finished the first branch. Loop: lanes that continue. Switch: all lanes.
    /// Call: the return address.
    second: u64,
}

/// Instructions that a call counts for.
const CALL: u32 = 16;

const INSIDE: &str = "constructs are closed in the order they were opened";

impl<R: Real> Machine<'_, '_, R> {
    /// Returns the lanes in which a bool is true; lanes that are not active may hold any word.
    #[inline(always)]
    fn lanes_of(&self, reg: u32) -> u64 {
        lanes_of(column(&self.words, reg))
    }

    /// Runs an instruction that changes the active lanes; returns its jump target, if it jumps.
    #[inline(always)]
    pub(super) fn branch(&mut self, op: Op, head: &[u32]) -> Option<u32> {
        match op {
            Op::If(target) => {
                let yes = self.active & self.lanes_of(head[0]);
                let no = self.active & !yes;
                self.frames.push(ControlFrame { kind: BlockKind::If, first: no, second: 0 });
                self.set(yes);
                (yes == 0).then_some(target)
            }
            Op::Else(target) => {
                let frame = self.frames.last_mut().expect(INSIDE);
                frame.second = self.active;
                let no = std::mem::take(&mut frame.first);
                self.set(no);
                (no == 0).then_some(target)
            }
            Op::EndIf(skip) => {
                let frame = self.frames.pop().expect(INSIDE);
                self.set(self.active | frame.first | frame.second);
                (self.active == 0).then_some(skip)
            }
            Op::Loop => {
                self.frames.push(ControlFrame { kind: BlockKind::Loop, first: 0, second: 0 });
                None
            }
            Op::Continuing(leave) => {
                let frame = self.frames.last_mut().expect(INSIDE);
                let back = std::mem::take(&mut frame.second);
                self.set(self.active | back);
                (self.active == 0).then_some(leave)
            }
            Op::BreakIf => {
                let out = self.active & self.lanes_of(head[0]);
                self.frames.last_mut().expect(INSIDE).first |= out;
                self.set(self.active & !out);
                None
            }
            Op::LoopEnd(skip) => {
                let frame = self.frames.pop().expect(INSIDE);
                self.set(frame.first);
                (self.active == 0).then_some(skip)
            }
            Op::Switch => {
                let second = self.active;
                self.frames.push(ControlFrame { kind: BlockKind::Switch, first: 0, second });
                self.set(0);
                None
            }
            Op::Case(table) => {
                let values = &self.program.values[table as usize];
                let column = column(&self.words, head[0]);
                let mut found = 0;
                for (lane, word) in column.iter().enumerate() {
                    found |= u64::from(values.bits.contains(word)) << lane;
                }
                let all = self.frames.last().expect(INSIDE).second;
                let taken = if values.default { all & !found } else { all & found };
                self.set(self.active | taken);
                None
            }
            Op::CaseSkip(target) => (self.active == 0).then_some(target),
            Op::CaseEnd => {
                self.frames.last_mut().expect(INSIDE).first |= self.active;
                self.set(0);
                None
            }
            Op::SwitchEnd(skip) => {
                let frame = self.frames.pop().expect(INSIDE);
                self.set(self.active | frame.first);
                (self.active == 0).then_some(skip)
            }
            Op::Break => {
                let out = self.active;
                let inner =
                    self.frames.iter_mut().rev().find(|f| f.kind != BlockKind::If).expect(INSIDE);
                inner.first |= out;
                self.set(0);
                None
            }
            Op::Continue => {
                let back = self.active;
                let inner =
                    self.frames.iter_mut().rev().find(|f| f.kind == BlockKind::Loop).expect(INSIDE);
                inner.second |= back;
                self.set(0);
                None
            }
            Op::Return => {
                self.set(0);
                None
            }
            Op::Kill => {
                self.killed |= self.active;
                self.set(0);
                None
            }
            other => unreachable!("{other:?} is no branch"),
        }
    }

    /// Calls a function; returns its first instruction.
    #[inline(always)]
    pub(super) fn enter(&mut self, function: u32, pc: usize) -> Result<usize, Stopped> {
        self.tally.calls[function as usize] += self.count;
        self.call_tick(pc)?;
        // The call continues behind itself.
        let (first, second) = (self.active, pc as u64 + 1);
        self.frames.push(ControlFrame { kind: BlockKind::Call, first, second });
        Ok(self.program.starts[function as usize] as usize)
    }

    /// Fails unless all invocations of a workgroup are here.
    pub(super) fn barrier(&self, pc: usize) -> Result<(), Stopped> {
        match self.barriers && self.all_lanes_active() {
            true => Ok(()),
            false => Err(Stopped::Barrier(self.program.origins[pc])),
        }
    }

    /// Ends a function; returns where its caller continues, if it has one.
    #[inline(always)]
    pub(super) fn end(&mut self) -> Option<usize> {
        let frame = self.frames.pop()?;
        // Lanes that returned wait here; those that were discarded do not come back.
        self.set(frame.first & !self.killed);
        Some(frame.second as usize)
    }

    /// Returns whether all remaining lanes of the batch are active.
    fn all_lanes_active(&self) -> bool {
        // No lane may wait in another branch, in the next iteration or behind the construct.
        self.frames.iter().all(|frame| match frame.kind {
            BlockKind::If => frame.first | frame.second == 0,
            BlockKind::Loop => frame.first | frame.second == 0,
            BlockKind::Switch => frame.second & !frame.first & !self.active == 0,
            BlockKind::Call => frame.first & !self.killed == self.active,
        })
    }

    /// Counts one call, and checks the limit of calls and the deadline.
    #[inline(always)]
    pub(super) fn call_tick(&mut self, pc: usize) -> Result<(), Stopped> {
        self.batch_calls += 1;
        if self.batch_calls > u64::from(self.budget) * CALLS_PER_STEP {
            return Err(Stopped::Calls(self.program.origins[pc]));
        }
        self.check_deadline(pc, CALL)
    }

    /// Checks the deadline if about [`CHECKED_EVERY`] instructions ran since the last check.
    fn check_deadline(&mut self, pc: usize, instructions: u32) -> Result<(), Stopped> {
        if let Some(left) = self.until_check.checked_sub(instructions) {
            self.until_check = left;
            return Ok(());
        }
        self.until_check = CHECKED_EVERY;
        let is_stopped = self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed));
        match is_stopped || self.deadline.is_some_and(|deadline| Instant::now() > deadline) {
            true => Err(Stopped::Deadline(self.program.origins[pc])),
            false => Ok(()),
        }
    }

    /// Counts one loop iteration, and checks the budget and the deadline; `start` is the first
    /// instruction of the loop.
    #[inline(always)]
    pub(super) fn tick(&mut self, pc: usize, start: u32) -> Result<(), Stopped> {
        self.batch_steps = self.batch_steps.saturating_add(1);
        // The usual case, which is vectorised.
        if self.active == u64::MAX {
            self.steps.iter_mut().for_each(|n| *n = n.wrapping_add(1));
        } else {
            for lane in 0..LANES {
                self.steps[lane] = self.steps[lane].wrapping_add((self.active >> lane & 1) as u32);
            }
        }
        // No lane has more steps than the batch, so that lanes are rarely looked at.
        if self.batch_steps >= self.budget && self.steps.iter().any(|&n| n >= self.budget) {
            return Err(Stopped::Budget(self.program.origins[pc]));
        }
        // The loop's code has about as many instructions.
        self.check_deadline(pc, u32::try_from(pc).unwrap_or(u32::MAX).saturating_sub(start))
    }
}
