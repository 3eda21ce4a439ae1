//! Scenes by seed: lamps and cubes strewn over a floor, the same everywhere.
//!
//! Numbers come from SplitMix64: the state grows by `0x9e3779b97f4a7c15`, and a copy of it is
//! mixed by `x ^= x >> 30; x *= 0xbf58476d1ce4e5b9; x ^= x >> 27; x *= 0x94d049bb133111eb;
//! x ^= x >> 31`. A number from 0 to 1 is its upper 53 bits over 2^53. Lamps, then cubes, are
//! made one after another, each drawing in the order of the code below. No sine is taken, so
//! that no platform's library has a say.

use glam::{DMat4, DVec3, DVec4, dvec3, dvec4};

use super::{Attenuation, Emission, Object, PointLight, mesh};

/// What to strew.
#[derive(Clone, Debug, PartialEq)]
pub struct Generate {
    /// Where the random numbers start.
    pub seed: u64,
    /// Edges of the floor along x and z, its middle at the origin.
    pub area: [f64; 2],
    /// The lamps.
    pub lights: Option<RandomLights>,
    /// The cubes.
    pub cubes: Option<RandomCubes>,
    /// The material of a floor, if there is one.
    pub floor: Option<usize>,
}

/// Lamps at random places, in random colours, each of a random one of some attenuations.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomLights {
    /// How many.
    pub count: u32,
    /// Lowest and highest place above the floor.
    pub height: [f64; 2],
    /// The attenuations.
    pub attenuations: Vec<Attenuation>,
    /// What every colour is multiplied with.
    pub gain: f64,
    /// Where set, lamps end where their brightest channel has sunk to that much.
    pub window: Option<f64>,
}

/// Cubes that stand on the floor.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomCubes {
    /// How many.
    pub count: u32,
    /// Shortest and longest edge.
    pub edge: [f64; 2],
    /// Their material.
    pub material: usize,
}

/// Lamps and objects of a seed.
pub fn generate(from: &Generate) -> (Vec<PointLight>, Vec<Object>) {
    let mut random = SplitMix64(from.seed);
    let mut lamps = Vec::new();
    if let Some(lights) = &from.lights {
        lamps.extend((0..lights.count).map(|_| lamp(&mut random, from, lights)));
    }
    let mut objects = Vec::new();
    if let Some(material) = from.floor {
        let scale = dvec3(from.area[0], 1.0, from.area[1]);
        // One texture a unit of length would be too fine to see: one for ten.
        let mesh = mesh::plane(from.area[0].max(from.area[1]) / 10.0);
        objects.push(Object { mesh, material, transform: DMat4::from_scale(scale) });
    }
    if let Some(cubes) = &from.cubes {
        objects.extend((0..cubes.count).map(|_| standing(&mut random, from, cubes)));
    }
    (lamps, objects)
}

fn lamp(random: &mut SplitMix64, from: &Generate, lights: &RandomLights) -> PointLight {
    let (x, z) = random.place(from.area);
    let y = random.between(lights.height);
    let color = dvec3(random.unit(), random.unit(), random.unit());
    let count = lights.attenuations.len() as u64;
    let row = random.next().checked_rem(count).map(|row| row as usize);
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
    let (x, z) = random.place(from.area);
    let edge = random.between(cubes.edge);
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
    /// The distance at which a lamp of that strength has sunk to `least`: the larger root of
    /// `constant + linear d + quadratic d^2 = strength / least`, in the form that cancels
    /// nothing and needs no quadratic term. Infinite where it never sinks so far; 0 where it is
    /// below at the lamp already.
    pub fn reach(&self, strength: f64, least: f64) -> f64 {
        let over = strength / least - self.constant;
        if over <= 0.0 {
            return 0.0;
        }
        let root = (self.linear * self.linear + 4.0 * self.quadratic * over).sqrt();
        2.0 * over / (self.linear + root)
    }
}

struct SplitMix64(u64);

impl SplitMix64 {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// From 0 to just below 1.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, [low, high]: [f64; 2]) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A place on the floor: x, then z.
    fn place(&mut self, [x, z]: [f64; 2]) -> (f64, f64) {
        ((self.unit() - 0.5) * x, (self.unit() - 0.5) * z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first numbers of the generator's author for seed 1234567.
    #[test]
    fn the_numbers_are_those_of_splitmix64() {
        let mut random = SplitMix64(1_234_567);
        let first: Vec<u64> = (0..3).map(|_| random.next()).collect();
        assert_eq!(
            first,
            [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]
        );
    }

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
