//! The [`robust`] form for several fragments at once, as many as the processor's registers hold.
//!
//! Each lane is a fragment and takes the same operations in the same order as [`robust::shade`],
//! none of them fused, so that its bits are the same. What `robust` skips for a fragment is masked
//! in its lane; lights that reach no lane are skipped.

use std::borrow::Cow;

use glam::Vec3;
use pulp::{Simd, WithSimd};

use super::robust::NEAREST;
use super::{Directional, Gates, Lights, Model, Point, Power, Spot, Surface, TermColors, robust};
use crate::plan::LightSet;
use crate::reference::SpecularGate;

/// The most lanes of any processor.
/// AVX-512 has 16 lanes of `f32`.
const LIMIT: usize = 16;

/// Fragments to be lit by the same lights.
pub(super) struct WideBatch<'a> {
    /// All surfaces of the frame.
    pub surfaces: &'a [Surface],
    /// The evaluation of their power, if it is that of all.
    pub power: Option<Power>,
    /// The indices of those to be lit.
    pub numbers: &'a [u32],
    pub eye: Vec3,
    pub lights: &'a Lights,
    /// Those of them that light the fragments.
    pub set: &'a LightSet,
    /// Whether no colour of theirs is infinite or NaN.
    pub finite: bool,
    pub model: &'a Model,
    pub gates: Gates,
}

impl WideBatch<'_> {
    /// Lights the fragments, which must be among the surfaces, in the colours of the frame.
    pub fn shade(&self, colors: &mut [Vec3]) {
        pulp::Arch::new().dispatch(Shading { batch: self, colors });
    }

    /// Returns the fragments by the evaluation of their power, in order.
    fn by_power(&self) -> Vec<(Power, Cow<'_, [u32]>)> {
        // Lanes must share one evaluation of the power: a branch in a lane does not exist.
        if let Some(power) = self.power {
            return vec![(power, Cow::Borrowed(self.numbers))];
        }
        let mut groups: Vec<(Power, Cow<'_, [u32]>)> = Vec::new();
        for &number in self.numbers {
            let of = self.surfaces[number as usize].power;
            match groups.iter_mut().find(|(power, _)| *power == of) {
                Some((_, group)) => group.to_mut().push(number),
                None => groups.push((of, Cow::Owned(vec![number]))),
            }
        }
        groups
    }
}

/// Returns the evaluation of the power of all surfaces, if it is the same.
pub(super) fn common_power(surfaces: &[Surface]) -> Option<Power> {
    let first = surfaces.first()?.power;
    surfaces.iter().all(|surface| surface.power == first).then_some(first)
}

struct Shading<'a> {
    batch: &'a WideBatch<'a>,
    colors: &'a mut [Vec3],
}

impl WithSimd for Shading<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Shading { batch, colors } = self;
        let mut near = Vec::new();
        let ambient = if batch.set.ambient { batch.lights.ambient } else { Vec3::ZERO };
        for (power, numbers) in batch.by_power() {
            // One by one: `exp` and `ln_1p` have no wide form; a factor 0 does not mask infinite
            // colours; a single lane has nothing to gain.
            if power == Power::Chord || !batch.finite || S::F32_LANES == 1 {
                let WideBatch { eye, model, gates, .. } = *batch;
                let mut lights = Lights::default();
                batch.lights.select(batch.set, &mut lights);
                for &number in numbers.iter() {
                    let surface = &batch.surfaces[number as usize];
                    let color = robust::shade(surface, eye, &lights, model, gates, &mut ());
                    colors[number as usize] = color;
                }
                continue;
            }
            for numbers in numbers.chunks(S::F32_LANES.min(LIMIT)) {
                let [r, g, b, sr, sg, sb] = &shade(simd, batch, power, numbers, &mut near);
                for (lane, &number) in numbers.iter().enumerate() {
                    let surface = &batch.surfaces[number as usize];
                    let body = Vec3::new(r[lane], g[lane], b[lane]);
                    let shine = Vec3::new(sr[lane], sg[lane], sb[lane]);
                    colors[number as usize] = ambient * surface.ambient
                        + body * surface.diffuse
                        + shine * surface.specular;
                }
            }
        }
    }
}

