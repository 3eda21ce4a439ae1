//! The proven error of interpolating a light over a rectangle of a plane.
//!
//! Through `m` Chebyshev nodes along a side of half length `H`, a function errs by at most
//! `2 (H / 2)^m |f_m|`, `f_m` being the `m`th coefficient of its Taylor series along that side at
//! any point; over both sides by `E_x + L E_y`, `L` being Lebesgue's constant.
//!
//! Body: of `s = r^2`, `1 / (c + l r + q r^2)` is the inverse of a complete Bernstein function, so a sum
//! of `1 / (s + z)` with positive weights and `z >= 0`, and that over `r` one of `(s + z)^(-3/2)`
//! (Schilling, Song, Vondracek, *Bernstein Functions*, theorem 7.3). The Taylor coefficients of those
//! along a line are Gegenbauer polynomials of the cosine `t` between the line and the direction to the
//! light, which `z` makes smaller, over powers of `r`, which it makes larger: of order `m` at most
//! `|C_m(t')| / r^m` of the function, with the worst `|t'| <= |t|`. On a plane `n . (D - x)` is constant.
//!
//! Highlight: a function from 0 to `M` errs by at most half of `M (1 + L^2)`. Or by Cauchy's estimate on
//! discs of radius `R` around real points. There the angles of `D - x` and of the mirrored view turn by
//! complex numbers of absolute values that sum to at most `q = sin a / (1 - a) + sin' b / (1 - b)`,
//! `a = R / d`, `b = R / e`, with the sines of their angles to the side; for turns of `X + i Y` the
//! cosine of the angle between them has the bound of [`cosine`].
//!
//! Bounds are computed in `f32`, of several lights at once. Coordinates are those of the plane, whose
//! rounding counts as distance from it; angles are made smaller by the error of their approximation;
//! the hundred roundings of a bound, raised to the power of the highlight, are within one percent.

use glam::DVec3;
use pulp::{Simd, WithSimd};

use super::lamps::{COMPONENTS, Lamps};
use crate::lanes::Lanes;

mod gegenbauer;

use gegenbauer::Gegenbauer;

/// Larger than the error of [`angle`] and of its subtractions.
const ANGLE: f32 = 1e-4;

/// The factor above all relative errors of `f32`.
const MORE: f32 = 1.01;

/// The part of a distance by which its `f32` may be too large.
const FARTHER: f32 = 1.0 / (1 << 20) as f32;

/// The distance up to which no square overflows.
const FARTHEST: f32 = 1e15;

/// A rectangle of a plane, in coordinates along the plane's axes and normal.
pub(super) struct Rectangle {
    pub center: [f64; 2],
    /// Half its length along each axis.
    pub half: [f64; 2],
    /// The camera.
    pub eye: DVec3,
    /// The largest distance of a fragment or node from its place on the plane.
    pub off: f64,
    /// The largest error of a coordinate.
    pub rounding: f64,
    /// The largest difference of a unit normal from that of the plane.
    pub tilt: f64,
}

impl Rectangle {
    pub fn diameter(&self) -> f64 {
        2.0 * self.half[0].hypot(self.half[1])
    }
}

/// What is done with the light of a lamp.
pub(super) struct Shading {
    pub shininess: f64,
    /// Whether surfaces that face away have highlights.
    pub everywhere: bool,
}

/// The constants of interpolation through `m` nodes a side, 2 to 6.
pub(super) struct Order {
    m: u32,
    /// The bounds of the `m`th terms of the attenuation, and of that over the distance.
    terms: [Gegenbauer; 2],
    lebesgue: f64,
}

impl Order {
    pub fn new(nodes: u32) -> Order {
        let lebesgue = 1.0 + 2.0 / std::f64::consts::PI * f64::from(nodes).ln();
        Order { m: nodes, terms: [1.0, 1.5].map(|of| Gegenbauer::new(nodes, of)), lebesgue }
    }

