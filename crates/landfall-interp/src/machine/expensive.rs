//! Functions without a processor instruction: in wide registers where a series has the same bits, else
//! lane by lane, and once where all lanes agree.

use pulp::Arch;

use super::super::code::{RealBinary, RealUnary};
use super::super::lanes::Lanes;
use super::super::real::{ColumnWork, Real};
use super::float::{apply1, apply2};
use super::kernel::once_if_uniform;
use super::{Machine, apart};

impl<R: Real> Machine<'_, '_, R> {
    pub(super) fn transcendental1(&mut self, f: RealUnary, operands: &[u32]) {
        for group in operands.chunks_exact(2) {
            let (to, others) = apart(&mut self.reals, group[0]);
            let work = Expensive1 { arch: self.arch, f, active: self.active };
            R::on_parts(to, [others.column(group[1])], &work);
        }
    }

    pub(super) fn transcendental2(&mut self, f: RealBinary, operands: &[u32]) {
        for group in operands.chunks_exact(3) {
            let (to, others) = apart(&mut self.reals, group[0]);
            let (a, b) = (others.column(group[1]), others.column(group[2]));
            let work = Expensive2 { arch: self.arch, f, active: self.active };
            R::on_parts(to, [a, b], &work);
        }
    }
}

/// A function of one operand in the active lanes; what the others hold is left open.
struct Expensive1 {
    arch: Arch,
    f: RealUnary,
    active: u64,
}

impl ColumnWork<1> for Expensive1 {
    fn run<R: Real>(&self, to: &mut R::Lanes, [a]: [&R::Lanes; 1]) {
        let &Expensive1 { arch, f, active } = self;
        let agree = agree(a);
        // The bits of the lanes that it leaves out.
        let left = if agree { u64::MAX } else { R::column1(arch, f, to, a) };
        once_if_uniform(to, active & left, agree, |lane| a.lane(lane), |x: R| apply1(f, x));
    }
}

/// The same for two operands.
struct Expensive2 {
    arch: Arch,
    f: RealBinary,
    active: u64,
}

impl ColumnWork<2> for Expensive2 {
    fn run<R: Real>(&self, to: &mut R::Lanes, [a, b]: [&R::Lanes; 2]) {
        let &Expensive2 { arch, f, active } = self;
        let agree = agree(a) && agree(b);
        let left = if agree { u64::MAX } else { R::column2(arch, f, to, a, b) };
        let (active, pair) = (active & left, |lane| (a.lane(lane), b.lane(lane)));
        once_if_uniform(to, active, agree, pair, |(a, b): (R, R)| apply2(f, a, b));
    }
}

fn agree<L: Lanes<Item: Real>>(a: &L) -> bool {
    let first = a.lane(0);
    a.each().all(|x| x.same(first))
}
