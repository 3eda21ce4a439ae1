//! The [`robust`](super::robust) form of plain point lights with fused operations and one division,
//! for plans whose result is not exact anyway.
//!
//! Results differ from `robust` by rounding: also by a highlight where a light is in the surface's plane
//! up to rounding, and by powers below [`Surface::gate`]. Fragments for which a number is not finite, or
//! too large for the division, are left to `robust`.

use glam::Vec3;
use pulp::{Simd, WithSimd};

use super::robust::NEAREST;
use super::wide::Batch;
use super::{Lights, Point, Power, SpecularTerm, Surface};
use crate::lanes::{Lanes, MOST};
use crate::plan::LightSet;

/// A point light: position, attenuation by powers of the distance, diffuse and specular colour. NaN in
/// place of one with a range or an ambient term.
type Plain = [f32; 12];

/// The point lights of an upload.
pub(super) struct PlainLights {
    points: Vec<Plain>,
    /// Whether all are plain.
    all: bool,
}

impl PlainLights {
    pub fn new(lights: &Lights) -> PlainLights {
        let points: Vec<Plain> = lights.point.iter().map(plain).collect();
        PlainLights { all: points.iter().all(is_plain), points }
    }

    /// Whether the lights of a set are plain point lights.
    fn has(&self, set: &LightSet) -> bool {
        let is_plain = |number: &u32| self.points.get(*number as usize).is_none_or(is_plain);
        let are_plain = self.all || set.point.iter().all(is_plain);
        are_plain && set.directional.is_empty() && set.spot.is_empty()
    }
}

fn is_plain(point: &Plain) -> bool {
    point.iter().all(|x| x.is_finite())
}

fn plain(point: &Point) -> Plain {
    let Point { position, emission, constant, linear, quadratic, range, .. } = *point;
    let mut all = [f32::NAN; 12];
    if range > 0.0 || emission.ambient != Vec3::ZERO {
        return all;
    }
    all[..3].copy_from_slice(&position.to_array());
    all[3..6].copy_from_slice(&[constant, linear, quadratic]);
    all[6..9].copy_from_slice(&emission.diffuse.to_array());
    all[9..].copy_from_slice(&emission.specular.to_array());
    all
}

/// Fragments to be lit by the same plain lights.
pub(super) struct Fused<'a> {
    batch: &'a Batch<'a>,
    plain: &'a PlainLights,
    power: Power,
}

impl<'a> Fused<'a> {
    /// Returns `None` where lights are not plain, or powers not whole.
    pub fn of(batch: &'a Batch<'a>, plain: &'a PlainLights) -> Option<Fused<'a>> {
        let power = batch.power.filter(|power| *power != Power::Chord)?;
        (batch.finite && plain.has(batch.set)).then_some(Fused { batch, plain, power })
    }

    /// Lights the fragments; returns the indices of those that are left to the robust form.
    pub fn shade(&self, colors: &mut [Vec3]) -> Vec<u32> {
        pulp::Arch::new().dispatch(Shading { fused: self, colors })
    }
}

struct Shading<'a> {
    fused: &'a Fused<'a>,
    colors: &'a mut [Vec3],
}

/// The divisor from which its inverse loses digits.
const LARGEST: f32 = 1e37;

impl WithSimd for Shading<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<u32> {
        let Shading { fused, colors } = self;
        let Batch { surfaces, numbers, set, lights, .. } = *fused.batch;
        let ambient = if set.ambient { lights.ambient } else { Vec3::ZERO };
        let mut left = Vec::new();
        for numbers in numbers.chunks(S::F32_LANES.min(MOST)) {
            let (sums, largest) = fused.sums(simd, numbers);
            for (lane, &number) in numbers.iter().enumerate() {
                let surface = &surfaces[number as usize];
                let [r, g, b, sr, sg, sb] = [0, 1, 2, 3, 4, 5].map(|at: usize| sums[at][lane]);
                let color = ambient * surface.ambient
                    + Vec3::new(r, g, b) * surface.diffuse
                    + Vec3::new(sr, sg, sb) * surface.specular;
                if !(largest[lane] < LARGEST && color.is_finite()) {
                    left.push(number);
                }
                colors[number as usize] = color;
            }
        }
        left
    }
}

