//! The upper bound of a light's contribution anywhere in a region, on which all culling rests.
//!
//! `U = (amb a + dif a [may face] + spe s [may shine]) win(d) / (c + d (l + q d)) [cone may touch]`
//! with `d` the distance to the region's box. Attenuation and window decrease with distance and no
//! term is negative, so no point of the region gets more. Each test leaves a margin for `f32`
//! arithmetic, so that a bound of zero means exactly zero in a shader too.

use glam::DVec3;

use super::region::Region;
use crate::Upload;
use crate::reference::SpecularGate;
use crate::scene::{Kind, PointLight, SpotLight};
use crate::shading_f32::Model;

/// A light with the data for its bound, or the reason it has none.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounded {
    pub kind: Kind,
    /// The index among its kind.
    pub number: u32,
    /// The shape, or the reason there is no bound.
    pub shape: Result<Shape, Unbounded>,
    /// The colours of the ambient, diffuse and specular terms, none negative where `shape` is
    /// known.
    terms: [DVec3; 3],
}

/// The reason a light has no bound; such a light is never dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unbounded {
    /// A colour is negative or not a number.
    Color,
    /// An attenuation coefficient is negative or not a number, or all are zero.
    Attenuation,
    /// The position or direction is not a number, or the direction is zero.
    Place,
}

