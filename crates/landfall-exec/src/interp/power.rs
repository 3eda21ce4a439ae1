//! Powers with a whole exponent over columns of `f64`, in wide registers.
//!
//! Each is computed as the sum of two `f64`, to about 2^-90. The first of them is the number nearest
//! to the power; where the second is so small that no other number is within the error of the C
//! library's function, that function returns it too. The other lanes are left to the scalar function.
//! glibc and musl state their error (`e_pow.c`, `pow.c`): 0.511 units in the last place and, for each
//! unit of the power's logarithm, 1.5 * 2^-15. With other libraries all lanes are left.

use pulp::{Arch, NullaryFnOnce};

use super::code::LANES;
use super::elementary::has_fused;
use super::lanes::lanes_of;

/// What the second number is multiplied by before it is rounded away: 1 / (1 - 2 e) for errors of up
/// to 1/2 + e units, here 0.515 for powers near 1 and 0.555 for others.
const DOUBT: [f64; 2] = [1.032, 1.125];

/// The least power near 1, of which 0.511 + 69.4 * 1.5 * 2^-15 is 0.5142; its inverse is the largest.
const NEAR: f64 = f64::from_bits((1023 - 100) << 52);

/// The largest exponent: the relative error grows by it.
const MOST: f64 = 1024.0;

/// The least power of which both parts have all their bits; its inverse is the largest.
const LEAST: f64 = f64::from_bits((1023 - 900) << 52);

/// Computes powers in all lanes; returns the lanes it leaves to the scalar function.
pub(super) fn powers(arch: Arch, to: &mut [f64; LANES], a: &[f64; LANES], b: &[f64; LANES]) -> u64 {
    match whole(b) {
        Some(exponent) if is_quick(arch) => {
            let mut doubts = [0; LANES];
            arch.dispatch(Powers { to, doubts: &mut doubts, a, exponent });
            lanes_of(&doubts)
        }
        _ => u64::MAX,
    }
}

/// Whether the error of the C library is known, and the processor multiplies and adds by one
/// instruction.
fn is_quick(arch: Arch) -> bool {
    cfg!(all(target_os = "linux", any(target_env = "gnu", target_env = "musl"))) && has_fused(arch)
}

/// Returns the whole number from 1 to [`MOST`] that all lanes hold.
fn whole(b: &[f64; LANES]) -> Option<u32> {
    let first = b[0];
    let is_whole = first.fract() == 0.0 && (1.0..=MOST).contains(&first);
    let differ = b.iter().fold(0, |bits, x| bits | (x.to_bits() ^ first.to_bits()));
    (is_whole && differ == 0).then_some(first as u32)
}

struct Powers<'c> {
    to: &'c mut [f64; LANES],
    doubts: &'c mut [u32; LANES],
    a: &'c [f64; LANES],
    exponent: u32,
}

/// Sums of two numbers in all lanes, the first of which is the nearest number to the sum.
struct Sums {
    high: [f64; LANES],
    low: [f64; LANES],
}

impl Sums {
    #[inline(always)]
    fn one() -> Sums {
        Sums { high: [1.0; LANES], low: [0.0; LANES] }
    }

    #[inline(always)]
    fn multiply(&mut self, by: &Sums) {
        for lane in 0..LANES {
            let (a, b) = ((self.high[lane], self.low[lane]), (by.high[lane], by.low[lane]));
            (self.high[lane], self.low[lane]) = product(a, b);
        }
    }

    #[inline(always)]
    fn square(&mut self) {
        for lane in 0..LANES {
            let a = (self.high[lane], self.low[lane]);
            (self.high[lane], self.low[lane]) = product(a, a);
        }
    }
}

/// Returns the product of two sums of two numbers, as one.
#[inline(always)]
pub(super) fn product(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    let high = a.0 * b.0;
    let low = a.0.mul_add(b.0, -high) + a.0.mul_add(b.1, a.1 * b.0);
    let sum = high + low;
    (sum, low - (sum - high))
}

impl NullaryFnOnce for Powers<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (mut power, mut square) = (Sums::one(), Sums::one());
        square.high = *self.a;
        let mut left = self.exponent;
        loop {
            if left & 1 == 1 {
                power.multiply(&square);
            }
            left >>= 1;
            if left == 0 {
                break;
            }
            square.square();
        }
        for lane in 0..LANES {
            let (x, high, low) = (self.a[lane], power.high[lane], power.low[lane]);
            let is_zero = x.to_bits() == 0;
            let fits = (high > LEAST) & (high < 1.0 / LEAST);
            let is_near = (high > NEAR) & (high < 1.0 / NEAR);
            let doubt = if is_near { DOUBT[0] } else { DOUBT[1] };
            let sure = fits & (low * doubt + high == high);
            self.to[lane] = if is_zero { 0.0 } else { high };
            self.doubts[lane] = u32::from(!(is_zero | (x > 0.0) & sure));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_have_the_bits_of_the_scalar_ones() {
        let mut rng = fastrand::Rng::with_seed(5);
        let special = [0.0, -0.0, 1.0, -1.0, 2.0, 0.5, f64::INFINITY, f64::NAN, 5e-324, f64::MAX];
        let mut left = 0;
        for round in 0..6000 {
            let exponent = [2, 5, 32, 64, 256, 1 + round % 1024][round % 6] as f64;
            let a: [f64; LANES] = std::array::from_fn(|_| match round % 8 {
                0 => special[rng.usize(..special.len())],
                1 => f64::from_bits(rng.u64(..)),
                2 => 4.0 * rng.f64(),
                _ => 1.0 - 0.5 * rng.f64(),
            });
            let mut to = [0.0; LANES];
            let rest = powers(Arch::new(), &mut to, &a, &[exponent; LANES]);
            if round % 8 > 2 {
                left += rest.count_ones() as usize;
            }
            for lane in (0..LANES).filter(|lane| rest >> lane & 1 == 0) {
                let expected = a[lane].powf(exponent);
                let same = to[lane].to_bits() == expected.to_bits();
                assert!(same, "pow({:e}, {exponent}) = {:e}", a[lane], to[lane]);
            }
        }
        if is_quick(Arch::new()) {
            assert!(left < 6000 * LANES / 32, "{left} are left");
        }
    }

    #[test]
    fn other_exponents_are_left_to_the_scalar_function() {
        let mut to = [0.0; LANES];
        let mut differ = [3.0; LANES];
        differ[9] = 4.0;
        for b in [[2.2; LANES], [0.0; LANES], [-2.0; LANES], [1025.0; LANES], differ] {
            assert_eq!(powers(Arch::new(), &mut to, &[0.5; LANES], &b), u64::MAX);
        }
    }
}
