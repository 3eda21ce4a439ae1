//! Sines and cosines over columns of `f64`, in wide registers.
//!
//! Each is computed as the sum of two `f64`, to about 2^-60. The first of them is the number nearest to
//! the result; where the second is so small that no other number is within the error of the C
//! library's function, that function returns it too. The other lanes, and arguments beyond the range
//! of the series, are left to the scalar function. glibc states an error of 0.548 units in the last
//! place at most (`s_sin.c`). With other libraries all lanes are left.

use pulp::{Arch, NullaryFnOnce};
use std::f64::consts::FRAC_2_PI;

use super::code::{F1, LANES};
use super::elementary::{RIGHT, has_fused, inverse_factorials, nearest, polynomial, turned};
use super::lanes::lanes_of;
use super::power::product;

/// A number as the sum of two, the first of which is the nearest one.
type Sum = (f64, f64);

/// What the second number is multiplied by before it is rounded away: 1 / (1 - 2 e) for errors of up
/// to 1/2 + e units, e the library's 0.048 and at most 0.014 of the series.
const DOUBT: f64 = 1.142;

/// 1/3!, rounded down by a third of 2^-55, and 1/4!, a quarter of it.
const SIXTH: Sum = (1.0 / 6.0, f64::from_bits((1023 - 55) << 52) / 3.0);
const TWENTY_FOURTH: Sum = (SIXTH.0 / 4.0, SIXTH.1 / 4.0);

/// -1^n / (2 n + 1)! for n = 8, 7, … 2: the next term is 2^-63 of the sine.
const SINE: [f64; 7] = inverse_factorials(17, 2, -1.0);
/// -1^(n + 1) / (2 n)! for n = 9, 8, … 3: the next term is 2^-67 of the cosine.
const COSINE: [f64; 7] = inverse_factorials(18, 2, -1.0);

/// Computes a function of one operand in all lanes; returns the lanes it leaves to the scalar one.
pub(super) fn circular(arch: Arch, f: F1, to: &mut [f64; LANES], a: &[f64; LANES]) -> u64 {
    let angles = match f {
        F1::Sin => 0,
        F1::Cos => 1,
        _ => return u64::MAX,
    };
    if !is_quick(arch) {
        return u64::MAX;
    }
    let mut doubts = [0; LANES];
    arch.dispatch(Circular { to, doubts: &mut doubts, a, angles });
    lanes_of(&doubts)
}

/// Whether the error of the C library is known, and the processor multiplies and adds by one
/// instruction.
fn is_quick(arch: Arch) -> bool {
    cfg!(all(target_os = "linux", target_env = "gnu")) && has_fused(arch)
}

struct Circular<'c> {
    to: &'c mut [f64; LANES],
    doubts: &'c mut [u32; LANES],
    a: &'c [f64; LANES],
    /// The right angles to add.
    angles: u64,
}

impl NullaryFnOnce for Circular<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for lane in 0..LANES {
            let x = self.a[lane];
            let (word, quadrant) = nearest(x * FRAC_2_PI);
            let rest = rest(x, quadrant);
            let square = product(rest, rest);
            let (sine, cosine) = (sine(rest, square), cosine(square));
            let word = word.wrapping_add(self.angles);
            let (high, low) = if word & 1 == 0 { sine } else { cosine };
            // Close to a multiple of a right angle, few digits of the rest are left.
            let digits = (rest.0.abs() > 1.0 / 65536.0) | (quadrant == 0.0);
            let fits = digits & (x.abs() < 1_000_000.0) & (x != 0.0);
            self.to[lane] = turned(high, word);
            self.doubts[lane] = u32::from(!(fits & (low * DOUBT + high == high)));
        }
    }
}

/// Returns a number less so many right angles.
#[inline(always)]
fn rest(x: f64, quadrant: f64) -> Sum {
    // Both are exact: the parts have 33 bits, and what is left of the number fits.
    let (a, b) = (x - quadrant * RIGHT[0], -quadrant * RIGHT[1]);
    let sum = a + b;
    let of_b = sum - a;
    let error = (a - (sum - of_b)) + (b - of_b);
    quick_sum(sum, error - quadrant * RIGHT[2])
}

/// Returns the sum of two numbers, the first of which is the larger one.
#[inline(always)]
fn quick_sum(a: f64, b: f64) -> Sum {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// The same for two sums.
#[inline(always)]
fn add(a: Sum, b: Sum) -> Sum {
    let (sum, error) = quick_sum(a.0, b.0);
    quick_sum(sum, error + (a.1 + b.1))
}

/// Returns `r - r^3 (1/3! - r^2 (1/5! - …))`.
#[inline(always)]
fn sine(rest: Sum, square: Sum) -> Sum {
    let more = square.0 * polynomial::<true, _>(square.0, SINE);
    let factor = add((-SIXTH.0, -SIXTH.1), (more, 0.0));
    add(rest, product(product(rest, square), factor))
}

/// Returns `1 - r^2 / 2 + r^4 (1/4! - r^2 (1/6! - …))`.
#[inline(always)]
fn cosine(square: Sum) -> Sum {
    let more = -square.0 * polynomial::<true, _>(square.0, COSINE);
    let factor = add(TWENTY_FOURTH, (more, 0.0));
    let start = add((1.0, 0.0), (-0.5 * square.0, -0.5 * square.1));
    add(start, product(product(square, square), factor))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns how many lanes are left, after the others are found to have the bits of the scalar
    /// function.
    fn left(columns: usize, number: impl Fn(&mut fastrand::Rng) -> f64) -> usize {
        let mut rng = fastrand::Rng::with_seed(3);
        let mut left = 0;
        for _ in 0..columns {
            let a = [0; LANES].map(|_| number(&mut rng));
            for (f, scalar) in [(F1::Sin, f64::sin as fn(f64) -> f64), (F1::Cos, f64::cos)] {
                let mut to = [0.0; LANES];
                let rest = circular(Arch::new(), f, &mut to, &a);
                left += rest.count_ones() as usize;
                for lane in (0..LANES).filter(|lane| rest >> lane & 1 == 0) {
                    let expected = scalar(a[lane]);
                    let same = to[lane].to_bits() == expected.to_bits();
                    assert!(same, "{f:?}({:e}) = {:e}, not {expected:e}", a[lane], to[lane]);
                }
            }
        }
        left
    }

    #[test]
    fn usual_numbers_have_the_bits_of_the_scalar_functions() {
        let left = left(20_000, |rng| 40.0 * rng.f64() - 20.0);
        if is_quick(Arch::new()) {
            assert!(left < 40_000 * LANES / 7, "{left} are left");
        }
    }

    #[test]
    fn any_number_has_the_bits_of_the_scalar_functions() {
        left(2000, |rng| f64::from_bits(rng.u64(..)));
        left(2000, |rng| (2e6 * rng.f64() - 1e6) * rng.f64());
        left(2000, |rng| [0.0, -0.0, f64::INFINITY, f64::NAN, 5e-324, 1e-160][rng.usize(..6)]);
        // Multiples of a right angle, and what is beside them.
        left(2000, |rng| {
            let angle = f64::from(rng.i32(-600_000..600_000)) * std::f64::consts::FRAC_PI_2;
            f64::from_bits(angle.to_bits().wrapping_add(rng.u64(..1 << 24)).wrapping_sub(1 << 23))
        });
    }
}
