//! Points at which operations are likely to break: corners, faces, axes, equal inputs, zeros, and
//! what a descent on the operands finds.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::super::inputs::domain::ValueRange;
use super::super::inputs::input::Sample;
use super::super::inputs::random::Random;
use super::space::{InputSpace, is_finite};
use landfall_interp::graph::{Arithmetic, Bounds, Distance, Graph, Range, Site};
use landfall_ir::threads;

/// The most corners of a box that are all tried.
const CORNERS: usize = 1 << 9;

/// The most and the fewest points around which others vary, and about how many these are.
const BASES: [usize; 2] = [24, 3];
const VARIED: usize = 1 << 11;

/// About the most variations of one point; of more, as with arrays of lights, some are drawn.
const MAX_VARIATIONS: usize = 1 << 13;

const RANDOM: usize = 256;

/// Returns the points to try first; none or fewer once the caller gives up.
pub(super) fn first(space: &InputSpace<'_>, random: &mut Random, stop: &AtomicBool) -> Vec<Sample> {
    // What breaks shaders is mostly simple: a zero, a limit of a range, two equal points, an axis.
    // These come before random numbers, in the order of corners, variations of some points, random
    // points.
    let is_stopped = || stop.load(Ordering::Relaxed);
    let mut all: Vec<Sample> = Vec::new();
    let scalars: Vec<usize> =
        (0..space.root.len()).filter(|&at| space.input(at).is_some()).collect();
    let at_ends = |mask: usize, random: &mut Random| {
        let mut sample = vec![0; space.root.len()];
        for (bit, &at) in scalars.iter().enumerate() {
            let Range { low, high } = space.root[at];
            // Past 60 scalars the bits of one word are used up.
            let up = if bit < 60 { mask >> bit & 1 == 1 } else { random.chance(0.5) };
            sample[at] = space.word(at, if up { high } else { low });
        }
        sample
    };
    let corners = 1usize.checked_shl(scalars.len() as u32).unwrap_or(usize::MAX);
    if is_stopped() {
        return all;
    }
    // All 2^n corners for up to 9 scalars, else a sample of them.
    if corners <= CORNERS {
        all.extend((0..corners).map(|mask| at_ends(mask, random)));
    } else {
        all.extend((0..CORNERS).map(|_| {
            let mask = random.word() as usize;
            at_ends(mask, random)
        }));
    }
    let [most, fewest] = BASES;
    let before = all.len();
    for nth in 0..most {
        // The first point is the middle of the box: it is where most functions are as their
        // authors think.
        let base = anywhere(space, random, nth == 0);
        if is_stopped() {
            break;
        }
        vary(space, &base, random, &mut all);
        all.push(base);
        // At least three, and more only for functions of few inputs.
        if nth + 1 >= fewest && all.len() - before >= VARIED {
            break;
        }
    }
    all.extend((0..RANDOM).map(|_| anywhere(space, random, false)));
    all.retain_mut(|sample| !is_stopped() && fits(space, sample, random));
    all
}

/// Moves a sample into the domain; returns false if that is impossible.
pub(super) fn fits(space: &InputSpace<'_>, sample: &mut Sample, random: &mut Random) -> bool {
    space.domain.fit(sample, space.inputs, random)
        && is_finite(space.inputs, sample)
        && space.domain.holds(sample, space.inputs)
}

/// Returns a point of the box: its middle, or a random one.
fn anywhere(space: &InputSpace<'_>, random: &mut Random, middle: bool) -> Sample {
    let mut sample = vec![0; space.root.len()];
    for (at, word) in sample.iter_mut().enumerate() {
        let Some(input) = space.input(at) else { continue };
        let Range { low, high } = space.root[at];
        let wide = high > 1.0e6 || low < -1.0e6;
        // A range of no meaning, such as that of an undeclared float, is drawn by orders of
        // magnitude.
        let x = match (middle, wide) {
            (true, _) => low / 2.0 + high / 2.0,
            (false, false) => random.between(low, high),
            (false, true) => {
                let x = random.scale(1.0e-3, 1.0e4);
                (if random.chance(0.5) { x } else { -x }).clamp(low, high)
            }
        };
        *word = space.word(at, if input.is_float() { x } else { x.round() });
    }
    sample
}

