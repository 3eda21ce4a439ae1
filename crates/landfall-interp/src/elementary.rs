//! Powers, exponentials, logarithms, sines and cosines over columns of `f32`, in wide registers.
//!
//! Each is computed in `f64` by a series whose relative error stays below [`ERROR`]. Where every
//! number that close rounds to the same `f32`, so does the result of the C library's function,
//! which errs by 2^-52: the bits are those of the scalar function. The other lanes, and arguments
//! beyond the range of the series, are left to the scalar function.

use pulp::{Arch, NullaryFnOnce};
use std::f64::consts::{FRAC_2_PI, LN_2, LOG2_E};

use super::code::{LANES, RealBinary, RealUnary};
use super::lanes::lanes_of;

/// Bound of the relative error of all series: 2^-36, at least four times what their last terms and
/// roundings add up to. A result in doubt is one in about 4,000.
const ERROR: f64 = 1.0 / (1u64 << 36) as f64;

/// A result, and whether its arguments are in the range of the series.
type Series = (f64, bool);

/// Computes a function of one operand in all lanes; returns the lanes it leaves.
pub(super) fn function1(arch: Arch, f: RealUnary, to: &mut [f32; LANES], a: &[f32; LANES]) -> u64 {
    match has_fused(arch) {
        true => fused_or_not1::<true>(arch, f, to, a),
        false => fused_or_not1::<false>(arch, f, to, a),
    }
}

fn fused_or_not1<const FUSED: bool>(
    arch: Arch,
    f: RealUnary,
    to: &mut [f32; LANES],
    a: &[f32; LANES],
) -> u64 {
    match f {
        RealUnary::Exp => each(arch, to, a, a, |x, _| exponential::<FUSED>(x * LOG2_E)),
        RealUnary::Exp2 => each(arch, to, a, a, |x, _| exponential::<FUSED>(x)),
        RealUnary::Log => each(arch, to, a, a, |x, _| (log2::<FUSED>(x) * LN_2, is_positive(x))),
        RealUnary::Log2 => each(arch, to, a, a, |x, _| (log2::<FUSED>(x), is_positive(x))),
        RealUnary::Sin => each(arch, to, a, a, |x, _| sine::<FUSED>(x, 0)),
        RealUnary::Cos => each(arch, to, a, a, |x, _| sine::<FUSED>(x, 1)),
        _ => u64::MAX,
    }
}

/// Computes a function of two operands in all lanes; returns the lanes it leaves.
pub(super) fn function2(
    arch: Arch,
    f: RealBinary,
    to: &mut [f32; LANES],
    a: &[f32; LANES],
    b: &[f32; LANES],
) -> u64 {
    if let (RealBinary::Pow, Some(exponent)) = (f, whole(b)) {
        return each_power(arch, to, a, exponent);
    }
    match (f, has_fused(arch)) {
        (RealBinary::Pow, true) => each(arch, to, a, b, power::<true>),
        (RealBinary::Pow, false) => each(arch, to, a, b, power::<false>),
        _ => u64::MAX,
    }
}

/// Whether code for these registers multiplies and adds by one instruction. The results are the same,
/// as the bound of the error holds for both.
fn has_fused(arch: Arch) -> bool {
    cfg!(any(target_arch = "x86", target_arch = "x86_64", target_arch = "aarch64"))
        && !matches!(arch, Arch::Scalar)
}

struct Each<'c, F> {
    to: &'c mut [f32; LANES],
    doubts: &'c mut [u32; LANES],
    a: &'c [f32; LANES],
    b: &'c [f32; LANES],
    f: F,
}

impl<F: Fn(f64, f64) -> Series> NullaryFnOnce for Each<'_, F> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for lane in 0..LANES {
            let (y, fits) = (self.f)(f64::from(self.a[lane]), f64::from(self.b[lane]));
            // If all numbers within the error round to one `f32`, it is the result.
            let (low, high) = ((y - y * ERROR) as f32, (y + y * ERROR) as f32);
            self.to[lane] = high;
            self.doubts[lane] = u32::from(!(fits & (low == high)));
        }
    }
}

#[inline(never)]
fn each(
    arch: Arch,
    to: &mut [f32; LANES],
    a: &[f32; LANES],
    b: &[f32; LANES],
    f: impl Fn(f64, f64) -> Series,
) -> u64 {
    let mut doubts = [0; LANES];
    arch.dispatch(Each { to, doubts: &mut doubts, a, b, f });
    lanes_of(&doubts)
}

