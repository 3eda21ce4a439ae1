//! The planes of a frame and the grids of far lights on them.
//!
//! On a plane `n . (light - p)` is constant, so that the facing of a far light has one sign, and
//! attenuation and highlight are smooth: a light `k` diameters away is a polynomial up to an error
//! that falls with `k`. The fragments of a plane are halved repeatedly; each half removes the
//! lights that are far for its size from the list passed on to its own halves.

use std::collections::HashMap;

use glam::DVec3;

use super::bound::{Bounded, Shape};
use super::options::Interpolate;
use super::region::{Points, Region};
use super::{Job, set};
use crate::Fragment;
use crate::plan::{Draw, Grid, Plan, places};
use crate::scene::Surface;

/// Returns the plan with grids, the tests of lights against patches, and the fragments sorted.
pub(super) fn patches(job: &Job<'_>, interpolate: Interpolate) -> (Plan, u64, u64) {
    let points = Points::new(job.frame, job.upload, job.model);
    let mut patches = Patches {
        job,
        points: &points,
        nodes: (interpolate.nodes * interpolate.nodes) as usize,
        interpolate,
        plan: Plan::default(),
        tests: 0,
        sorted: 0,
    };
    let all: Vec<u32> = (0..job.lights.len() as u32).collect();
    let (planes, rest) = planes(job, &points);
    for (plane, fragments) in planes {
        patches.split(fragments, Some(&plane), &all, None);
    }
    for fragments in rest {
        patches.split(fragments, None, &all, None);
    }
    (patches.plan, patches.tests, patches.sorted)
}

/// The directions of a plane.
struct Plane {
    axes: [DVec3; 2],
}

/// The fewest fragments for a plane of its own.
const FEWEST: usize = 24;
/// The resolution at which normals are compared.
const SAME_NORMAL: f64 = 65_536.0;
/// The distance, in diameters of a plane, beyond which a fragment is off it.
const FLAT: f64 = 1e-4;

type Group = Vec<u32>;

/// Returns the fragments of each plane of each object, and those on no plane.
fn planes(job: &Job<'_>, points: &Points<'_>) -> (Vec<(Plane, Group)>, Vec<Group>) {
    let plain: Vec<bool> = job
        .upload
        .materials
        .iter()
        .map(|m| {
            let surfaces = [&m.ambient, &m.diffuse, &m.specular];
            surfaces.iter().all(|surface| matches!(surface, Surface::Constant(_)))
        })
        .collect();
    let mut groups: Vec<(u32, Group)> = Vec::new();
    let mut known: HashMap<(u32, u32, [i32; 3]), usize> = HashMap::new();
    let mut rest: Vec<(u32, Group)> = Vec::new();
    let mut curved: HashMap<u32, usize> = HashMap::new();
    let mut set_aside = |object: u32, fragments: Group| {
        let at = *curved.entry(object).or_insert_with(|| {
            rest.push((object, Vec::new()));
            rest.len() - 1
        });
        rest[at].1.extend(fragments);
    };
    for (number, fragment) in job.frame.fragments.iter().enumerate() {
        let normal = points.normal(number as u32);
        let flat = plain.get(fragment.material as usize).copied().unwrap_or(false);
        if !flat || normal == DVec3::ZERO {
            set_aside(fragment.object, vec![number as u32]);
            continue;
        }
        let key = (normal * SAME_NORMAL).round().to_array().map(|at| at as i32);
        let at = *known.entry((fragment.object, fragment.material, key)).or_insert_with(|| {
            groups.push((fragment.object, Vec::new()));
            groups.len() - 1
        });
        groups[at].1.push(number as u32);
    }
    let mut planes = Vec::new();
    for (object, group) in groups {
        let normal = points.normal(group[0]);
        let (first, second) = normal.any_orthonormal_pair();
        let region = points.region(&group);
        let origin = points.position(group[0]);
        let diameter = (region.high - region.low).length();
        let off = |n: &u32| (points.position(*n) - origin).dot(normal).abs();
        if group.len() >= FEWEST && group.iter().all(|n| off(n) <= FLAT * diameter) {
            planes.push((Plane { axes: [first, second] }, group));
        } else {
            set_aside(object, group);
        }
    }
    (planes, rest.into_iter().map(|(_, group)| group).collect())
}

struct Patches<'a> {
    job: &'a Job<'a>,
    points: &'a Points<'a>,
    interpolate: Interpolate,
    /// The nodes of a grid.
    nodes: usize,
    plan: Plan,
    tests: u64,
    sorted: u64,
}

