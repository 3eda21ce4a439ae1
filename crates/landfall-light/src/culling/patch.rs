//! The patches of a frame and the grids of far lights on them.
//!
//! On a plane `n . (light - p)` is constant, so that the facing of a far light has one sign, and
//! attenuation and highlight are smooth: a light `k` diameters away is a polynomial up to an error
//! that falls with `k`. The rectangle of a plane is halved repeatedly; each half removes the lights
//! that are far for its size from the list passed on to its own halves.

use std::rc::Rc;

use glam::{DVec3, Vec4, Vec4Swizzles};
use rustc_hash::FxHashMap;

use super::bound::{Bounded, Shape};
use super::lamps::{GROUP, Lamps};
use super::near::{Near, Prepared};
use super::options::Interpolate;
use super::plane::{Group, Plane, planes};
use super::region::{Points, Region};
use super::select::Selected;
use super::smooth::{Errors, ORDERS, Order, Rectangle};
use super::{Job, STEP};
use crate::Fragment;
use crate::plan::{Draw, Grid, Plan, places};
use crate::shading_f32::SpecularTerm;

mod proven;

use proven::{SIDES, Taken};

/// A plan with grids.
pub(super) struct Patched {
    pub plan: Plan,
    /// The tests of lights against patches.
    pub tests: u64,
    /// The fragments sorted, each once a level.
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
        interpolate,
        plan: Plan::default(),
        tests: 0,
        sorted: 0,
        error: 0.0,
        orders: SIDES.map(Order::new),
        errors: Errors::default(),
        selected: Selected::default(),
        later: Vec::new(),
        prepared: FxHashMap::default(),
    };
    let (planes, rest) = planes(job, &points);
    for (plane, fragments) in planes {
        patches.plane(&plane, &fragments);
    }
    let all: Vec<u32> = (0..job.lights.len() as u32).collect();
    let costs = &job.options.costs;
    // For few fragments lights that do not end are sooner evaluated than tested.
    let endless = |light: &Bounded| matches!(&light.shape, Ok(Shape::Around(lamp)) if lamp.range.is_infinite() && lamp.cone.is_none());
    let endless = job.lights.iter().all(endless);
    let is_few =
        |some: &Group| endless && some.len() as f64 * costs.evaluation < TESTS * costs.test;
    let (few, rest): (Vec<Group>, Vec<Group>) = rest.into_iter().partition(is_few);
    for fragments in rest {
        patches.curved(fragments, &all);
    }
    let mut fragments = few.concat();
    if !fragments.is_empty() {
        fragments.sort_unstable();
        let lights = job.sets.set(all, job.ambient);
        patches.plan.draws.push(Draw { fragments, lights, grid: None });
    }
    let Patches { plan, tests, sorted, error, .. } = patches;
    Patched { plan, tests, sorted, error }
}

/// What larger patches give a patch.
#[derive(Clone, Copy)]
struct Above {
    /// The innermost grid around it.
    grid: Option<u32>,
    /// The proven error of all grids around it.
    spent: f64,
}

/// A fragment of a plane.
#[derive(Clone, Copy)]
struct Item {
    /// The coordinates along the plane's axes.
    at: [f32; 2],
    number: u32,
}

/// The fragments up to which a patch is not divided for a proven error.
const LEAF: usize = 500;

/// The factor of the cost of a test beside that of evaluations, as several fragments are lit at once.
const TESTS: f64 = 4.0;

struct Patches<'a> {
    job: &'a Job<'a>,
    points: &'a Points<'a>,
    interpolate: Interpolate,
    plan: Plan,
    tests: u64,
    sorted: u64,
    error: f64,
    orders: [Order; ORDERS],
    /// The errors of the lamps of a patch.
    errors: Errors,
    selected: Selected,
    /// The fragments of the upper half while the lower ones are moved.
    later: Vec<Item>,
    /// The lights of each material.
    prepared: FxHashMap<u32, Rc<Prepared>>,
}