    /// Writes the largest error of any channel for each lamp: infinite or NaN if unknown, and infinite
    /// if more than `most` without a highlight. Returns whether one is at most `most`.
    pub fn errors(
        &self,
        lamps: &Lamps,
        at: &Rectangle,
        shading: &Shading,
        most: f32,
        into: &mut Errors,
    ) -> bool {
        let Errors { errors, highlights, indices, some, better } = into;
        let Some(bound) = Bound::new(self, at, shading, most) else { return false };
        let arch = pulp::Arch::new();
        let mut any = arch.dispatch(BySize { bound: &bound, lamps, errors, highlights });
        if !bound.whole {
            return any;
        }
        // Discs take longest: for the few lamps that might be taken by them.
        indices.clear();
        let both = errors.iter().zip(highlights.iter()).enumerate();
        let wants = |(error, highlight): (&f32, &f32)| {
            *highlight > most * 1e-3 && *error - *highlight <= most
        };
        indices.extend(both.filter(|(_, both)| wants(*both)).map(|(at, _)| at as u32));
        if !indices.is_empty() {
            lamps.copy(indices, some);
            any |= arch.dispatch(ByDiscs { bound: &bound, lamps: some, errors: better });
            for (at, better) in indices.iter().zip(better) {
                errors[*at as usize] = *better;
            }
        }
        any
    }
}

/// The errors of lamps, and memory for computing them.
#[derive(Default)]
pub(super) struct Errors {
    pub errors: Vec<f32>,
    /// The parts that are highlights.
    highlights: Vec<f32>,
    /// The lamps whose highlights are bounded by discs.
    indices: Vec<u32>,
    some: Lamps,
    better: Vec<f32>,
}

/// Writes the errors of lamps, and the parts of them that are highlights, whose bounds are by size.
struct BySize<'a> {
    bound: &'a Bound,
    lamps: &'a Lamps,
    errors: &'a mut Vec<f32>,
    highlights: &'a mut Vec<f32>,
}

/// Writes the errors of lamps with highlights by discs.
struct ByDiscs<'a> {
    bound: &'a Bound,
    lamps: &'a Lamps,
    errors: &'a mut Vec<f32>,
}

impl WithSimd for BySize<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let BySize { bound, lamps, errors, highlights } = self;
        errors.resize(lamps.len(), 0.0);
        highlights.resize(lamps.len(), 0.0);
        let mut any = false;
        let chunks = errors.chunks_mut(S::F32_LANES).zip(highlights.chunks_mut(S::F32_LANES));
        for (chunk, (errors, highlights)) in chunks.enumerate() {
            let light = lamps.load(simd, chunk * S::F32_LANES, errors.len());
            let [error, highlight] = bound.of(light, false);
            any |= error.less(error.splat(bound.most.next_up())).any();
            error.store(errors);
            highlight.store(highlights);
        }
        any
    }
}

impl WithSimd for ByDiscs<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let ByDiscs { bound, lamps, errors } = self;
        errors.resize(lamps.len(), 0.0);
        let mut any = false;
        for (chunk, errors) in errors.chunks_mut(S::F32_LANES).enumerate() {
            let light = lamps.load(simd, chunk * S::F32_LANES, errors.len());
            let [error, _] = bound.of(light, true);
            any |= error.less(error.splat(bound.most.next_up())).any();
            error.store(errors);
        }
        any
    }
}

/// What the errors of all lamps over a rectangle have in common.
struct Bound {
    center: [f32; 2],
    half: [f32; 2],
    off: f32,
    /// The largest error of a distance.
    margin: f32,
    tilt: f32,
    /// The distance of the camera, inverted.
    eye: f32,
    /// The largest sines of the angles of the view to the sides.
    eye_sines: [f32; 2],
    /// The direction of the mirrored view at the centre.
    mirrored: [f32; 3],
    radius: f32,
    m: u32,
    terms: [Gegenbauer; 2],
    lebesgue: f32,
    /// The factor of an error at points and nodes.
    twice: f32,
    shininess: f32,
    /// The power of the highlight, not above `shininess`.
    exponent: u32,
    /// Whether `shininess` is `exponent`.
    whole: bool,
    /// The turn of the highlight by its discs.
    turn: f32,
    everywhere: bool,
    most: f32,
}