impl Patches<'_> {
    fn split(
        &mut self,
        mut fragments: Group,
        plane: Option<&Plane>,
        candidates: &[u32],
        parent: Option<u32>,
    ) {
        let region = self.points.region(&fragments);
        self.tests += candidates.len() as u64;
        self.sorted += fragments.len() as u64;
        let (lights, model) = (self.job.lights, self.job.model);
        let shines = |place: &u32| lights[*place as usize].most(&region, model) != DVec3::ZERO;
        let mut near: Vec<u32> = candidates.iter().copied().filter(shines).collect();
        let mut grid = parent;
        let sides = match plane {
            Some(plane) => {
                let rectangle = self.rectangle(&fragments, plane);
                grid = self.take_far(&fragments, plane, &rectangle, &region, &mut near, parent);
                rectangle.half
            }
            None => [0.0; 2],
        };
        let lamps = near.iter().any(|&p| matches!(lights[p as usize].shape, Ok(Shape::Around(_))));
        if !lamps || fragments.len() <= self.nodes * 3 {
            fragments.sort_unstable();
            let lights = set(lights, &near, self.job.ambient);
            self.plan.draws.push(Draw { fragments, lights, grid });
            return;
        }
        let axis = match plane {
            Some(plane) => plane.axes[usize::from(sides[1] > sides[0])],
            None => longest(&region),
        };
        let along = |n: &u32| self.points.position(*n).dot(axis);
        let middle = fragments.len() / 2;
        fragments.select_nth_unstable_by(middle, |a, b| along(a).total_cmp(&along(b)));
        let upper = fragments.split_off(middle);
        self.split(fragments, plane, &near, grid);
        self.split(upper, plane, &near, grid);
    }

    fn rectangle(&self, fragments: &[u32], plane: &Plane) -> Rectangle {
        let origin = self.points.position(fragments[0]);
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for &number in fragments {
            let from = self.points.position(number) - origin;
            for axis in 0..2 {
                let at = from.dot(plane.axes[axis]);
                (low[axis], high[axis]) = (low[axis].min(at), high[axis].max(at));
            }
        }
        let middle = [0, 1].map(|axis| (low[axis] + high[axis]) / 2.0);
        let center = origin + plane.axes[0] * middle[0] + plane.axes[1] * middle[1];
        let half = [0, 1].map(|axis| (high[axis] - low[axis]) / 2.0);
        Rectangle { center, half }
    }

    /// Moves the lights far from the rectangle out of `near` into a grid of their own; returns the
    /// innermost grid.
    fn take_far(
        &mut self,
        fragments: &[u32],
        plane: &Plane,
        rectangle: &Rectangle,
        region: &Region,
        near: &mut Vec<u32>,
        parent: Option<u32>,
    ) -> Option<u32> {
        let Rectangle { center, half } = *rectangle;
        let diameter = 2.0 * half[0].hypot(half[1]);
        let apart = self.interpolate.diameters * diameter;
        let lights = self.job.lights;
        let is_far = |place: &u32| far(&lights[*place as usize], region, apart);
        let count = near.iter().filter(|place| is_far(place)).count();
        // Worth it if the evaluations saved exceed the cost of nodes and polynomial.
        let saved = count as f64 * (fragments.len() as f64 - self.nodes as f64);
        let polynomial = if parent.is_some() { self.nodes } else { fragments.len() };
        let costs = &self.job.options.costs;
        let overhead = costs.interpolation / costs.evaluation * polynomial as f64;
        if count == 0 || diameter <= 0.0 || saved <= overhead {
            return parent;
        }
        let (taken, kept): (Vec<u32>, Vec<u32>) = near.iter().partition(|place| is_far(place));
        *near = kept;
        // Not so narrow that rounding of node positions matters.
        let half = half.map(|h| h.max(diameter * 1e-3));
        let places = places(self.interpolate.nodes);
        let first = &self.job.frame.fragments[fragments[0] as usize];
        let node = |x: f64, y: f64| {
            let at = center + plane.axes[0] * (x * half[0]) + plane.axes[1] * (y * half[1]);
            Fragment { position: at.as_vec3().to_array(), ..*first }
        };
        let row = |y: &f64| places.iter().map(|x| node(*x, *y)).collect::<Vec<_>>();
        self.plan.grids.push(Grid {
            nodes: places.iter().flat_map(row).collect(),
            side: self.interpolate.nodes,
            lights: set(lights, &taken, false),
            parent,
            center,
            axes: plane.axes,
            half,
        });
        Some(self.plan.grids.len() as u32 - 1)
    }
}

struct Rectangle {
    center: DVec3,
    half: [f64; 2],
}

/// Whether a light is that far from a region and smooth all over it: without a cone, and with no
/// window ending there.
fn far(light: &Bounded, region: &Region, apart: f64) -> bool {
    let Ok(Shape::Around(lamp)) = &light.shape else { return false };
    let farthest = (region.high - lamp.position).abs().max((region.low - lamp.position).abs());
    lamp.cone.is_none() && region.distance(lamp.position) >= apart && farthest.length() < lamp.range
}

fn longest(region: &Region) -> DVec3 {
    let size = region.high - region.low;
    if size.x >= size.y && size.x >= size.z {
        DVec3::X
    } else if size.y >= size.z {
        DVec3::Y
    } else {
        DVec3::Z
    }
}
