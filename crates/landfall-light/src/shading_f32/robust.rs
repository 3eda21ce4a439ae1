//! The lights of a fragment in more accurate and faster forms.
//!
//! One inverse square root per light gives both direction and distance; the attenuation uses
//! Horner's method; the cone is a chord, `1 - cos = |l - axis|^2 / 2`, which is accurate for narrow
//! cones; the view is reflected once per fragment instead of per light; integer powers are
//! squarings; the material multiplies sums. Gates skip terms that are exactly zero and, if
//! requested, powers below a threshold.

use glam::Vec3;

use super::{Directional, Lights, Model, Point, Power, Spot, Surface, Tally, TermColors};
use crate::reference::SpecularGate;

/// The squared distance below which a light has no direction, as in the shaders: that of 1e-15,
/// below which the reference leaves it undefined.
pub(super) const NEAREST: f32 = 1e-30;

/// The terms skipped for a light without effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gates {
    /// Everything outside its cone: exact.
    pub cone: bool,
    /// The power where the surface faces away, if the model counts it there at all: exact. Also
    /// where the base of the power is below the surface's gate: an error of at most that gate times
    /// the specular colours.
    pub power: bool,
    /// Everything outside its window: exact.
    pub window: bool,
}

impl Gates {
    pub const ALL: Gates = Gates { cone: true, power: true, window: true };
    pub const NONE: Gates = Gates { cone: false, power: false, window: false };
}

/// Returns the light that a fragment sends to `eye`.
#[inline]
pub fn shade<T: Tally>(
    surface: &Surface,
    eye: Vec3,
    lights: &Lights,
    model: &Model,
    gates: Gates,
    tally: &mut T,
) -> Vec3 {
    let normal = unit(surface.normal);
    let view = unit(eye - surface.position);
    // Reflecting the view instead of each light: l.reflect(v) = v.reflect(l) for a unit normal.
    let reflected = 2.0 * normal.dot(view) * normal - view;
    let at = RobustState { surface, normal, reflected, gates, facing: model.specular };
    let mut sums = LightSums { body: Vec3::ZERO, shine: Vec3::ZERO };
    for light in &lights.directional {
        tally.trip();
        directional(&at, light, &mut sums, tally);
    }
    for light in &lights.point {
        tally.trip();
        point(&at, light, &mut sums, tally);
    }
    for light in &lights.spot {
        tally.trip();
        spot(&at, light, &mut sums, tally);
    }
    // Colours of the material are factors of every light's terms and multiply once, at the end.
    lights.ambient * surface.ambient + sums.body * surface.diffuse + sums.shine * surface.specular
}

struct RobustState<'a> {
    surface: &'a Surface,
    normal: Vec3,
    reflected: Vec3,
    gates: Gates,
    facing: SpecularGate,
}

/// The sums that multiply the material's ambient and diffuse, and its specular, colours.
struct LightSums {
    body: Vec3,
    shine: Vec3,
}

#[inline]
fn directional<T: Tally>(
    at: &RobustState<'_>,
    light: &Directional,
    sums: &mut LightSums,
    tally: &mut T,
) {
    tally.evaluation();
    add(at, light.towards, 1.0, &light.emission, sums, tally);
}

#[inline]
fn point<T: Tally>(at: &RobustState<'_>, light: &Point, sums: &mut LightSums, tally: &mut T) {
    let to = light.position - at.surface.position;
    let square = to.dot(to);
    // `square / range^2 >= 1` before the root is taken: most lights of a large scene end here.
    if at.gates.window && light.range > 0.0 && square * light.inverse_square_range >= 1.0 {
        return;
    }
    // `max` keeps the division finite at the light: `to * inverse` is then 0, or short.
    let inverse = 1.0 / square.max(NEAREST).sqrt();
    tally.evaluation();
    tally.attenuation();
    let weight = attenuation(light, square, inverse);
    add(at, to * inverse, weight, &light.emission, sums, tally);
}

#[inline]
fn spot<T: Tally>(at: &RobustState<'_>, light: &Spot, sums: &mut LightSums, tally: &mut T) {
    let to = light.point.position - at.surface.position;
    let square = to.dot(to);
    let inverse = 1.0 / square.max(NEAREST).sqrt();
    let towards = to * inverse;
    let chord = towards - light.axis;
    // (outer - m) / (outer - inner) with m = 1 - cos = |l - axis|^2 / 2 and the quotient
    // precomputed.
    let cone = ((light.outer_chord - 0.5 * chord.dot(chord)) * light.ramp).clamp(0.0, 1.0);
    if at.gates.cone && cone <= 0.0 {
        return;
    }
    tally.evaluation();
    tally.attenuation();
    let weight = attenuation(&light.point, square, inverse) * cone;
    add(at, towards, weight, &light.point.emission, sums, tally);
}

#[inline(always)]
fn attenuation(light: &Point, square: f32, inverse: f32) -> f32 {
    let distance = square * inverse;
    let weight = 1.0 / (light.constant + distance * (light.linear + light.quadratic * distance));
    if light.range > 0.0 {
        let ratio = square * light.inverse_square_range;
        // (d / range)^4 as the square of d^2 / range^2.
        let window = (1.0 - ratio * ratio).max(0.0);
        return weight * window * window;
    }
    weight
}

#[inline(always)]
fn add<T: Tally>(
    at: &RobustState<'_>,
    towards: Vec3,
    weight: f32,
    emission: &TermColors,
    sums: &mut LightSums,
    tally: &mut T,
) {
    let facing = at.normal.dot(towards).max(0.0);
    sums.body += (emission.ambient + emission.diffuse * facing) * weight;
    let behind = at.facing == SpecularGate::Facing && facing <= 0.0;
    let base = towards.dot(at.reflected).clamp(0.0, 1.0);
    // `base <= gate` also for a gate of 0: 0 to a positive power adds nothing.
    if behind || (at.gates.power && base <= at.surface.gate) {
        return;
    }
    tally.power();
    let shine = raise(at, base, towards);
    sums.shine += emission.specular * (shine * weight);
}

#[inline(always)]
fn raise(at: &RobustState<'_>, base: f32, towards: Vec3) -> f32 {
    match at.surface.power {
        Power::Squarings(times) => (0..times).fold(base, |power, _| power * power),
        Power::Whole(exponent) => integer_power(base, exponent),
        Power::Chord => chord(towards - at.reflected, at.surface.shininess),
    }
}

// Squaring and multiplying: at most 16 products for an exponent up to 256, accurate to a few
// units, where `pow` of a GPU is exp2(n log2(x)).
fn integer_power(base: f32, exponent: u32) -> f32 {
    let (mut power, mut square, mut left) = (1.0, base, exponent);
    while left > 0 {
        if left & 1 == 1 {
            power *= square;
        }
        square *= square;
        left >>= 1;
    }
    power
}

#[cold]
fn chord(across: Vec3, shininess: f32) -> f32 {
    // `1 - cos` of the angle, as the reference computes it: accurate for a high exponent near the
    // peak.
    let m = 0.5 * across.dot(across);
    if m >= 1.0 { 0.0 } else { (shininess * (-m).ln_1p()).exp() }
}

#[inline(always)]
fn unit(v: Vec3) -> Vec3 {
    v * (1.0 / v.dot(v).max(NEAREST).sqrt())
}
