//! Random scenes: point lights and cubes over a floor, the same on every machine.
//!
//! Numbers come from [`SplitMix64`]. Lights, then cubes, are made one after another, each drawing
//! numbers in the order of the code below. No trigonometric function is used, whose results depend
//! on the platform.

use glam::{DMat4, DVec3, DVec4, dvec3, dvec4};

use crate::splitmix64::SplitMix64;

use super::{Attenuation, Emission, Object, PointLight, mesh};

#[derive(Clone, Debug, PartialEq)]
pub struct Generate {
    pub seed: u64,
    /// The edges of the floor along x and z, centred at the origin.
    pub area: [f64; 2],
    pub lights: Option<RandomLights>,
    pub cubes: Option<RandomCubes>,
    /// The index of the floor's material, if there is a floor.
    pub floor: Option<usize>,
}

/// Point lights with random places and colours, each with one of several attenuations.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomLights {
    pub count: u32,
    /// The lowest and highest height above the floor.
    pub height: [f64; 2],
    pub attenuations: Vec<Attenuation>,
    /// The factor of every colour.
    pub gain: f64,
    /// If set, the range of a light is where its brightest channel falls to this value.
    pub window: Option<f64>,
    /// Whether they are left out, and only their random numbers drawn: the cubes stand as with
    /// them.
    pub omit: bool,
}

/// Cubes that stand on the floor.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomCubes {
    pub count: u32,
    /// The shortest and longest edge.
    pub edge: [f64; 2],
    pub material: usize,
}

pub fn generate(from: &Generate) -> (Vec<PointLight>, Vec<Object>) {
    let mut random = SplitMix64(from.seed);
    let mut points = Vec::new();
    if let Some(lights) = &from.lights {
        points.extend((0..lights.count).map(|_| point(&mut random, from, lights)));
        // After drawing, so that the cubes get the same numbers.
        if lights.omit {
            points.clear();
        }
    }
    let mut objects = Vec::new();
    if let Some(material) = from.floor {
        let scale = dvec3(from.area[0], 1.0, from.area[1]);
        // One texture per unit of length would be too fine to see: one for ten.
        let mesh = mesh::plane(from.area[0].max(from.area[1]) / 10.0);
        objects.push(Object { mesh, material, transform: DMat4::from_scale(scale) });
    }
    if let Some(cubes) = &from.cubes {
        objects.extend((0..cubes.count).map(|_| standing(&mut random, from, cubes)));
    }
    (points, objects)
}

fn point(random: &mut SplitMix64, from: &Generate, lights: &RandomLights) -> PointLight {
    let (x, z) = place(random, from.area);
    let y = between(random, lights.height);
    let color = dvec3(random.unit(), random.unit(), random.unit());
    let count = lights.attenuations.len() as u64;
    // Also drawn without a table, so that the numbers after it stay the same.
    let row = random.next_u64().checked_rem(count).map(|row| row as usize);
    let unweakened = Attenuation { constant: 1.0, linear: 0.0, quadratic: 0.0, range: None };
    let mut attenuation = row.map_or(unweakened, |row| lights.attenuations[row]);
    if let Some(least) = lights.window {
        let reach = attenuation.reach(color.max_element() * lights.gain, least);
        attenuation.range = Some(reach).filter(|reach| *reach > 0.0 && reach.is_finite());
    }
    let sent = color * lights.gain;
    let emission = Emission {
        ambient: DVec3::ZERO,
        diffuse: sent,
        specular: sent,
        color,
        intensity: lights.gain,
    };
    PointLight { position: dvec3(x, y, z), emission, attenuation }
}

fn standing(random: &mut SplitMix64, from: &Generate, cubes: &RandomCubes) -> Object {
    let (x, z) = place(random, from.area);
    let edge = between(random, cubes.edge);
    // The tangent of half the angle, from -1 to 1, gives a quarter turn either way.
    let half = 2.0 * random.unit() - 1.0;
    let (cos, sin) = ((1.0 - half * half) / (1.0 + half * half), 2.0 * half / (1.0 + half * half));
    let transform = DMat4::from_cols(
        dvec4(cos * edge, 0.0, -sin * edge, 0.0),
        dvec4(0.0, edge, 0.0, 0.0),
        dvec4(sin * edge, 0.0, cos * edge, 0.0),
        DVec4::new(x, edge * 0.5, z, 1.0),
    );
    Object { mesh: mesh::cube(), material: cubes.material, transform }
}

impl Attenuation {
    /// Returns the distance at which a light of that strength falls to `least`: the larger root of
    /// `constant + linear d + quadratic d^2 = strength / least`, in a form without cancellation
    /// that needs no quadratic term. Infinite if it never does; 0 if it is below at the light
    /// already.
    pub fn reach(&self, strength: f64, least: f64) -> f64 {
        let over = strength / least - self.constant;
        if over <= 0.0 {
            return 0.0;
        }
        let root = (self.linear * self.linear + 4.0 * self.quadratic * over).sqrt();
        2.0 * over / (self.linear + root)
    }
}

fn between(random: &mut SplitMix64, [low, high]: [f64; 2]) -> f64 {
    low + (high - low) * random.unit()
}

/// Returns a random place on the floor: x, then z.
fn place(random: &mut SplitMix64, [x, z]: [f64; 2]) -> (f64, f64) {
    ((random.unit() - 0.5) * x, (random.unit() - 0.5) * z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lamp_reaches_to_where_it_has_sunk() {
        let row = Attenuation { constant: 1.0, linear: 0.09, quadratic: 0.032, range: None };
        let d = row.reach(0.6, 5.0 / 256.0);
        assert!((0.6 / (1.0 + d * (0.09 + 0.032 * d)) - 5.0 / 256.0).abs() < 1e-15);
        // Without a quadratic term: 1 + 0.5 d = 4 at 6.
        let straight = Attenuation { linear: 0.5, quadratic: 0.0, ..row };
        assert_eq!(straight.reach(1.0, 0.25), 6.0);
        assert_eq!(row.reach(0.5, 0.5), 0.0);
        let never = Attenuation { linear: 0.0, quadratic: 0.0, ..row };
        assert_eq!(never.reach(1.0, 0.5), f64::INFINITY);
    }
}
