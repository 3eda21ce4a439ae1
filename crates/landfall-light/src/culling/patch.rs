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
use super::lamps::Lamps;
use super::near::{GROUP, Near, Prepared};
use super::options::Interpolate;
use super::plane::{Group, Plane, planes};
use super::region::{Points, Region};
use super::smooth::{Errors, Order, Rectangle, Shading};
use super::{Job, STEP, set};
use crate::Fragment;
use crate::plan::{Draw, Grid, Plan, places};
use crate::shading_f32::SpecularTerm;

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
        orders: (2..=6).map(Order::new).collect(),
        errors: Errors::default(),
        kept: Vec::new(),
        later: Vec::new(),
        prepared: FxHashMap::default(),
    };
    let (planes, rest) = planes(job, &points);
    for (plane, fragments) in planes {
        patches.plane(&plane, &fragments);
    }
    let all: Vec<u32> = (0..job.lights.len() as u32).collect();
    for fragments in rest {
        patches.curved(fragments, &all);
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

/// Lights for a grid: their places, and the sum of their errors.
struct Taken {
    places: Vec<u32>,
    spent: f64,
}

/// The fragments from which a grid has as many nodes as it may, and not four.
const FEW: usize = 60;

/// The fragments up to which a patch is not divided for a proven error.
const LEAF: usize = 240;

struct Patches<'a> {
    job: &'a Job<'a>,
    points: &'a Points<'a>,
    interpolate: Interpolate,
    plan: Plan,
    tests: u64,
    sorted: u64,
    error: f64,
    /// From two nodes a side.
    orders: Vec<Order>,
    /// The errors of the lamps of a patch.
    errors: Errors,
    /// The lamps that a patch keeps, by their indices in its list.
    kept: Vec<u32>,
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
    fn near(&mut self, plane: &Plane, items: &[Item]) -> (Near, Option<Taken>) {
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
            Some((far, kept)) => (Some(far), kept),
            None => (None, groups),
        };
        let far = far.map(|far| Taken { places: prepared.places(&far.places), ..far });
        let lamps = prepared.lamps(kept.places(), plane, back);
        self.tests += lamps.len() as u64;
        (Near { lamps, others }, far)
    }

    fn split(
        &mut self,
        items: &mut [Item],
        plane: &Plane,
        (near, far): (&Near, Option<Taken>),
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
                        self.split(quarter, plane, (near, None), here);
                    }
                }
            }
            None => {
                let mut places = [near.lamps.places(), &near.others].concat();
                // The order of the sum of all lights, whose bits are kept where no grid adds light.
                places.sort_unstable();
                let fragments = items.iter().map(|item| item.number).collect();
                let lights = set(self.job.lights, &places, self.job.ambient);
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
        if rectangle.diameter() > 0.0 && self.is_worth(taken.len(), items.len(), above) {
            here.grid = self.grid(items, plane, rectangle, (taken, above.grid));
            others = left;
        }
        (here, Some(Near { lamps: Lamps::default(), others }))
    }

    /// Moves lamps into a grid as long as their errors stay within this patch's share, with those that
    /// are `far` already; returns the innermost grid, and the lights left if they are others.
    fn take_proven(
        &mut self,
        items: &[Item],
        plane: &Plane,
        rectangle: &Rectangle,
        (near, far): (&Near, Option<Taken>),
        above: Above,
    ) -> (Above, Option<Near>) {
        let others = (!near.others.is_empty()).then(|| self.others(items, near).0);
        let left = self.interpolate.within.unwrap_or(0.0) * STEP - above.spent;
        let share = self.share(items.len(), left) - far.as_ref().map_or(0.0, |far| far.spent);
        let found = self.provably_far(items, rectangle, (&near.lamps, 1), (share, above));
        let (more, lamps) = found.unzip();
        let taken = match (far, more) {
            (Some(mut far), Some(more)) => {
                far.places.extend(more.places);
                Some(Taken { spent: far.spent + more.spent, ..far })
            }
            (far, more) => far.or(more),
        };
        let mut here = above;
        if let Some(Taken { places, spent }) = taken {
            here.grid = self.grid(items, plane, rectangle, (places, above.grid));
            here.spent += spent;
        }
        let kept = (lamps.is_some() || others.is_some()).then(|| Near {
            lamps: lamps.unwrap_or_else(|| near.lamps.clone()),
            others: others.unwrap_or_else(|| near.others.clone()),
        });
        (here, kept)
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

    /// Returns the nodes a side of the grid of so many fragments: two for few of them.
    fn side(&self, fragments: usize) -> u32 {
        let is_small = self.interpolate.within.is_some() && fragments < FEW;
        if is_small { 2 } else { self.interpolate.nodes }
    }

    /// Whether so many lights in a grid save more than nodes and polynomial cost.
    fn is_worth(&self, lights: usize, fragments: usize, above: Above) -> bool {
        let costs = &self.job.options.costs;
        let nodes = f64::from(self.side(fragments).pow(2));
        let saved = lights as f64 * (fragments as f64 - nodes) * costs.evaluation;
        let polynomial = if above.grid.is_some() { nodes } else { fragments as f64 };
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
        (taken, parent): (Vec<u32>, Option<u32>),
    ) -> Option<u32> {
        let side = self.side(items.len());
        let Rectangle { center, half, .. } = *rectangle;
        let center = plane.origin + plane.axes[0] * center[0] + plane.axes[1] * center[1];
        let places = places(side);
        let first = &self.job.frame.fragments[items[0].number as usize];
        let node = |x: f64, y: f64| {
            let at = center + plane.axes[0] * (x * half[0]) + plane.axes[1] * (y * half[1]);
            Fragment { position: at.as_vec3().to_array(), ..*first }
        };
        let row = |y: &f64| places.iter().map(|x| node(*x, *y)).collect::<Vec<_>>();
        self.plan.grids.push(Grid {
            nodes: places.iter().flat_map(row).collect(),
            side,
            lights: set(self.job.lights, &taken, false),
            parent,
            center,
            axes: plane.axes,
            half,
        });
        Some(self.plan.grids.len() as u32 - 1)
    }

    /// Divides lamps, or groups of `each`, into those whose errors together fit into `share`, the smallest first, and the
    /// others. `None` if taking them does not pay.
    fn provably_far(
        &mut self,
        items: &[Item],
        rectangle: &Rectangle,
        (lamps, each): (&Lamps, usize),
        (share, above): (f64, Above),
    ) -> Option<(Taken, Lamps)> {
        let Job { upload, model, frame, .. } = *self.job;
        let known = rectangle.diameter() > 0.0 && share > 0.0;
        if !(known && self.is_worth(each * lamps.len(), items.len(), above)) {
            return None;
        }
        let first = &frame.fragments[items[0].number as usize];
        let given = upload.materials[first.material as usize].shininess;
        let shading = Shading {
            shininess: model.shininess.map_or(given, f64::from),
            everywhere: model.specular == SpecularTerm::Everywhere,
        };
        self.tests += lamps.len() as u64;
        let order = &self.orders[self.side(items.len()) as usize - 2];
        if !order.errors(lamps, rectangle, &shading, share as f32, &mut self.errors) {
            return None;
        }
        let (count, spent) = affordable(&mut self.errors.errors, share);
        if !self.is_worth(each * count, items.len(), above) {
            return None;
        }
        let mut places = Vec::with_capacity(count);
        self.kept.clear();
        self.kept.reserve(lamps.len());
        for (at, (place, error)) in lamps.places().iter().zip(&self.errors.errors).enumerate() {
            match *error < 0.0 {
                true => places.push(*place),
                false => self.kept.push(at as u32),
            }
        }
        // A patch that is not divided tests no lamps again.
        let kept = match each == 1 && items.len() <= self.fewest() {
            true => lamps.some_places(&self.kept),
            false => lamps.some(&self.kept),
        };
        Some((Taken { places, spent }, kept))
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
            let lights = set(lights, &near, self.job.ambient);
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

/// Makes as many errors negative as stay within `share` together, those below a power of the square
/// root of 2 first; returns their number and sum.
fn affordable(errors: &mut [f32], share: f64) -> (usize, f64) {
    const BUCKETS: usize = 64;
    let most = share as f32;
    let bucket = |error: f32| (most.to_bits().saturating_sub(error.to_bits()) >> 22) as usize;
    let bucket = |error: f32| bucket(error).min(BUCKETS - 1);
    let mut sums = [0.0; BUCKETS];
    for &error in errors.iter().filter(|error| **error <= most) {
        sums[bucket(error)] += f64::from(error);
    }
    let (mut spent, mut first) = (0.0, BUCKETS);
    while first > 0 && spent + sums[first - 1] <= share {
        first -= 1;
        spent += sums[first];
    }
    let mut count = 0;
    for error in errors.iter_mut().filter(|error| **error <= most) {
        let fits = bucket(*error) + 1 == first && spent + f64::from(*error) <= share;
        if fits {
            spent += f64::from(*error);
        }
        if fits || bucket(*error) >= first {
            count += 1;
            *error = -*error;
        }
    }
    (count, spent)
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
