//! Finds the instructions whose results are the same for all invocations of a run: those of constants,
//! of uniform buffers, and of other such results.

use rustc_hash::FxHashSet;

use super::super::body::Body;
use super::super::code::{Access, Inst, Op, Reg, WriteRegion};
use super::super::program::{BufferInfo, BufferSpace};
use super::{RegisterRole, registers};

/// Marks these instructions; returns what they write, whose registers nothing else may write.
pub(super) fn mark(body: &mut Body, accesses: &[Access], buffers: &[BufferInfo]) -> FxHashSet<Reg> {
    let mut kept = FxHashSet::default();
    // In the order of the code: what is marked is known before it is read.
    for inst in body.code.iter_mut().filter(|inst| depends_on_operands(inst, accesses, buffers)) {
        let (mut same, mut writes) = (true, Vec::new());
        registers(inst, |place, role| {
            let reg = Reg(body.pool[inst.at as usize + place]);
            match role {
                RegisterRole::Read => {
                    same &= reg.region() == WriteRegion::Constant || kept.contains(&reg)
                }
                RegisterRole::Write => {
                    // A variable has other writers.
                    same &= reg.region() == WriteRegion::Temporary;
                    writes.push(reg);
                }
            }
        });
        inst.once = same;
        if same {
            kept.extend(writes);
        }
    }
    kept
}

/// Whether the results depend on nothing but the operands, and nothing is noted of them.
fn depends_on_operands(inst: &Inst, accesses: &[Access], buffers: &[BufferInfo]) -> bool {
    match inst.op {
        Op::Load(access) => {
            let space = buffers[accesses[access as usize].buffer as usize].space;
            match space {
                BufferSpace::Uniform | BufferSpace::PushConstant => true,
                BufferSpace::Storage { writable } => !writable,
                BufferSpace::Workgroup => false,
            }
        }
        op => op.computes_reals(),
    }
}
