//! The drivers beside the evaluator: every sample also runs on each of them, while there is time.
//!
//! Takes batches of [`sample`](super::sample) and of climbs; [`judge`](super::judge) keeps what
//! [`readers`](super::readers) make a report of.

use std::time::{Duration, Instant};

use super::deadline::Deadline;
use super::input::{Input, Sample};
use super::judge::{Judge, Seen, Why, singles};
use super::measure::{Outcome, floats};
use super::sample::Plan;
use landfall_exec::backend::{BackendKind, FailureKind, Reader};
use landfall_exec::harness::call::driven::{Driven, DrivenCalled};
use landfall_exec::harness::call::pure::{Pure, PureCalled};

/// A driver that is not done with one job by then has failed.
const LIMIT: Duration = Duration::from_secs(20);

/// Longer than the time that is left a job may take so much: what is begun is mostly done by then.
const OVERTIME: Duration = Duration::from_secs(1);

/// Samples the evaluator ran, and what they should come to.
#[derive(Clone, Debug, Default)]
pub(super) struct Batch {
    /// Words by scalar, then by sample.
    pub columns: Vec<Vec<u64>>,
    /// By float of the results, then by sample: in `f64`.
    pub doubles: Vec<Vec<f64>>,
    /// What each came to on the evaluator.
    pub outcomes: Vec<Outcome>,
    /// Inputs that are not finite: they count for nothing.
    pub special: bool,
    /// The chunk, and the lane of the first.
    pub at: (usize, usize),
}

impl Batch {
    /// A batch of what the evaluator gave.
    pub fn of(
        columns: Vec<Vec<u64>>,
        called: PureCalled,
        floats: &[(usize, usize)],
        outcomes: Vec<Outcome>,
    ) -> Batch {
        let mut results = called.results;
        let take = |&(nth, at): &(usize, usize)| std::mem::take(&mut results[nth].doubles[at]);
        let doubles = floats.iter().map(take).collect();
        Batch { columns, doubles, outcomes, ..Batch::default() }
    }

    /// Leaves out its first sample.
    pub fn drop_first(&mut self) {
        self.columns.iter_mut().for_each(|column| drop(column.drain(..1)));
        self.doubles.iter_mut().for_each(|column| drop(column.drain(..1)));
        self.outcomes.drain(..1);
    }

    pub fn sample(&self, lane: usize) -> Sample {
        self.columns.iter().map(|column| column[lane]).collect()
    }

    fn append(&mut self, more: Batch) {
        if self.columns.is_empty() && self.outcomes.is_empty() {
            *self = more;
            return;
        }
        let columns = self.columns.iter_mut().zip(more.columns);
        columns.for_each(|(all, more)| all.extend(more));
        let doubles = self.doubles.iter_mut().zip(more.doubles);
        doubles.for_each(|(all, more)| all.extend(more));
        self.outcomes.extend(more.outcomes);
    }
}

/// A driver's name, and by sample the floats it gives, or why it gives none.
pub(super) type Given = (BackendKind, Result<Vec<Vec<f32>>, String>);

/// A driver at work.
struct Seat<'r> {
    reader: &'r mut dyn Reader,
    driven: Option<Driven<'r>>,
    seen: Seen,
}

/// All drivers that were asked for.
pub(super) struct Drivers<'r> {
    seats: Vec<Seat<'r>>,
    judge: Judge<'r>,
    /// Climbs are of few samples: they wait for each other.
    waiting: Batch,
    climbs: usize,
    until: Deadline,
    /// Whether samples were left out because the time was up.
    cut: bool,
}

/// Samples that wait at most.
const WAITING: usize = 1024;

