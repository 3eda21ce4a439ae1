//! A sampling thread: runs chunks, counts outcomes, and keeps the samples to examine.
//!
//! Started by [`sample`](super::sample), which merges the results; sends batches to the
//! [`drivers`](super::drivers).

use std::sync::mpsc::SyncSender;

use super::batch::SampleBatch;
use super::generate::{Chunk, Family, TAG_BITS};
use super::kept::{KeepReason, Kept, SampledResults, Tally, keep_most_severe, top};
use super::measure::{Outcome, floats, outcome, outcome_beside};
use super::plan::{Plan, columns, settings};
use landfall_exec::backend::{Failure, FailureKind};
use landfall_exec::harness::call::pure::{PureCallResult, PureFunction};
use landfall_interp::{Precision, Settings};

/// The most exemplars a thread keeps.
/// A bound of memory: a sample of 1000 scalars takes 8 KB.
const KEPT: usize = 6000;

pub(super) struct Worker<'a> {
    pure: &'a PureFunction,
    plan: &'a Plan,
    floats: Vec<(usize, usize)>,
    pub sampled: SampledResults,
    /// The channel to the drivers.
    to: Option<SyncSender<SampleBatch>>,
}

impl<'a> Worker<'a> {
    pub fn new(
        pure: &'a PureFunction,
        plan: &'a Plan,
        to: Option<SyncSender<SampleBatch>>,
    ) -> Worker<'a> {
        let sampled = SampledResults::new();
        Worker { pure, plan, floats: floats(pure), sampled, to }
    }

    /// Runs a chunk.
    ///
    /// # Errors
    /// Code that the interpreter does not support.
    pub fn run(&mut self, number: usize, chunk: &Chunk) -> Result<(), Failure> {
        let watch = match chunk.family {
            Family::Coincidences | Family::Scenes | Family::Drawn | Family::Every => true,
            // Some, as an index out of its array shows in no result.
            Family::Bits => number.is_multiple_of(3),
            Family::Mixed | Family::Special | Family::Climbed => false,
        };
        self.part(number, chunk, 0..chunk.samples.len(), watch)
    }

    /// Runs lanes of a chunk; finds those that do not terminate by halving.
    fn part(
        &mut self,
        number: usize,
        chunk: &Chunk,
        lanes: std::ops::Range<usize>,
        watch: bool,
    ) -> Result<(), Failure> {
        if lanes.is_empty() {
            return Ok(());
        }
        let samples = &chunk.samples[lanes.clone()];
        let settings = settings(self.plan, watch);
        let columns = columns(samples);
        // A call runs all lanes until every loop has ended. If it runs over the budget, its halves
        // tell which lanes do not end: log2(lanes) calls for each of them.
        match self.pure.call(&columns, samples.len(), &settings) {
            Ok(called) => {
                let at = (number, lanes.start);
                let outcomes = self.judge(number, chunk, lanes.clone(), &called);
                self.diverged(number, chunk, lanes, (&called, &outcomes));
                if let Some(to) = &self.to {
                    let special = chunk.family == Family::Special;
                    let batch = SampleBatch::new(columns, called, &self.floats, outcomes);
                    // The receiver outlives all senders.
                    let _ = to.send(SampleBatch { special, at, ..batch });
                }
                Ok(())
            }
            Err(failure) if failure.kind == FailureKind::TimedOut => {
                // The time is over rather than the loop endless.
                if self.plan.until.is_over() {
                    self.sampled.stopped = true;
                    return Ok(());
                }
                if lanes.len() == 1 {
                    let tally = self.tally(chunk.family);
                    tally.samples += 1;
                    tally.endless += 1;
                    let kept = Kept {
                        sample: chunk.samples[lanes.start].clone(),
                        severity: 1.0,
                        at: (number, lanes.start),
                    };
                    keep_most_severe(
                        &mut self.sampled.exemplars,
                        (0, KeepReason::Endless),
                        kept,
                        KEPT,
                    );
                    return Ok(());
                }
                let middle = lanes.start + lanes.len() / 2;
                self.part(number, chunk, lanes.start..middle, watch)?;
                self.part(number, chunk, middle..lanes.end, watch)
            }
            Err(failure) => Err(failure),
        }
    }

    fn tally(&mut self, family: Family) -> &mut Tally {
        let at = Family::ALL.iter().position(|f| *f == family).unwrap_or(0);
        &mut self.sampled.families[at].1
    }

    fn judge(
        &mut self,
        number: usize,
        chunk: &Chunk,
        lanes: std::ops::Range<usize>,
        called: &PureCallResult,
    ) -> Vec<Outcome> {
        let mut outcomes = Vec::with_capacity(lanes.len());
        let special = chunk.family == Family::Special;
        for lane in 0..lanes.len() {
            let outcome = outcome(called, &self.floats, lane);
            outcomes.push(outcome);
            self.tally(chunk.family).add(outcome);
            if special {
                continue;
            }
            let nth = lanes.start + lane;
            if let Outcome::Finite(off, _) = outcome {
                let sample = || chunk.samples[nth].clone();
                let [by_ulp, by_steps] = &mut self.sampled.tops;
                top(by_ulp, off.ulp, (number, nth), sample);
                top(by_steps, off.steps, (number, nth), sample);
            }
            let (why, severity) = match outcome {
                Outcome::Discarded => continue,
                Outcome::NotANumber => (KeepReason::NotANumber, 2.0),
                Outcome::Infinite => (KeepReason::Infinite, 1.0),
                // Small errors are counted, not kept.
                Outcome::Finite(off, _) if !self.plan.is_large(&off) => continue,
                Outcome::Finite(off, above) => {
                    (if above { KeepReason::Above } else { KeepReason::Below }, off.steps)
                }
            };
            let tag = chunk.tags[nth];
            // Samples of random bits are kept from all over, not only the worst, which mostly
            // overflow.
            let tag = match tag {
                // Tags decide which samples compete: with one tag, all samples of random bits
                // would be represented by the one that overflows most.
                TAG_BITS => (1 << 28) + (nth as u32 & 63),
                tag => tag,
            };
            self.keep(chunk, number, nth, (tag, why), severity);
        }
        let mut undefined = 0;
        for seen in &called.called.notes.undefined {
            undefined += seen.count;
            let span = seen.place.span;
            for &lane in seen.lanes.iter().filter(|_| !special) {
                let nth = lanes.start + lane;
                let key =
                    (chunk.tags[nth], KeepReason::Undefined(seen.kind, span.file, span.start));
                self.keep(chunk, number, nth, key, 0.0);
            }
        }
        self.tally(chunk.family).undefined += undefined;
        outcomes
    }

    /// Keeps samples whose `f32` takes another branch than their `f64`, if the results differ.
    fn diverged(
        &mut self,
        number: usize,
        chunk: &Chunk,
        lanes: std::ops::Range<usize>,
        (called, outcomes): (&PureCallResult, &[Outcome]),
    ) {
        if chunk.family == Family::Special {
            return;
        }
        let is_apart = |lane: &usize| {
            called.called.unsure.get(*lane) == Some(&true)
                && matches!(outcomes[*lane], Outcome::Finite(..))
        };
        let apart: Vec<usize> = (0..lanes.len()).filter(is_apart).collect();
        if apart.is_empty() {
            return;
        }
        let samples: Vec<_> =
            apart.iter().map(|lane| chunk.samples[lanes.start + lane].clone()).collect();
        // The same samples in `f64` with branches of its own: `called` has followed those of
        // `f32`.
        let settings = Settings { precision: Precision::Double, ..settings(self.plan, false) };
        let Ok(own) = self.pure.call(&columns(&samples), samples.len(), &settings) else { return };
        for (nth, &lane) in apart.iter().enumerate() {
            if own.called.discarded.get(nth) == Some(&true) {
                continue;
            }
            let off = outcome_beside((called, lane), (&own, nth), &self.floats);
            let Outcome::Finite(off, _) = off else { continue };
            if self.plan.is_large(&off) {
                let at = lanes.start + lane;
                let key = (chunk.tags[at] & !(1 << 28), KeepReason::Diverged);
                self.keep(chunk, number, at, key, off.steps);
            }
        }
    }

    fn keep(
        &mut self,
        chunk: &Chunk,
        number: usize,
        nth: usize,
        key: (u32, KeepReason),
        severity: f64,
    ) {
        let known = self.sampled.exemplars.get(&key);
        // Before the sample is cloned.
        if known.is_some_and(|known| known.severity >= severity) {
            return;
        }
        let kept = Kept { sample: chunk.samples[nth].clone(), severity, at: (number, nth) };
        keep_most_severe(&mut self.sampled.exemplars, key, kept, KEPT);
    }
}