/// Adds variations of a point: each input at its ends, at zero, along axes, equal to another one.
fn vary(space: &InputSpace<'_>, base: &Sample, random: &mut Random, all: &mut Vec<Sample>) {
    // Each input has up to 33 variations of its own, and two for each other input.
    let inputs = space.inputs.len();
    // The share keeps the number of variations of a point at about `MAX_VARIATIONS`.
    let share = MAX_VARIATIONS as f64 / (inputs * (inputs + 33)).max(1) as f64;
    let mut is_drawn = || share >= 1.0 || random.chance(share);
    for (nth, input) in space.inputs.iter().enumerate() {
        let within = space.domain.within[nth];
        let mut with = |value: &dyn Fn(usize) -> f64| {
            if !is_drawn() {
                return;
            }
            let mut sample = base.clone();
            for (i, at) in input.range().enumerate() {
                sample[at] = space.word(at, value(i));
            }
            all.push(sample);
        };
        let Range { low, high } = space.root[input.first];
        // A unit vector is not changed as a whole to equal numbers.
        if within != ValueRange::Unit {
            for x in [low, high, 0.0, 1.0, -1.0] {
                if low <= x && x <= high {
                    with(&|_| x);
                }
            }
        }
        // Along an axis, and in the plane beside it: normals and directions that are parallel to
        // others.
        if input.len > 1 && input.len <= 4 {
            for axis in 0..input.len {
                for sign in [1.0, -1.0] {
                    with(&|i| if i == axis { sign } else { 0.0 });
                    with(&|i| if i == axis { 0.0 } else { sign });
                }
            }
        }
        // One component at a time at an end or at zero.
        for at in input.range().filter(|_| input.len > 1) {
            for x in [space.root[at].low, space.root[at].high, 0.0] {
                if !is_drawn() {
                    continue;
                }
                let mut sample = base.clone();
                sample[at] = space.word(at, x);
                all.push(sample);
            }
        }
        for other in &space.inputs[nth + 1..] {
            if other.len != input.len || other.scalar != input.scalar {
                continue;
            }
            // Equal and opposite: differences, cross products and half vectors vanish there.
            for flip in [0, 1u64 << 31] {
                if !is_drawn() {
                    continue;
                }
                let mut sample = base.clone();
                for (to, from) in other.range().zip(input.range()) {
                    // The sign bit of an `f32`.
                    sample[to] = sample[from] ^ if input.is_float() { flip } else { 0 };
                }
                all.push(sample);
            }
        }
    }
}

/// The room for one search.
pub(super) struct Scratch {
    pub bounds: Bounds,
    pub point: Vec<Range>,
    /// The points that the current descent may still evaluate.
    left: usize,
    /// Set to end the search.
    stop: Arc<AtomicBool>,
}

impl Scratch {
    pub fn new(stop: &Arc<AtomicBool>) -> Scratch {
        Scratch { bounds: Bounds::default(), point: Vec::new(), left: 0, stop: Arc::clone(stop) }
    }

    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// The values that the search for one operation computes at most.
/// A large function gets fewer points for them.
const VALUES: usize = 1 << 21;

/// The points from which a search descends.
const NEAREST: usize = 3;

/// The points that a thread ranks at a time.
const RANKED: usize = 64;

/// Returns the points that the search for one operation may evaluate.
fn points_each(graph: &Graph) -> usize {
    // One point costs an evaluation of the whole graph.
    VALUES / graph.len().max(1)
}

/// Returns how many points are ranked: the rest of the evaluations is for the descents.
fn ranked(graph: &Graph, starts: &[Sample]) -> usize {
    starts.len().min(points_each(graph) / 2)
}

/// Returns for each operation the numbers of the points at which it is nearest to breaking, the
/// nearest first.
pub(super) fn nearest(
    space: &InputSpace<'_>,
    graph: &Graph,
    sites: &[&Site],
    starts: &[Sample],
    scratch: &mut [Scratch],
) -> Vec<Vec<usize>> {
    // Half of the budget ranks the starting points, the rest descends from the best.
    let count = ranked(graph, starts);
    // Each thread ranks packs and keeps the nearest of a pack; merged, they are the nearest of
    // all.
    let packs = threads::run(scratch, count.div_ceil(RANKED), |scratch, pack| {
        let mut nearest: Vec<Vec<(f64, usize)>> = vec![Vec::new(); sites.len()];
        let numbered = starts[..count].iter().enumerate();
        for (nth, start) in numbered.skip(pack * RANKED).take(RANKED) {
            if scratch.is_stopped() {
                break;
            }
            space.point(start, &mut scratch.point);
            graph.bounds(&scratch.point, Arithmetic::Nearest, &mut scratch.bounds);
            for (site, nearest) in sites.iter().zip(&mut nearest) {
                // An infinite distance gives no direction to descend in.
                let found = scratch.bounds.distance(graph, site).map(Distance::size);
                nearest.extend(found.filter(|size| size.is_finite()).map(|size| (size, nth)));
            }
        }
        nearest.iter_mut().for_each(keep_nearest);
        nearest
    });
    let each = (0..sites.len()).map(|site| {
        let mut all: Vec<(f64, usize)> =
            packs.iter().flat_map(|nearest| nearest[site].iter().copied()).collect();
        keep_nearest(&mut all);
        all.into_iter().map(|(_, nth)| nth).collect()
    });
    each.collect()
}

/// Sorts points by distance and keeps the nearest.
fn keep_nearest(points: &mut Vec<(f64, usize)>) {
    // By number where distances are equal: independent of threads.
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    points.truncate(NEAREST);
}

const ROUNDS: usize = 40;

/// Searches from the nearest of some points for one at which an operation breaks, and returns the
/// best found from each.
pub(super) fn descend(
    space: &InputSpace<'_>,
    graph: &Graph,
    site: &Site,
    (starts, nearest): (&[Sample], &[usize]),
    (random, scratch): (&mut Random, &mut Scratch),
) -> Vec<Sample> {
    scratch.left = points_each(graph) - ranked(graph, starts);
    let mut all = Vec::new();
    for &nth in nearest {
        let mut descent =
            Descent { space, graph, site, random, scratch, best: starts[nth].clone() };
        descent.run();
        all.push(descent.best);
    }
    all
}

struct Descent<'d, 'a> {
    space: &'d InputSpace<'a>,
    graph: &'d Graph,
    site: &'d Site,
    random: &'d mut Random,
    scratch: &'d mut Scratch,
    best: Sample,
}

// A coordinate search on the distance that `graph` reports: 0 where the operation breaks, with a
// sign where a value crosses its limit. Operands are piecewise smooth at best, so no gradient is
// used.
impl Descent<'_, '_> {
    /// Returns how far the operation is from breaking at a sample.
    fn at(&mut self, sample: &Sample) -> Option<Distance> {
        let scratch = &mut *self.scratch;
        scratch.left = scratch.left.checked_sub(1)?;
        if scratch.is_stopped() {
            return None;
        }
        self.space.point(sample, &mut scratch.point);
        self.graph.bounds(&scratch.point, Arithmetic::Nearest, &mut scratch.bounds);
        scratch.bounds.distance(self.graph, self.site)
    }

