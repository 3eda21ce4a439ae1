//! Floats of fewer than 32 bits, which Rust has no types for: conversion to and from bits.
//!
//! IEEE 754 binary16, bfloat16 and E5M2 differ only in the widths of their fields; E4M3 has no
//! infinity. The two 8-bit formats are those of the OCP 8-bit floating point specification 1.0, §5.

use std::cmp::Ordering;

use crate::shape::{Scalar, ScalarKind};

/// Widths of the exponent and mantissa of a float in IEEE 754 layout.
#[derive(Clone, Copy)]
struct Fields {
    exponent: u32,
    mantissa: u32,
}

const BINARY16: Fields = Fields { exponent: 5, mantissa: 10 };
const BFLOAT16: Fields = Fields { exponent: 8, mantissa: 7 };

impl Fields {
    fn bias(self) -> i32 {
        (1 << (self.exponent - 1)) - 1
    }

    /// The bits of infinity: every exponent bit set.
    fn infinity(self) -> u64 {
        ((1 << self.exponent) - 1) << self.mantissa
    }

    /// Returns the bits of the nearest float, ties to even; a NaN keeps its upper bits.
    fn narrow(self, number: f64) -> u64 {
        let bits = number.to_bits();
        let sign = (bits >> 63) << (self.exponent + self.mantissa);
        // Quiet, so that a NaN whose payload is cut off does not become an infinity.
        if number.is_nan() {
            let payload = (bits & ((1 << 52) - 1)) >> (52 - self.mantissa);
            return sign | self.infinity() | 1 << (self.mantissa - 1) | payload;
        }
        // The exponent of the last place: numbers below the smallest normal one share its exponent,
        // in `f64` (which gives -1023 here) as in the target.
        let exponent = ((bits >> 52 & 0x7ff) as i32 - 1023).max(1 - self.bias());
        if exponent > self.bias() {
            return sign | self.infinity();
        }
        let mantissa = self.mantissa as i32;
        // How many units in the last place the number has. Scaling by a power of two is exact.
        let steps = (number.abs() * 2f64.powi(mantissa - exponent)).round_ties_even() as u64;
        // The leading 1 of normal numbers is implied by the exponent; a carry goes into it.
        let magnitude = ((exponent + self.bias() - 1) as u64) << self.mantissa;
        // Rounding up past the largest finite number gives infinity by the same carry.
        sign | (magnitude + steps).min(self.infinity())
    }

    /// Returns the exact value of the bits.
    fn widen(self, bits: u64) -> f64 {
        let sign = bits >> (self.exponent + self.mantissa) & 1;
        let exponent = (bits & self.infinity()) >> self.mantissa;
        let mantissa = bits & ((1 << self.mantissa) - 1);
        // All exponent bits set: infinity or NaN. Otherwise subnormal numbers, of exponent 0, have
        // the scale of exponent 1 and no leading 1.
        let magnitude = match exponent << self.mantissa == self.infinity() {
            true if mantissa == 0 => f64::INFINITY,
            true => f64::from_bits(0x7ff8 << 48 | mantissa << (52 - self.mantissa)),
            false => {
                let leading = if exponent == 0 { 0 } else { 1 << self.mantissa };
                let scale = exponent.max(1) as i32 - self.bias() - self.mantissa as i32;
                (leading + mantissa) as f64 * 2f64.powi(scale)
            }
        };
        f64::from_bits(magnitude.to_bits() | sign << 63)
    }
}

/// The largest finite E4M3: bias 7, no infinity, and only the mantissa of all ones is a NaN.
const E4M3_MAX: u8 = 0x7e;
/// The largest finite E5M2: the upper half of a binary16.
const E5M2_MAX: u8 = 0x7b;

/// Returns the bits of the nearest component, ties to even; past the largest number infinity, or
/// NaN in E4M3, which has no infinity. 0 for integers and bools.
pub(crate) fn narrow(scalar: Scalar, number: f64) -> u64 {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 8) => number.to_bits(),
        (ScalarKind::Float, 2) => BINARY16.narrow(number),
        (ScalarKind::Float, _) => (number as f32).to_bits().into(),
        (ScalarKind::Bfloat, _) => BFLOAT16.narrow(number),
        (ScalarKind::FloatE5m2, _) => nearest(scalar, number, E5M2_MAX, 0x7c).into(),
        (ScalarKind::FloatE4m3, _) => nearest(scalar, number, E4M3_MAX, 0x7f).into(),
        (ScalarKind::Bool | ScalarKind::Sint | ScalarKind::Uint, _) => 0,
    }
}

