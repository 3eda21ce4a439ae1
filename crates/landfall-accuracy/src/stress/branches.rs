//! Searches for comparisons that rounding decides: from a sample on one side of a comparison to one
//! on the other, and around the place where they meet.
//!
//! Random samples are seldom so near. What is found is examined with the other kept samples by
//! [`find`](super::find).

use super::generate::Generator;
use super::input::{Sample, float};
use super::kept::{Exemplars, KeepReason, Kept};
use super::measure::{Outcome, floats, outcome_beside};
use super::plan::{Plan, SampleSearch, columns, settings};
use super::random::Random;
use landfall_exec::harness::call::pure::PureFunction;
use landfall_interp::{Comparison, Operation, Precision, Settings};
use landfall_layout::source::Span;
use rustc_hash::FxHashMap;

/// A comparison with the samples run around where its sides meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FlippedBranch {
    pub span: Span,
    /// The samples run around it.
    pub near: usize,
    /// Those of them in which rounding takes another branch, with another result.
    pub flipped: usize,
}

/// A comparison: its place, and how often it was met before.
type Met = (Span, usize);

/// The samples from which the search starts.
const STARTS: usize = 48;

/// The changes tried to reach the other side of a comparison.
const TRIALS: usize = 2000;

/// The samples from which the other side is looked for if no start is there.
const AIMED: usize = 3;

/// The pairs of samples between which the sides of a comparison meet.
const PAIRS: usize = 8;

/// The halvings of the way between two samples.
const HALVINGS: usize = 40;

/// The samples run around where the sides meet, and their relative distances: from 16 units of the
/// last place on, as the rounding of the inputs decides what is nearer.
const NEAR: usize = 96;
const DISTANCE: [f64; 2] = [1.0e-6, 1.0e-4];

/// The least share of them that rounding sends into another branch.
const SHARE: f64 = 0.02;

/// The comparisons of a loop that are followed.
const TURNS: usize = 4;

/// The tag of samples found.
const TAG: u32 = 1 << 22;

/// Adds samples that rounding sends into another branch, and returns the comparisons followed.
pub(super) fn search(search: SampleSearch<'_>, exemplars: &mut Exemplars) -> Vec<FlippedBranch> {
    let SampleSearch { pure, generator, plan } = search;
    // Where every input was run, nothing is left to find.
    if generator.all().is_some() {
        return Vec::new();
    }
    let mut random = Random::new(31, 31);
    let starts = generator.sampler.all_drawn(31, STARTS);
    let mut sides: FxHashMap<Met, [Vec<Sample>; 2]> = FxHashMap::default();
    let mut order: Vec<Met> = Vec::new();
    // Which comparisons are met, and from which side, by some samples of the domain.
    for sample in &starts {
        for (met, apart) in compared(pure, plan, sample) {
            let both = sides.entry(met).or_insert_with(|| {
                order.push(met);
                Default::default()
            });
            both[usize::from(apart > 0.0)].push(sample.clone());
        }
    }
    let mut edges: Vec<FlippedBranch> = Vec::new();
    for met in order {
        let mut both = sides.remove(&met).unwrap_or_default();
        // No start on one side: the other side is looked for by changes of the inputs.
        if let Some(empty) = both.iter().position(Vec::is_empty) {
            let from = both[1 - empty].iter().take(AIMED);
            let found = from.filter_map(|s| across(search, met, s, &mut random));
            both[empty] = found.collect();
        }
        let [below, above] = &both;
        // Between a sample below and one above, the point where both sides meet is found by
        // halving, and the samples around it are run: near it rounding decides.
        for (a, b) in below.iter().zip(above).take(PAIRS) {
            if plan.until.is_over() {
                return edges;
            }
            let between = (a.clone(), b.clone());
            let (a, b) = meeting(search, met, between, &mut random);
            let ends = [a, b];
            let near = (0..NEAR).map(|nth| beside(generator, &ends[nth % 2], &mut random));
            let near: Vec<Sample> = near.collect();
            let found = flipped(pure, plan, &near);
            let count = found.len();
            // One in fifty at a distance of 16 units and more: a comparison that rounding decides
            // over an area, not a line.
            let is_often = count as f64 >= SHARE * near.len() as f64;
            for (severity, lane) in found.into_iter().filter(|_| is_often) {
                let key = (TAG + exemplars.len() as u32, KeepReason::Diverged);
                let kept = Kept { sample: near[lane].clone(), severity, at: (usize::MAX, lane) };
                exemplars.insert(key, kept);
            }
            match edges.iter_mut().find(|edge| edge.span == met.0) {
                Some(edge) => {
                    edge.near += near.len();
                    edge.flipped += count;
                }
                None => edges.push(FlippedBranch { span: met.0, near: near.len(), flipped: count }),
            }
        }
    }
    edges
}

