//! Finds the instructions whose results are the same for all invocations of a run: those of constants,
//! of uniform buffers, and of other such results.

use rustc_hash::FxHashSet;

use super::super::body::Body;
use super::super::code::{Access, Inst, Op, Reg, Region};
use super::super::program::{BufferInfo, BufferSpace};
use super::{Role, registers};

/// Marks these instructions; returns what they write, whose registers nothing else may write.
pub(super) fn mark(body: &mut Body, accesses: &[Access], buffers: &[BufferInfo]) -> FxHashSet<Reg> {
    let mut kept = FxHashSet::default();
    for inst in &mut body.code {
        let regs = |role: Role| {
            let mut regs = Vec::new();
            registers(inst, |place, of| {
                if of == role {
                    regs.push(Reg(body.pool[inst.at as usize + place]));
                }
            });
            regs
        };
        let is_same = |reg: &Reg| reg.region() == Region::Constant || kept.contains(reg);
        let is_own = |reg: &Reg| reg.region() == Region::Temporary;
        let writes = regs(Role::Write);
        inst.once = depends_on_operands(inst, accesses, buffers)
            && regs(Role::Read).iter().all(is_same)
            && writes.iter().all(is_own);
        if inst.once {
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
        Op::F1(_)
        | Op::F2(_)
        | Op::F3(_)
        | Op::Dot(_)
        | Op::Length(_)
        | Op::Distance(_)
        | Op::Normalize(_)
        | Op::Cross => true,
        _ => false,
    }
}