impl Patches<'_> {
    fn plane(&mut self, plane: &Plane, fragments: &[u32]) {
        let item = |&number: &u32| {
            let [x, y, _] = plane.coordinates(self.points.position(number)).as_vec3().to_array();
            Item { at: [x, y], number }
        };
        let mut items: Vec<Item> = fragments.iter().map(item).collect();
        self.later.reserve(items.len());
        let (near, far) = self.near(plane, &items);
        self.split(&mut items, plane, (&near, far), Above { grid: None, spent: 0.0 });
    }

    /// Returns the lights that may contribute to a plane, apart from those of groups that are far from
    /// all of it.
    fn near(&mut self, plane: &Plane, items: &[Item]) -> (Near, Vec<Taken>) {
        let Job { lights, model, upload, .. } = *self.job;
        let within = self.interpolate.within;
        let new = || match within {
            Some(_) => Rc::new(Prepared::new(lights, &plane.region)),
            None => Rc::new(Prepared::unbounded(lights)),
        };
        let prepared = Rc::clone(self.prepared.entry(plane.material).or_insert_with(new));
        let adds = |place: &&u32| lights[**place as usize].adds(&plane.region, model);
        let others: Vec<u32> = prepared.others.iter().filter(adds).copied().collect();
        self.tests += prepared.others.len() as u64;
        let back = model.specular == SpecularTerm::Everywhere;
        let groups = prepared.groups(plane, back);
        let rectangle = rectangle_of(items, plane, upload.camera);
        let share = within.map_or(0.0, |steps| self.share(items.len(), steps * STEP) / 2.0);
        let above = Above { grid: None, spent: 0.0 };
        let found = self.provably_far(items, &rectangle, (&groups, GROUP), (share, above));
        let (far, kept) = match found {
            Some((far, kept)) => (far, kept),
            None => (Vec::new(), groups),
        };
        let mut between = Vec::new();
        let mut far_of = |far: Taken| {
            let places = prepared.far(&far.places, plane, back, &mut between);
            Taken { places, ..far }
        };
        let far = far.into_iter().map(&mut far_of);
        let far = far.filter(|far| !far.places.is_empty()).collect();
        between.extend(kept.places().iter().map(|group| (*group, u16::MAX)));
        let lamps = prepared.lamps(&between, plane, back);
        self.tests += lamps.len() as u64;
        (Near { lamps, others }, far)
    }

    fn split(
        &mut self,
        items: &mut [Item],
        plane: &Plane,
        (near, far): (&Near, Vec<Taken>),
        above: Above,
    ) {
        self.sorted += items.len() as u64;
        let rectangle = rectangle_of(items, plane, self.job.upload.camera);
        let (here, kept) = match self.interpolate.within {
            Some(_) => self.take_proven(items, plane, &rectangle, (near, far), above),
            None => self.take_distant(items, plane, &rectangle, near, above),
        };
        let near = kept.as_ref().unwrap_or(near);
        let is_divided = items.len() > self.fewest() && self.has_lamps(near);
        let divided = is_divided.then(|| self.halve(items, &rectangle)).flatten();
        match divided {
            Some(middle) => {
                // Into quarters: one test for two halvings.
                let (lower, upper) = items.split_at_mut(middle);
                for half in [lower, upper] {
                    let middle = (half.len() > self.fewest()).then(|| {
                        self.halve(half, &rectangle_of(half, plane, self.job.upload.camera))
                    });
                    let (lower, upper) = half.split_at_mut(middle.flatten().unwrap_or_default());
                    for quarter in [lower, upper].into_iter().filter(|items| !items.is_empty()) {
                        self.split(quarter, plane, (near, Vec::new()), here);
                    }
                }
            }
            None => {
                let mut places = [near.lamps.places(), &near.others].concat();
                // The order of the sum of all lights.
                places.sort_unstable();
                let fragments = items.iter().map(|item| item.number).collect();
                let lights = self.job.sets.set(places, self.job.ambient);
                self.plan.draws.push(Draw { fragments, lights, grid: here.grid });
                self.error = self.error.max(here.spent);
            }
        }
    }

    /// Moves the items of the lower half of the rectangle's longer side to the front, each half in its
    /// order; returns their number, or `None` if all are at one place.
    fn halve(&mut self, items: &mut [Item], rectangle: &Rectangle) -> Option<usize> {
        let axis = usize::from(rectangle.half[1] > rectangle.half[0]);
        let middle = rectangle.center[axis] as f32;
        self.later.clear();
        let mut lower = 0;
        for at in 0..items.len() {
            let item = items[at];
            match item.at[axis] < middle {
                true => {
                    items[lower] = item;
                    lower += 1;
                }
                false => self.later.push(item),
            }
        }
        items[lower..].copy_from_slice(&self.later);
        (lower > 0 && lower < items.len()).then_some(lower)
    }

    /// Returns those of the lights without a proven error that contribute to a patch, and its bounds.
    fn others(&mut self, items: &[Item], near: &Near) -> (Vec<u32>, Region) {
        let fragments: Vec<u32> = items.iter().map(|item| item.number).collect();
        let region = self.points.region(&fragments);
        self.tests += near.others.len() as u64;
        let (lights, model) = (self.job.lights, self.job.model);
        let adds = |place: &&u32| lights[**place as usize].adds(&region, model);
        (near.others.iter().filter(adds).copied().collect(), region)
    }

    /// Moves the lights distant from the rectangle into a grid of their own; returns the innermost
    /// grid, and the lights left.
    fn take_distant(
        &mut self,
        items: &[Item],
        plane: &Plane,
        rectangle: &Rectangle,
        near: &Near,
        above: Above,
    ) -> (Above, Option<Near>) {
        let (mut others, region) = self.others(items, near);
        let apart = self.interpolate.diameters * rectangle.diameter();
        let is_far = |place: &u32| far(&self.job.lights[*place as usize], &region, apart);
        let (taken, left): (Vec<u32>, Vec<u32>) = others.iter().partition(|place| is_far(place));
        let mut here = above;
        let side = self.interpolate.nodes;
        let pays = self.is_worth(taken.len(), items.len(), side, above.grid.is_some());
        if rectangle.diameter() > 0.0 && pays {
            here.grid = self.grid(items, plane, rectangle, (side, taken), above.grid);
            others = left;
        }
        (here, Some(Near { lamps: Lamps::default(), others }))
    }

    /// Returns the share of a patch of the error that is left: less, the more levels follow, as the
    /// smallest patches are the most.
    fn share(&self, fragments: usize, left: f64) -> f64 {
        // Each level has quarters.
        let levels = (fragments as f64 / self.fewest() as f64).log2().ceil().max(0.0) / 2.0;
        left.max(0.0) / (3.0 * levels + 1.0)
    }

    /// The fragments up to which a patch is not divided.
    fn fewest(&self) -> usize {
        match self.interpolate.within {
            Some(_) => LEAF,
            None => 3 * self.interpolate.nodes.pow(2) as usize,
        }
    }

    fn has_lamps(&self, near: &Near) -> bool {
        let lights = self.job.lights;
        let around = |&place: &u32| matches!(lights[place as usize].shape, Ok(Shape::Around(_)));
        near.lamps.len() > 0 || near.others.iter().any(around)
    }

    /// Whether so many lights in a grid save more than nodes and polynomial cost; `inner` if there is a
    /// grid around it already.
    fn is_worth(&self, lights: usize, fragments: usize, side: u32, inner: bool) -> bool {
        let costs = &self.job.options.costs;
        let nodes = f64::from(side.pow(2));
        let saved = lights as f64 * (fragments as f64 - nodes) * costs.evaluation;
        let polynomial = if inner { nodes } else { fragments as f64 };
        let interpolation = costs.interpolation * polynomial;
        match self.interpolate.within {
            Some(_) => saved > interpolation + costs.light * lights as f64 + costs.draw,
            None => saved > interpolation,
        }
    }

    /// Adds a grid with those lights.
    fn grid(
        &mut self,
        items: &[Item],
        plane: &Plane,
        rectangle: &Rectangle,
        (side, taken): (u32, Vec<u32>),
        parent: Option<u32>,
    ) -> Option<u32> {
        let Rectangle { center, half, .. } = *rectangle;
        let center = plane.origin + plane.axes[0] * center[0] + plane.axes[1] * center[1];
        let places = &places(side);
        let first = &self.job.frame.fragments[items[0].number as usize];
        let node = |x: f64, y: f64| {
            let at = center + plane.axes[0] * (x * half[0]) + plane.axes[1] * (y * half[1]);
            Fragment { position: at.as_vec3().to_array(), ..*first }
        };
        let mut nodes = Vec::with_capacity(places.len() * places.len());
        for y in places {
            nodes.extend(places.iter().map(|x| node(*x, *y)));
        }
        self.plan.grids.push(Grid {
            nodes,
            side,
            lights: self.job.sets.set(taken, false),
            parent,
            center,
            axes: plane.axes,
            half,
        });
        Some(self.plan.grids.len() as u32 - 1)
    }

    /// Divides fragments that are on no plane, without grids.
    fn curved(&mut self, mut fragments: Group, candidates: &[u32]) {
        let region = self.points.region(&fragments);
        self.tests += candidates.len() as u64;
        self.sorted += fragments.len() as u64;
        let (lights, model) = (self.job.lights, self.job.model);
        let adds = |place: &u32| lights[*place as usize].adds(&region, model);
        let near: Vec<u32> = candidates.iter().copied().filter(adds).collect();
        let lamps = near.iter().any(|&p| matches!(lights[p as usize].shape, Ok(Shape::Around(_))));
        if !lamps || fragments.len() <= self.fewest() {
            fragments.sort_unstable();
            let lights = self.job.sets.set(near, self.job.ambient);
            self.plan.draws.push(Draw { fragments, lights, grid: None });
            return;
        }
        let axis = longest(&region);
        let along = |n: &u32| self.points.position(*n).dot(axis);
        let middle = fragments.len() / 2;
        fragments.select_nth_unstable_by(middle, |a, b| along(a).total_cmp(&along(b)));
        let upper = fragments.split_off(middle);
        self.curved(fragments, &near);
        self.curved(upper, &near);
    }
}

