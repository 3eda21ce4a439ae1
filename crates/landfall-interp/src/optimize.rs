//! Optimises a function's instructions: propagates copies, removes dead code, marks what is the same
//! for all invocations and what is fused, and reuses registers.
//!
//! Called by [`compile`](super::compile) for one function at a time.

mod copies;
mod fuse;
mod once;
mod reuse;

use super::body::{Body, Compiled};
use super::code::{Access, Inst, Op, Reg, WriteRegion};
use super::program::BufferInfo;

/// The use that an instruction makes of a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RegisterRole {
    Read,
    Write,
}

/// Calls `each` for every register operand of an instruction: its place after `at`, and its role.
pub(super) fn registers(inst: &Inst, mut each: impl FnMut(usize, RegisterRole)) {
    let head = usize::from(inst.head);
    (0..head).for_each(|place| each(place, RegisterRole::Read));
    let shape = inst.op.shape();
    for group in 0..inst.groups as usize {
        let at = head + group * shape.len();
        (0..shape.writes).for_each(|i| each(at + i, RegisterRole::Write));
        (0..shape.reads).for_each(|i| each(at + shape.writes + i, RegisterRole::Read));
    }
}

pub(super) fn optimize(
    body: &mut Body,
    accesses: &[Access],
    buffers: &[BufferInfo],
    interface: &Compiled,
) {
    // Registers are reused last: the passes before rely on a temporary having one writer.
    drop_unread(body);
    copies::remove_copies(body, accesses, interface);
    let kept = once::mark(body, accesses, buffers);
    fuse::mark(body);
    reuse::reuse(body, &kept);
}

/// Removes the groups of pure instructions whose results are never read.
fn drop_unread(body: &mut Body) {
    let mut reads: [Vec<u32>; 3] = body.temporaries.map(|n| vec![0; n as usize]);
    let pool = &mut body.pool;
    for inst in &body.code {
        registers(inst, |place, role| {
            let reg = Reg(pool[inst.at as usize + place]);
            if role == RegisterRole::Read && reg.region() == WriteRegion::Temporary {
                reads[reg.class() as usize][reg.number() as usize] += 1;
            }
        });
    }
    // Backwards, so that the operands of a removed instruction may go too.
    for inst in body.code.iter_mut().rev() {
        if !inst.op.is_pure() {
            continue;
        }
        let shape = inst.op.shape();
        let start = inst.at as usize + usize::from(inst.head);
        let mut kept = 0;
        for group in 0..inst.groups as usize {
            let at = start + group * shape.len();
            let needed = pool[at..at + shape.writes].iter().any(|&word| {
                let reg = Reg(word);
                reg.region() != WriteRegion::Temporary
                    || reads[reg.class() as usize][reg.number() as usize] > 0
            });
            if needed {
                pool.copy_within(at..at + shape.len(), start + kept * shape.len());
                kept += 1;
                continue;
            }
            for &word in &pool[at + shape.writes..at + shape.writes + shape.reads] {
                let reg = Reg(word);
                if reg.region() == WriteRegion::Temporary {
                    reads[reg.class() as usize][reg.number() as usize] -= 1;
                }
            }
        }
        inst.groups = kept as u32;
        if kept == 0 {
            for &word in &pool[inst.at as usize..start] {
                let reg = Reg(word);
                if reg.region() == WriteRegion::Temporary {
                    reads[reg.class() as usize][reg.number() as usize] -= 1;
                }
            }
            inst.op = Op::Nop;
            inst.head = 0;
        }
    }
    drop_nothings(body);
}

/// Removes the instructions without operands that do nothing.
fn drop_nothings(body: &mut Body) {
    let mut place = Vec::with_capacity(body.code.len() + 1);
    let mut next = 0;
    for inst in &body.code {
        place.push(next);
        next += u32::from(inst.op != Op::Nop);
    }
    // A jump may lead past the last instruction.
    place.push(next);
    let mut origins = std::mem::take(&mut body.origins).into_iter();
    let mut kept = Vec::with_capacity(next as usize);
    body.code.retain_mut(|inst| {
        let origin = origins.next().expect("every instruction has an origin");
        if let Some(target) = inst.op.target() {
            *target = place[*target as usize];
        }
        if inst.op == Op::Nop {
            return false;
        }
        kept.push(origin);
        true
    });
    body.origins = kept;
}