/// Returns the sums of all lights that multiply the materials, by channel and lane.
#[inline(always)]
fn shade<S: Simd>(
    simd: S,
    batch: &WideBatch<'_>,
    power: Power,
    numbers: &[u32],
    near: &mut Vec<u32>,
) -> [[f32; LIMIT]; 6] {
    let at = Fragments::new(simd, batch, power, numbers);
    let zero = simd.splat_f32s(0.0);
    let mut sums = WideSums::<S> { body: [zero; 3], shine: [zero; 3] };
    // The mask of all lanes, `0 <= 0`.
    let all = simd.less_than_or_equal_f32s(zero, zero);
    let Lights { directional, point: points, spot: spots, .. } = batch.lights;
    let [by_direction, by_point, by_spot] = &batch.set.numbers;
    for light in chosen(directional, by_direction) {
        let towards = splat(simd, light.towards);
        let one = simd.splat_f32s(1.0);
        let Directional { emission, .. } = light;
        add(simd, &at, towards, one, all, emission, &mut sums);
    }
    // Lights without a lane to reach are dropped first, then the rest is evaluated without a
    // branch.
    let lit = reached(simd, points, by_point, near, |light| point_reaches(simd, &at, light, all));
    for light in chosen(points, lit) {
        point(simd, &at, light, all, &mut sums);
    }
    let lit = reached(simd, spots, by_spot, near, |light| spot_reaches(simd, &at, light, all));
    for light in chosen(spots, lit) {
        spot(simd, &at, light, all, &mut sums);
    }
    let mut stored = [[0.0; LIMIT]; 6];
    for channel in 0..3 {
        store(simd, sums.body[channel], &mut stored[channel]);
        store(simd, sums.shine[channel], &mut stored[3 + channel]);
    }
    stored
}

type Vector<S> = [<S as Simd>::f32s; 3];

/// The fragments of the lanes.
struct Fragments<S: Simd> {
    position: Vector<S>,
    normal: Vector<S>,
    reflected: Vector<S>,
    gate: S::f32s,
    power: Power,
    gates: Gates,
    facing: SpecularGate,
}

/// The sums that multiply the material's ambient and diffuse, and its specular, colours.
struct WideSums<S: Simd> {
    body: Vector<S>,
    shine: Vector<S>,
}

impl<S: Simd> Fragments<S> {
    /// Lanes without a fragment repeat the first one.
    #[inline(always)]
    fn new(simd: S, batch: &WideBatch<'_>, power: Power, numbers: &[u32]) -> Fragments<S> {
        let mut given = [[0.0f32; LIMIT]; 7];
        // Lanes past the last fragment repeat one that exists: their sums are not read, and no NaN
        // or denormal slows the others.
        let repeated = numbers.iter().chain(std::iter::repeat(&numbers[0]));
        for (lane, number) in repeated.take(S::F32_LANES.min(LIMIT)).enumerate() {
            let Surface { position, normal, gate, .. } = batch.surfaces[*number as usize];
            let Vec3 { x, y, z } = position;
            [given[0][lane], given[1][lane], given[2][lane]] = [x, y, z];
            let Vec3 { x, y, z } = normal;
            [given[3][lane], given[4][lane], given[5][lane]] = [x, y, z];
            given[6][lane] = gate;
        }
        let [px, py, pz, nx, ny, nz, gate] = &given;
        let position = [load(simd, px), load(simd, py), load(simd, pz)];
        let normal = unit(simd, [load(simd, nx), load(simd, ny), load(simd, nz)]);
        let gate = load(simd, gate);
        let view = unit(simd, sub(simd, splat(simd, batch.eye), position));
        // The order of operations is that of `robust`, here and below: bits must be equal.
        let twice = simd.mul_f32s(simd.splat_f32s(2.0), dot(simd, normal, view));
        let reflected = sub(simd, scaled(simd, normal, twice), view);
        let (gates, facing) = (batch.gates, batch.model.specular);
        Fragments { position, normal, reflected, gate, power, gates, facing }
    }
}

/// Finds the lights that reach a lane. Apart from their evaluation, since a branch for each that is
/// taken at random costs more than the test: an index is written always and counted if it stays.
#[inline(always)]
fn reached<'a, S: Simd, L>(
    simd: S,
    lights: &[L],
    numbers: &[u32],
    into: &'a mut Vec<u32>,
    reaches: impl Fn(&L) -> S::m32s,
) -> &'a [u32] {
    into.resize(numbers.len(), 0);
    let mut len = 0;
    for &number in numbers {
        let Some(light) = lights.get(number as usize) else { continue };
        into[len] = number;
        len += usize::from(simd.first_true_m32s(reaches(light)) < S::F32_LANES);
    }
    &into[..len]
}

/// Returns the lights of these numbers.
#[inline(always)]
fn chosen<'a, L>(lights: &'a [L], numbers: &'a [u32]) -> impl Iterator<Item = &'a L> {
    numbers.iter().filter_map(|&number| lights.get(number as usize))
}

