//! The lights of a fragment in the arithmetic of the published shaders: every vector divided by its
//! length, the light reflected for each, `pow`, the attenuation as written, the cone from cosines.
//! Kept unchanged, hazards included, as the baseline of the robust form.

use glam::Vec3;

use super::{Directional, Lights, Model, Point, Spot, Surface, Tally};
use crate::reference::SpecularGate;

/// Returns the light that a fragment sends to `eye`.
pub fn shade<T: Tally>(
    surface: &Surface,
    eye: Vec3,
    lights: &Lights,
    model: &Model,
    tally: &mut T,
) -> Vec3 {
    let normal = normalize(surface.normal);
    let view = normalize(eye - surface.position);
    let at = FragmentState { surface, normal, view, model };
    let mut sum = lights.ambient * surface.ambient;
    for light in &lights.directional {
        tally.trip();
        sum += directional(&at, light, tally);
    }
    for light in &lights.point {
        tally.trip();
        sum += point(&at, light, 1.0, tally);
    }
    for light in &lights.spot {
        tally.trip();
        sum += spot(&at, light, tally);
    }
    sum
}

struct FragmentState<'a> {
    surface: &'a Surface,
    normal: Vec3,
    view: Vec3,
    model: &'a Model,
}

fn directional<T: Tally>(at: &FragmentState<'_>, light: &Directional, tally: &mut T) -> Vec3 {
    tally.evaluation();
    terms(at, normalize(-light.direction), &light.emission, tally).into_iter().sum()
}

fn point<T: Tally>(at: &FragmentState<'_>, light: &Point, cone: f32, tally: &mut T) -> Vec3 {
    tally.evaluation();
    tally.attenuation();
    let towards = normalize(light.position - at.surface.position);
    let [ambient, diffuse, specular] = terms(at, towards, &light.emission, tally);
    let distance = length(light.position - at.surface.position);
    let mut attenuation =
        // `d * d`, since the shaders write it so; `(linear + quadratic d) d` rounds differently.
        1.0 / (light.constant + light.linear * distance + light.quadratic * (distance * distance));
    if light.range > 0.0 {
        let ratio = distance / light.range;
        let window = (1.0 - ratio * ratio * ratio * ratio).clamp(0.0, 1.0);
        attenuation *= window * window;
    }
    // Each term separately, as in the published shaders.
    ambient * attenuation * cone + diffuse * attenuation * cone + specular * attenuation * cone
}

fn spot<T: Tally>(at: &FragmentState<'_>, light: &Spot, tally: &mut T) -> Vec3 {
    let towards = normalize(light.point.position - at.surface.position);
    let theta = towards.dot(normalize(-light.direction));
    let epsilon = light.inner_cos - light.outer_cos;
    // 0 / 0 for equal angles: the hazard of the published shaders stays.
    let cone = ((theta - light.outer_cos) / epsilon).clamp(0.0, 1.0);
    point(at, &light.point, cone, tally)
}

fn terms<T: Tally>(
    at: &FragmentState<'_>,
    towards: Vec3,
    emission: &super::TermColors,
    tally: &mut T,
) -> [Vec3; 3] {
    let facing = maximum(at.normal.dot(towards), 0.0);
    let reflected = reflect(-towards, at.normal);
    let mut shine = 0.0;
    if at.model.specular == SpecularGate::None || facing > 0.0 {
        tally.power();
        shine = maximum(at.view.dot(reflected), 0.0).powf(at.surface.shininess);
    }
    [
        emission.ambient * at.surface.diffuse,
        emission.diffuse * facing * at.surface.diffuse,
        emission.specular * shine * at.surface.specular,
    ]
}

fn length(v: Vec3) -> f32 {
    v.dot(v).sqrt()
}

fn normalize(v: Vec3) -> Vec3 {
    // No guard: a zero vector becomes NaN, as in GLSL on common hardware.
    let length = length(v);
    Vec3::new(v.x / length, v.y / length, v.z / length)
}

fn reflect(v: Vec3, normal: Vec3) -> Vec3 {
    v - 2.0 * normal.dot(v) * normal
}

/// GLSL's `max`: `y` if `x < y`, so that a NaN in `x` stays.
fn maximum(x: f32, y: f32) -> f32 {
    if x < y { y } else { x }
}