/// Returns the whole number from 1 to 1024 that all lanes hold: of a power by multiplications, whose
/// 20 roundings grow by the exponent, the relative error is below 2^-42.
fn whole(b: &[f32; LANES]) -> Option<u32> {
    let first = b[0];
    let is_whole = first.fract() == 0.0 && (1.0..=1024.0).contains(&first);
    let differ = b.iter().fold(0, |bits, x| bits | (x.to_bits() ^ first.to_bits()));
    (is_whole && differ == 0).then_some(first as u32)
}

struct EachPower<'c> {
    to: &'c mut [f32; LANES],
    doubts: &'c mut [u32; LANES],
    a: &'c [f32; LANES],
    exponent: u32,
}

impl NullaryFnOnce for EachPower<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (mut power, mut square) = ([1.0; LANES], [0.0; LANES]);
        for (square, x) in square.iter_mut().zip(self.a) {
            *square = f64::from(*x);
        }
        // Squares and multiplications by the bits of the exponent, which all lanes share.
        let mut left = self.exponent;
        loop {
            if left & 1 == 1 {
                for (power, square) in power.iter_mut().zip(&square) {
                    *power *= square;
                }
            }
            left >>= 1;
            if left == 0 {
                break;
            }
            for number in &mut square {
                *number *= *number;
            }
        }
        for (lane, y) in power.into_iter().enumerate() {
            let x = self.a[lane];
            let (low, high) = ((y - y * ERROR) as f32, (y + y * ERROR) as f32);
            // Normal, zero, or less than half of the least `f32`.
            let fits = (y > LEAST) & (y < 1.0 / LEAST) | (y < VANISHING);
            let positive = (x > 0.0) | (x.to_bits() == 0);
            self.to[lane] = high;
            self.doubts[lane] = u32::from(!(positive & fits & (low == high)));
        }
    }
}

/// 2^-125, and 2^-160.
const LEAST: f64 = f64::from_bits((1023 - 125) << 52);
const VANISHING: f64 = f64::from_bits((1023 - 160) << 52);

#[inline(never)]
fn each_power(arch: Arch, to: &mut [f32; LANES], a: &[f32; LANES], exponent: u32) -> u64 {
    let mut doubts = [0; LANES];
    arch.dispatch(EachPower { to, doubts: &mut doubts, a, exponent });
    lanes_of(&doubts)
}

#[inline(always)]
fn is_positive(x: f64) -> bool {
    (x > 0.0) & (x < f64::INFINITY)
}

/// The bits of 2^52, whose last ones are a whole number's.
const WHOLE: u64 = 0x4330_0000_0000_0000;

/// Returns the binary logarithm of a positive number: its exponent, and twice the series of the
/// inverse hyperbolic tangent, for a fraction from the root of 1/2 to the root of 2.
#[inline(always)]
fn log2<const FUSED: bool>(x: f64) -> f64 {
    const ROOT: u64 = 0x3fe6_a09e_0000_0000;
    const FRACTION: u64 = (1 << 52) - 1;
    // Moved so that the exponent field counts from the root of 1/2 instead of from 1: the fraction
    // stays close to 1, where few terms suffice.
    let shifted = x.to_bits().wrapping_add(1f64.to_bits() - ROOT);
    let exponent = f64::from_bits(shifted >> 52 | WHOLE) - (f64::from_bits(WHOLE) + 1023.0);
    let fraction = f64::from_bits((shifted & FRACTION) + ROOT);
    let s = (fraction - 1.0) / (fraction + 1.0);
    let z = s * s;
    // The next term, z^8 / 17, is 2^-44.
    exponent + s * polynomial::<FUSED, _>(z, LOGARITHM)
}

/// Returns the coefficients' polynomial, the highest power first.
#[inline(always)]
fn polynomial<const FUSED: bool, const N: usize>(x: f64, coefficients: [f64; N]) -> f64 {
    let mut sum = coefficients[0];
    for coefficient in &coefficients[1..] {
        sum = if FUSED { sum.mul_add(x, *coefficient) } else { sum * x + coefficient };
    }
    sum
}

/// Returns 2^p, where that is a normal `f32` or less than half of the least one.
#[inline(always)]
fn exponential<const FUSED: bool>(p: f64) -> Series {
    let vanishes = p < -160.0;
    (if vanishes { 0.0 } else { exp2::<FUSED>(p) }, vanishes | (p.abs() < 125.0))
}