impl<'r> Drivers<'r> {
    /// Takes the readers that are drivers: the evaluator runs in any case.
    pub fn new(
        pure: &'r Pure,
        inputs: &'r [Input],
        readers: &'r mut [Box<dyn Reader>],
        plan: &Plan,
    ) -> Drivers<'r> {
        let drivers = readers.iter_mut().filter(|reader| reader.device().reader.is_driver());
        let seats = drivers.map(|reader| {
            let device = reader.device().clone();
            let (driven, failure) = match pure.on(&device) {
                Ok(driven) => (Some(driven), None),
                Err(failure) => (None, Some(failure)),
            };
            Seat { reader: reader.as_mut(), driven, seen: Seen::new(device, failure) }
        });
        Drivers {
            seats: seats.collect(),
            judge: Judge { inputs, floats: floats(pure), steps: plan.steps, ulp: plan.ulp },
            waiting: Batch::default(),
            climbs: 0,
            until: plan.until.clone(),
            cut: false,
        }
    }

    /// When the next jobs should be done.
    pub fn set_until(&mut self, until: &Deadline) {
        self.until = until.clone();
    }

    /// Whether samples were left out because the time was up.
    pub fn is_cut(&self) -> bool {
        self.cut || self.seats.iter().any(|seat| seat.seen.cut)
    }

    /// Whether nobody is left to run anything.
    pub fn idle(&self) -> bool {
        self.seats.iter().all(|seat| seat.seen.failure.is_some())
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.seats.len()
    }

    /// Runs a batch on each if there is time.
    pub fn take(&mut self, batch: &Batch) {
        match self.until.is_over() {
            true => self.cut |= !self.idle(),
            false => drop(self.run(batch)),
        }
    }

    /// Runs a batch on each, and says what its samples came to there.
    fn run(&mut self, batch: &Batch) -> Vec<Vec<Outcome>> {
        let Drivers { seats, judge, until, .. } = self;
        let each = seats.iter_mut().map(|seat| {
            let called = seat.call(&batch.columns, batch.outcomes.len(), until);
            called.map_or(Vec::new(), |called| seat.seen.judge(batch, &called, judge))
        });
        each.collect()
    }

    /// Runs a few samples of a climb now.
    pub fn climbed(&mut self, mut batch: Batch) -> Vec<Vec<Outcome>> {
        // After all that were drawn.
        batch.at = (usize::MAX, self.climbs);
        self.climbs += batch.outcomes.len();
        self.run(&batch)
    }

    /// Where to climb from on one of them, and how high that is.
    pub fn starts(&self, driver: usize, why: Why) -> Vec<(Sample, f64)> {
        let tops = &self.seats[driver].seen.tops[why as usize];
        tops.iter().map(|kept| (kept.sample.0.clone(), kept.severity)).collect()
    }

    /// Runs a few samples of a climb, sooner or later.
    pub fn add(&mut self, batch: Batch) {
        if self.idle() {
            return;
        }
        self.waiting.append(batch);
        if self.waiting.outcomes.len() >= WAITING {
            self.flush();
        }
    }

    /// Runs what still waits.
    pub fn flush(&mut self) {
        let batch = std::mem::take(&mut self.waiting);
        if !batch.outcomes.is_empty() {
            self.climbed(batch);
        }
    }

    /// The floats each driver gives for samples, or why it gives none.
    pub fn ask(&mut self, samples: &[Sample]) -> Vec<Given> {
        let floats = &self.judge.floats;
        let each = self.seats.iter_mut().map(|seat| {
            let columns = super::sample::columns(samples);
            let called = seat.call(&columns, samples.len(), &self.until);
            let given = called.map(|called| {
                let lane = |lane| singles(&called, floats, lane).collect();
                (0..samples.len()).map(lane).collect()
            });
            let late = || "the time was up".to_string();
            let why = || seat.seen.failure.as_ref().map_or_else(late, |f| f.message.clone());
            (seat.seen.device.reader, given.ok_or_else(why))
        });
        each.collect()
    }

    /// What each has seen so far.
    pub fn seen(&self) -> Vec<Seen> {
        self.seats.iter().map(|seat| seat.seen.clone()).collect()
    }
}

impl Seat<'_> {
    fn call(
        &mut self,
        columns: &[Vec<u64>],
        lanes: usize,
        until: &Deadline,
    ) -> Option<DrivenCalled> {
        if self.seen.failure.is_some() || lanes == 0 {
            return None;
        }
        let began = Instant::now();
        let limit = until.left().map_or(LIMIT, |left| left.saturating_add(OVERTIME).min(LIMIT));
        let called = self.driven.as_ref()?.call(self.reader, columns, lanes, limit);
        match called {
            Ok(called) => {
                self.seen.busy += began.elapsed();
                self.seen.ran += lanes as u64;
                Some(called)
            }
            // It was not the driver that took too long.
            Err(failure) if failure.kind == FailureKind::TimedOut && limit < LIMIT => {
                self.seen.cut = true;
                None
            }
            Err(failure) => {
                self.seen.failure = Some(failure);
                None
            }
        }
    }
}