/// Returns a sample on the other side of a comparison: by changes that bring its operands nearer.
fn across(
    search: SampleSearch<'_>,
    met: Met,
    from: &Sample,
    random: &mut Random,
) -> Option<Sample> {
    let SampleSearch { pure, generator, plan } = search;
    let apart_at = |sample: &Sample| {
        // The difference of the operands, or nothing if another branch is taken before.
        compared(pure, plan, sample).into_iter().find(|(other, _)| *other == met).map(|all| all.1)
    };
    let (mut apart, mut best) = (apart_at(from)?, from.clone());
    for _ in 0..TRIALS {
        if plan.until.is_over() {
            return None;
        }
        let mut next = best.clone();
        let nth = random.below(generator.inputs.len().max(1));
        let input = generator.inputs.get(nth)?;
        // Now and then a jump, else a step of one scalar by 1e-4 to 1 of its size.
        if !input.is_float() || random.chance(0.25) {
            generator.any_of(nth, &mut next, random);
        } else {
            let at = input.first + random.below(input.len);
            let x = f64::from(float(&next, at));
            let moved = x + random.between(-1.0, 1.0) * random.scale(1.0e-4, 1.0) * (x.abs() + 1.0);
            next[at] = u64::from((moved as f32).to_bits());
        }
        if !generator.domain.fit(&mut next, generator.inputs, random) {
            continue;
        }
        let Some(now) = apart_at(&next) else { continue };
        // The sign has changed.
        if (now > 0.0) != (apart > 0.0) {
            return Some(next);
        }
        if now.abs() < apart.abs() {
            (apart, best) = (now, next);
        }
    }
    None
}

/// Returns the comparisons that a sample meets, with the differences of their operands.
fn compared(pure: &PureFunction, plan: &Plan, sample: &Sample) -> Vec<(Met, f64)> {
    let settings = Settings { trace: true, ..settings(plan, true) };
    let called = pure.call(&columns(std::slice::from_ref(sample)), 1, &settings);
    let Ok(trace) = called.map(|called| called.called.notes.trace.unwrap_or_default()) else {
        return Vec::new();
    };
    let mut turns: FxHashMap<Span, usize> = FxHashMap::default();
    let mut all = Vec::new();
    // In a loop the same comparison is met in each iteration: each is a comparison of its own.
    for step in &trace.steps {
        let Operation::Compare(Comparison::Numbers(_)) = step.operation else { continue };
        let span = pure.place_of(step).span;
        let turn = turns.entry(span).or_default();
        *turn += 1;
        let [a, b] = [0, 1].map(|nth| step.operands[nth].number.double);
        if *turn <= TURNS && a.is_finite() && b.is_finite() {
            all.push(((span, *turn), a - b));
        }
    }
    all
}

/// Returns two samples, one of each side, as near to each other as halving the way comes.
fn meeting(
    SampleSearch { pure, generator, plan }: SampleSearch<'_>,
    met: Met,
    (mut below, mut above): (Sample, Sample),
    random: &mut Random,
) -> (Sample, Sample) {
    for _ in 0..HALVINGS {
        let mut middle = below.clone();
        // The middle in each scalar, in the precision of the inputs.
        for at in generator.inputs.float_scalars() {
            let [a, b] = [&below, &above].map(|sample| f64::from(float(sample, at)));
            middle[at] = u64::from((((a + b) / 2.0) as f32).to_bits());
        }
        let is_in = generator.domain.fit(&mut middle, generator.inputs, random);
        if !is_in || middle == below || middle == above {
            break;
        }
        let side = compared(pure, plan, &middle).into_iter().find(|(other, _)| *other == met);
        match side {
            Some((_, apart)) if apart > 0.0 => above = middle,
            Some(_) => below = middle,
            // Another branch before it.
            // The comparison is not reached there, so the way between the samples is no straight
            // line.
            None => break,
        }
    }
    (below, above)
}

/// Returns a sample beside another one, in the domain.
fn beside(generator: &Generator<'_>, sample: &Sample, random: &mut Random) -> Sample {
    let mut next = generator.inputs.with_floats(sample, |x| {
        let distance = random.scale(DISTANCE[0], DISTANCE[1]);
        x * if random.chance(0.5) { 1.0 + distance } else { 1.0 - distance }
    });
    match generator.domain.fit(&mut next, generator.inputs, random) {
        true => next,
        false => sample.clone(),
    }
}

/// Returns the samples that `f32` sends into another branch than `f64`, with another result: the
/// difference in steps, and the lane.
pub(super) fn flipped(pure: &PureFunction, plan: &Plan, samples: &[Sample]) -> Vec<(f64, usize)> {
    let columns = columns(samples);
    let single = settings(plan, false);
    let double = Settings { precision: Precision::Double, ..single.clone() };
    // `called` follows the branches of `f32` also in its `f64`; `own` takes its own.
    let called = pure.call(&columns, samples.len(), &single);
    let own = pure.call(&columns, samples.len(), &double);
    let (Ok(called), Ok(own)) = (called, own) else { return Vec::new() };
    let floats = floats(pure);
    let is_unsure = |lane: &usize| {
        called.called.unsure.get(*lane) == Some(&true) && !own.called.discarded[*lane]
    };
    let lanes = (0..samples.len()).filter(is_unsure);
    let off = |lane| match outcome_beside((&called, lane), (&own, lane), &floats) {
        Outcome::Finite(off, _) if plan.is_large(&off) => Some((off.steps, lane)),
        Outcome::Finite(..) | Outcome::Discarded | Outcome::NotANumber | Outcome::Infinite => None,
    };
    lanes.filter_map(off).collect()
}
