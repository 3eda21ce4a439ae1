//! The proven error of interpolating a light over a rectangle of a plane.
//!
//! Through `m` Chebyshev nodes along a side of half length `H`, a function errs by at most
//! `2 (H / 2)^m |f_m|`, `f_m` being the `m`th coefficient of its Taylor series along that side at
//! any point; over both sides by `E_x + L E_y`, `L` being Lebesgue's constant.
//!
//! Body: with `r = |D - x|`, `d = |D|` and `y = |x| / d`, the terms of `r / d` of order `n` are
//! `(1 - t^2) P'_{n-1}(t) / (n (n - 1)) y^n`, at most [`ROOT`]. Each factor `1 / (r - z)` of the
//! attenuation, whose roots have `Re z <= 0` so that `|d - z| >= d`, has terms of at most those of
//! `1 / (|d - z| (1 - u))` with `u` the series of `ROOT`; `1 / r` has Legendre polynomials, at most
//! `1 / (1 - y)`. On a plane `n . (D - x)` is constant.
//!
//! Highlight: by Cauchy's estimate on discs of radius `R` around real points. There the angles of
//! `D - x` and of the mirrored view turn by complex numbers of absolute values that sum to at most
//! `q = a / (1 - a) + b / (1 - b)`, `a = R / d`, `b = R / e`; for turns of `X + i Y` the cosine of
//! the angle between them has the bound of [`cosine`].
//!
//! Bounds are computed in `f32`, of several lights at once. Coordinates are those of the plane, whose
//! rounding counts as distance from it; angles are made smaller by the error of their approximation;
//! the hundred roundings of a bound, raised to the power of the highlight, are within one percent.

use glam::DVec3;
use pulp::{Simd, WithSimd};

use super::lamps::{COMPONENTS, Lamps};
use crate::lanes::Lanes;

/// The largest coefficients of the series of a distance, from order 1.
const ROOT: [f64; 6] = [1.0, 0.5, 0.19246, 0.125, 0.083, 0.0625];

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
    /// The largest distance of a fragment or node from the plane, with the rounding of coordinates.
    pub off: f64,
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
    terms: [f64; 2],
    lebesgue: f64,
}

impl Order {
    pub fn new(nodes: u32) -> Order {
        let m = nodes as usize;
        // 1 / (1 - u), its square, and that over 1 - y.
        let mut one = vec![1.0];
        for n in 1..=m {
            let next: f64 = (1..=n).map(|k| ROOT[k - 1] * one[n - k]).sum();
            one.push(next);
        }
        let square: Vec<f64> =
            (0..=m).map(|n| (0..=n).map(|k| one[k] * one[n - k]).sum()).collect();
        let terms = [square[m], square.iter().sum()];
        let lebesgue = 1.0 + 2.0 / std::f64::consts::PI * (m as f64).ln();
        Order { m: nodes, terms, lebesgue }
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
    tilt: f32,
    /// The distance of the camera, inverted.
    eye: f32,
    /// The direction of the mirrored view at the centre.
    mirrored: [f32; 3],
    radius: f32,
    m: u32,
    terms: [f32; 2],
    lebesgue: f32,
    /// The factor of an error at points and nodes.
    twice: f32,
    shininess: f32,
    /// The power of the highlight, not above `shininess`.
    exponent: u32,
    /// Whether `shininess` is `exponent`.
    whole: bool,
    /// The turns of the highlight's discs to try.
    turns: [f32; 2],
    everywhere: bool,
    most: f32,
}

impl Bound {
    /// Returns `None` if no error is known.
    fn new(order: &Order, at: &Rectangle, shading: &Shading, most: f32) -> Option<Bound> {
        let beyond = |axis: usize| {
            ((at.eye.to_array()[axis] - at.center[axis]).abs() - at.half[axis]).max(0.0)
        };
        let over = at.eye.z;
        let eye = beyond(0).hypot(beyond(1)).hypot(over) * (1.0 - 1e-9) - at.off;
        let known = eye > 0.0 && over.abs() > at.off && shading.shininess >= 0.0;
        if !known || !(eye + at.half[0] + at.half[1]).is_finite() {
            return None;
        }
        let view = at.eye - DVec3::new(at.center[0], at.center[1], 0.0);
        let mirrored = DVec3::new(-view.x, -view.y, view.z).normalize();
        let exponent = shading.shininess.floor().min(1024.0);
        let whole = exponent >= 1.0 && exponent == shading.shininess;
        let best = (f64::from(order.m) / shading.shininess).sqrt();
        Some(Bound {
            center: at.center.map(|x| x as f32),
            half: at.half.map(|x| x as f32),
            off: at.off as f32,
            tilt: at.tilt as f32,
            eye: (1.0 / eye) as f32,
            mirrored: mirrored.to_array().map(|x| x as f32),
            radius: (at.half[0].hypot(at.half[1]) + at.off) as f32,
            m: order.m,
            terms: order.terms.map(|x| x as f32),
            lebesgue: order.lebesgue as f32,
            twice: (1.0 + order.lebesgue * order.lebesgue) as f32,
            shininess: shading.shininess as f32,
            exponent: exponent as u32,
            whole,
            turns: [0.7, 1.2].map(|part| (best * part) as f32),
            everywhere: shading.everywhere,
            most,
        })
    }

