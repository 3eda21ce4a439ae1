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
use super::smooth::{Order, Reflects};
use super::{Job, STEP, set, smooth};
use crate::Fragment;
use crate::plan::{Draw, Grid, Plan, places};
use crate::scene::Surface;

/// A plan with grids.
pub(super) struct Patched {
    pub plan: Plan,
    /// The tests of lights against patches.
    pub tests: u64,
    /// The fragments sorted.
    pub sorted: u64,
    /// The largest sum of proven errors at a fragment.
    pub error: f64,
}

/// Returns the plan with grids.
pub(super) fn patches(job: &Job<'_>, interpolate: Interpolate) -> Patched {
    let points = Points::new(job.frame, job.upload, job.model);
    let mut patches = Patches {
        job,
        points: &points,
        nodes: (interpolate.nodes * interpolate.nodes) as usize,
        interpolate,
        plan: Plan::default(),
        tests: 0,
        sorted: 0,
        error: 0.0,
        order: Order::new(interpolate.nodes.min(6)),
    };
    let all: Vec<u32> = (0..job.lights.len() as u32).collect();
    let (planes, rest) = planes(job, &points);
    for (plane, fragments) in planes {
        patches.split(fragments, Some(&plane), &all, Above { grid: None, spent: 0.0 });
    }
    for fragments in rest {
        patches.split(fragments, None, &all, Above { grid: None, spent: 0.0 });
    }
    let Patches { plan, tests, sorted, error, .. } = patches;
    Patched { plan, tests, sorted, error }
}

/// The directions of a plane.
struct Plane {
    axes: [DVec3; 2],
    normal: DVec3,
    /// The largest distance of a fragment from it.
    off: f64,
    /// The largest difference of a unit normal from its own.
    tilt: f64,
}

/// What larger patches give a patch.
#[derive(Clone, Copy)]
struct Above {
    /// The innermost grid around it.
    grid: Option<u32>,
    /// The proven error of all grids around it.
    spent: f64,
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
        let off = group.iter().map(off).fold(0.0, f64::max);
        if group.len() >= FEWEST && off <= FLAT * diameter {
            let tilt = |n: &u32| (points.normal(*n) - normal).length();
            let tilt = group.iter().map(tilt).fold(0.0, f64::max);
            planes.push((Plane { axes: [first, second], normal, off, tilt }, group));
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
    error: f64,
    order: Order,
}

impl Patches<'_> {
    fn split(
        &mut self,
        mut fragments: Group,
        plane: Option<&Plane>,
        candidates: &[u32],
        above: Above,
    ) {
        let region = self.points.region(&fragments);
        self.tests += candidates.len() as u64;
        self.sorted += fragments.len() as u64;
        let (lights, model) = (self.job.lights, self.job.model);
        let shines = |place: &u32| lights[*place as usize].most(&region, model) != DVec3::ZERO;
        let mut near: Vec<u32> = candidates.iter().copied().filter(shines).collect();
        let mut here = above;
        let sides = match plane {
            Some(plane) => {
                let rectangle = self.rectangle(&fragments, plane);
                here = self.take_far(&fragments, plane, &rectangle, &region, &mut near, above);
                rectangle.half
            }
            None => [0.0; 2],
        };
        let lamps = near.iter().any(|&p| matches!(lights[p as usize].shape, Ok(Shape::Around(_))));
        if !lamps || fragments.len() <= self.nodes * 3 {
            fragments.sort_unstable();
            let lights = set(lights, &near, self.job.ambient);
            self.plan.draws.push(Draw { fragments, lights, grid: here.grid });
            self.error = self.error.max(here.spent);
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
        self.split(fragments, plane, &near, here);
        self.split(upper, plane, &near, here);
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
        above: Above,
    ) -> Above {
        let Rectangle { center, half } = *rectangle;
        let diameter = 2.0 * half[0].hypot(half[1]);
        let apart = self.interpolate.diameters * diameter;
        let lights = self.job.lights;
        let (taken, kept, spent) = match self.interpolate.within {
            Some(steps) => {
                let shape = rectangle.of(plane);
                self.provably_far(fragments, &shape, near, (steps * STEP - above.spent).max(0.0))
            }
            None => {
                let is_far = |place: &&u32| far(&lights[**place as usize], region, apart);
                let (taken, kept): (Vec<u32>, Vec<u32>) = near.iter().partition(is_far);
                (taken, kept, 0.0)
            }
        };
        let count = taken.len();
        let parent = above.grid;
        // Worth it if the evaluations saved exceed the cost of nodes and polynomial.
        let saved = count as f64 * (fragments.len() as f64 - self.nodes as f64);
        let polynomial = if parent.is_some() { self.nodes } else { fragments.len() };
        let costs = &self.job.options.costs;
        let overhead = costs.interpolation / costs.evaluation * polynomial as f64;
        if count == 0 || diameter <= 0.0 || saved <= overhead {
            return above;
        }
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
        let grid = Some(self.plan.grids.len() as u32 - 1);
        Above { grid, spent: above.spent + spent }
    }

    /// Divides the lights of a patch into those whose errors together fit into this patch's share of
    /// `left`, the smallest first, and the others; returns that error too.
    fn provably_far(
        &self,
        fragments: &[u32],
        shape: &smooth::Rectangle,
        near: &[u32],
        left: f64,
    ) -> (Vec<u32>, Vec<u32>, f64) {
        let Job { upload, model, lights, frame, .. } = *self.job;
        let first = &frame.fragments[fragments[0] as usize];
        let region = self.points.region(&fragments[..1]);
        let given = upload.materials[first.material as usize].shininess;
        let shininess = model.shininess.map_or(given, f64::from);
        let reflects = Reflects { body: region.body, shine: region.shine, shininess };
        // As many levels as will follow share what is left.
        let levels = (fragments.len() as f64 / (3 * self.nodes) as f64).log2().ceil().max(0.0);
        let share = left / (levels + 1.0);
        let error = |place: &u32| {
            self.order.error(
                &lights[*place as usize],
                shape,
                upload.camera,
                &reflects,
                model,
                share,
            )
        };
        let mut errors: Vec<(u32, f64)> = near.iter().map(|place| (*place, error(place))).collect();
        errors.sort_unstable_by(|a, b| a.1.total_cmp(&b.1));
        let mut spent = 0.0;
        let mut count = 0;
        while errors.get(count).is_some_and(|(_, error)| spent + error <= share) {
            spent += errors[count].1;
            count += 1;
        }
        let (taken, kept) = errors.split_at(count);
        let ascending = |part: &[(u32, f64)]| {
            let mut places: Vec<u32> = part.iter().map(|(place, _)| *place).collect();
            places.sort_unstable();
            places
        };
        (ascending(taken), ascending(kept), spent)
    }
}

struct Rectangle {
    center: DVec3,
    half: [f64; 2],
}

impl Rectangle {
    fn of(&self, plane: &Plane) -> smooth::Rectangle {
        // Nodes are rounded to `f32`, and a side is not shorter than that.
        let rounding = self.center.abs().max_element().max(1.0) * 2f64.powi(-22);
        let longest = 2.0 * self.half[0].hypot(self.half[1]);
        smooth::Rectangle {
            center: self.center,
            axes: plane.axes,
            normal: plane.normal,
            half: self.half.map(|half| half.max(longest * 1e-3) + rounding),
            off: plane.off + rounding,
            tilt: plane.tilt + 2f64.powi(-22),
        }
    }
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
