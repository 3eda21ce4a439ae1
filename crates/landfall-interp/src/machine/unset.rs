//! Finds variables that a watched run reads before they were written.
//!
//! In GLSL such a variable is undefined: the machine has zeros there, as WGSL requires, and a
//! driver whatever the register held. Only floats are followed: through copies, to the first
//! operation.

use rustc_hash::FxHashMap;

use super::super::code::{Class, Op, Stored};
use super::super::lanes::lane_numbers;
use super::super::real::Real;
use super::super::undefined::UndefinedKind;
use super::{Machine, column};

/// By register of a float: the lanes in which it was not written.
#[derive(Clone, Debug, Default)]
pub(crate) struct Unset {
    lanes: FxHashMap<u32, u64>,
}

impl Unset {
    /// Clears the state for other invocations.
    pub fn clear(&mut self) {
        self.lanes.clear();
    }

    fn of(&self, reg: u32) -> u64 {
        self.lanes.get(&reg).copied().unwrap_or(0)
    }

    fn put(&mut self, reg: u32, lanes: u64) {
        if lanes == 0 {
            self.lanes.remove(&reg);
        } else {
            self.lanes.insert(reg, lanes);
        }
    }
}

impl<R: Real> Machine<'_, '_, R> {
    /// Notes the unwritten operands of an operation.
    pub(super) fn inspect_unset(&mut self, pc: usize, op: Op, operands: &[u32]) {
        let Some(mut watch) = self.watch.take() else { return };
        let computes = op.computes_reals() && op.takes_reals() || matches!(op, Op::FCmp(_));
        if computes && !watch.unset.lanes.is_empty() {
            let shape = op.shape();
            for group in operands.chunks_exact(shape.len()) {
                let reads = &group[shape.writes..shape.writes + shape.reads];
                let lanes = reads.iter().fold(0, |all, &reg| all | watch.unset.of(reg));
                for lane in lane_numbers(lanes & self.active) {
                    watch.see((pc, lane), UndefinedKind::Uninitialised, Vec::new);
                }
            }
        }
        self.watch = Some(watch);
    }

    /// Propagates the state through an executed instruction.
    pub(super) fn follow_unset(&mut self, op: Op, head: &[u32], operands: &[u32]) {
        let Some(mut watch) = self.watch.take() else { return };
        let unset = &mut watch.unset;
        let active = self.active;
        match op {
            Op::Undefined(Class::Real) => {
                for group in operands.chunks_exact(2) {
                    // Other lanes keep their state.
                    unset.put(group[0], unset.of(group[0]) | active);
                }
            }
            Op::Move(Class::Real) | Op::Store(Class::Real) if !unset.lanes.is_empty() => {
                for group in operands.chunks_exact(2) {
                    let [to, from] = [group[0], group[1]];
                    unset.put(to, unset.of(to) & !active | unset.of(from) & active);
                }
            }
            Op::Scatter(Class::Real, access) | Op::Gather(Class::Real, access)
                if !unset.lanes.is_empty() =>
            {
                let access = &self.program.accesses[access as usize];
                // Each lane has an index of its own.
                for lane in lane_numbers(active) {
                    let way = self.computed_offset(access, head, lane, Class::Real as usize) as u32;
                    for group in operands.chunks_exact(2) {
                        let [to, from] = match op {
                            Op::Gather(..) => [group[0], group[1] + way],
                            _ => [group[1] + way, group[0]],
                        };
                        unset.put(to, unset.of(to) & !(1 << lane) | unset.of(from) & 1 << lane);
                    }
                }
            }
            Op::Select(Class::Real) if !unset.lanes.is_empty() => {
                for group in operands.chunks_exact(4) {
                    let conditions = column(&self.words, group[1]);
                    let lanes = (0..64).filter(|&lane| conditions[lane] != 0);
                    let taken = lanes.fold(0, |all, lane| all | 1u64 << lane);
                    let from = unset.of(group[2]) & taken | unset.of(group[3]) & !taken;
                    unset.put(group[0], from & active);
                }
            }
            // An argument may be computed where it was unset before.
            Op::Load(_) if !unset.lanes.is_empty() => {
                for group in operands.chunks_exact(3) {
                    if Stored::ALL[group[2] as usize].class() == Class::Real {
                        unset.put(group[0], unset.of(group[0]) & !active);
                    }
                }
            }
            _ if op.writes_reals() && !unset.lanes.is_empty() => {
                let shape = op.shape();
                for group in operands.chunks_exact(shape.len()) {
                    // Operations compute all lanes, active or not.
                    group[..shape.writes].iter().for_each(|reg| unset.put(*reg, 0));
                }
            }
            _ => {}
        }
        self.watch = Some(watch);
    }
}
