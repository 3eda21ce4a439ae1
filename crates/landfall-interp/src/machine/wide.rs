//! Doubles and 64-bit integers: operations in their own width, whatever the precision of the run.

use super::super::code::{LANES, Op, RealTernary, Test, WideBinary};
use super::super::real::Real;
use super::float::{apply1, apply2, mix, smoothstep};
use super::integer::binary_wide;
use super::{Aligned, apart, column, column_mut};

fn float3(f: RealTernary, a: f64, b: f64, c: f64) -> f64 {
    match f {
        RealTernary::Fma => a.mul_add(b, c),
        RealTernary::Mix => mix(a, b, c),
        RealTernary::Clamp => Real::min(Real::max(a, b), c),
        RealTernary::SmoothStep => smoothstep(a, b, c),
    }
}

/// Runs an instruction of doubles or 64-bit integers.
pub(super) fn compute(
    op: Op,
    operands: &[u32],
    words: &mut [Aligned<[u32; LANES]>],
    wides: &mut [Aligned<[u64; LANES]>],
) {
    let shape = op.shape();
    let real = f64::from_bits;
    for group in operands.chunks_exact(shape.len()) {
        if matches!(op, Op::DCmp(_) | Op::DCmpSint(_) | Op::DCmpUint(_) | Op::DTest(_)) {
            let to = column_mut(words, group[0]);
            let a = column(wides, group[1]);
            // A test has one operand, a comparison two.
            let b = column(wides, *group.last().expect("a group has operands"));
            for lane in 0..LANES {
                let (a, b) = (a[lane], b[lane]);
                to[lane] = match op {
                    Op::DCmp(cmp) => u32::from(cmp.holds(real(a), real(b))),
                    Op::DCmpSint(cmp) => u32::from(cmp.holds(a as i64, b as i64)),
                    Op::DCmpUint(cmp) => u32::from(cmp.holds(a, b)),
                    Op::DTest(Test::IsNan) => u32::from(real(a).is_nan()),
                    _ => u32::from(real(a).is_infinite()),
                };
            }
            continue;
        }
        let (to, others) = apart(wides, group[0]);
        for (lane, to) in to.iter_mut().enumerate() {
            let x = |i: usize| others.column(group[i])[lane];
            *to = match op {
                Op::D1(f) => apply1(f, real(x(1))).to_bits(),
                Op::DNeg => x(1).wrapping_neg(),
                Op::DNot => !x(1),
                Op::WideBinary(WideBinary::Float(f)) => apply2(f, real(x(1)), real(x(2))).to_bits(),
                Op::WideBinary(WideBinary::Int(f)) => binary_wide(f, x(1), x(2)),
                Op::D3(f) => float3(f, real(x(1)), real(x(2)), real(x(3))).to_bits(),
                Op::DAbsSint => (x(1) as i64).wrapping_abs() as u64,
                Op::DSignSint => (x(1) as i64).signum() as u64,
                Op::DDot(n) => {
                    let n = usize::from(n);
                    let product = |i: usize| real(x(1 + i)) * real(x(1 + n + i));
                    (1..n).fold(product(0), |sum, i| sum + product(i)).to_bits()
                }
                other => unreachable!("{other:?} is not of doubles"),
            };
        }
    }
}