/// Returns the lanes inside the window of a light.
#[inline(always)]
fn point_reaches<S: Simd>(simd: S, at: &Fragments<S>, light: &Point, all: S::m32s) -> S::m32s {
    if !(at.gates.window && light.range > 0.0) {
        return all;
    }
    let to = sub(simd, splat(simd, light.position), at.position);
    let ratio = simd.mul_f32s(dot(simd, to, to), simd.splat_f32s(light.inverse_square_range));
    // `not (ratio >= 1)`, since a NaN ratio is not skipped by `robust` either.
    simd.not_m32s(simd.greater_than_or_equal_f32s(ratio, simd.splat_f32s(1.0)))
}

#[inline(always)]
fn point<S: Simd>(simd: S, at: &Fragments<S>, light: &Point, all: S::m32s, sums: &mut WideSums<S>) {
    let to = sub(simd, splat(simd, light.position), at.position);
    let square = dot(simd, to, to);
    let inverse = inverse_length(simd, square);
    let weight = attenuation(simd, light, square, inverse);
    let reached = point_reaches(simd, at, light, all);
    add(simd, at, scaled(simd, to, inverse), weight, reached, &light.emission, sums);
}

/// Returns the lanes inside the cone of a light.
#[inline(always)]
fn spot_reaches<S: Simd>(simd: S, at: &Fragments<S>, light: &Spot, all: S::m32s) -> S::m32s {
    if !at.gates.cone {
        return all;
    }
    let to = sub(simd, splat(simd, light.point.position), at.position);
    let towards = scaled(simd, to, inverse_length(simd, dot(simd, to, to)));
    let outside = simd.less_than_or_equal_f32s(cone(simd, light, towards), simd.splat_f32s(0.0));
    simd.not_m32s(outside)
}

#[inline(always)]
fn spot<S: Simd>(simd: S, at: &Fragments<S>, light: &Spot, all: S::m32s, sums: &mut WideSums<S>) {
    let to = sub(simd, splat(simd, light.point.position), at.position);
    let square = dot(simd, to, to);
    let inverse = inverse_length(simd, square);
    let towards = scaled(simd, to, inverse);
    let cone = cone(simd, light, towards);
    let weight = simd.mul_f32s(attenuation(simd, &light.point, square, inverse), cone);
    let reached = spot_reaches(simd, at, light, all);
    add(simd, at, towards, weight, reached, &light.point.emission, sums);
}

#[inline(always)]
fn cone<S: Simd>(simd: S, light: &Spot, towards: Vector<S>) -> S::f32s {
    let chord = sub(simd, towards, splat(simd, light.axis));
    let half = simd.mul_f32s(simd.splat_f32s(0.5), dot(simd, chord, chord));
    let inside = simd.sub_f32s(simd.splat_f32s(light.outer_chord), half);
    unorm(simd, simd.mul_f32s(inside, simd.splat_f32s(light.ramp)))
}

#[inline(always)]
fn attenuation<S: Simd>(simd: S, light: &Point, square: S::f32s, inverse: S::f32s) -> S::f32s {
    let one = simd.splat_f32s(1.0);
    let distance = simd.mul_f32s(square, inverse);
    let slope = simd.mul_f32s(simd.splat_f32s(light.quadratic), distance);
    let slope = simd.add_f32s(simd.splat_f32s(light.linear), slope);
    let divisor = simd.mul_f32s(distance, slope);
    let divisor = simd.add_f32s(simd.splat_f32s(light.constant), divisor);
    let weight = simd.div_f32s(one, divisor);
    if light.range > 0.0 {
        let ratio = simd.mul_f32s(square, simd.splat_f32s(light.inverse_square_range));
        let rest = simd.sub_f32s(one, simd.mul_f32s(ratio, ratio));
        let window = positive(simd, rest);
        return simd.mul_f32s(simd.mul_f32s(weight, window), window);
    }
    weight
}

#[inline(always)]
fn add<S: Simd>(
    simd: S,
    at: &Fragments<S>,
    towards: Vector<S>,
    weight: S::f32s,
    reached: S::m32s,
    emission: &TermColors,
    sums: &mut WideSums<S>,
) {
    let zero = simd.splat_f32s(0.0);
    let facing = positive(simd, dot(simd, at.normal, towards));
    // The colours and `facing` are finite, so that a weight of 0 adds 0, which changes no bit of a
    // sum that started at 0.
    let weight = simd.select_f32s(reached, weight, zero);
    let mut lit = scaled(simd, splat(simd, emission.diffuse), facing);
    // `robust` adds an ambient of 0 as well; `0 + x` is `x` but for the sign of a zero, which no
    // sum shows.
    if emission.ambient != Vec3::ZERO {
        lit = plus(simd, splat(simd, emission.ambient), lit);
    }
    sums.body = plus(simd, sums.body, scaled(simd, lit, weight));
    let base = unorm(simd, dot(simd, towards, at.reflected));
    let mut shining = reached;
    if at.facing == SpecularGate::Facing {
        let behind = simd.less_than_or_equal_f32s(facing, zero);
        shining = simd.and_m32s(shining, simd.not_m32s(behind));
    }
    if at.gates.power {
        let below = simd.less_than_or_equal_f32s(base, at.gate);
        shining = simd.and_m32s(shining, simd.not_m32s(below));
    }
    let shine = simd.mul_f32s(raise(simd, base, at.power), weight);
    let shine = simd.select_f32s(shining, shine, zero);
    let specular = scaled(simd, splat(simd, emission.specular), shine);
    sums.shine = plus(simd, sums.shine, specular);
}

