//! Runs every sample on each driver as well, while there is time.
//!
//! Takes batches from [`sample`](super::sample) and from climbs; [`verdict`](super::verdict) keeps
//! the records that [`backends`](super::backends) reports.

use std::time::{Duration, Instant};

use super::batch::SampleBatch;
use super::deadline::Deadline;
use super::domain::Domain;
use super::input::{Input, Sample};
use super::measure::{Outcome, floats};
use super::plan::{Plan, columns};
use super::verdict::{DriverKeepReason, DriverRecord, VerdictContext, singles};
use landfall_exec::backend::{Backend, BackendKind, FailureKind};
use landfall_exec::harness::call::kernel::{Kernel, KernelResult};
use landfall_exec::harness::call::pure::PureFunction;

/// The time after which a job of a driver has failed.
const LIMIT: Duration = Duration::from_secs(20);

/// The time a started job may take beyond the deadline: most then finish.
const OVERTIME: Duration = Duration::from_secs(1);

/// A driver, and its floats by sample or the reason there are none.
pub(super) type DriverFloats = (BackendKind, Result<Vec<Vec<f32>>, String>);

struct DriverSlot<'r> {
    backend: &'r mut dyn Backend,
    driven: Option<Kernel<'r>>,
    seen: DriverRecord,
}

pub(super) struct Drivers<'r> {
    seats: Vec<DriverSlot<'r>>,
    judge: VerdictContext<'r>,
    /// Samples of climbs, collected into larger batches.
    waiting: SampleBatch,
    climbs: usize,
    until: Deadline,
    /// Whether samples were skipped because time ran out.
    cut: bool,
}

/// The most samples collected before they run.
const WAITING: usize = 1024;

impl<'r> Drivers<'r> {
    /// Takes the drivers among the backends: the interpreter always runs.
    pub fn new(
        pure: &'r PureFunction,
        (inputs, domain): (&'r [Input], &'r Domain),
        backends: &'r mut [Box<dyn Backend>],
        plan: &Plan,
    ) -> Drivers<'r> {
        let drivers = backends.iter_mut().filter(|backend| backend.device().backend.is_driver());
        let seats = drivers.map(|backend| {
            let device = backend.device().clone();
            let (driven, failure) = match pure.on(&device) {
                Ok(driven) => (Some(driven), None),
                Err(failure) => (None, Some(failure)),
            };
            DriverSlot {
                backend: backend.as_mut(),
                driven,
                seen: DriverRecord::new(device, failure),
            }
        });
        Drivers {
            seats: seats.collect(),
            judge: VerdictContext {
                inputs,
                domain,
                floats: floats(pure),
                steps: plan.steps,
                ulp: plan.ulp,
            },
            waiting: SampleBatch::default(),
            climbs: 0,
            until: plan.until.clone(),
            cut: false,
        }
    }

    pub fn set_until(&mut self, until: &Deadline) {
        self.until = until.clone();
    }

    /// Whether samples were skipped because time ran out.
    pub fn is_cut(&self) -> bool {
        self.cut || self.seats.iter().any(|seat| seat.seen.cut)
    }

    /// Whether no driver is left to run samples.
    pub fn all_failed(&self) -> bool {
        self.seats.iter().all(|seat| seat.seen.failure.is_some())
    }

    pub fn len(&self) -> usize {
        self.seats.len()
    }

    /// Runs a batch on each driver if there is time.
    pub fn take(&mut self, batch: &SampleBatch) {
        // What comes after the time is over is dropped, and the report says so.
        match self.until.is_over() {
            true => self.cut |= !self.all_failed(),
            false => drop(self.run(batch)),
        }
    }

    /// Runs a batch on each driver; returns the outcomes of its samples on each.
    fn run(&mut self, batch: &SampleBatch) -> Vec<Vec<Outcome>> {
        let Drivers { seats, judge, until, .. } = self;
        let each = seats.iter_mut().map(|seat| {
            let called = seat.call(&batch.columns, batch.outcomes.len(), until);
            called.map_or(Vec::new(), |called| seat.seen.judge(batch, &called, judge))
        });
        each.collect()
    }

    /// Runs the samples of a climb now.
    pub fn climbed(&mut self, mut batch: SampleBatch) -> Vec<Vec<Outcome>> {
        // In ties, drawn samples come first.
        // `usize::MAX` sorts climbs after all chunks.
        batch.at = (usize::MAX, self.climbs);
        self.climbs += batch.outcomes.len();
        self.run(&batch)
    }

    /// Returns the samples to climb from on a driver, with their severity.
    pub fn climb_starts(&self, driver: usize, why: DriverKeepReason) -> Vec<(Sample, f64)> {
        let tops = &self.seats[driver].seen.tops[why as usize];
        tops.iter().map(|kept| (kept.sample.0.clone(), kept.severity)).collect()
    }

    /// Queues the samples of a climb.
    pub fn add(&mut self, batch: SampleBatch) {
        // Small batches of climbs cost a job each; collected they cost few.
        if self.all_failed() {
            return;
        }
        self.waiting.append(batch);
        if self.waiting.outcomes.len() >= WAITING {
            self.flush();
        }
    }

    pub fn flush(&mut self) {
        let batch = std::mem::take(&mut self.waiting);
        if !batch.outcomes.is_empty() {
            self.climbed(batch);
        }
    }

    /// Returns each driver's floats for samples, or the reason there are none.
    pub fn run_samples(&mut self, samples: &[Sample]) -> Vec<DriverFloats> {
        let floats = &self.judge.floats;
        let each = self.seats.iter_mut().map(|seat| {
            let columns = columns(samples);
            let called = seat.call(&columns, samples.len(), &self.until);
            let given = called.map(|called| {
                let lane = |lane| singles(&called, floats, lane).collect();
                (0..samples.len()).map(lane).collect()
            });
            let late = || "time ran out".to_string();
            let why = || seat.seen.failure.as_ref().map_or_else(late, |f| f.message.clone());
            (seat.seen.device.backend, given.ok_or_else(why))
        });
        each.collect()
    }

    pub fn records(&self) -> Vec<DriverRecord> {
        self.seats.iter().map(|seat| seat.seen.clone()).collect()
    }
}

impl DriverSlot<'_> {
    fn call(
        &mut self,
        columns: &[Vec<u64>],
        lanes: usize,
        until: &Deadline,
    ) -> Option<KernelResult> {
        if self.seen.failure.is_some() || lanes == 0 {
            return None;
        }
        let began = Instant::now();
        // A job gets what is left and a second, never more than the limit of a hung driver.
        let limit = until.left().map_or(LIMIT, |left| left.saturating_add(OVERTIME).min(LIMIT));
        let called = self.driven.as_ref()?.call(self.backend, columns, lanes, limit);
        match called {
            Ok(called) => {
                self.seen.busy += began.elapsed();
                self.seen.ran += lanes as u64;
                Some(called)
            }
            // The deadline cut the job short; the driver did not fail.
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