    /// Returns the best point with one scalar changed, if it is in the domain.
    fn changed(&mut self, at: usize, x: f64) -> Option<(Sample, Distance)> {
        let mut sample = self.best.clone();
        sample[at] = self.space.word(at, x);
        if sample[at] == self.best[at] || !fits(self.space, &mut sample, self.random) {
            return None;
        }
        let found = self.at(&sample)?;
        Some((sample, found))
    }

    fn run(&mut self) {
        let best = self.best.clone();
        let Some(mut now) = self.at(&best) else { return };
        // The step is half of the range at first and a quarter of the last one whenever a round
        // brings nothing.
        let mut reach = 0.5;
        for _ in 0..ROUNDS {
            if now.size() == 0.0 {
                return;
            }
            let before = now.size();
            for &at in &self.site.inputs {
                let Some(input) = self.space.input(at) else { continue };
                let is_float = input.is_float();
                let here = input.number(self.best[at]);
                let Range { low, high } = self.space.root[at];
                // In large ranges the step is relative to the value.
                let step = reach * (high - low).min(2.0 * here.abs().max(1.0));
                // Both ends, zero, additive and multiplicative steps: the latter reach other
                // powers of two.
                let tries = [
                    low,
                    high,
                    0.0,
                    here + step,
                    here - step,
                    here * (1.0 + reach),
                    here * (1.0 - reach),
                ];
                for x in tries {
                    let x = if is_float { x } else { x.round() }.clamp(low, high);
                    let Some((sample, found)) = self.changed(at, x) else { continue };
                    // The sign has changed between here and there, so a zero lies between them.
                    if found.signed() * now.signed() < 0.0 {
                        self.bisect(at, here, x, now);
                        let best = self.best.clone();
                        let Some(after) = self.at(&best) else { return };
                        now = after;
                        break;
                    }
                    // The first improvement is taken; trying the rest would cost a graph
                    // evaluation each.
                    if found.size() < now.size() {
                        (self.best, now) = (sample, found);
                        break;
                    }
                }
            }
            if now.size() >= before {
                reach /= 4.0;
            }
        }
    }

    /// Finds a change of sign along one scalar, to neighbouring numbers.
    fn bisect(&mut self, at: usize, mut from: f64, mut to: f64, start: Distance) {
        let sign = start.signed();
        // 160 halvings lead from 1 past the smallest `f32`, 2^-149.
        for _ in 0..160 {
            let Some(input) = self.space.input(at) else { return };
            let middle = from / 2.0 + to / 2.0;
            let middle = if input.is_float() { f64::from(middle as f32) } else { middle.round() };
            if middle == from || middle == to {
                break;
            }
            // The middle is where the sample is already: halve the other side.
            let Some((sample, found)) = self.changed(at, middle) else {
                if self.best[at] == self.space.word(at, middle) {
                    from = middle;
                    continue;
                }
                return;
            };
            if found.signed() == 0.0 {
                self.best = sample;
                return;
            }
            if found.signed() * sign < 0.0 { to = middle } else { from = middle }
        }
        // The two neighbours on either side of the zero: one of them may break by rounding.
        for x in [to, from] {
            if let Some((sample, found)) = self.changed(at, x) {
                let best = self.best.clone();
                if self.at(&best).is_none_or(|now| found.size() <= now.size()) {
                    self.best = sample;
                }
            }
        }
    }
}
