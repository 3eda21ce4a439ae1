//! Finds multiplications whose products the next instruction adds or subtracts, and nothing else reads:
//! the machine then keeps the products in the processor's registers.

use super::super::body::Body;
use super::super::code::{Class, Inst, Op, RealBinary, Reg, WriteRegion};
use super::{RegisterRole, registers};

/// Marks these multiplications.
pub(super) fn mark(body: &mut Body) {
    let mut reads = vec![0u32; body.temporaries[0] as usize];
    for inst in &body.code {
        registers(inst, |place, role| {
            let reg = Reg(body.pool[inst.at as usize + place]);
            if role == RegisterRole::Read && is_temporary(reg) {
                reads[reg.number() as usize] += 1;
            }
        });
    }
    for index in 1..body.code.len() {
        let (first, then) = (&body.code[index - 1], &body.code[index]);
        let is_single =
            |product: Reg| is_temporary(product) && reads[product.number() as usize] == 1;
        body.code[index - 1].fused = are_fused(&body.pool, first, then, is_single);
    }
}

fn is_temporary(reg: Reg) -> bool {
    reg.region() == WriteRegion::Temporary && reg.class() == Class::Real
}

fn are_fused(pool: &[u32], first: &Inst, then: &Inst, is_single: impl Fn(Reg) -> bool) -> bool {
    let adds = matches!(then.op, Op::RealBinary(RealBinary::Add | RealBinary::Sub));
    if first.op != Op::RealBinary(RealBinary::Mul)
        || first.once
        || !adds
        || first.groups != then.groups
    {
        return false;
    }
    let groups = |inst: &Inst| {
        let at = inst.at as usize;
        pool[at..at + inst.operands()].chunks_exact(3)
    };
    // The sums are written before all products are made.
    let mut sums = groups(then).map(|sum| sum[0]);
    let kept = sums.all(|sum| groups(first).all(|product| !product[1..].contains(&sum)));
    let pairs = || groups(first).zip(groups(then));
    let single = pairs().all(|(product, _)| is_single(Reg(product[0])));
    let on_the_left = pairs().all(|(product, sum)| product[0] == sum[1]);
    let on_the_right = pairs().all(|(product, sum)| product[0] == sum[2]);
    kept && single && (on_the_left || on_the_right)
}
