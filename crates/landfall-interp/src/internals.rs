//! What the tests in `tests/interp` reach inside of the crate; no part of its interface.

use pulp::Arch;

use crate::code::{LANES, RealBinary};
use crate::{Program, Programs, elementary};

pub use crate::code::RealUnary;
pub use crate::lanes::{lanes_of, quotient, remainder, saturated};
pub use crate::outward::{Outward, with_reversed};

/// The results in all lanes, and the lanes that are left to the scalar function.
pub type Lanes = ([f32; LANES], u64);

/// Computes a function that has a series without vector registers and with the widest there are.
pub fn series(function: RealUnary, a: &[f32; LANES]) -> [Lanes; 2] {
    on_each(|arch, to| elementary::function1(arch, function, to, a))
}

/// Computes powers without vector registers and with the widest there are.
pub fn powers(a: &[f32; LANES], b: &[f32; LANES]) -> [Lanes; 2] {
    on_each(|arch, to| elementary::function2(arch, RealBinary::Pow, to, a, b))
}

fn on_each(compute: impl Fn(Arch, &mut [f32; LANES]) -> u64) -> [Lanes; 2] {
    [Arch::Scalar, Arch::new()].map(|arch| {
        let mut to = [0.0; LANES];
        let rest = compute(arch, &mut to);
        (to, rest)
    })
}

/// Returns the operations that are computed once for all lanes, and those done with the one after.
pub fn once_and_fused(program: &Program) -> [Vec<String>; 2] {
    let operations = |is: fn(&crate::code::Inst) -> bool| {
        program.code.iter().filter(|inst| is(inst)).map(|inst| format!("{:?}", inst.op)).collect()
    };
    [operations(|inst| inst.once), operations(|inst| inst.fused)]
}

/// Whether these are the same programs, not others of the same modules.
pub fn are_same(a: &Programs, b: &Programs) -> bool {
    a.is_same(b)
}
