//! Doubles and 64-bit integers: operations in their own width, whatever the precision of the run.

use super::super::code::{
    Cmp, LANES, Op, RealBinary, RealTernary, RealUnary, Test, WideBinary, WordBinary,
};
use super::super::real::Real;
use super::float::{mix, pow, simple1, smoothstep, step, transcendental};
use super::{Aligned, apart, column, column_mut};

pub(super) fn int(f: WordBinary, a: u64, b: u64) -> u64 {
    let (x, y) = (a as i64, b as i64);
    match f {
        WordBinary::Add => a.wrapping_add(b),
        WordBinary::Sub => a.wrapping_sub(b),
        WordBinary::Mul => a.wrapping_mul(b),
        WordBinary::DivSint => (if y == 0 { x } else { x.wrapping_div(y) }) as u64,
        WordBinary::DivUint => a.checked_div(b).unwrap_or(a),
        WordBinary::RemSint => (if y == 0 { 0 } else { x.wrapping_rem(y) }) as u64,
        WordBinary::RemUint => a.checked_rem(b).unwrap_or(0),
        WordBinary::And => a & b,
        WordBinary::Or => a | b,
        WordBinary::Xor => a ^ b,
        // The low six bits of an amount count.
        WordBinary::Shl => a.wrapping_shl(b as u32),
        WordBinary::ShrSint => x.wrapping_shr(b as u32) as u64,
        WordBinary::ShrUint => a.wrapping_shr(b as u32),
        WordBinary::MinSint => x.min(y) as u64,
        WordBinary::MinUint => a.min(b),
        WordBinary::MaxSint => x.max(y) as u64,
        WordBinary::MaxUint => a.max(b),
        // Defined for packed words only.
        WordBinary::Dot4Sint | WordBinary::Dot4Uint => 0,
    }
}

fn float1(f: RealUnary, x: f64) -> f64 {
    simple1::<f64>(f).map_or_else(|| transcendental(f, x), |f| f(x))
}

fn float2(f: RealBinary, a: f64, b: f64) -> f64 {
    match f {
        RealBinary::Add => a + b,
        RealBinary::Sub => a - b,
        RealBinary::Mul => a * b,
        RealBinary::Div => a / b,
        RealBinary::Rem => a % b,
        RealBinary::Min => Real::min(a, b),
        RealBinary::Max => Real::max(a, b),
        RealBinary::Step => step(a, b),
        RealBinary::Pow => pow(a, b),
        RealBinary::Atan2 => a.atan2(b),
    }
}

fn float3(f: RealTernary, a: f64, b: f64, c: f64) -> f64 {
    match f {
        RealTernary::Fma => a.mul_add(b, c),
        RealTernary::Mix => mix(a, b, c),
        RealTernary::Clamp => Real::min(Real::max(a, b), c),
        RealTernary::SmoothStep => smoothstep(a, b, c),
    }
}

fn compare<T: PartialOrd>(cmp: Cmp, a: T, b: T) -> u32 {
    u32::from(match cmp {
        Cmp::Eq => a == b,
        Cmp::Ne => a != b,
        Cmp::Lt => a < b,
        Cmp::Le => a <= b,
        Cmp::Gt => a > b,
        Cmp::Ge => a >= b,
    })
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
                    Op::DCmp(cmp) => compare(cmp, real(a), real(b)),
                    Op::DCmpSint(cmp) => compare(cmp, a as i64, b as i64),
                    Op::DCmpUint(cmp) => compare(cmp, a, b),
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
                Op::D1(f) => float1(f, real(x(1))).to_bits(),
                Op::DNeg => x(1).wrapping_neg(),
                Op::DNot => !x(1),
                Op::WideBinary(WideBinary::Float(f)) => float2(f, real(x(1)), real(x(2))).to_bits(),
                Op::WideBinary(WideBinary::Int(f)) => int(f, x(1), x(2)),
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