/// Returns an integer power, as `robust` does.
#[inline(always)]
fn raise<S: Simd>(simd: S, base: S::f32s, power: Power) -> S::f32s {
    match power {
        Power::Squarings(times) => {
            let mut power = base;
            for _ in 0..times {
                power = simd.mul_f32s(power, power);
            }
            power
        }
        Power::Whole(exponent) => {
            let (mut power, mut square, mut left) = (simd.splat_f32s(1.0), base, exponent);
            while left > 0 {
                if left & 1 == 1 {
                    // The same order of products as `robust::integer_power`.
                    power = simd.mul_f32s(power, square);
                }
                square = simd.mul_f32s(square, square);
                left >>= 1;
            }
            power
        }
        Power::Chord => unreachable!("lit one by one"),
    }
}

#[inline(always)]
fn unit<S: Simd>(simd: S, v: Vector<S>) -> Vector<S> {
    scaled(simd, v, inverse_length(simd, dot(simd, v, v)))
}

/// Returns `1 / sqrt(max(square, NEAREST))`; `NEAREST` for NaN too, as `f32::max` has it.
#[inline(always)]
fn inverse_length<S: Simd>(simd: S, square: S::f32s) -> S::f32s {
    let nearest = simd.splat_f32s(NEAREST);
    let square = simd.select_f32s(simd.greater_than_f32s(square, nearest), square, nearest);
    simd.div_f32s(simd.splat_f32s(1.0), simd.sqrt_f32s(square))
}

/// Returns `max(x, 0)`; 0 for NaN.
#[inline(always)]
fn positive<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let zero = simd.splat_f32s(0.0);
    simd.select_f32s(simd.greater_than_f32s(x, zero), x, zero)
}

/// Returns `x` limited to 0 to 1; NaN stays.
#[inline(always)]
fn unorm<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let (zero, one) = (simd.splat_f32s(0.0), simd.splat_f32s(1.0));
    let x = simd.select_f32s(simd.less_than_f32s(x, zero), zero, x);
    simd.select_f32s(simd.greater_than_f32s(x, one), one, x)
}

#[inline(always)]
fn splat<S: Simd>(simd: S, v: Vec3) -> Vector<S> {
    [simd.splat_f32s(v.x), simd.splat_f32s(v.y), simd.splat_f32s(v.z)]
}

#[inline(always)]
fn sub<S: Simd>(simd: S, a: Vector<S>, b: Vector<S>) -> Vector<S> {
    [simd.sub_f32s(a[0], b[0]), simd.sub_f32s(a[1], b[1]), simd.sub_f32s(a[2], b[2])]
}

#[inline(always)]
fn plus<S: Simd>(simd: S, a: Vector<S>, b: Vector<S>) -> Vector<S> {
    [simd.add_f32s(a[0], b[0]), simd.add_f32s(a[1], b[1]), simd.add_f32s(a[2], b[2])]
}

#[inline(always)]
fn scaled<S: Simd>(simd: S, v: Vector<S>, by: S::f32s) -> Vector<S> {
    [simd.mul_f32s(v[0], by), simd.mul_f32s(v[1], by), simd.mul_f32s(v[2], by)]
}

/// Returns `x x' + y y' + z z'`, added in this order.
#[inline(always)]
fn dot<S: Simd>(simd: S, a: Vector<S>, b: Vector<S>) -> S::f32s {
    let [x, y, z] =
        [simd.mul_f32s(a[0], b[0]), simd.mul_f32s(a[1], b[1]), simd.mul_f32s(a[2], b[2])];
    simd.add_f32s(simd.add_f32s(x, y), z)
}

#[inline(always)]
fn load<S: Simd>(simd: S, values: &[f32; LIMIT]) -> S::f32s {
    simd.partial_load_f32s(&values[..S::F32_LANES.min(LIMIT)])
}

#[inline(always)]
fn store<S: Simd>(simd: S, values: S::f32s, into: &mut [f32; LIMIT]) {
    simd.partial_store_f32s(&mut into[..S::F32_LANES.min(LIMIT)], values);
}
