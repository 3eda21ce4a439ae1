//! Divides the box of the inputs until operations are shown not to break in any part of it.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Goal;
use super::points::Scratch;
use super::space::InputSpace;
use landfall_interp::graph::{Arithmetic, Graph, Range};
use landfall_ir::threads;

/// A part of the box in which some goals are not shown. Parts in which nothing is possible are
/// dropped, so that what is left encloses all faults.
#[derive(Debug)]
struct SubBox {
    /// Whether only digits can be lost in it, or numbers leave the range of an `f32`.
    minor: bool,
    depth: u32,
    number: u64,
    ranges: Vec<Range>,
    goals: Vec<u32>,
}

impl PartialEq for SubBox {
    fn eq(&self, other: &SubBox) -> bool {
        self.number == other.number
    }
}

impl Eq for SubBox {}

impl PartialOrd for SubBox {
    fn partial_cmp(&self, other: &SubBox) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for SubBox {
    /// Parts in which results may be undefined come first, and of those the largest.
    fn cmp(&self, other: &SubBox) -> std::cmp::Ordering {
        let key = |part: &SubBox| (part.minor, part.depth, part.number);
        // `BinaryHeap` takes the greatest, hence reversed.
        Reverse(key(self)).cmp(&Reverse(key(other)))
    }
}

/// The most parts kept by size; further ones are examined one after the other. Breadth first up to
/// this number, so that all of the box is examined evenly; beyond it depth first, which bounds the
/// memory.
const MAX_PARTS: usize = 1 << 14;

/// The values that a thread computes at least: starting one takes as long as some hundred.
const VALUES_A_THREAD: usize = 1 << 11;

/// A scalar at which to divide a part, where its lower half ends, and where its upper one begins;
/// `None` where it cannot be divided.
type Cut = Option<(usize, [f64; 2])>;

pub(super) struct Split<'a> {
    space: &'a InputSpace<'a>,
    graph: &'a Graph,
    parts: BinaryHeap<SubBox>,
    /// Beyond the most parts, the parts of one part at a time, the smallest last.
    deep: Vec<SubBox>,
    /// The parts that cannot be divided, or for which there was no room.
    left: Vec<(Vec<Range>, Vec<u32>)>,
    made: u64,
}

