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

use glam::DVec3;

use super::bound::{Bounded, Shape};
use crate::shading_f32::{Model, SpecularTerm};

/// The largest coefficients of the series of a distance, from order 1.
const ROOT: [f64; 6] = [1.0, 0.5, 0.19246, 0.125, 0.083, 0.0625];

/// A rectangle of a plane.
pub(super) struct Rectangle {
    pub center: DVec3,
    pub axes: [DVec3; 2],
    pub normal: DVec3,
    /// Half its length along each axis.
    pub half: [f64; 2],
    /// The largest distance of a fragment or node from the plane.
    pub off: f64,
    /// The largest difference of a unit normal from that of the plane.
    pub tilt: f64,
}

/// What is reflected there: ambient and diffuse, then specular with its exponent.
pub(super) struct Reflects {
    pub body: DVec3,
    pub shine: DVec3,
    pub shininess: f64,
}

/// The constants of interpolation through `m` nodes a side, 2 to 6.
pub(super) struct Order {
    m: i32,
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
        Order { m: m as i32, terms, lebesgue }
    }

    /// Returns the error over both sides for terms of at most `term / scale^m`.
    fn both(&self, half: [f64; 2], scale: f64, term: f64) -> f64 {
        let [x, y] = half.map(|half| 2.0 * (half / (2.0 * scale)).powi(self.m));
        term * (x.max(y) + self.lebesgue * x.min(y))
    }

    /// Returns the largest error of any channel; infinite if unknown or more than `most`. `eye` is the
    /// camera.
    pub fn error(
        &self,
        light: &Bounded,
        at: &Rectangle,
        eye: DVec3,
        reflects: &Reflects,
        model: &Model,
        most: f64,
    ) -> f64 {
        let Ok(Shape::Around(lamp)) = &light.shape else { return f64::INFINITY };
        if lamp.cone.is_some() || lamp.range.is_finite() {
            return f64::INFINITY;
        }
        let nearest = |point: DVec3| {
            let from = point - at.center;
            let beyond = |axis: usize| (from.dot(at.axes[axis]).abs() - at.half[axis]).max(0.0);
            let height = from.dot(at.normal);
            (beyond(0).hypot(beyond(1)).hypot(height) * (1.0 - 1e-9) - at.off, height)
        };
        let ((d, height), (e, over)) = (nearest(lamp.position), nearest(eye));
        let slack = at.off + d * at.tilt;
        // The side of the plane is the same everywhere, in `f32` too.
        if !(d > 0.0 && e > 0.0 && height.abs() > slack + 1e-5 * d && over.abs() > at.off) {
            return f64::INFINITY;
        }
        let [c, l, q] = lamp.attenuation;
        let falls = |d: f64| 1.0 / (c + d * (l + q * d));
        let weight = falls(d);
        let [ambient, diffuse, specular] = light.terms();
        // Points off the plane and normals off its own, nodes among them: twice for the polynomial.
        let twice = 1.0 + self.lebesgue * self.lebesgue;
        let moved = at.off / d;
        let mut error = ambient
            * reflects.body
            * (self.both(at.half, d, self.terms[0] * weight) + twice * 2.0 * moved * weight);
        if height > 0.0 {
            let facing = (height + slack) / d;
            let body = self.both(at.half, d, self.terms[1] * weight * facing)
                + twice * weight * (at.tilt + 4.0 * moved);
            error += diffuse * reflects.body * body;
        }
        // The highlight takes longest.
        if error.max_element() > most {
            return f64::INFINITY;
        }
        if height > 0.0 || model.specular == SpecularTerm::Everywhere {
            let turned = 4.0 * at.tilt + moved + at.off / e;
            let flat = twice * weight * (reflects.shininess * turned + 2.0 * moved);
            let shine = self.highlight(
                at,
                [lamp.position, eye],
                [d, e],
                reflects.shininess,
                &falls,
                most * 1e-4,
            );
            error += specular * reflects.shine * (shine + flat);
        }
        if error.is_nan() { f64::INFINITY } else { error.max_element() }
    }

    fn highlight(
        &self,
        at: &Rectangle,
        [light, eye]: [DVec3; 2],
        [d, e]: [f64; 2],
        shininess: f64,
        falls: &dyn Fn(f64) -> f64,
        enough: f64,
    ) -> f64 {
        let (to, view) = (light - at.center, eye - at.center);
        let mirrored = 2.0 * at.normal.dot(view) * at.normal - view;
        let cosine_here = to.dot(mirrored) / (to.length() * mirrored.length());
        let angle = cosine_here.clamp(-1.0, 1.0).acos();
        let radius = at.half[0].hypot(at.half[1]) + at.off;
        let turn = radius * (1.0 / d + 1.0 / e);
        let least = (angle - turn - 1e-6).max(0.0);
        let most = if least >= std::f64::consts::FRAC_PI_2 { 0.0 } else { least.cos() };
        let whole = shininess.fract() == 0.0 && (1.0..=1024.0).contains(&shininess);
        let power = |x: f64| if whole { x.powi(shininess as i32) } else { x.powf(shininess) };
        let rough = (1.0 + self.lebesgue * self.lebesgue) * power(most) * falls(d);
        // Where it is not clamped, a whole power is a polynomial of the cosine.
        if !whole || angle + turn >= 1.57 || rough <= enough {
            return rough;
        }
        let best = (f64::from(self.m) / shininess).sqrt();
        let bound = |q: f64| {
            let radius = (q / (1.0 / d + 1.0 / e + q * (1.0 / d).max(1.0 / e))).min(0.8 * d);
            let (a, b) = (radius / d, radius / e);
            let q = a / (1.0 - a) + b / (1.0 - b);
            if !(b < 1.0 && q <= 1.0) {
                return f64::INFINITY;
            }
            let weight = falls(d * (1.0 - a)) / (1.0 - a * a).sqrt();
            self.both(at.half, radius, power(cosine(least, q).sqrt()) * weight)
        };
        [0.7, 1.2].iter().fold(rough, |least, part| least.min(bound(best * part)))
    }
}

/// Returns the largest squared absolute value of the cosine of an angle of at least `least` that
/// turns by `X + i Y`, `X^2 + Y^2 <= q^2`, `q <= 1`: for directions in space
/// `(B cosh Y + (1 - B) (cosh Y - 1) / 2)^2 + (1 - B^2) sinh^2 Y`, `B = cos(least - X)`, which grows
/// with `B` and `Y`; each of three parts of `Y` has the bound of its ends. Series stand for cosines,
/// above them.
fn cosine(least: f64, q: f64) -> f64 {
    let part = |k: u32| {
        let [low, high] = [k, k + 1].map(|k| q * f64::from(k) / 3.0);
        let real = (least - (q * q - low * low).sqrt()).max(0.0);
        let real = 1.0 - real * real * (0.5 - real * real / 24.0);
        // The rest of the series is less than Y^4 / 600 up to 1.
        let real = real.clamp(0.0, 1.0);
        let cosh = 1.0 + high * high * (0.5 + high * high / 23.0);
        (real * cosh + (1.0 - real) * (cosh - 1.0) / 2.0).powi(2)
            + (1.0 - real * real) * (cosh * cosh - 1.0)
    };
    (0..3).map(part).fold(0.0, f64::max)
}