impl Fused<'_> {
    /// Returns the sums of all lights that multiply the materials, by channel and lane, and the largest
    /// divisors, NaN for fragments that are not finite.
    #[inline(always)]
    fn sums<S: Simd>(&self, simd: S, numbers: &[u32]) -> ([[f32; MOST]; 6], [f32; MOST]) {
        let mut given = [[0.0f32; MOST]; 6];
        let repeated = numbers.iter().chain(std::iter::repeat(&numbers[0]));
        for (lane, number) in repeated.take(S::F32_LANES.min(MOST)).enumerate() {
            let Surface { position, normal, .. } = self.batch.surfaces[*number as usize];
            let Vec3 { x, y, z } = position;
            [given[0][lane], given[1][lane], given[2][lane]] = [x, y, z];
            let Vec3 { x, y, z } = normal;
            [given[3][lane], given[4][lane], given[5][lane]] = [x, y, z];
        }
        let [px, py, pz, nx, ny, nz] =
            given.each_ref().map(|x| Lanes::load(simd, &x[..S::F32_LANES.min(MOST)]));
        let [nx, ny, nz] = unit([nx, ny, nz]);
        let Vec3 { x, y, z } = self.batch.eye;
        let view = unit([x - px, y - py, z - pz]);
        let twice = dot([nx, ny, nz], view) * 2.0;
        let mirrored = [nx * twice - view[0], ny * twice - view[1], nz * twice - view[2]];
        let at = Lit { place: [px, py, pz], normal: [nx, ny, nz], mirrored };
        let (sums, largest) = match self.batch.model.specular {
            SpecularTerm::Everywhere => self.raised::<S, true>(&at),
            _ => self.raised::<S, false>(&at),
        };
        let mut stored = [[0.0; MOST]; 6];
        for (sum, stored) in sums.iter().zip(&mut stored) {
            sum.store(&mut stored[..S::F32_LANES.min(MOST)]);
        }
        let [x, y, z] = at.mirrored;
        let finite = (x + y + z) * 0.0;
        let mut divisors = [0.0; MOST];
        (largest + finite).store(&mut divisors[..S::F32_LANES.min(MOST)]);
        (stored, divisors)
    }

    /// As `lit`, by the power of the surfaces.
    #[inline(always)]
    fn raised<S: Simd, const EVERYWHERE: bool>(&self, at: &Lit<S>) -> ([Lanes<S>; 6], Lanes<S>) {
        match self.power {
            Power::Squarings(4) => self.lit::<S, EVERYWHERE>(at, |x| x.squared::<4>()),
            Power::Squarings(5) => self.lit::<S, EVERYWHERE>(at, |x| x.squared::<5>()),
            Power::Squarings(6) => self.lit::<S, EVERYWHERE>(at, |x| x.squared::<6>()),
            Power::Squarings(times) => self.lit::<S, EVERYWHERE>(at, |x| x.powi(1 << times)),
            Power::Whole(exponent) => self.lit::<S, EVERYWHERE>(at, |x| x.powi(exponent)),
            Power::Chord => unreachable!("lit one by one"),
        }
    }

    /// Returns the sums of all lights, the body's channels before those of the highlight, and the largest
    /// divisor; `EVERYWHERE` if surfaces that face away have highlights.
    #[inline(always)]
    fn lit<S: Simd, const EVERYWHERE: bool>(
        &self,
        at: &Lit<S>,
        raise: impl Fn(Lanes<S>) -> Lanes<S>,
    ) -> ([Lanes<S>; 6], Lanes<S>) {
        let [px, py, pz] = at.place;
        let zero = px.splat(0.0);
        let one = px.splat(1.0);
        let mut largest = zero;
        let mut sums = [zero; 6];
        for &number in &self.batch.set.point {
            let Some(of) = self.plain.points.get(number as usize) else { continue };
            let to = [of[0] - px, of[1] - py, of[2] - pz];
            let distance = dot(to, to).sqrt();
            let slope = distance.mul_add(px.splat(of[5]), px.splat(of[4]));
            let divisor = distance.mul_add(slope, px.splat(of[3]));
            let product = distance * divisor;
            largest = largest.larger(product);
            let both = one / product;
            let (inverse, weight) = (both * divisor, both * distance);
            let facing = (dot(at.normal, to) * inverse).larger(zero);
            let base = (dot(at.mirrored, to) * inverse).larger(zero).smaller(one);
            let shine = raise(base) * weight;
            let shine = if EVERYWHERE { shine } else { zero.less(facing).select(shine, zero) };
            let body = facing * weight;
            sums[0] = body.mul_add(px.splat(of[6]), sums[0]);
            sums[1] = body.mul_add(px.splat(of[7]), sums[1]);
            sums[2] = body.mul_add(px.splat(of[8]), sums[2]);
            sums[3] = shine.mul_add(px.splat(of[9]), sums[3]);
            sums[4] = shine.mul_add(px.splat(of[10]), sums[4]);
            sums[5] = shine.mul_add(px.splat(of[11]), sums[5]);
        }
        (sums, largest)
    }
}

/// The fragments of the lanes.
struct Lit<S: Simd> {
    place: [Lanes<S>; 3],
    normal: [Lanes<S>; 3],
    mirrored: [Lanes<S>; 3],
}

#[inline(always)]
fn unit<S: Simd>(v: [Lanes<S>; 3]) -> [Lanes<S>; 3] {
    let inverse = 1.0 / dot(v, v).max(v[0].splat(NEAREST)).sqrt();
    v.map(|x| x * inverse)
}

#[inline(always)]
fn dot<S: Simd>([ax, ay, az]: [Lanes<S>; 3], [bx, by, bz]: [Lanes<S>; 3]) -> Lanes<S> {
    az.mul_add(bz, ay.mul_add(by, ax * bx))
}