/// Returns 2^p for |p| < 1000: the power of the nearest whole number, and the series of the
/// exponential function for the rest.
#[inline(always)]
fn exp2<const FUSED: bool>(p: f64) -> f64 {
    let (shifted, whole) = nearest(p);
    let t = (p - whole) * LN_2;
    let power = f64::from_bits((shifted << 52).wrapping_add(1f64.to_bits()));
    // The next term, t^11 / 11!, is 2^-42.
    power * polynomial::<FUSED, _>(t, EXPONENTIAL)
}

/// 2 / ln 2 / n for n = 15, 13, … 1.
const LOGARITHM: [f64; 8] = {
    let mut all = [0.0; 8];
    let mut i = 0;
    while i < 8 {
        all[i] = 2.0 * LOG2_E / (15 - 2 * i) as f64;
        i += 1;
    }
    all
};

/// 1/n! for n = 10, 9, … 0.
const EXPONENTIAL: [f64; 11] = inverse_factorials(10, 1, 1.0);
/// -1^n / (2 n + 1)! and -1^n / (2 n)! for n = 6, 5, … 0.
const SINE: [f64; 7] = inverse_factorials(13, 2, -1.0);
const COSINE: [f64; 7] = inverse_factorials(12, 2, -1.0);

/// Returns the inverse factorials of `most` and every `step`-th number below it, each of another
/// sign than the next if `sign` is negative; the last one is positive.
const fn inverse_factorials<const N: usize>(most: usize, step: usize, sign: f64) -> [f64; N] {
    let mut all = [1.0; N];
    let (mut i, mut factorial, mut n) = (N, 1.0, 0);
    while i > 0 {
        i -= 1;
        // The factorials below 23! are exact.
        while n < most - step * i {
            n += 1;
            factorial *= n as f64;
        }
        let negative = sign < 0.0 && (N - 1 - i) % 2 == 1;
        all[i] = if negative { -1.0 / factorial } else { 1.0 / factorial };
    }
    all
}

/// Returns the nearest whole number, and a word whose last bits are its.
#[inline(always)]
fn nearest(x: f64) -> (u64, f64) {
    // Numbers from 2^52 to 2^53 are whole.
    let shift = 1.5 * f64::from_bits(WHOLE);
    let shifted = x + shift;
    (shifted.to_bits(), shifted - shift)
}

#[inline(always)]
fn power<const FUSED: bool>(x: f64, y: f64) -> Series {
    let p = y * log2::<FUSED>(x);
    let is_zero = (x.to_bits() == 0) & (y > 0.0);
    // Less than half of the least `f32`.
    let vanishes = is_positive(x) & (p < -160.0);
    let result = exp2::<FUSED>(p);
    let gone = is_zero | vanishes;
    (if gone { 0.0 } else { result }, gone | (is_positive(x) & (p.abs() < 125.0)))
}

/// A right angle in three parts, the first two of 33 bits: their products with a quadrant below 2^20
/// are exact.
const RIGHT: [f64; 3] =
    [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];

/// Returns a sine or cosine with the sign that it has in a quadrant.
#[inline(always)]
fn turned(value: f64, quadrant: u64) -> f64 {
    // The third and fourth quadrants have the other sign: bit 1 of the number becomes the sign.
    f64::from_bits(value.to_bits() ^ (quadrant & 2) << 62)
}

/// Returns the sine of a number plus so many right angles.
#[inline(always)]
fn sine<const FUSED: bool>(x: f64, angles: u64) -> Series {
    let (word, quadrant) = nearest(x * FRAC_2_PI);
    // In the parts of Cody and Waite, so that the large products cancel without a rounding.
    let rest = x - quadrant * RIGHT[0] - quadrant * RIGHT[1] - quadrant * RIGHT[2];
    let z = rest * rest;
    // The next terms, z^7 / 15! and z^7 / 14!, are at most 2^-44 and 2^-40.
    let sine = rest * polynomial::<FUSED, _>(z, SINE);
    let cosine = polynomial::<FUSED, _>(z, COSINE);
    // The quadrants alternate between the two series.
    let word = word.wrapping_add(angles);
    let value = if word & 1 == 0 { sine } else { cosine };
    // Close to a multiple of a right angle, few digits of the rest are left.
    let digits = (rest.abs() > 1.0 / 65536.0) | (quadrant == 0.0);
    (turned(value, word), digits & (x.abs() < 1_000_000.0))
}
