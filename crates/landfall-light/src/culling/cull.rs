//! The lights that each region keeps.
//!
//! Lights are tested against blocks of regions first: a light without effect in a block has none in
//! its regions, which saves most tests.

use glam::DVec3;

use super::STEP;
use super::bound::{Bounded, Shape};
use super::options::Cull;
use super::radius;
use super::region::{Divided, Region};
use crate::shading_f32::Model;

/// The lights of each region, as ascending indices into the given list.
pub(super) struct Lists {
    pub of: Vec<Vec<u32>>,
    /// The number of tests of a light against a region.
    pub tests: u64,
    /// The largest sum of dropped bounds in any channel of any region.
    pub dropped: DVec3,
}

pub(super) fn lists(divided: &Divided, lights: &[Bounded], model: &Model, cull: Cull) -> Lists {
    let reach: Vec<f64> = match cull {
        Cull::Range(tau) => lights.iter().map(|light| reach(light, tau)).collect(),
        Cull::Exact | Cull::Budget(_) | Cull::Threshold(_) => Vec::new(),
    };
    let keeps = |place: u32, region: &Region| {
        let light = &lights[place as usize];
        match (cull, light.shape) {
            (Cull::Range(_), Ok(Shape::Around(lamp)))
                if region.distance(lamp.position) > reach[place as usize] =>
            {
                None
            }
            (Cull::Threshold(tau), _) => {
                Some(light.most(region, model)).filter(|most| most.max_element() >= tau)
            }
            (Cull::Exact | Cull::Budget(_) | Cull::Range(_), _) => {
                Some(light.most(region, model)).filter(|most| *most != DVec3::ZERO)
            }
        }
    };
    let all: Vec<u32> = (0..lights.len() as u32).collect();
    let mut tests = 0;
    let blocks: Vec<Vec<u32>> = divided
        .blocks
        .iter()
        .map(|block| {
            tests += all.len() as u64;
            all.iter().copied().filter(|&place| keeps(place, block).is_some()).collect()
        })
        .collect();
    let mut dropped = DVec3::ZERO;
    let mut bounds: Vec<(u32, DVec3)> = Vec::new();
    let of = divided
        .cells
        .iter()
        .map(|cell| {
            let candidates = &blocks[cell.block];
            tests += candidates.len() as u64;
            bounds.clear();
            bounds.extend(
                candidates
                    .iter()
                    .filter_map(|&place| keeps(place, &cell.region).map(|most| (place, most))),
            );
            if let Cull::Budget(steps) = cull {
                dropped = dropped.max(spend(&mut bounds, steps * STEP));
            }
            bounds.iter().map(|(place, _)| *place).collect()
        })
        .collect();
    Lists { of, tests, dropped }
}

/// Drops as many lights as contribute at most `budget` together in any channel, the weakest first,
/// which maximises their number; returns their largest contribution.
fn spend(bounds: &mut Vec<(u32, DVec3)>, budget: f64) -> DVec3 {
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
    bounds.drain(..count);
    bounds.sort_unstable_by_key(|(place, _)| *place);
    sum
}

fn reach(light: &Bounded, tau: f64) -> f64 {
    let Ok(Shape::Around(lamp)) = light.shape else { return f64::INFINITY };
    let [constant, linear, quadratic] = lamp.attenuation;
    let attenuation = crate::scene::Attenuation { constant, linear, quadratic, range: None };
    radius::radius(&attenuation, light.strength(), tau).unwrap_or(f64::INFINITY)
}