/// Returns the rectangle around the items.
fn rectangle_of(items: &[Item], plane: &Plane, eye: DVec3) -> Rectangle {
    let [mut low, mut high] = [Vec4::INFINITY, Vec4::NEG_INFINITY];
    // Two at once; comparisons ignore NaN.
    for pair in items.chunks(2) {
        let ([ax, ay], [bx, by]) = (pair[0].at, pair[pair.len() - 1].at);
        let at = Vec4::new(ax, ay, bx, by);
        low = Vec4::select(at.cmplt(low), at, low);
        high = Vec4::select(at.cmpgt(high), at, high);
    }
    let low = low.xy().min(low.zw()).to_array().map(f64::from);
    let high = high.xy().max(high.zw()).to_array().map(f64::from);
    let half = [0, 1].map(|axis| (high[axis] - low[axis]) / 2.0);
    let longest = 2.0 * half[0].hypot(half[1]);
    let center = [0, 1].map(|axis| (low[axis] + high[axis]) / 2.0);
    Rectangle {
        center,
        // Not so narrow that rounding of node positions matters.
        half: half.map(|half| half.max(longest * 1e-3) + plane.rounding),
        eye: plane.coordinates(eye),
        off: plane.off + plane.moved,
        rounding: plane.rounding,
        tilt: plane.tilt + 2f64.powi(-30),
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
