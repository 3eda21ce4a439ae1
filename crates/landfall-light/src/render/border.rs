//! The fragments at which a plan is most likely to be wrong: those nearest to each light among the
//! regions that leave it out, where a light that does not end where the model does still shines.

use glam::DVec3;

use super::{RenderError, Rendered, Renderer, Work};
use crate::culling::{LightSet, Measured, Plan};
use crate::plan::Draw;
use crate::{Frame, Upload};
use landfall_exec::backend::Backend;

/// The most light evaluations of a check; the number of its fragments follows.
const MOST: usize = 1 << 20;

/// The fewest and the most fragments of a check.
const FRAGMENTS: [usize; 2] = [256, 4096];

impl Renderer {
    /// Compares a picture made by a plan with the shader's own result for all lights: at fragments
    /// all over the frame, and at those nearest to each light among the regions that leave it out.
    ///
    /// # Errors
    /// More lights than slots, or a failure of the backend.
    pub fn check_plan<R: Backend + ?Sized>(
        &self,
        backend: &mut R,
        work: &Work<'_>,
        plan: &Plan,
        rendered: &Rendered,
    ) -> Result<Measured, RenderError> {
        let lights = &work.upload.lights;
        let count = lights.directional.len() + lights.point.len() + lights.spot.len();
        let most = (MOST / count.max(1)).clamp(FRAGMENTS[0], FRAGMENTS[1]);
        let total = work.frame.fragments.len();
        let every = total.div_ceil(most / 2).max(1);
        let mut numbers: Vec<u32> = (0..total as u32).step_by(every).collect();
        numbers.extend(borders(plan, work.upload, work.frame, most / 2));
        numbers.sort_unstable();
        numbers.dedup();
        let measured = self.check_at(backend, work, rendered, &numbers)?;
        Ok(Measured { every: 0, ..measured })
    }
}

/// A draw with the bounds of its fragments.
struct Bounded<'p> {
    draw: &'p Draw,
    low: DVec3,
    high: DVec3,
}

impl Bounded<'_> {
    fn distance(&self, place: DVec3) -> f64 {
        (self.low - place).max(place - self.high).max(DVec3::ZERO).length()
    }
}

/// Returns at most so many fragments at the borders of the regions of a plan.
fn borders(plan: &Plan, upload: &Upload, frame: &Frame, most: usize) -> Vec<u32> {
    let position = |at: u32| DVec3::from(frame.fragments[at as usize].position.map(f64::from));
    let normal = |at: u32| {
        DVec3::from(frame.fragments[at as usize].normal.map(f64::from)).normalize_or_zero()
    };
    let draws: Vec<Bounded<'_>> = plan
        .draws
        .iter()
        .filter(|draw| !draw.fragments.is_empty())
        .map(|draw| {
            let places = draw.fragments.iter().map(|at| position(*at));
            let (low, high) = places
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), at| {
                    (low.min(at), high.max(at))
                });
            Bounded { draw, low, high }
        })
        .collect();
    let lights = &upload.lights;
    let mut found = Vec::new();
    for (number, light) in lights.directional.iter().enumerate() {
        let out = left_out(&draws, |set| &set.directional, number);
        let all = out.flat_map(|bounded| bounded.draw.fragments.iter().copied());
        let facing = |at: &u32| normal(*at).dot(-light.direction);
        found.extend(all.max_by(|a, b| facing(a).total_cmp(&facing(b))));
    }
    // As many lights as there is room for, two or three fragments each.
    let lamps = lights.point.len() + lights.spot.len();
    let stride = (3 * lamps).div_ceil(most.max(1)).max(1);
    for (number, light) in lights.point.iter().enumerate().step_by(stride) {
        let out = left_out(&draws, |set| &set.point, number);
        found.extend(nearest(out, light.position, &position));
    }
    for (number, light) in lights.spot.iter().enumerate().step_by(stride) {
        let place = light.lamp.position;
        found.extend(nearest(left_out(&draws, |set| &set.spot, number), place, &position));
        let along = |at: DVec3| (at - place).normalize_or_zero().dot(light.direction);
        let out = left_out(&draws, |set| &set.spot, number);
        let middle = |bounded: &Bounded<'_>| along((bounded.low + bounded.high) * 0.5);
        let ahead = out.max_by(|a, b| middle(a).total_cmp(&middle(b)));
        let fragments = ahead.into_iter().flat_map(|bounded| bounded.draw.fragments.iter());
        let axis = |at: &u32| along(position(*at));
        found.extend(fragments.copied().max_by(|a, b| axis(a).total_cmp(&axis(b))));
    }
    found
}

/// Returns the draws that leave out a light.
fn left_out<'d, 'p>(
    draws: &'d [Bounded<'p>],
    of: impl Fn(&LightSet) -> &Vec<u32> + 'd,
    number: usize,
) -> impl Iterator<Item = &'d Bounded<'p>> {
    let has = move |bounded: &&Bounded<'_>| {
        of(&bounded.draw.lights).binary_search(&(number as u32)).is_err()
    };
    draws.iter().filter(has)
}

/// Returns the nearest fragment of each of the two nearest draws.
fn nearest<'d, 'p: 'd>(
    draws: impl Iterator<Item = &'d Bounded<'p>>,
    place: DVec3,
    position: &impl Fn(u32) -> DVec3,
) -> Vec<u32> {
    let mut near: Vec<(f64, &Bounded<'_>)> = Vec::new();
    for bounded in draws {
        let distance = bounded.distance(place);
        let at = near.partition_point(|(known, _)| *known <= distance);
        if at < 2 {
            near.insert(at, (distance, bounded));
            near.truncate(2);
        }
    }
    let apart = |at: &u32| (position(*at) - place).length_squared();
    let nearest = near.iter().filter_map(|(_, bounded)| {
        bounded.draw.fragments.iter().copied().min_by(|a, b| apart(a).total_cmp(&apart(b)))
    });
    nearest.collect()
}
