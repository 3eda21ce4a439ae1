//! The lights that each region keeps.
//!
//! Lights are tested against blocks of regions first: a light without effect in a block has none in
//! its regions, which saves most tests.

use glam::DVec3;

use super::STEP;
use super::bound::Bounded;
use super::options::Options;
use super::region::{DividedFrame, Region};
use crate::shading_f32::Model;

/// The lights of each region, as ascending indices into the given list.
pub(super) struct Lists {
    pub of: Vec<Vec<u32>>,
    /// The number of tests of a light against a region.
    pub tests: u64,
    /// The largest sum of dropped bounds in any channel of any region.
    pub dropped: DVec3,
}

pub(super) fn lists(
    divided: &DividedFrame,
    lights: &[Bounded],
    model: &Model,
    options: &Options,
) -> Lists {
    // What is shown of the code leaves nothing to the model: only the range is tested. Without a
    // budget a bound's size is of no use, and `adds` does not compute it.
    let keeps = |place: u32, region: &Region| {
        let light = &lights[place as usize];
        match (&options.shown, options.budget) {
            (Some(_), _) => light.reaches(region).then_some(DVec3::ZERO),
            (None, None) => light.adds(region, model).then_some(DVec3::ZERO),
            (None, Some(_)) => Some(light.most(region, model)).filter(|most| *most != DVec3::ZERO),
        }
    };
    // Three tests, the cheapest first: sphere against block, sphere against the cells of the
    // block, then the bound itself. A block's region contains those of its cells, so what misses
    // the block misses them.
    let all = Spheres::from_lights(lights);
    let mut tests = 0;
    let mut near: Vec<u32> = Vec::new();
    let blocks: Vec<Spheres> = divided
        .blocks
        .iter()
        .map(|block| {
            all.near(block, &mut near);
            tests += near.len() as u64;
            near.retain(|&place| keeps(place, block).is_some());
            all.some(&near)
        })
        .collect();
    let mut dropped = DVec3::ZERO;
    let mut bounds: Vec<(u32, DVec3)> = Vec::new();
    let of = divided
        .cells
        .iter()
        .map(|cell| {
            blocks[cell.block].near(&cell.region, &mut near);
            tests += near.len() as u64;
            // Exact: everything near stays, nothing is spent.
            let Some(steps) = options.budget else {
                near.retain(|&place| keeps(place, &cell.region).is_some());
                return near.clone();
            };
            bounds.clear();
            let most = |&place: &u32| keeps(place, &cell.region).map(|most| (place, most));
            bounds.extend(near.iter().filter_map(most));
            // `keeps` has already removed bounds of zero, which cost no budget.
            dropped = dropped.max(spend(&mut bounds, steps * STEP));
            bounds.iter().map(|(place, _)| *place).collect()
        })
        .collect();
    Lists { of, tests, dropped }
}

/// Returns the smallest `f32` not below a non-negative `x`.
fn round_up(x: f64) -> f32 {
    let nearest = x as f32;
    // Rounding a radius down would leave out a light at its very edge.
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

/// The spheres outside which lights contribute nothing, in `f32` and by component, so that one
/// instruction tests several.
#[derive(Default)]
struct Spheres {
    center: [Vec<f32>; 3],
    /// The squares of the radii, larger by the error of the test.
    square: Vec<f32>,
    /// The indices of the lights.
    places: Vec<u32>,
}

impl Spheres {
    fn from_lights(lights: &[Bounded]) -> Spheres {
        let mut spheres = Spheres::default();
        for (place, light) in lights.iter().enumerate() {
            let (center, radius) = light.sphere();
            // A position rounded to `f32` moves by 2^-24 of its size; the sum of the squares of
            // three differences, each rounded, is off by less than 2^-21 of it.
            let radius =
                radius * (1.0 + 2f64.powi(-20)) + center.abs().max_element() * 2f64.powi(-22);
            spheres.push(center.as_vec3().to_array(), round_up(radius * radius), place as u32);
        }
        spheres
    }

    fn push(&mut self, center: [f32; 3], square: f32, place: u32) {
        for (to, at) in self.center.iter_mut().zip(center) {
            to.push(at);
        }
        self.square.push(square);
        self.places.push(place);
    }

    /// Returns the spheres at these indices, which are ascending and among its own.
    fn some(&self, places: &[u32]) -> Spheres {
        // One pass over both, since both are ascending.
        let mut spheres = Spheres::default();
        let mut at = 0;
        for &place in places {
            while self.places[at] != place {
                at += 1;
            }
            let center = [0, 1, 2].map(|axis: usize| self.center[axis][at]);
            spheres.push(center, self.square[at], place);
        }
        spheres
    }

    /// Finds the lights whose spheres touch the box of a region, and at most a few others.
    fn near(&self, region: &Region, into: &mut Vec<u32>) {
        into.clear();
        // A box with NaN or infinity in it has no distance: all lights count as near.
        if !region.is_finite() {
            into.extend_from_slice(&self.places);
            return;
        }
        // The corners are those of fragments, and so numbers of `f32`.
        let (low, high) = (region.low.as_vec3(), region.high.as_vec3());
        into.resize(self.places.len(), 0);
        let [x, y, z] = &self.center;
        let lights = x.iter().zip(y).zip(z).zip(&self.square).zip(&self.places);
        let mut len = 0;
        // `max(0)` makes the gap along an axis 0 inside of the box; the sum is the squared
        // distance.
        for ((((x, y), z), square), place) in lights {
            let dx = (low.x - x).max(x - high.x).max(0.0);
            let dy = (low.y - y).max(y - high.y).max(0.0);
            let dz = (low.z - z).max(z - high.z).max(0.0);
            // Written always, counted if near: no branch is mispredicted.
            into[len] = *place;
            // `!far` keeps a light whose distance is NaN.
            let far = dx * dx + dy * dy + dz * dz > *square;
            len += usize::from(!far);
        }
        into.truncate(len);
    }
}

/// Drops as many lights as contribute at most `budget` together in any channel, the weakest first,
/// which maximises their number; returns their largest contribution.
fn spend(bounds: &mut Vec<(u32, DVec3)>, budget: f64) -> DVec3 {
    // The greedy choice: with one budget for each channel, the light that is weakest in its
    // strongest channel goes first.
    bounds.sort_unstable_by(|a, b| a.1.max_element().total_cmp(&b.1.max_element()));
    let mut sum = DVec3::ZERO;
    let mut count = 0;
    for (_, most) in bounds.iter() {
        let next = sum + *most;
        // Bounds are infinite or numbers, never NaN.
        if next.max_element() > budget {
            break;
        }
        sum = next;
        count += 1;
    }
    // Back to ascending order, that of the sum of a shader and of shared draws.
    bounds.drain(..count);
    bounds.sort_unstable_by_key(|(place, _)| *place);
    sum
}
