//! Compares a driver's results with the interpreter's `f64` of the same inputs.
//!
//! Takes results from [`drivers`](super::drivers); keeps the records that
//! [`backends`](super::backends) reports.

use std::time::Duration;

use super::batch::SampleBatch;
use super::domain::Domain;
use super::input::{Input, Sample};
use super::kept::{Kept, Tally, top};
use super::measure::{Outcome, SampleError, outcome_of};
use super::shrink::plausible;
use landfall_exec::backend::{Device, Failure};
use landfall_exec::harness::call::kernel::KernelResult;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriverOutcome {
    /// A result is NaN.
    NotANumber,
    Infinite,
    /// All are finite: the error, if the expected results fit an `f32`.
    Finite(Option<SampleError>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DriverKeepReason {
    /// The largest error in units of the last place.
    Ulp,
    /// The largest error in steps.
    Steps,
    /// Beyond the error limit on the driver but not on the interpreter.
    Apart,
    /// Not finite on the driver but finite on the interpreter.
    NotFinite,
    /// Finite on the driver but not on the interpreter.
    Hidden,
}

impl DriverKeepReason {
    pub const ALL: [DriverKeepReason; 5] = [
        DriverKeepReason::Ulp,
        DriverKeepReason::Steps,
        DriverKeepReason::Apart,
        DriverKeepReason::NotFinite,
        DriverKeepReason::Hidden,
    ];
}

/// A kept sample with the driver's floats.
pub(super) type Answered = Kept<(Sample, Vec<f32>)>;

#[derive(Clone, Debug)]
pub(super) struct DriverRecord {
    pub device: Device,
    /// The samples with finite inputs; errors where both results are finite.
    pub tally: Tally,
    /// The number of samples for each [`DriverKeepReason`]; meaningless for the largest errors.
    pub counts: [u64; 5],
    /// The worst samples for each [`DriverKeepReason`], with the driver's floats.
    pub tops: [Vec<Answered>; 5],
    /// The samples discarded by either the driver or the interpreter, not both.
    pub parted: u64,
    /// The time spent in the driver.
    pub busy: Duration,
    /// The samples run in that time.
    pub ran: u64,
    /// Whether a job was unfinished when time ran out.
    pub cut: bool,
    /// The reason it runs no more samples.
    pub failure: Option<Failure>,
}

/// The inputs and limits for judging a driver's results.
pub(super) struct VerdictContext<'r> {
    pub inputs: &'r [Input],
    pub domain: &'r Domain,
    pub floats: Vec<(usize, usize)>,
    /// The error limits beyond which a sample is kept.
    pub steps: f64,
    pub ulp: f64,
}

/// Returns the floats of a lane.
pub(super) fn singles<'c>(
    called: &'c KernelResult,
    floats: &'c [(usize, usize)],
    lane: usize,
) -> impl Iterator<Item = f32> + 'c {
    floats.iter().map(move |&place| single(called, place, lane))
}

fn single(called: &KernelResult, (result, at): (usize, usize), lane: usize) -> f32 {
    f32::from_bits(called.results[result][at][lane] as u32)
}

/// Returns the outcome of the floats of a driver's results, each paired with its expected value.
pub(super) fn driver_outcome(
    floats: &[(usize, usize)],
    pair: impl Fn(usize) -> (f32, f64),
) -> DriverOutcome {
    let singles = || (0..floats.len()).map(|nth| pair(nth).0);
    if singles().any(f32::is_nan) {
        return DriverOutcome::NotANumber;
    }
    if singles().any(f32::is_infinite) {
        return DriverOutcome::Infinite;
    }
    // A truth beyond `f32` cannot be returned: a finite result of a driver is then no error.
    let held = |nth| pair(nth).1.abs() <= f64::from(f32::MAX);
    DriverOutcome::Finite(match outcome_of(floats, &pair) {
        Outcome::Finite(off, _) if (0..floats.len()).all(held) => Some(off),
        Outcome::Finite(..) | Outcome::Discarded | Outcome::NotANumber | Outcome::Infinite => None,
    })
}

impl DriverRecord {
    /// The record of a driver that has run nothing.
    pub fn new(device: Device, failure: Option<Failure>) -> DriverRecord {
        DriverRecord {
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

    /// Counts a batch, keeps notable samples and returns the outcome of each sample.
    pub fn judge(
        &mut self,
        batch: &SampleBatch,
        called: &KernelResult,
        judge: &VerdictContext<'_>,
    ) -> Vec<Outcome> {
        let mut outcomes = Vec::new();
        // Infinities among the inputs: drivers may do anything (WGSL §15.7.2).
        if batch.special {
            return outcomes;
        }
        let VerdictContext { inputs, domain, floats, steps, ulp } = judge;
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
                    // One of both discarded: neither result can be compared.
                    continue;
                }
            }
            let finite = matches!(theirs, Outcome::Finite(..));
            // Plausible samples rank before all others, as in findings.
            let rank = |severity: f64, sample: &Sample| {
                // Maps severities from 1e-300 to infinity to below 1, in order.
                let below_one = (severity.max(1.0e-300).log2() + 1000.0) / 3000.0;
                below_one + if plausible(inputs, domain, sample) { 1.0 } else { 0.0 }
            };
            let pair = |nth: usize| (single(called, floats[nth], lane), batch.doubles[nth][lane]);
            let mut not_finite = |outcome: Outcome, severity: f64| {
                self.tally.add(outcome);
                outcomes.push(outcome);
                if finite {
                    let severity = rank(severity, &batch.sample(lane));
                    self.keep(DriverKeepReason::NotFinite, severity, at, sample);
                }
            };
            match driver_outcome(floats, pair) {
                DriverOutcome::NotANumber => not_finite(Outcome::NotANumber, 2.0),
                DriverOutcome::Infinite => not_finite(Outcome::Infinite, 1.0),
                DriverOutcome::Finite(off) => {
                    match off {
                        Some(off) => self.tally.add(Outcome::Finite(off, false)),
                        None => self.tally.samples += 1,
                    }
                    // For a climb, a finite result in place of an infinite one is of no interest.
                    outcomes.push(off.map_or(Outcome::Infinite, |off| Outcome::Finite(off, false)));
                    if !finite {
                        let severity = rank(1.0, &batch.sample(lane));
                        self.keep(DriverKeepReason::Hidden, severity, at, sample);
                    }
                    let Some(off) = off else { continue };
                    self.keep(DriverKeepReason::Ulp, off.ulp, at, sample);
                    self.keep(DriverKeepReason::Steps, off.steps, at, sample);
                    let Outcome::Finite(own, _) = theirs else { continue };
                    let fine = own.steps <= *steps && own.ulp <= *ulp;
                    // Slightly more than the limit is not a different kind of error.
                    let far = off.steps > *steps && off.steps > 2.0 * own.steps
                        || off.ulp > *ulp && off.ulp > 2.0 * own.ulp;
                    if fine && far {
                        let severity = rank(off.steps, &batch.sample(lane));
                        self.keep(DriverKeepReason::Apart, severity, at, sample);
                    }
                }
            }
        }
        outcomes
    }

    fn keep(
        &mut self,
        why: DriverKeepReason,
        severity: f64,
        at: (usize, usize),
        sample: impl FnOnce() -> (Sample, Vec<f32>),
    ) {
        let nth = why as usize;
        self.counts[nth] += 1;
        top(&mut self.tops[nth], severity, at, sample);
    }
}