impl<'a> Split<'a> {
    pub fn new(space: &'a InputSpace<'a>, graph: &'a Graph, goals: &[Goal]) -> Split<'a> {
        let all: Vec<u32> = (0..goals.len() as u32).collect();
        let mut split = Split {
            space,
            graph,
            parts: BinaryHeap::new(),
            deep: Vec::new(),
            left: Vec::new(),
            made: 0,
        };
        split.push(goals, 0, space.root.clone(), all);
        split
    }

    fn push(&mut self, all: &[Goal], depth: u32, mut ranges: Vec<Range>, goals: Vec<u32>) {
        if self.space.cut(&mut ranges) {
            self.made += 1;
            let minor = goals.iter().all(|&nth| all[nth as usize].is_minor());
            let part = SubBox { minor, depth, number: self.made, ranges, goals };
            // Results that may be undefined and minor faults share one queue; `minor` sorts them.
            match self.parts.len() < MAX_PARTS {
                true => self.parts.push(part),
                false => self.deep.push(part),
            }
        }
    }

    /// Examines the largest parts, at most so many, and returns how many; none is left if they are
    /// fewer. The goals that may break in a part stay with its halves.
    pub fn step(&mut self, goals: &[Goal], most: usize, scratch: &mut [Scratch]) -> usize {
        let mut examined = 0;
        while examined < most {
            let parts = self.next(most - examined);
            if parts.is_empty() {
                break;
            }
            examined += parts.len();
            let values = parts.len() * self.graph.len();
            // Threads are worth it for large graphs only.
            let threads = (values / VALUES_A_THREAD).clamp(1, scratch.len());
            let found = threads::run(&mut scratch[..threads], parts.len(), |scratch, nth| {
                self.examine(&parts[nth], goals, scratch)
            });
            // Divided in the order of the parts, whatever thread examined them: numbers, and so
            // the order of later parts, are reproducible.
            for (part, (still, chosen)) in parts.into_iter().zip(found) {
                if !still.is_empty() {
                    self.divide(part, still, chosen, goals);
                }
            }
        }
        examined
    }

    /// Takes the next parts to examine: those of which none is a part of another one, in the order
    /// in which they come one by one.
    fn next(&mut self, most: usize) -> Vec<SubBox> {
        // Near the limit it depends on the parts before which ones there is room for.
        let is_free = self.deep.is_empty() && self.parts.len() + most <= MAX_PARTS;
        let Some(first) = self.deep.pop().or_else(|| self.parts.pop()) else { return Vec::new() };
        let key = (first.minor, first.depth);
        let mut next = vec![first];
        // Parts of one depth are disjoint, so none of them is a descendant of another.
        let is_alike = |part: &SubBox| (part.minor, part.depth) == key;
        while is_free && next.len() < most && self.parts.peek().is_some_and(is_alike) {
            next.extend(self.parts.pop());
        }
        next
    }

    /// Returns the goals that may break in a part, and where to divide it.
    fn examine(&self, part: &SubBox, goals: &[Goal], scratch: &mut Scratch) -> (Vec<u32>, Cut) {
        let open = |nth: &u32| !goals[*nth as usize].is_found();
        let mut still: Vec<u32> = part.goals.iter().copied().filter(open).collect();
        if still.is_empty() || scratch.is_stopped() {
            return (still, None);
        }
        let bounds = &mut scratch.bounds;
        // `Permitted` contains the results of every conformant device: a fault that is impossible
        // here is impossible on all.
        self.graph.bounds(&part.ranges, Arithmetic::Permitted, bounds);
        let sites = self.graph.sites();
        // Possible at one of its sites is enough to stay open.
        still.retain(|&nth| {
            let goal = &goals[nth as usize];
            // Only inputs that some open goal depends on are worth dividing.
            goal.sites.iter().any(|&site| bounds.is_possible(&sites[site]))
        });
        let cut = self.dimension(&part.ranges, part.depth, &still, goals);
        (still, cut)
    }

    /// Divides a part, if it can be divided and there is room.
    fn divide(&mut self, part: SubBox, still: Vec<u32>, cut: Cut, goals: &[Goal]) {
        match cut {
            Some((at, [end, begin])) if self.deep.len() < MAX_PARTS => {
                let mut upper = part.ranges.clone();
                let mut lower = part.ranges;
                (lower[at].high, upper[at].low) = (end, begin);
                self.push(goals, part.depth + 1, lower, still.clone());
                self.push(goals, part.depth + 1, upper, still);
            }
            // No number is left to divide at, or no room: the part stays open.
            _ => self.left.push((part.ranges, still)),
        }
    }

    /// Returns the scalar to divide and where: of those that an operation depends on, the widest.
    fn dimension(&self, ranges: &[Range], depth: u32, still: &[u32], goals: &[Goal]) -> Cut {
        // The goals take turns, first those of undefined results.
        let of = |minor: bool| -> Vec<&Goal> {
            let goals = still.iter().map(|&nth| &goals[nth as usize]);
            goals.filter(|goal| goal.is_minor() == minor).collect()
        };
        let [mut major, mut minor] = [of(false), of(true)];
        for goals in [&mut major, &mut minor] {
            // By depth, so that each goal has its inputs divided every so often.
            let turn = depth as usize % goals.len().max(1);
            goals.rotate_left(turn);
        }
        for goal in major.into_iter().chain(minor) {
            let mut best: Option<(f64, usize, [f64; 2])> = None;
            for &at in &goal.inputs {
                let Some(middle) = self.space.middle(at, ranges[at]) else { continue };
                let (whole, part) = (self.space.root[at], ranges[at]);
                // In relation to the whole range, as in `errors`.
                let wide = width(part) / width(whole).max(f64::MIN_POSITIVE);
                if best.is_none_or(|(most, _, _)| wide > most) {
                    best = Some((wide, at, middle));
                }
            }
            if let Some((_, at, middle)) = best {
                return Some((at, middle));
            }
        }
        None
    }

    /// The parts that are left, and the goals that may break in each.
    fn remaining(&self) -> impl Iterator<Item = (&Vec<Range>, &Vec<u32>)> {
        let parts = self.parts.iter().chain(&self.deep).map(|part| (&part.ranges, &part.goals));
        parts.chain(self.left.iter().map(|(ranges, goals)| (ranges, goals)))
    }

    /// Whether a goal may break in any part.
    pub fn is_open(&self, goal: u32) -> bool {
        self.remaining().any(|(_, goals)| goals.contains(&goal))
    }

    /// Returns for each goal the least box around all parts in which it may break; `None` if there
    /// are none.
    pub fn open(&self, goals: usize) -> Vec<Option<Vec<Range>>> {
        let mut all: Vec<Option<Vec<Range>>> = vec![None; goals];
        for (ranges, goals) in self.remaining() {
            for &goal in goals {
                match &mut all[goal as usize] {
                    Some(open) => {
                        for (range, more) in open.iter_mut().zip(ranges) {
                            range.low = range.low.min(more.low);
                            range.high = range.high.max(more.high);
                        }
                    }
                    none => *none = Some(ranges.clone()),
                }
            }
        }
        all
    }

    /// Returns the middles of the largest parts of a goal, as starting points.
    pub fn largest_midpoints(&self, goal: u32, most: usize) -> Vec<Vec<f64>> {
        let parts = self.parts.iter().filter(|part| part.goals.contains(&goal));
        let all = parts.map(|part| &part.ranges);
        let left = self.left.iter().filter(|(_, goals)| goals.contains(&goal));
        let all = all.chain(left.map(|(ranges, _)| ranges)).take(most);
        all.map(|ranges| ranges.iter().map(|r| r.low / 2.0 + r.high / 2.0).collect()).collect()
    }
}

/// Returns the width of a range, in which each power of two far out counts alike.
fn width(Range { low, high }: Range) -> f64 {
    // x up to 1, then 1 + log2(x): linear near zero, where a logarithm has no end.
    let scale = |x: f64| x.abs().min(1.0) + x.abs().max(1.0).log2();
    let signed = |x: f64| scale(x) * if x < 0.0 { -1.0 } else { 1.0 };
    signed(high) - signed(low)
}
