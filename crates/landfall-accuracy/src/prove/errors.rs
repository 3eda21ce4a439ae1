//! Bounds of the largest error over the domain, by dividing it where the bound is largest.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::super::inputs::Inputs;
use super::super::inputs::domain::Domain;
use super::ProofLimits;
use super::space::InputSpace;
use landfall_exec::harness::call::pure::PureFunction;
use landfall_exec::processor::Stopwatch;
use landfall_interp::graph::{Bounds, Graph, Range, Rounding};
use landfall_layout::buffer::float::last_place;

/// A bound of the error of every result over the whole domain; infinite where none is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorBound {
    pub absolute: f64,
    /// The error in units of the last place of an `f32`.
    pub ulp: f64,
    /// The error in steps of 1/255 of full scale, which is at least 1.
    pub steps: f64,
    /// The least and greatest value that any result may have, with its error.
    pub results: [f64; 2],
}

/// When a search for a bound ends before its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Until {
    /// Once the bound is not above a limit.
    Below(f64),
    /// Once twice the parts lower the bound by less than a fiftieth.
    Settled,
}

/// What a search for a bound divides the domain for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundGoal {
    pub rounding: Rounding,
    pub measure: Measure,
    pub until: Until,
}

/// The measure whose largest value is sought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Measure {
    Absolute,
    Ulp,
    Steps,
}

impl ErrorBound {
    pub(crate) fn in_measure(self, measure: Measure) -> f64 {
        match measure {
            Measure::Absolute => self.absolute,
            Measure::Ulp => self.ulp,
            Measure::Steps => self.steps,
        }
    }

    /// Returns the lower of two bounds of the same errors.
    pub(crate) fn and(self, other: ErrorBound) -> ErrorBound {
        // Both hold, so for each measure the lower one does.
        ErrorBound {
            absolute: self.absolute.min(other.absolute),
            ulp: self.ulp.min(other.ulp),
            steps: self.steps.min(other.steps),
            results: [self.results[0].max(other.results[0]), self.results[1].min(other.results[1])],
        }
    }

    fn or(self, other: ErrorBound) -> ErrorBound {
        ErrorBound {
            absolute: self.absolute.max(other.absolute),
            ulp: self.ulp.max(other.ulp),
            steps: self.steps.max(other.steps),
            results: [self.results[0].min(other.results[0]), self.results[1].max(other.results[1])],
        }
    }
}

const NONE: ErrorBound =
    // The neutral element of `or`: an error of 0, and no result.
    ErrorBound {
        absolute: 0.0,
        ulp: 0.0,
        steps: 0.0,
        results: [f64::INFINITY, f64::NEG_INFINITY],
    };

struct Part {
    height: f64,
    bound: ErrorBound,
    ranges: Vec<Range>,
    number: u64,
}

impl PartialEq for Part {
    fn eq(&self, other: &Part) -> bool {
        self.number == other.number
    }
}

impl Eq for Part {}