impl Bound {
    /// Returns `None` if no error is known.
    fn new(order: &Order, at: &Rectangle, shading: &Shading, most: f32) -> Option<Bound> {
        let margin = at.off + at.rounding;
        let beyond = |axis: usize| {
            ((at.eye.to_array()[axis] - at.center[axis]).abs() - at.half[axis]).max(0.0)
        };
        let over = at.eye.z;
        let eye = beyond(0).hypot(beyond(1)).hypot(over) * (1.0 - 1e-9) - margin;
        let known = eye > 0.0 && over.abs() > margin && shading.shininess >= 0.0;
        if !known || !(eye + at.half[0] + at.half[1]).is_finite() {
            return None;
        }
        let view = at.eye - DVec3::new(at.center[0], at.center[1], 0.0);
        let mirrored = DVec3::new(-view.x, -view.y, view.z).normalize();
        let sine = |axis: usize| {
            let across = view.to_array()[1 - axis].abs() + at.half[1 - axis];
            let across = across.hypot(over) + margin;
            across / across.hypot((beyond(axis) - margin).max(0.0))
        };
        let exponent = shading.shininess.floor().min(1024.0);
        let whole = exponent >= 1.0 && exponent == shading.shininess;
        let best = (f64::from(order.m) / shading.shininess).sqrt();
        Some(Bound {
            center: at.center.map(|x| x as f32),
            half: at.half.map(|x| x as f32),
            off: at.off as f32,
            margin: margin as f32,
            tilt: at.tilt as f32,
            eye: (1.0 / eye) as f32,
            eye_sines: [sine(0) as f32, sine(1) as f32],
            mirrored: mirrored.to_array().map(|x| x as f32),
            radius: (at.half[0].hypot(at.half[1]) + margin) as f32,
            m: order.m,
            terms: order.terms,
            lebesgue: order.lebesgue as f32,
            twice: (1.0 + order.lebesgue * order.lebesgue) as f32,
            shininess: shading.shininess as f32,
            exponent: exponent as u32,
            whole,
            turn: (best * 0.8) as f32,
            everywhere: shading.everywhere,
            most,
        })
    }

    /// Returns the error of the body over both sides.
    #[inline(always)]
    fn body<S: Simd>(
        &self,
        terms: &Gegenbauer,
        inverse: Lanes<S>,
        [x, y]: [Lanes<S>; 2],
    ) -> Lanes<S> {
        let [width, height] = self.half;
        let x = (inverse * (0.5 * width)).powi(self.m) * terms.most(x);
        let y = (inverse * (0.5 * height)).powi(self.m) * terms.most(y);
        self.both([x, y]) * 2.0
    }

    /// Returns the error over both sides.
    #[inline(always)]
    fn both<S: Simd>(&self, [x, y]: [Lanes<S>; 2]) -> Lanes<S> {
        x.max(y) + x.min(y) * self.lebesgue
    }