/// Rounds a number to `f32` by round-to-odd, so that rounding to fewer bits afterwards is as exact
/// as in one step. `from_f64` of `half` 2.7.1 drops the lower 32 bits instead, so that a number
/// just above the middle of two rounds the wrong way.
pub fn round_to_odd(number: f64) -> f32 {
    let near = number as f32;
    let bits = near.to_bits();
    // If a nonzero part is cut off, the last bit is set: that number lies on no tie of a format
    // with fewer bits. Where `near` is above the number, the number cut off is one less, and it is
    // either odd already or set to `near` again.
    match f64::from(near).abs().total_cmp(&number.abs()) {
        Ordering::Less => f32::from_bits(bits | 1),
        Ordering::Greater if bits & 1 == 0 && !near.is_nan() => f32::from_bits(bits - 1),
        Ordering::Equal | Ordering::Greater => near,
    }
}

/// Returns the exact value of a float component's bits; for integers and bools, the bits.
pub(crate) fn widen(scalar: Scalar, bits: u64) -> f64 {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 8) => f64::from_bits(bits),
        (ScalarKind::Float, 2) => BINARY16.widen(bits),
        (ScalarKind::Float, _) => f32::from_bits(bits as u32).into(),
        (ScalarKind::Bfloat, _) => BFLOAT16.widen(bits),
        // E5M2 is the upper half of a binary16.
        (ScalarKind::FloatE5m2, _) => BINARY16.widen(bits << 8),
        // E4M3: bias 7; subnormal numbers are multiples of 2^-9.
        (ScalarKind::FloatE4m3, _) => {
            let sign = if bits & 0x80 == 0 { 1.0 } else { -1.0 };
            let (exponent, mantissa) = ((bits >> 3 & 15) as i32, (bits & 7) as f64);
            let magnitude = match (exponent, bits & 7) {
                (15, 7) => f64::NAN,
                (0, _) => mantissa / 8.0 * 2f64.powi(-6),
                _ => (1.0 + mantissa / 8.0) * 2f64.powi(exponent - 7),
            };
            sign * magnitude
        }
        (ScalarKind::Bool | ScalarKind::Sint | ScalarKind::Uint, _) => bits as f64,
    }
}

/// Returns the unit in the last place of the `f32` nearest to a number; past the largest, that of
/// the largest.
pub fn last_place(number: f64) -> f64 {
    // Subnormal numbers have the unit of the smallest normal one. An `f32` has 23 bits after the
    // leading one, and exponents up to 127.
    let magnitude = number.abs().max(f64::from(f32::MIN_POSITIVE));
    let exponent = (magnitude.to_bits() >> 52) as i32 - 1023;
    f64::powi(2.0, exponent.min(127) - 23)
}

/// Returns the bits of the quiet NaN that `"nan"` denotes; `None` for integers and bools.
pub(crate) fn quiet_nan(scalar: Scalar) -> Option<u64> {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 8) => Some(0x7ff8 << 48),
        (ScalarKind::Float, 2) => Some(0x7e00),
        (ScalarKind::Float, _) => Some(0x7fc0_0000),
        (ScalarKind::Bfloat, _) => Some(0x7fc0),
        (ScalarKind::FloatE5m2, _) => Some(0x7e),
        (ScalarKind::FloatE4m3, _) => Some(0x7f),
        (ScalarKind::Bool | ScalarKind::Sint | ScalarKind::Uint, _) => None,
    }
}

/// Returns the nearest 8-bit float: `max` is the largest finite one, `over` the result past it.
fn nearest(scalar: Scalar, number: f64, max: u8, over: u8) -> u8 {
    let sign = if number.is_sign_negative() { 0x80 } else { 0 };
    if number.is_nan() {
        return sign | quiet_nan(scalar).map_or(over, |bits| bits as u8);
    }
    let value = |bits: u8| widen(scalar, bits.into());
    let magnitude = number.abs();
    // Positive floats are ordered like their bits.
    let above = (0..=max).collect::<Vec<u8>>().partition_point(|&bits| value(bits) <= magnitude);
    // 0 is at most any magnitude, so that there is a float below.
    let below = above as u8 - 1;
    // Past the largest float, its own step decides whether the result is the float or `over`.
    let step =
        if below == max { value(max) - value(max - 1) } else { value(below + 1) - value(below) };
    let past = magnitude - value(below);
    // Of two equally near floats, whose bits differ by one, the one with even bits.
    let up = past > step / 2.0 || (past == step / 2.0 && below % 2 == 1);
    let bits = if !up {
        below
    } else if below == max {
        over
    } else {
        below + 1
    };
    sign | bits
}

#[cfg(test)]
mod tests {
    use super::*;

    const F16: Scalar = Scalar::F16;
    const BF16: Scalar = Scalar { kind: ScalarKind::Bfloat, width: 2 };
    const E5M2: Scalar = Scalar { kind: ScalarKind::FloatE5m2, width: 1 };
    const E4M3: Scalar = Scalar { kind: ScalarKind::FloatE4m3, width: 1 };