impl PartialOrd for Part {
    fn partial_cmp(&self, other: &Part) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

// A heap by height; of equal heights the older part first, so that results do not depend on
// chance.
impl Ord for Part {
    fn cmp(&self, other: &Part) -> Ordering {
        self.height.total_cmp(&other.height).then(other.number.cmp(&self.number))
    }
}

/// The parts from which a bound may be settled.
const SETTLED_FROM: u64 = 1 << 9;

const MAX_PARTS: usize = 1 << 18;

/// Returns a bound of the errors of a function, whose domain is divided for one measure; `None` if
/// the code is too large to follow.
pub(crate) fn bound(
    pure: &PureFunction,
    inputs: &Inputs,
    domain: &Domain,
    limits: &ProofLimits,
    BoundGoal { rounding, measure, until }: BoundGoal,
) -> Option<ErrorBound> {
    // Best first: the bound over the domain is the largest bound of its parts, so only dividing the
    // part with the largest can lower it. Cutting stops when that part is below the limit, cannot
    // be divided, or the time is over.
    let began = Stopwatch::start();
    let space = InputSpace::new(inputs, domain);
    let graph = pure.graph(&space.root, &space.units)?;
    let mut bounds = Bounds::default();
    let mut exact = Bounds::default();
    let mut of = |ranges: &[Range]| over(&graph, ranges, rounding, &mut bounds, &mut exact);
    let mut parts = BinaryHeap::new();
    let mut made = 0;
    let mut push = |ranges: Vec<Range>, parts: &mut BinaryHeap<Part>| {
        let mut ranges = ranges;
        if space.cut(&mut ranges) {
            let bound = of(&ranges);
            made += 1;
            parts.push(Part { height: bound.in_measure(measure), bound, ranges, number: made });
        }
    };
    push(space.root.clone(), &mut parts);
    let mut done = NONE;
    let mut count = 0u64;
    let (mut settles, mut last) = (SETTLED_FROM, f64::INFINITY);
    let enough = match until {
        Until::Below(most) => most,
        Until::Settled => 0.0,
    };
    while let Some(part) = parts.pop() {
        let over = limits.is_stopped()
            // The clock is read every 64 parts.
            || count % 64 == 63 && (limits.is_over(&began) || count >= limits.parts);
        count += 1;
        // The widest range in relation to the whole domain, so that units of inputs do not matter.
        let widest = (0..part.ranges.len()).filter_map(|at| {
            let [end, begin] = space.middle(at, part.ranges[at])?;
            let whole = space.root[at].high - space.root[at].low;
            Some(((part.ranges[at].high - part.ranges[at].low) / whole, at, end, begin))
        });
        let widest = widest.max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, at, end, begin)) = widest else {
            // A single point: its bound is final. If it is above the limit, the limit cannot be
            // reached.
            done = done.or(part.bound);
            if done.in_measure(measure) > enough {
                parts.push(part);
                break;
            }
            continue;
        };
        // Compared at powers of two of the number of parts, from 2^9 on: below 2 % for twice the
        // work is settled.
        let is_settled = until == Until::Settled && count == settles && part.height > 0.98 * last;
        if count == settles {
            (settles, last) = (2 * settles, part.height);
        }
        // What is not divided any more counts with the bound it has.
        if over || is_settled || part.height <= enough || parts.len() >= MAX_PARTS {
            parts.push(part);
            break;
        }
        let (mut lower, mut upper) = (part.ranges.clone(), part.ranges);
        (lower[at].high, upper[at].low) = (end, begin);
        push(lower, &mut parts);
        push(upper, &mut parts);
    }
    Some(parts.iter().fold(done, |all, part| all.or(part.bound)))
}

/// Returns the bound over one part.
fn over(
    graph: &Graph,
    ranges: &[Range],
    rounding: Rounding,
    bounds: &mut Bounds,
    exact: &mut Bounds,
) -> ErrorBound {
    // The error by propagation of rounding through the graph.
    graph.bounds(ranges, rounding.arithmetic(), bounds);
    let errors = graph.errors(bounds, rounding);
    let values = graph.exact_results(ranges, exact);
    let scale = values.iter().map(|x| least(*x)).fold(1.0, f64::max);
    let each = errors.iter().zip(bounds.results(graph)).zip(&values);
    // A bound as well: how far any computed value may be from any exact one over the part. It is
    // the smaller one where propagation has lost track, as near a division by almost 0.
    let each = each.map(|((&error, computed), &value)| {
        let error = error.min(farthest(computed, value));
        ErrorBound {
            absolute: error,
            // The last place of the smallest value in the range is the smallest unit, so the
            // quotient is an upper bound.
            ulp: if error == 0.0 { 0.0 } else { error / last_place(least(value)) },
            steps: 255.0 * error / scale,
            results: [computed.low, computed.high],
        }
    });
    each.fold(NONE, ErrorBound::or)
}

/// Returns how far apart a number of each range may be; infinite if one of them has none.
fn farthest(a: Range, b: Range) -> f64 {
    match a.low <= a.high && b.low <= b.high {
        // An empty range means that no value is defined there.
        true => (a.high - b.low).max(b.high - a.low).max(0.0).next_up(),
        false => f64::INFINITY,
    }
}

fn least(x: Range) -> f64 {
    x.low.max(-x.high).max(0.0)
}
