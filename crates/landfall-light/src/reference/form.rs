//! The formulas of lighting in numerically stable forms.
//!
//! Used by [`light`](super::light). A cosine near 1 is stored as its distance from 1: half the
//! squared chord between two unit vectors. Lengths need no scaling here: an `f64` holds the square
//! of any `f32` and of any difference of two.

use glam::DVec3;

use super::model::Window;
use super::undef::UndefinedReason;
use crate::scene::Attenuation;
use landfall_ir::analysis::hazard::threshold::{COORDINATE, LENGTH};
use landfall_ir::analysis::undefined::condition::{self, direction, division};

/// Cosines closer than this are equal once rounded: `f32` numbers below 1 are 6e-8 apart. A cone
/// with equal angles divides 0 by 0 there, and nowhere else.
const EQUAL: f64 = 1e-7;

pub(super) fn unit(v: DVec3) -> Result<DVec3, UndefinedReason> {
    let length = v.length();
    // `direction` is the condition of `normalize`, shared with traces and lints: what is undefined
    // for a shader is undefined here.
    match length {
        _ if !length.is_finite() => Err(UndefinedReason::NotFinite),
        _ if direction(length.into()).is_some() => Err(UndefinedReason::ZeroVector),
        _ => Ok(v / length),
    }
}

/// Returns a length whose square a shader can represent; `zero` if there is none.
pub(super) fn distance(
    v: DVec3,
    zero: UndefinedReason,
    near: UndefinedReason,
) -> Result<f64, UndefinedReason> {
    let d = v.length();
    // Squares below LENGTH^2 underflow and those above COORDINATE^2 overflow `f32`, so that a
    // shader has no distance there, although `f64` has.
    match d {
        _ if d.is_nan() => Err(UndefinedReason::NotFinite),
        _ if direction(d.into()).is_some() => Err(zero),
        _ if d < LENGTH.value => Err(near),
        _ if d > COORDINATE.value => Err(UndefinedReason::TooFar),
        _ => Ok(d),
    }
}

// |a - b|^2 = 2 - 2 a.b for unit vectors. `1 - a.b` would lose all digits of a small angle.
pub(super) fn chord(a: DVec3, b: DVec3) -> f64 {
    (a - b).length_squared() * 0.5
}

/// Returns `max(1 - m, 0)` to the power of `n`.
pub(super) fn power(m: f64, n: f64) -> Result<f64, UndefinedReason> {
    match m {
        // (1 - m)^n = exp(n ln(1 - m)), and `ln_1p` has the digits of a small `m`.
        _ if m < 1.0 => Ok((n * (-m).ln_1p()).exp()),
        // From here on `m >= 1`: the base is 0, and `pow(0, n)` is undefined for `n <= 0` (GLSL
        // 4.60 §8.2).
        _ if m.is_nan() || n.is_nan() => Err(UndefinedReason::NotFinite),
        _ if condition::power(0.0.into(), n.into())[1].is_none() => Ok(0.0),
        _ if n == 0.0 => Err(UndefinedReason::ZeroToZero),
        _ => Err(UndefinedReason::ZeroToNegative),
    }
}

/// Returns the squared length of a vector of `f32`s, minus one: such products are exact, and the
/// rounding error of their sum is added back.
pub(super) fn squared_less_one(v: DVec3) -> f64 {
    // The product of two `f32`s has at most 48 bits and is exact in `f64`; -1 goes first, where it
    // cancels.
    let (first, lost) = two_sum(v.x * v.x, -1.0);
    let (second, more) = two_sum(first, v.y * v.y);
    let (third, most) = two_sum(second, v.z * v.z);
    third + (lost + more + most)
}

pub(super) fn attenuation(a: &Attenuation, window: Window, d: f64) -> Result<f64, UndefinedReason> {
    let divisor = a.constant + d * (a.linear + a.quadratic * d);
    if !(divisor > 0.0 && divisor.is_finite()) {
        return Err(UndefinedReason::Attenuation);
    }
    // A scene's range is positive, so `q` is a number.
    let kept = match (window, a.range) {
        (Window::None, _) | (Window::Quartic, None) => 1.0,
        (Window::Quartic, Some(range)) => {
            let q = d / range;
            // 1 - q^4 by its factors, the difference first.
            let less = ((range - d) / range * (1.0 + q) * (1.0 + q * q)).max(0.0);
            less * less
        }
    };
    Ok(kept / divisor)
}

/// Returns one minus the cosine of the angle between two vectors of any length.
pub(super) fn off_axis(to_light: DVec3, axis: DVec3) -> Result<f64, UndefinedReason> {
    // By the chord from 1e-3 on (2.6 degrees), where its relative error is below 1e-12.
    let m = chord(unit(to_light)?, unit(axis)?);
    if m > 1e-3 {
        return Ok(m);
    }
    // Near the axis the difference of unit vectors is mostly rounding error; the cross product of
    // the original vectors is not.
    let cross = DVec3::new(
        difference(to_light.y, axis.z, to_light.z, axis.y),
        difference(to_light.z, axis.x, to_light.x, axis.z),
        difference(to_light.x, axis.y, to_light.y, axis.x),
    );
    // |cross|^2 = |to|^2 |axis|^2 sin^2, and 1 - cos = sin^2 / (1 + cos).
    let sine = cross.length_squared() / (to_light.length_squared() * axis.length_squared());
    Ok(sine / (1.0 + (1.0 - sine).sqrt()))
}

/// Returns the ramp between two angles, each given as one minus its cosine.
pub(super) fn ramp(m: f64, outer: f64, inner: f64) -> Result<f64, UndefinedReason> {
    // `division` is the condition of a quotient: equal angles divide by zero, and the ramp is a
    // step.
    if division((outer - inner).into()).is_none() {
        return Ok(((outer - m) / (outer - inner)).clamp(0.0, 1.0));
    }
    match m - outer {
        // Within EQUAL of the step a shader's rounding decides the side: no number is right there.
        near if near.abs() < EQUAL => Err(UndefinedReason::EqualCones),
        past => Ok(if past < 0.0 { 1.0 } else { 0.0 }),
    }
}

/// Returns the ramp from one angle to the axis.
pub(super) fn ramp_to_axis(m: f64, outer: f64) -> Result<f64, UndefinedReason> {
    match outer {
        _ if division(outer.into()).is_some() => Err(UndefinedReason::ZeroCone),
        _ if m < outer => Ok(((outer - m) / outer).clamp(0.0, 1.0)),
        _ => Ok(0.0),
    }
}

/// Returns `a b - c d` to within two units of its last place (Kahan).
fn difference(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let product = c * d;
    let lost = (-c).mul_add(d, product);
    a.mul_add(b, -product) + lost
}

/// Returns a sum and its rounding error (Knuth).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}