    #[inline(always)]
    fn of<S: Simd>(&self, light: [Lanes<S>; COMPONENTS], discs: bool) -> [Lanes<S>; 2] {
        let [x, y, height, c, l, q, ambient, diffuse, specular, radius] = light;
        let lamp = [c, l, q];
        let (zero, unknown) = (x.splat(0.0), x.splat(f32::INFINITY));
        let (x, y) = (x - self.center[0], y - self.center[1]);
        let beyond_x = (x.abs() - self.half[0]).max(zero);
        let beyond_y = (y.abs() - self.half[1]).max(zero);
        let square = beyond_x * beyond_x + beyond_y * beyond_y + height * height;
        let d = square.sqrt() * (1.0 - FARTHER) - radius - self.margin;
        let slack = (d + radius * 2.0) * self.tilt + self.margin;
        // The side of the plane is the same everywhere, in `f32` too.
        let known = zero
            .less(d)
            .and(d.less(d.splat(FARTHEST)))
            .and((slack + radius + (d + radius * 2.0) * 1e-5).less(height.abs() * (1.0 - FARTHER)));
        let inverse = 1.0 / d;
        let weight = weight(lamp, d);
        let ends = [x.abs() + self.half[0], y.abs() + self.half[1]];
        let within = radius + self.margin;
        let above = height * height;
        let across = [beyond_y * beyond_y + above, beyond_x * beyond_x + above];
        let cosines = [
            squared_cosine(ends[0], across[0], within, [d, inverse]),
            squared_cosine(ends[1], across[1], within, [d, inverse]),
        ];
        // Points off the plane and normals off its own, nodes among them: twice for the polynomial.
        let moved = inverse * self.off;
        let faces = zero.less(height);
        let facing = (height + radius + slack) * inverse;
        let body = self.body(&self.terms[1], inverse, cosines) * facing;
        let body = faces.select(diffuse * (body + (moved * 4.0 + self.tilt) * self.twice), zero)
            + ambient * (self.body(&self.terms[0], inverse, cosines) + moved * (2.0 * self.twice));
        let body = known.select(body * weight, unknown);
        if !body.less(body.splat(self.most)).any() {
            return [unknown, zero];
        }
        let [mx, my, mz] = self.mirrored;
        let along = x * mx + y * my + height * mz;
        let length = (x * x + y * y + height * height).sqrt();
        let angle = angle(along / length);
        // What fragments and nodes off their places turn both by, what the rectangle does, and the
        // angle under which several lamps are seen: the arc sine is below its secant.
        let turned = moved + (4.0 * self.tilt + self.off * self.eye);
        let turn = (inverse + self.eye) * self.radius + turned;
        let turn = turn + (radius / length * std::f32::consts::FRAC_PI_2 + ANGLE);
        let least = (angle - turn).max(zero);
        let square = least * least;
        // Above the cosine, up to a right angle.
        let most = (1.0 - square * (0.5 - square * (1.0 / 24.0))).max(zero);
        let most = least.less(zero + std::f32::consts::FRAC_PI_2).select(most, zero);
        let mut shine = most.powi(self.exponent) * weight * (0.5 * self.twice);
        if discs {
            let sines = [
                sine(beyond_x, (ends[1], height), within),
                sine(beyond_y, (ends[0], height), within),
            ];
            let slope = most.powi(self.exponent.saturating_sub(1));
            let flat = slope * (turned * self.shininess + moved * 2.0) * weight * self.twice;
            let by_discs = self.highlight(least, sines, lamp, [d, inverse]) + flat;
            // Where it is not clamped, a whole power is a polynomial of the cosine.
            let smooth = (angle + turn).less(zero + 1.57);
            shine = smooth.select(by_discs, shine).min(shine);
        }
        let shine = match self.everywhere {
            true => specular * shine,
            false => faces.select(specular * shine, zero),
        };
        [(body + shine) * MORE + f32::MIN_POSITIVE, shine * MORE]
    }

    /// Returns the error of a highlight of strength 1 by discs, of points of the plane; infinite or NaN
    /// if that is none.
    #[inline(always)]
    fn highlight<S: Simd>(
        &self,
        least: Lanes<S>,
        sines: [Lanes<S>; 2],
        lamp: [Lanes<S>; 3],
        distance: [Lanes<S>; 2],
    ) -> Lanes<S> {
        let mut sides = sines;
        for (axis, side) in sides.iter_mut().enumerate() {
            let angles = (least, sines[axis]);
            *side = self.by_discs(self.turn, axis, angles, lamp, distance);
        }
        self.both(sides)
    }

    /// Returns the error along a side by discs that turn the angle by `q` at most; infinite or NaN if
    /// that is none.
    #[inline(always)]
    fn by_discs<S: Simd>(
        &self,
        q: f32,
        axis: usize,
        (least, sine): (Lanes<S>, Lanes<S>),
        lamp: [Lanes<S>; 3],
        [d, inverse]: [Lanes<S>; 2],
    ) -> Lanes<S> {
        let one = d.splat(1.0);
        let eye = self.eye_sines[axis];
        let nearer = inverse.max(d.splat(self.eye));
        let radius = (q / (sine * inverse + eye * self.eye + nearer * q)).min(d * 0.8);
        let (a, b) = (radius * inverse, radius * self.eye);
        let q = sine * a / (1.0 - a) + b * eye / (1.0 - b);
        let known = b.less(one).and(q.less(one));
        let weight = weight(lamp, d * (1.0 - a)) / (1.0 - a * a).sqrt();
        let power = cosine(least, q).sqrt().powi(self.exponent);
        let bound = (0.5 * self.half[axis] / radius).powi(self.m) * 2.0 * power * weight;
        known.select(bound, d.splat(f32::INFINITY))
    }
}

