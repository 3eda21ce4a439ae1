//! The most a light can give anywhere in a region: what every cull here rests on.
//!
//! `U = (amb a + dif a [may face] + spe s [may shine]) win(d) / (c + d (l + q d)) [cone may touch]`
//! with `d` the distance to the region's box. Attenuation and window decrease with distance and
//! every term is not negative, so that no point of the region gets more. Each test leaves a
//! margin for `f32` arithmetic, so that what has a bound of zero is exactly zero in a shader too.

use glam::DVec3;

use super::region::Region;
use crate::Upload;
use crate::compiled::{Model, SpecularTerm};
use crate::scene::{PointLight, SpotLight};

/// A light with what its bound needs, or why it has none.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounded {
    /// What kind of light it is.
    pub kind: Kind,
    /// Its number among its kind.
    pub number: u32,
    /// Its shape, or why nothing is known of it.
    pub shape: Result<Shape, Unbounded>,
    terms: [DVec3; 3],
}

/// The kinds of lights, in the order they are added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// A sun.
    Directional,
    /// A lamp.
    Point,
    /// A lamp with a cone.
    Spot,
}

impl Kind {
    /// As messages call it.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Directional => "directional light",
            Kind::Point => "point light",
            Kind::Spot => "spot light",
        }
    }
}

/// Why a light has no bound; such a light is never dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unbounded {
    /// A colour is negative or no number.
    Color,
    /// A coefficient of its attenuation is negative or no number, or all are zero.
    Attenuation,
    /// Its position or direction is no number, or its direction zero.
    Place,
}

impl Unbounded {
    /// As messages say it.
    pub fn reason(self) -> &'static str {
        match self {
            Unbounded::Color => "has a colour that is negative or not a number",
            Unbounded::Attenuation => "has an attenuation that is zero, negative or not a number",
            Unbounded::Place => "has a position or direction that is not a number",
        }
    }
}

/// Where a light shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Everywhere, from there.
    From(DVec3),
    /// Around a place.
    Around(Lamp),
}

/// A lamp and its cone, if any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// Where it is.
    pub position: DVec3,
    /// Its attenuation, by powers of the distance.
    pub attenuation: [f64; 3],
    /// Where its window ends it; infinite without.
    pub range: f64,
    /// Direction, sine and cosine of a cone that is a little wider.
    pub cone: Option<(DVec3, f64, f64)>,
}

/// For `f32` arithmetic that computes a distance, with room to spare.
const NEARER: f64 = 1.0 - 1.0 / (1 << 20) as f64;
/// For `f32` arithmetic that evaluates the terms.
const MORE: f64 = 1.0 + 1.0 / (1 << 18) as f64;
/// The cosine below which a surface faces away in `f32` arithmetic too.
const AWAY: f64 = 1.0 / (1 << 19) as f64;

/// The lights of an upload, kind by kind: the order they are added in.
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
        let shape = lamp(light, model).map(Shape::Around);
        (Kind::Point, number, shape, model.colors(&light.emission))
    });
    let spot = lights.spot.iter().enumerate().map(|(number, light)| {
        let shape = lamp(&light.lamp, model).and_then(|lamp| {
            let cone = Some(cone(light)).filter(|_| light.cone.inner_cos >= light.cone.outer_cos);
            let directed = light.direction.is_finite() && light.direction.length_squared() > 0.0;
            let lamp = Lamp { cone, ..lamp };
            if directed { Ok(Shape::Around(lamp)) } else { Err(Unbounded::Place) }
        });
        (Kind::Spot, number, shape, model.colors(&light.lamp.emission))
    });
    let check = |(kind, number, shape, terms): (Kind, usize, _, [DVec3; 3])| {
        let light = terms.iter().all(|c| c.is_finite() && c.cmpge(DVec3::ZERO).all());
        let shape = if light { shape } else { Err(Unbounded::Color) };
        Bounded { kind, number: number as u32, shape, terms }
    };
    directional.chain(point).chain(spot).map(check).collect()
}

