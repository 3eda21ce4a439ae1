//! The lights of an upload as arrays of `f32`, as in a shader's blocks, with the values that a host
//! precomputes for the robust forms.

use glam::{DVec3, Vec3};

use super::{ConeTerm, Model};
use crate::plan::LightSet;
use crate::scene::{Attenuation, PointLight, SpotLight};
use crate::{Upload, scene};

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lights {
    /// The ambient light: colour times intensity.
    pub ambient: Vec3,
    pub directional: Vec<Directional>,
    pub point: Vec<Point>,
    pub spot: Vec<Spot>,
}

/// The colours of a light's three terms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TermColors {
    pub ambient: Vec3,
    pub diffuse: Vec3,
    pub specular: Vec3,
}

impl TermColors {
    /// Whether no colour is infinite or NaN.
    pub fn is_finite(&self) -> bool {
        self.ambient.is_finite() && self.diffuse.is_finite() && self.specular.is_finite()
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Directional {
    /// The direction of travel, as uploaded.
    pub direction: Vec3,
    /// The unit vector towards the light, precomputed.
    pub towards: Vec3,
    pub emission: TermColors,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    pub position: Vec3,
    pub emission: TermColors,
    pub constant: f32,
    pub linear: f32,
    pub quadratic: f32,
    /// The range of its window; 0 without a window.
    pub range: f32,
    /// `1 / range^2`, precomputed; 0 without a window.
    pub inverse_square_range: f32,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spot {
    pub point: Point,
    /// The direction of its axis, as uploaded.
    pub direction: Vec3,
    /// The cosine of the inner angle, as uploaded.
    pub inner_cos: f32,
    /// The cosine of the outer angle, as uploaded.
    pub outer_cos: f32,
    /// The unit vector along its axis, towards the light, precomputed.
    pub axis: Vec3,
    /// `1 - cos` of the outer angle, computed in `f64`.
    pub outer_chord: f32,
    /// The factor of the cone's ramp, computed in `f64`.
    pub ramp: f32,
}

impl Lights {
    pub fn new(upload: &Upload, model: &Model) -> Lights {
        let Upload { lights, .. } = upload;
        let ambient = lights.ambient.filter(|_| model.counts_ambient());
        let ambient = ambient.map_or(DVec3::ZERO, |a| a.color * a.intensity);
        Lights {
            ambient: ambient.as_vec3(),
            directional: lights.directional.iter().map(|l| directional(l, model)).collect(),
            point: lights.point.iter().map(|l| point(l, model)).collect(),
            spot: lights.spot.iter().map(|l| spot(l, model)).collect(),
        }
    }

    /// Returns the lights padded with zeros to the lengths of a shader's arrays.
    pub fn padded(mut self, [directional, point, spot]: [usize; 3]) -> Lights {
        // Zeros are what a buffer's unused slots hold; the published shaders evaluate them, too.
        self.directional.resize(directional.max(self.directional.len()), Directional::default());
        self.point.resize(point.max(self.point.len()), Point::default());
        self.spot.resize(spot.max(self.spot.len()), Spot::default());
        self
    }

    /// Copies only these lights, contiguously, as a draw uploads them.
    pub fn select(&self, set: &LightSet, into: &mut Lights) {
        fn pick<T: Copy>(from: &[T], numbers: &[u32], into: &mut Vec<T>) {
            into.clear();
            into.extend(numbers.iter().filter_map(|&n| from.get(n as usize).copied()));
        }
        into.ambient = if set.ambient { self.ambient } else { Vec3::ZERO };
        let [directional, point, spot] = &set.numbers;
        pick(&self.directional, directional, &mut into.directional);
        pick(&self.point, point, &mut into.point);
        pick(&self.spot, spot, &mut into.spot);
    }

    /// Whether no colour of these lights is infinite or NaN.
    pub fn are_finite(&self, set: &LightSet) -> bool {
        fn all<T>(of: &[T], numbers: &[u32], emission: impl Fn(&T) -> &TermColors) -> bool {
            let mut lights = numbers.iter().filter_map(|&n| of.get(n as usize));
            lights.all(|light| emission(light).is_finite())
        }
        let [directional, point, spot] = &set.numbers;
        all(&self.directional, directional, |light| &light.emission)
            && all(&self.point, point, |light| &light.emission)
            && all(&self.spot, spot, |light| &light.point.emission)
    }

    pub fn emissions(&self) -> impl Iterator<Item = &TermColors> {
        let directional = self.directional.iter().map(|light| &light.emission);
        let point = self.point.iter().map(|light| &light.emission);
        directional.chain(point).chain(self.spot.iter().map(|light| &light.point.emission))
    }

    /// Returns the number of lights of all kinds.
    pub fn len(&self) -> usize {
        self.directional.len() + self.point.len() + self.spot.len()
    }

    /// Whether there are no lights of any kind.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

fn emission(from: &scene::Emission, model: &Model) -> TermColors {
    let [ambient, diffuse, specular] = model.colors(from).map(|color| color.as_vec3());
    TermColors { ambient, diffuse, specular }
}

fn directional(light: &scene::DirectionalLight, model: &Model) -> Directional {
    Directional {
        direction: light.direction.as_vec3(),
        towards: (-light.direction).normalize_or_zero().as_vec3(),
        emission: emission(&light.emission, model),
    }
}

fn point(light: &PointLight, model: &Model) -> Point {
    let Attenuation { constant, linear, quadratic, range } = light.attenuation;
    let range = range.filter(|_| model.windowed).unwrap_or(0.0);
    Point {
        position: light.position.as_vec3(),
        emission: emission(&light.emission, model),
        constant: constant as f32,
        linear: linear as f32,
        quadratic: quadratic as f32,
        range: range as f32,
        inverse_square_range: if range > 0.0 { (1.0 / (range * range)) as f32 } else { 0.0 },
    }
}

fn spot(light: &SpotLight, model: &Model) -> Spot {
    let [inner, outer] = chords(light);
    let [inner_cos, outer_cos] = [light.cone.inner_cos, light.cone.outer_cos];
    // `ToAxis` is a ramp whose inner angle is 0; `Hard` one of no width at the inner angle.
    let ([inner, outer], [inner_cos, outer_cos]) = match model.cone {
        ConeTerm::Ramp => ([inner, outer], [inner_cos, outer_cos]),
        ConeTerm::ToAxis => ([0.0, outer], [1.0, outer_cos]),
        ConeTerm::Hard => ([inner, inner], [inner_cos, inner_cos]),
    };
    // Equal angles get the steepest finite ramp; an inverted ramp stays inverted.
    let width = outer - inner;
    let width = if width == 0.0 { f64::from(f32::MIN_POSITIVE) } else { width };
    Spot {
        point: point(&light.point, model),
        direction: light.direction.as_vec3(),
        inner_cos: inner_cos as f32,
        outer_cos: outer_cos as f32,
        axis: (-light.direction).normalize_or_zero().as_vec3(),
        outer_chord: outer as f32,
        ramp: (1.0 / width) as f32,
    }
}

/// Returns `1 - cos` of the inner and outer angle, from the angles if the scene has them, since the
/// cosine of a narrow cone has lost them.
fn chords(light: &SpotLight) -> [f64; 2] {
    match light.cone.degrees {
        Some(angles) => angles.map(|angle| 2.0 * (angle.to_radians() / 2.0).sin().powi(2)),
        None => [1.0 - light.cone.inner_cos, 1.0 - light.cone.outer_cos],
    }
}