/// Returns the squared cosine of the smallest angle to a side of a rectangle, in which lamps `within`
/// that distance are seen at most so far along it and at least the root of `across` to its side, and
/// at least at a distance `d`.
#[inline(always)]
fn squared_cosine<S: Simd>(
    along: Lanes<S>,
    across: Lanes<S>,
    within: Lanes<S>,
    [d, inverse]: [Lanes<S>; 2],
) -> Lanes<S> {
    let along = along + within;
    // (x - w)^2 >= x^2 - 2 x w >= x^2 - w (x^2 / d + d), without a root.
    let across = (across - within * (across * inverse + d)).max(across.splat(0.0));
    let square = along * along;
    (square / (square + across)).min(square.splat(1.0))
}

/// Returns the sine of the largest angle to a side of lamps seen at least so far along it and at most
/// so far across and above.
#[inline(always)]
fn sine<S: Simd>(
    along: Lanes<S>,
    (across, height): (Lanes<S>, Lanes<S>),
    within: Lanes<S>,
) -> Lanes<S> {
    let along = (along - within).max(along.splat(0.0));
    let across = (across * across + height * height).sqrt() + within;
    across / (across * across + along * along).sqrt()
}

/// Returns the attenuation at a distance.
#[inline(always)]
fn weight<S: Simd>([c, l, q]: [Lanes<S>; 3], d: Lanes<S>) -> Lanes<S> {
    1.0 / (c + d * (l + q * d))
}

/// Returns the angle of a cosine, 7e-5 off at most (Abramowitz and Stegun, 4.4.45).
#[inline(always)]
fn angle<S: Simd>(cosine: Lanes<S>) -> Lanes<S> {
    let x = cosine.abs().min(cosine.splat(1.0));
    let series = x * (x * (x * -0.018_729_3 + 0.074_261) - 0.212_114_4) + 1.570_728_8;
    let acute = (1.0 - x).sqrt() * series;
    cosine.less(x.splat(0.0)).select(std::f32::consts::PI - acute, acute)
}

/// Returns the largest squared absolute value of the cosine of an angle of at least `least` that
/// turns by `X + i Y`, `X^2 + Y^2 <= q^2`, `q <= 1`: for directions in space
/// `(B cosh Y + (1 - B) (cosh Y - 1) / 2)^2 + (1 - B^2) sinh^2 Y`, `B = cos(least - X)`, which grows
/// with `B` and `Y`; each of three parts of `Y` has the bound of its ends. Series stand for cosines,
/// above them.
#[inline(always)]
fn cosine<S: Simd>(least: Lanes<S>, q: Lanes<S>) -> Lanes<S> {
    let first = cosine_part(least, q, 0.0);
    let second = cosine_part(least, q, 1.0 / 3.0);
    first.max(second).max(cosine_part(least, q, 2.0 / 3.0))
}

/// Returns the bound for `Y` between that part of `q` and a third more.
#[inline(always)]
fn cosine_part<S: Simd>(least: Lanes<S>, q: Lanes<S>, part: f32) -> Lanes<S> {
    let zero = q.splat(0.0);
    let low = q * part;
    let high = q * (part + 1.0 / 3.0);
    let real = (least - (q * q - low * low).max(zero).sqrt()).max(zero);
    let square = real * real;
    let real = (1.0 - square * (0.5 - square * (1.0 / 24.0))).clamp(0.0, 1.0);
    // The rest of the series is less than Y^4 / 600 up to 1.
    let square = high * high;
    let above = square * (square * (1.0 / 23.0) + 0.5);
    let cosh = above + 1.0;
    let grown = real * cosh + (1.0 - real) * above * 0.5;
    grown * grown + (1.0 - real * real) * (cosh * cosh - 1.0)
}

#[cfg(test)]
mod tests;