    /// Returns the error over both sides for terms of at most 1 by powers of `1 / scale`.
    #[inline(always)]
    fn both<S: Simd>(&self, inverse: Lanes<S>) -> Lanes<S> {
        let x = (inverse * (0.5 * self.half[0])).powi(self.m) * 2.0;
        let y = (inverse * (0.5 * self.half[1])).powi(self.m) * 2.0;
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
        let d = square.sqrt() * (1.0 - FARTHER) - radius - self.off;
        let slack = (d + radius * 2.0) * self.tilt + self.off;
        // The side of the plane is the same everywhere, in `f32` too.
        let known = zero
            .less(d)
            .and(d.less(d.splat(FARTHEST)))
            .and((slack + radius + (d + radius * 2.0) * 1e-5).less(height.abs() * (1.0 - FARTHER)));
        let inverse = 1.0 / d;
        let weight = weight(lamp, d);
        let both = self.both(inverse);
        // Points off the plane and normals off its own, nodes among them: twice for the polynomial.
        let moved = inverse * self.off;
        let faces = zero.less(height);
        let facing = (height + radius + slack) * inverse;
        let body = both * facing * self.terms[1] + (moved * 4.0 + self.tilt) * self.twice;
        let body = faces.select(diffuse * body, zero)
            + ambient * (both * self.terms[0] + moved * (2.0 * self.twice));
        let body = known.select(body * weight, unknown);
        if !body.less(body.splat(self.most)).any() {
            return [unknown, zero];
        }
        let turned = moved + (4.0 * self.tilt + self.off * self.eye);
        let flat = (turned * self.shininess + moved * 2.0) * weight * self.twice;
        let [mx, my, mz] = self.mirrored;
        let along = x * mx + y * my + height * mz;
        let length = (x * x + y * y + height * height).sqrt();
        // The angle under which several lamps are seen: the arc sine is below its secant.
        let spread = radius / length * std::f32::consts::FRAC_PI_2 + ANGLE;
        let angle = [angle(along / length), spread];
        let shine = self.highlight(angle, lamp, [d, inverse, weight], discs);
        let [flat, shine] = match self.everywhere {
            true => [specular * flat, specular * shine],
            false => [faces.select(specular * flat, zero), faces.select(specular * shine, zero)],
        };
        [(body + flat + shine) * MORE + f32::MIN_POSITIVE, shine * MORE]
    }

    /// Returns the error of a highlight of strength 1: of the smaller of the bound by its size and of
    /// those by discs.
    #[inline(always)]
    fn highlight<S: Simd>(
        &self,
        [angle, spread]: [Lanes<S>; 2],
        lamp: [Lanes<S>; 3],
        [d, inverse, weight]: [Lanes<S>; 3],
        discs: bool,
    ) -> Lanes<S> {
        let zero = d.splat(0.0);
        let turn = (inverse + self.eye) * self.radius;
        let least = (angle - turn - spread).max(zero);
        let square = least * least;
        // Above the cosine, up to a right angle.
        let most = 1.0 - square * (0.5 - square * (1.0 / 24.0));
        let most = least.less(d.splat(std::f32::consts::FRAC_PI_2)).select(most, zero);
        let rough = most.max(zero).powi(self.exponent) * weight * self.twice;
        // Where it is not clamped, a whole power is a polynomial of the cosine.
        if !discs {
            return rough;
        }
        let smooth = (angle + turn + spread).less(d.splat(1.57));
        let [first, second] = self.turns;
        let first = self.by_discs(first, least, lamp, [d, inverse]);
        let second = self.by_discs(second, least, lamp, [d, inverse]);
        rough.min(smooth.select(first.min(second), rough))
    }