fn lamp(light: &PointLight, model: &Model) -> Result<Lamp, Unbounded> {
    let a = light.attenuation;
    let attenuation = [a.constant, a.linear, a.quadratic];
    let known = |x: &f64| x.is_finite() && *x >= 0.0;
    let range = a.range.filter(|_| model.windowed).unwrap_or(f64::INFINITY);
    if !attenuation.iter().all(known) || attenuation == [0.0; 3] || range.is_nan() || range <= 0.0 {
        return Err(Unbounded::Attenuation);
    }
    if !light.position.is_finite() {
        return Err(Unbounded::Place);
    }
    Ok(Lamp { position: light.position, attenuation, range, cone: None })
}

/// The cone by its outer angle, wider by what a cosine in `f32` may be off.
fn cone(light: &SpotLight) -> (DVec3, f64, f64) {
    let from_cos = 1.0 - light.cone.outer_cos;
    let from_angle = light
        .cone
        .degrees
        .map_or(from_cos, |[_, outer]| 2.0 * (outer.to_radians() / 2.0).sin().powi(2));
    let chord = from_cos.max(from_angle) * (1.0 + 2f64.powi(-10)) + 2f64.powi(-20);
    let chord = chord.clamp(0.0, 2.0);
    (light.direction.normalize(), (chord * (2.0 - chord)).sqrt(), 1.0 - chord)
}

impl Bounded {
    /// The most each channel gets of it anywhere in `region`: infinite where that is not known,
    /// zero only where every `f32` evaluation of it is.
    pub fn most(&self, region: &Region, model: &Model) -> DVec3 {
        let Ok(shape) = &self.shape else { return DVec3::INFINITY };
        if !region.is_finite() {
            return DVec3::INFINITY;
        }
        let (weight, faces) = match shape {
            Shape::From(towards) => (1.0, may_face(region, |_| *towards, 1.0)),
            Shape::Around(lamp) => {
                let nearest = region.distance(lamp.position) * NEARER;
                if nearest >= lamp.range || !touches(lamp, region) {
                    return DVec3::ZERO;
                }
                let [c, l, q] = lamp.attenuation;
                let ratio = nearest / lamp.range;
                let window = (1.0 - ratio.powi(4)).powi(2);
                let weight = window / (c + nearest * (l + nearest * q));
                let farthest = (region.high - lamp.position)
                    .abs()
                    .max((region.low - lamp.position).abs())
                    .length();
                (weight, may_face(region, |corner| lamp.position - corner, farthest))
            }
        };
        let [ambient, diffuse, specular] = self.terms;
        let shines = faces || model.specular == SpecularTerm::Everywhere;
        let mut most = ambient * region.body;
        if faces {
            most += diffuse * region.body;
        }
        if shines {
            most += specular * region.shine;
        }
        // Zero times a bound that is not known is not known.
        let most = most * (weight * MORE);
        if most.is_nan() { DVec3::INFINITY } else { most }
    }

    /// The largest of its terms' channels added up: what its radius is for.
    pub fn strength(&self) -> f64 {
        super::radius::strength(&self.terms)
    }
}

/// Whether any normal of the region may face a light in the direction `towards(point)`, a vector
/// no longer than `longest`: by the largest `n . towards` over the boxes of both, which is
/// taken where each component is at an end.
fn may_face(region: &Region, towards: impl Fn(DVec3) -> DVec3, longest: f64) -> bool {
    let Some(normals) = region.normals else { return true };
    let ends = [towards(region.low), towards(region.high)];
    let most = (normals[0] * ends[0])
        .max(normals[0] * ends[1])
        .max(normals[1] * ends[0])
        .max(normals[1] * ends[1])
        .element_sum();
    most > -AWAY * longest
}

/// Whether the lamp's cone may touch the sphere around the region's box.
///
/// The cone lies on one side of the plane along its edge nearest the sphere's centre; for cones
/// wider than a half space the same expression tells whether the sphere lies in what is left out.
fn touches(lamp: &Lamp, region: &Region) -> bool {
    let Some((direction, sin, cos)) = lamp.cone else { return true };
    let half = (region.high - region.low) * 0.5;
    let to = region.low + half - lamp.position;
    let along = to.dot(direction);
    let across = (to - direction * along).length();
    let apart = cos * across - sin * along;
    apart <= (half.length() + to.length() * 2f64.powi(-40)) * (1.0 + 2f64.powi(-20))
}