    #[test]
    fn known_numbers_have_the_bits_of_their_specifications() {
        // IEEE 754 binary16: 1, the largest, the smallest, 1/3.
        for (number, bits) in [(1.0, 0x3c00), (65504.0, 0x7bff), (2f64.powi(-24), 1)] {
            assert_eq!(narrow(F16, number), bits);
        }
        assert_eq!(narrow(F16, 1.0 / 3.0), 0x3555);
        assert_eq!(narrow(BF16, 1.0), 0x3f80);
        // OCP OFP8 table 2: largest, smallest normal, smallest subnormal of each.
        for (number, bits) in [(448.0, 0x7e), (2f64.powi(-6), 0x08), (2f64.powi(-9), 0x01)] {
            assert_eq!(narrow(E4M3, number), bits);
            assert_eq!(widen(E4M3, bits), number);
        }
        for (number, bits) in [(57344.0, 0x7b), (2f64.powi(-14), 0x04), (2f64.powi(-16), 0x01)] {
            assert_eq!(narrow(E5M2, number), bits);
            assert_eq!(widen(E5M2, bits), number);
        }
    }

    #[test]
    fn what_lies_just_above_the_middle_goes_up() {
        // The upper half of each interval begins 2^-40 above its middle, past the bits of an f32.
        let above = 2f64.powi(-40);
        assert_eq!(narrow(F16, 1.0 + 2f64.powi(-11) + above), 0x3c01);
        assert_eq!(narrow(F16, -1.0 - 2f64.powi(-11) - above), 0xbc01);
        assert_eq!(narrow(F16, 1.0 + 2f64.powi(-11) - above), 0x3c00);
        assert_eq!(narrow(F16, 2f64.powi(-25) * (1.0 + above)), 1);
        assert_eq!(narrow(BF16, 1.0 + 2f64.powi(-8) + above), 0x3f81);
        assert_eq!(narrow(BF16, 1.0 + 2f64.powi(-8) - above), 0x3f80);
        assert_eq!((round_to_odd(1e300), round_to_odd(f64::INFINITY)), (f32::MAX, f32::INFINITY));
    }

    #[test]
    fn random_numbers_have_the_bits_that_half_gives_them() {
        let mut random = fastrand::Rng::with_seed(3);
        for _ in 0..200_000 {
            // All exponents of a bfloat16 and a few beyond, with all bits of an f64.
            let exponent = random.u64(1023 - 140..1023 + 140) << 52;
            let number = f64::from_bits(random.u64(..) & (1 << 63 | ((1 << 52) - 1)) | exponent);
            let short = round_to_odd(number);
            assert_eq!(narrow(F16, number), u64::from(half::f16::from_f32_const(short).to_bits()));
            assert_eq!(
                narrow(BF16, number),
                u64::from(half::bf16::from_f32_const(short).to_bits())
            );
        }
        for bits in 0..=u16::MAX {
            let ours = [widen(F16, bits.into()), widen(BF16, bits.into())];
            let theirs =
                [half::f16::from_bits(bits).to_f64(), half::bf16::from_bits(bits).to_f64()];
            assert_eq!(ours.map(f64::to_bits), theirs.map(f64::to_bits), "{bits:#x}");
        }
    }

    #[test]
    fn ties_go_to_the_even_neighbour() {
        assert_eq!(narrow(F16, 1.0 + 2f64.powi(-11)), 0x3c00);
        assert_eq!(narrow(F16, 1.0 + 3.0 * 2f64.powi(-11)), 0x3c02);
        assert_eq!(narrow(E4M3, 1.0 + 1.0 / 16.0), 0x38);
        assert_eq!(narrow(E4M3, 1.0 + 3.0 / 16.0), 0x3a);
        assert_eq!(narrow(E5M2, -1.125), 0xbc);
    }

    #[test]
    fn beyond_the_largest_is_infinity_or_nan() {
        assert_eq!(narrow(F16, 65520.0), 0x7c00);
        assert_eq!(narrow(E5M2, 61440.0), 0x7c);
        assert_eq!(narrow(E5M2, f64::NEG_INFINITY), 0xfc);
        assert_eq!(narrow(E4M3, 464.0), 0x7e);
        assert_eq!(narrow(E4M3, 465.0), 0x7f);
        assert!(widen(E4M3, 0x7f).is_nan() && widen(E5M2, 0x7d).is_nan());
    }

    #[test]
    fn every_small_float_comes_back_from_its_number() {
        for scalar in [F16, BF16, E5M2, E4M3] {
            for bits in 0..1u64 << (8 * scalar.width) {
                let number = widen(scalar, bits);
                if !number.is_nan() {
                    assert_eq!(narrow(scalar, number), bits, "{scalar:?} {bits:#x}");
                }
            }
        }
    }
}
