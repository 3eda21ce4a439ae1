//! What a driver's results come to, held against the evaluator's `f64` of the same bits.
//!
//! Takes what [`drivers`](super::drivers) call; keeps what [`readers`](super::readers) report.

use std::time::Duration;

use super::drivers::Batch;
use super::input::{Input, Sample};
use super::measure::{Off, Outcome, outcome_of};
use super::sample::{Kept, Tally, top};
use super::shrink::plausible;
use landfall_exec::backend::{Device, Failure};
use landfall_exec::harness::call::driven::DrivenCalled;

/// What a driver's results come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Came {
    /// One is NaN.
    NotANumber,
    /// One is infinite.
    Infinite,
    /// All are finite; how far off, where an `f32` can hold what they should be.
    Finite(Option<Off>),
}

/// Why a sample of a driver is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Why {
    /// The largest error in units of the last place.
    Ulp,
    /// The largest in steps.
    Steps,
    /// Off by more than is asked for where the evaluator is not.
    Apart,
    /// Not finite where the evaluator is.
    NotFinite,
    /// Finite where the evaluator is not.
    Hidden,
}

impl Why {
    pub const ALL: [Why; 5] = [Why::Ulp, Why::Steps, Why::Apart, Why::NotFinite, Why::Hidden];
}

/// A sample that is kept, and the floats a driver gave for it.
pub(super) type Answered = Kept<(Sample, Vec<f32>)>;

/// What one driver made of the samples.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    pub device: Device,
    /// Samples of finite inputs, and their errors where both are finite.
    pub tally: Tally,
    /// How often each of [`Why`] held; of the largest errors, of no meaning.
    pub counts: [u64; 5],
    /// Samples of each, and the floats it gave.
    pub tops: [Vec<Answered>; 5],
    /// Samples that one of the two discards.
    pub parted: u64,
    /// Time in the driver, and samples in it.
    pub busy: Duration,
    pub ran: u64,
    /// Whether it was not done with a job when the time was up.
    pub cut: bool,
    /// Why it runs no more.
    pub failure: Option<Failure>,
}

/// What a driver's results are held against.
pub(super) struct Judge<'r> {
    pub inputs: &'r [Input],
    pub floats: Vec<(usize, usize)>,
    /// Errors beyond which a sample is kept.
    pub steps: f64,
    pub ulp: f64,
}

/// The floats of a lane.
pub(super) fn singles<'c>(
    called: &'c DrivenCalled,
    floats: &'c [(usize, usize)],
    lane: usize,
) -> impl Iterator<Item = f32> + 'c {
    floats.iter().map(move |&place| single(called, place, lane))
}

fn single(called: &DrivenCalled, (result, at): (usize, usize), lane: usize) -> f32 {
    f32::from_bits(called.results[result][at][lane] as u32)
}

/// What so many floats of a driver come to, each with what it should be.
pub(super) fn came(count: usize, pair: impl Fn(usize) -> (f32, f64)) -> Came {
    let singles = || (0..count).map(|nth| pair(nth).0);
    if singles().any(f32::is_nan) {
        return Came::NotANumber;
    }
    if singles().any(f32::is_infinite) {
        return Came::Infinite;
    }
    let held = |nth| pair(nth).1.abs() <= f64::from(f32::MAX);
    Came::Finite(match outcome_of(count, &pair) {
        Outcome::Off(off, _) if (0..count).all(held) => Some(off),
        Outcome::Off(..) | Outcome::Discarded | Outcome::NotANumber | Outcome::Infinite => None,
    })
}

impl Seen {
    /// A driver that has run nothing yet, or never will.
    pub fn new(device: Device, failure: Option<Failure>) -> Seen {
        Seen {
            device,
            tally: Tally::default(),
            counts: [0; 5],
            tops: Default::default(),
            parted: 0,
            busy: Duration::ZERO,
            ran: 0,
            cut: false,
            failure,
        }
    }

    /// Tallies a batch, keeps what is odd about it, and says what each sample came to.
    pub fn judge(
        &mut self,
        batch: &Batch,
        called: &DrivenCalled,
        judge: &Judge<'_>,
    ) -> Vec<Outcome> {
        let mut outcomes = Vec::new();
        if batch.special {
            return outcomes;
        }
        let Judge { inputs, floats, steps, ulp } = judge;
        for (lane, theirs) in batch.outcomes.iter().enumerate() {
            let at = (batch.at.0, batch.at.1 + lane);
            let sample = || (batch.sample(lane), singles(called, floats, lane).collect());
            match (called.discarded[lane], *theirs == Outcome::Discarded) {
                (true, true) => {
                    self.tally.add(Outcome::Discarded);
                    outcomes.push(Outcome::Discarded);
                    continue;
                }
                (false, false) => {}
                (true, false) | (false, true) => {
                    self.tally.samples += 1;
                    self.parted += 1;
                    outcomes.push(Outcome::Discarded);
                    continue;
                }
            }
            let finite = matches!(theirs, Outcome::Off(..));
            // Numbers as scenes have them go before all others, as they do in findings.
            let rank = |severity: f64, sample: &Sample| {
                let below_one = (severity.max(1.0e-300).log2() + 1000.0) / 3000.0;
                below_one + if plausible(inputs, sample) { 1.0 } else { 0.0 }
            };
            let pair = |nth: usize| (single(called, floats[nth], lane), batch.doubles[nth][lane]);
            let mut not_finite = |outcome: Outcome, severity: f64| {
                self.tally.add(outcome);
                outcomes.push(outcome);
                if finite {
                    let severity = rank(severity, &batch.sample(lane));
                    self.keep(Why::NotFinite, severity, at, sample);
                }
            };
            match came(floats.len(), pair) {
                Came::NotANumber => not_finite(Outcome::NotANumber, 2.0),
                Came::Infinite => not_finite(Outcome::Infinite, 1.0),
                Came::Finite(off) => {
                    match off {
                        Some(off) => self.tally.add(Outcome::Off(off, false)),
                        None => self.tally.samples += 1,
                    }
                    outcomes.push(off.map_or(Outcome::Infinite, |off| Outcome::Off(off, false)));
                    if !finite {
                        let severity = rank(1.0, &batch.sample(lane));
                        self.keep(Why::Hidden, severity, at, sample);
                    }
                    let Some(off) = off else { continue };
                    self.keep(Why::Ulp, off.ulp, at, sample);
                    self.keep(Why::Steps, off.steps, at, sample);
                    let Outcome::Off(own, _) = theirs else { continue };
                    let fine = own.steps <= *steps && own.ulp <= *ulp;
                    // A little more than what is just allowed is no other kind of error.
                    let far = off.steps > *steps && off.steps > 2.0 * own.steps
                        || off.ulp > *ulp && off.ulp > 2.0 * own.ulp;
                    if fine && far {
                        let severity = rank(off.steps, &batch.sample(lane));
                        self.keep(Why::Apart, severity, at, sample);
                    }
                }
            }
        }
        outcomes
    }

    fn keep(
        &mut self,
        why: Why,
        severity: f64,
        at: (usize, usize),
        sample: impl FnOnce() -> (Sample, Vec<f32>),
    ) {
        let nth = why as usize;
        self.counts[nth] += 1;
        top(&mut self.tops[nth], severity, at, sample);
    }
}