    /// Returns the bound by discs that turn the angle by `q` at most; NaN or infinite if that is none.
    #[inline(always)]
    fn by_discs<S: Simd>(
        &self,
        q: f32,
        least: Lanes<S>,
        lamp: [Lanes<S>; 3],
        [d, inverse]: [Lanes<S>; 2],
    ) -> Lanes<S> {
        let one = d.splat(1.0);
        let nearer = inverse.max(d.splat(self.eye));
        let radius = (q / (inverse + self.eye + nearer * q)).min(d * 0.8);
        let (a, b) = (radius * inverse, radius * self.eye);
        let q = a / (1.0 - a) + b / (1.0 - b);
        let known = b.less(one).and(q.less(one));
        let weight = weight(lamp, d * (1.0 - a)) / (1.0 - a * a).sqrt();
        let power = cosine(least, q).sqrt().powi(self.exponent);
        let bound = self.both(1.0 / radius) * power * weight;
        known.select(bound, d.splat(f32::INFINITY))
    }
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
mod tests {
    use super::super::lamps::Lamp;
    use super::*;

    struct Angles<'a>(&'a [f32], &'a mut [f32]);

    impl WithSimd for Angles<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let chunks = self.0.chunks(S::F32_LANES).zip(self.1.chunks_mut(S::F32_LANES));
            for (cosines, angles) in chunks {
                angle(Lanes::load(simd, cosines)).store(angles);
            }
        }
    }

    #[test]
    fn angles_are_as_near_as_bounds_expect() {
        let cosines: Vec<f32> = (-100_000..=100_000).map(|i| i as f32 / 100_000.0).collect();
        let mut angles = vec![0.0; cosines.len()];
        pulp::Arch::new().dispatch(Angles(&cosines, &mut angles));
        for (cosine, angle) in cosines.iter().zip(angles) {
            let exact = f64::from(*cosine).acos();
            let off = (f64::from(angle) - exact).abs();
            assert!(off < f64::from(ANGLE) * 0.75, "{cosine}: {angle}, {exact}");
        }
    }

    /// What is taken as a group has no more error than its bound says.
    #[test]
    fn several_lamps_err_by_no_more_than_the_bounds_of_all() {
        let mut random = fastrand::Rng::with_seed(3);
        let mut between = |low: f64, high: f64| low + (high - low) * random.f64();
        let (order, mut bounded) = (Order::new(4), 0);
        for round in 0..4000 {
            let center = DVec3::new(between(-9.0, 9.0), between(-9.0, 9.0), between(-1.0, 9.0));
            let size = between(0.01, 3.0);
            let mut lamps: Vec<Lamp> = Vec::new();
            for place in 0..5 {
                let beside = DVec3::new(between(-1.0, 1.0), between(-1.0, 1.0), between(-1.0, 1.0));
                let terms = [between(0.0, 0.1), between(0.0, 1.0), between(0.0, 1.0)];
                lamps.push(Lamp {
                    place,
                    position: center + beside * size,
                    radius: 0.0,
                    attenuation: [1.0, between(0.0, 0.5) as f32, between(0.0, 0.5) as f32],
                    terms: terms.map(|term| term as f32),
                });
            }
            let at = Rectangle {
                center: [between(-1.0, 1.0), 0.5],
                half: [between(0.1, 1.0), between(0.1, 1.0)],
                eye: DVec3::new(between(-9.0, 9.0), 4.0, between(1.0, 9.0)),
                off: 1e-5,
                tilt: 1e-6,
            };
            let shading =
                Shading { shininess: [32.0, 8.0, 10.5][round % 3], everywhere: round % 2 == 0 };
            // By discs, where they are known, as the bounds by size are not always the nearer ones.
            let sum_of = |lamps: &[Lamp]| {
                let mut near = Lamps::for_many(lamps.len());
                lamps.iter().for_each(|l| near.push(l, l.position.as_vec3().to_array()));
                let bound = &Bound::new(&order, &at, &shading, 1e3).expect("the camera is above");
                let (lamps, errors, highlights) = (&near, &mut Vec::new(), &mut Vec::new());
                let arch = pulp::Arch::new();
                match bound.whole {
                    true => arch.dispatch(ByDiscs { bound, lamps, errors }),
                    false => arch.dispatch(BySize { bound, lamps, errors, highlights }),
                };
                errors.iter().sum::<f32>()
            };
            let group = sum_of(&[super::super::near::group(0, &lamps)]);
            let each = sum_of(&lamps);
            assert!(!group.is_finite() || each <= group * 1.000_1, "{each} {group}");
            bounded += usize::from(group.is_finite());
        }
        assert!(bounded > 1000, "{bounded}");
    }
}