impl Unbounded {
    pub fn reason(self) -> &'static str {
        match self {
            Unbounded::Color => "has a colour that is negative or not a number",
            Unbounded::Attenuation => "has an attenuation that is zero, negative or not a number",
            Unbounded::Place => "has a position or direction that is not a number",
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Parallel light, by the unit vector towards it.
    From(DVec3),
    Around(BoundedLight),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundedLight {
    pub position: DVec3,
    /// The coefficients by powers of the distance.
    pub attenuation: [f64; 3],
    /// The range of its window; infinite without one.
    pub range: f64,
    /// The unit direction, and sine and cosine of an angle slightly past the outer one.
    pub cone: Option<(DVec3, f64, f64)>,
}

// A distance in `f32`: the differences of coordinates, their squares, the sum and its root each
// round by 2^-24 of their result, to less than 2^-20 together.
const NEARER: f64 = 1.0 - 1.0 / (1 << 20) as f64;
// The terms in `f32`: 2^-18 has room for 64 roundings of 2^-24, in whatever order a shader has
// them.
const ROUNDED_UP: f64 = 1.0 + 1.0 / (1 << 18) as f64;
/// The cosine below which a surface faces away in `f32` arithmetic too.
const AWAY: f64 = 1.0 / (1 << 19) as f64;

/// Returns the lights of an upload by kind, in the order of the sum.
pub fn bounded(upload: &Upload, model: &Model) -> Vec<Bounded> {
    let lights = &upload.lights;
    let directional = lights.directional.iter().enumerate().map(|(number, light)| {
        let from = -light.direction;
        let shape = match from.is_finite() && from.length_squared() > 0.0 {
            true => Ok(Shape::From(from.normalize())),
            false => Err(Unbounded::Place),
        };
        (Kind::Directional, number, shape, model.colors(&light.emission))
    });
    let point = lights.point.iter().enumerate().map(|(number, light)| {
        let shape = around(light, model).map(Shape::Around);
        (Kind::Point, number, shape, model.colors(&light.emission))
    });
    let spot = lights.spot.iter().enumerate().map(|(number, light)| {
        let shape = around(&light.point, model).and_then(|bounded| {
            // An inverted cone (inner angle past the outer) lights outside of it: no cone bounds
            // such a light.
            let cone = Some(cone(light)).filter(|_| light.cone.inner_cos >= light.cone.outer_cos);
            let directed = light.direction.is_finite() && light.direction.length_squared() > 0.0;
            let bounded = BoundedLight { cone, ..bounded };
            if directed { Ok(Shape::Around(bounded)) } else { Err(Unbounded::Place) }
        });
        (Kind::Spot, number, shape, model.colors(&light.point.emission))
    });
    // A negative term could cancel another, so that the sum of upper bounds would be none.
    let check = |(kind, number, shape, terms): (Kind, usize, _, [DVec3; 3])| {
        let light = terms.iter().all(|c| c.is_finite() && c.cmpge(DVec3::ZERO).all());
        let shape = if light { shape } else { Err(Unbounded::Color) };
        Bounded { kind, number: number as u32, shape, terms }
    };
    directional.chain(point).chain(spot).map(check).collect()
}

fn around(light: &PointLight, model: &Model) -> Result<BoundedLight, Unbounded> {
    let a = light.attenuation;
    let attenuation = [a.constant, a.linear, a.quadratic];
    let known = |x: &f64| x.is_finite() && *x >= 0.0;
    // A model without windows ignores ranges, which then end nothing.
    let range = a.range.filter(|_| model.windowed).unwrap_or(f64::INFINITY);
    // All zero divides by zero at every distance; a negative coefficient lets the light grow with
    // distance, so the nearest point would not be the brightest.
    if !attenuation.iter().all(known) || attenuation == [0.0; 3] || range.is_nan() || range <= 0.0 {
        return Err(Unbounded::Attenuation);
    }
    if !light.position.is_finite() {
        return Err(Unbounded::Place);
    }
    Ok(BoundedLight { position: light.position, attenuation, range, cone: None })
}

/// Returns the cone of the outer angle, wider by the `f32` error of its cosine.
fn cone(light: &SpotLight) -> (DVec3, f64, f64) {
    // `1 - cos` keeps a narrow cone apart from none where the cosine has rounded to 1. A shader
    // computes the cone from the cosine or from the angle, so the wider one counts. The relative
    // margin is for large chords, the absolute one for the rounding of a cosine near 1 (2^-25) in
    // small ones.
    let from_cos = 1.0 - light.cone.outer_cos;
    let from_angle = light
        .cone
        .degrees
        .map_or(from_cos, |[_, outer]| 2.0 * (outer.to_radians() / 2.0).sin().powi(2));
    let chord = from_cos.max(from_angle) * (1.0 + 2f64.powi(-10)) + 2f64.powi(-20);
    let chord = chord.clamp(0.0, 2.0);
    // sin^2 = 1 - cos^2 = chord (2 - chord), without the cancellation near cos = 1.
    (light.direction.normalize(), (chord * (2.0 - chord)).sqrt(), 1.0 - chord)
}

impl Bounded {
    /// Returns the largest contribution to each channel anywhere in `region`: infinite if unknown,
    /// zero only if every `f32` evaluation is zero.
    pub fn most(&self, region: &Region, model: &Model) -> DVec3 {
        // The product of the largest reflection and the largest weight. They may be reached at
        // different points of the region: the bound is then loose, never too small.
        let Ok(shape) = &self.shape else { return DVec3::INFINITY };
        if !region.is_finite() {
            return DVec3::INFINITY;
        }
        let reflected = match self.reflected(shape, region, model) {
            Some(reflected) => reflected,
            None => return DVec3::ZERO,
        };
        let weight = match shape {
            Shape::From(_) => 1.0,
            Shape::Around(bounded) => {
                // Nearest in `f32`, where the window and the attenuation are largest. `bounded.range`
                // is infinite without a window, which makes the ratio 0 and the window 1.
                let nearest = region.distance(bounded.position) * NEARER;
                let [c, l, q] = bounded.attenuation;
                let ratio = nearest / bounded.range;
                let window = (1.0 - ratio.powi(4)).powi(2);
                window / (c + nearest * (l + nearest * q))
            }
        };
        // Zero times an unknown bound is unknown.
        let most = reflected * (weight * ROUNDED_UP);
        if most.is_nan() { DVec3::INFINITY } else { most }
    }

    /// Whether it may contribute to some point of `region`: whether [`most`](Bounded::most) is not
    /// zero, without its size.
    pub fn adds(&self, region: &Region, model: &Model) -> bool {
        let Ok(shape) = &self.shape else { return true };
        if !region.is_finite() {
            return true;
        }
        self.reflected(shape, region, model).is_some_and(|reflected| reflected != DVec3::ZERO)
    }

    /// Whether some point of `region` may be within its range.
    pub fn reaches(&self, region: &Region) -> bool {
        let (center, radius) = self.sphere();
        // `!outside` rather than `<`: a NaN distance must keep the light.
        let outside = region.is_finite() && region.distance(center) * NEARER >= radius;
        !outside
    }

    /// Returns the light without what only the model says of it: it ends at a range, or nowhere.
    pub fn of_range(self, range: Option<f64>, position: DVec3) -> Bounded {
        // Only `reaches` is asked of such a light. Attenuation 0 divides by zero, so `most` would
        // be infinite: nothing is claimed about the light within its range.
        let shape = match range.filter(|range| *range > 0.0 && position.is_finite()) {
            Some(range) => Ok(Shape::Around(BoundedLight {
                position,
                attenuation: [0.0; 3],
                range,
                cone: None,
            })),
            None => Err(Unbounded::Place),
        };
        Bounded { shape, ..self }
    }

    /// Returns the largest reflection of a light of weight 1 in `region`; `None` if none of it is
    /// in its range and its cone.
    #[inline]
    fn reflected(&self, shape: &Shape, region: &Region, model: &Model) -> Option<DVec3> {
        let faces = match shape {
            Shape::From(towards) => may_face(region, |_| *towards, 1.0),
            Shape::Around(bounded) => {
                // At the edge of the window the factor is exactly 0, hence `>=`; the margin makes
                // a fragment which `f32` puts inside count as inside.
                let nearest = region.distance(bounded.position) * NEARER;
                if nearest >= bounded.range || !touches(bounded, region) {
                    return None;
                }
                // The corner farthest from the light, component by component.
                let farthest = (region.high - bounded.position)
                    .abs()
                    .max((region.low - bounded.position).abs())
                    .length();
                may_face(region, |corner| bounded.position - corner, farthest)
            }
        };
        let [ambient, diffuse, specular] = self.terms;
        // A published shader has no test of the facing side before its highlight: there the
        // highlight shows behind the surface, too.
        let shines = faces || model.specular == SpecularGate::None;
        let mut reflected = ambient * region.body;
        if faces {
            reflected += diffuse * region.body;
        }
        if shines {
            reflected += specular * region.shine;
        }
        Some(reflected)
    }

    /// Whether some channel of its highlights is black.
    pub fn is_dull(&self) -> bool {
        self.terms[2].cmpeq(DVec3::ZERO).any()
    }

    /// Returns the sphere outside which it contributes nothing: the centre and the radius, which is
    /// infinite if there is no such sphere.
    pub fn sphere(&self) -> (DVec3, f64) {
        match self.shape {
            Ok(Shape::Around(bounded)) => (bounded.position, bounded.range),
            Ok(Shape::From(_)) | Err(_) => (DVec3::ZERO, f64::INFINITY),
        }
    }
}

/// Whether any normal of the region may face a light in the direction `towards(point)`, a vector no
/// longer than `longest`: by the largest `n . towards` over the boxes of both, which is at the ends
/// of the components.
fn may_face(region: &Region, towards: impl Fn(DVec3) -> DVec3, longest: f64) -> bool {
    let Some(normals) = region.normals else { return true };
    // `n . t` is the sum of three products of intervals. Each is bilinear, so its largest value is
    // at one of four pairs of ends, and the sum of the largest is an upper bound of the sum.
    let ends = [towards(region.low), towards(region.high)];
    let most = (normals[0] * ends[0])
        .max(normals[0] * ends[1])
        .max(normals[1] * ends[0])
        .max(normals[1] * ends[1])
        .element_sum();
    // The sum of three products in `f32` is off by about 2^-22 of the length of `t`.
    most > -AWAY * longest
}

/// Whether the light's cone may touch the sphere around the region's box.
///
/// The cone lies on one side of the plane along its edge nearest the sphere's centre; for cones
/// wider than a half space the same expression tests whether the sphere lies in the complement.
fn touches(bounded: &BoundedLight, region: &Region) -> bool {
    let Some((direction, sin, cos)) = bounded.cone else { return true };
    // `along` and `across` are the coordinates of the sphere's centre in the plane of the axis;
    // `apart` is its signed distance from the edge line (cos, sin), positive outside of the cone.
    let half = (region.high - region.low) * 0.5;
    let to = region.low + half - bounded.position;
    let along = to.dot(direction);
    let across = (to - direction * along).length();
    let apart = cos * across - sin * along;
    // `to` times 2^-40 covers the rounding of `f64` where the box is a point far from the light.
    apart <= (half.length() + to.length() * 2f64.powi(-40)) * (1.0 + 2f64.powi(-20))
}
