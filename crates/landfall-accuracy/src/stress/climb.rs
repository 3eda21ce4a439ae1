//! Searches for the worst input by hill climbing on the bits of bad ones.
//!
//! Used by [`find`](super::find).

use super::batch::SampleBatch;
use super::drivers::Drivers;
use super::generate::Generator;
use super::input::{Input, Sample, float};
use super::kept::Tally;
use super::measure::{Outcome, SampleError, floats, outcome};
use super::plan::{SampleSearch, columns, settings};
use super::random::Random;

/// The neighbours tried per round.
const NEIGHBOURS: usize = 64;

const ROUNDS: usize = 48;
/// The rounds without improvement after which a climb stops.
const PATIENCE: usize = 10;

/// The results of all climbs, and the drivers that run their samples too.
pub(super) struct Climbs<'c, 'r> {
    pub tally: Tally,
    pub drivers: &'c mut Drivers<'r>,
    /// Whether every input was run, so that no climb is needed.
    pub over: bool,
}

/// The backend whose error a climb maximises.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ClimbTarget {
    Interpreter,
    /// The driver of that index, with its error at the start.
    Driver(usize, f64),
}

/// Climbs from a sample to the largest error found.
/// Hill climbing, since the error is no smooth function of the bits: each round tries neighbours
/// of the best sample in one call, and takes the worst of them.
pub(super) fn climb(
    search: SampleSearch<'_>,
    start: &Sample,
    (height, whose): (impl Fn(&SampleError) -> f64, ClimbTarget),
    random: &mut Random,
    climbs: &mut Climbs<'_, '_>,
) -> (Sample, SampleError) {
    let SampleSearch { pure, generator, plan } = search;
    let (inputs, domain) = (search.inputs(), search.domain());
    let floats = floats(pure);
    // Nothing is worse than the worst of all inputs.
    if climbs.over {
        let called = pure.call(&columns(std::slice::from_ref(start)), 1, &settings(plan, false));
        let off = called.ok().and_then(|called| match outcome(&called, &floats, 0) {
            Outcome::Finite(off, _) => Some(off),
            Outcome::Discarded | Outcome::NotANumber | Outcome::Infinite => None,
        });
        return (start.clone(), off.unwrap_or_default());
    }
    let mut best = (start.clone(), SampleError::default());
    let mut highest = match whose {
        ClimbTarget::Interpreter => 0.0,
        ClimbTarget::Driver(_, height) => height,
    };
    let mut idle = 0;
    for round in 0..ROUNDS {
        if plan.until.is_over() || idle > PATIENCE {
            break;
        }
        // Lane 0 repeats the best sample, which fills in its error in the first round.
        let mut samples = vec![best.0.clone()];
        while samples.len() < NEIGHBOURS {
            let mut next = best.0.clone();
            let times = if random.chance(0.7) { 1 } else { 1 + random.below(3) };
            for _ in 0..times {
                step(&mut next, inputs, generator, random);
            }
            if domain.fit(&mut next, inputs, random) {
                samples.push(next);
            } else if random.chance(0.05) {
                // Where the domain rejects nearly everything, the batch still fills up.
                samples.push(best.0.clone());
            }
        }
        let columns = columns(&samples);
        let Ok(called) = pure.call(&columns, samples.len(), &settings(plan, false)) else {
            break;
        };
        idle += 1;
        let lanes = 0..samples.len();
        let mut outcomes: Vec<Outcome> =
            lanes.map(|lane| outcome(&called, &floats, lane)).collect();
        let mut batch = SampleBatch::new(columns, called, &floats, outcomes.clone());
        // The first sample was already run.
        let known = usize::from(round == 0);
        (0..known).for_each(|_| batch.drop_first());
        outcomes[known..].iter().for_each(|outcome| climbs.tally.add(*outcome));
        match whose {
            ClimbTarget::Interpreter => climbs.drivers.add(batch),
            ClimbTarget::Driver(driver, _) => {
                // On a driver the samples run at once, since the next round depends on them.
                let there = climbs.drivers.climbed(batch).swap_remove(driver);
                if there.is_empty() {
                    break;
                }
                samples.drain(..known);
                outcomes = there;
            }
        }
        for (lane, (sample, outcome)) in samples.iter().zip(outcomes).enumerate() {
            if let Outcome::Finite(off, _) = outcome {
                if height(&off) > highest {
                    highest = height(&off);
                    idle = if lane == 0 { idle } else { 0 };
                    best = (sample.clone(), off);
                }
            }
        }
    }
    best
}

/// Changes one scalar: a bit, a few units of the last place, another value, or another input's.
fn step(sample: &mut Sample, inputs: &[Input], generator: &Generator<'_>, random: &mut Random) {
    if inputs.is_empty() {
        return;
    }
    let nth = random.below(inputs.len());
    let input = &inputs[nth];
    let at = input.first + random.below(input.len);
    if !input.is_float() {
        generator.any_of(nth, sample, random);
        return;
    }
    let x = float(sample, at);
    let bits = x.to_bits();
    let next = match random.below(8) {
        // Bits of the mantissa; neighbours; relative steps from 1e-7 to 0.5; scaling by up to 10;
        // any value of the domain.
        0 | 1 => bits ^ (1 << random.below(23)),
        2 => bits.wrapping_add(1),
        3 => bits.wrapping_sub(1),
        4 | 5 => {
            let by = 1.0 + random.between(-1.0, 1.0) * random.scale(1e-7, 0.5);
            ((f64::from(x) * by) as f32).to_bits()
        }
        6 => ((f64::from(x) * random.scale(0.1, 10.0)) as f32).to_bits(),
        _ => {
            generator.any_of(nth, sample, random);
            return;
        }
    };
    if f32::from_bits(next).is_finite() {
        sample[at] = u64::from(next);
    }
}
