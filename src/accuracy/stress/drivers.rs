//! The drivers beside the evaluator: every sample also runs on each of them, and what it gives is
//! held against the evaluator's `f64` of the same bits.
//!
//! Takes batches of [`sample`](super::sample) and of climbs; [`readers`](super::readers) makes a
//! report of what is kept.

use std::time::{Duration, Instant};

use super::input::{Input, Sample};
use super::measure::{Off, Outcome, floats, outcome_of};
use super::sample::{Kept, Plan, Tally, top};
use super::shrink::plausible;
use crate::run::call::driven::{Driven, DrivenCalled};
use crate::run::call::pure::{Pure, PureCalled};
use crate::run::reader::{Device, Failure, Reader};

/// A driver that is not done with one job by then has failed.
pub(super) const LIMIT: Duration = Duration::from_secs(20);

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

    fn sample(&self, lane: usize) -> Sample {
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

/// A driver's name, and by sample the floats it gives, or why it gives none.
pub(super) type Given = (&'static str, Result<Vec<Vec<f32>>, String>);

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
    /// Why it runs no more.
    pub failure: Option<Failure>,
}

/// A driver at work.
struct Seat<'r> {
    reader: &'r mut dyn Reader,
    driven: Option<Driven<'r>>,
    seen: Seen,
}

/// What a driver's results are held against.
struct Judge<'r> {
    inputs: &'r [Input],
    floats: Vec<(usize, usize)>,
    /// Errors from which on a sample is kept.
    steps: f64,
    ulp: f64,
}

/// All drivers that were asked for.
pub(super) struct Drivers<'r> {
    seats: Vec<Seat<'r>>,
    judge: Judge<'r>,
    /// Climbs are of few samples: they wait for each other.
    waiting: Batch,
    climbs: usize,
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
        let drivers = readers.iter_mut().filter(|reader| reader.device().reader != "cpu");
        let seats = drivers.map(|reader| {
            let device = reader.device().clone();
            let (driven, failure) = match pure.on(&device) {
                Ok(driven) => (Some(driven), None),
                Err(failure) => (None, Some(failure)),
            };
            let seen = Seen {
                device,
                tally: Tally::default(),
                counts: [0; 5],
                tops: Default::default(),
                parted: 0,
                busy: Duration::ZERO,
                ran: 0,
                failure,
            };
            Seat { reader: reader.as_mut(), driven, seen }
        });
        Drivers {
            seats: seats.collect(),
            judge: Judge { inputs, floats: floats(pure), steps: plan.steps, ulp: plan.ulp },
            waiting: Batch::default(),
            climbs: 0,
        }
    }

    /// Whether nobody is left to run anything.
    pub fn idle(&self) -> bool {
        self.seats.iter().all(|seat| seat.seen.failure.is_some())
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.seats.len()
    }

    /// Runs a batch on each, and says what its samples came to there.
    pub fn run(&mut self, batch: &Batch) -> Vec<Vec<Outcome>> {
        let Drivers { seats, judge, .. } = self;
        let each = seats.iter_mut().map(|seat| {
            let called = seat.call(&batch.columns, batch.outcomes.len());
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
            let called = seat.call(&columns, samples.len());
            let given = called.map(|called| {
                let lane = |lane| singles(&called, floats, lane).collect();
                (0..samples.len()).map(lane).collect()
            });
            let why = || seat.seen.failure.as_ref().map_or(String::new(), |f| f.message.clone());
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
    fn call(&mut self, columns: &[Vec<u64>], lanes: usize) -> Option<DrivenCalled> {
        if self.seen.failure.is_some() || lanes == 0 {
            return None;
        }
        let began = Instant::now();
        let called = self.driven.as_ref()?.call(self.reader, columns, lanes, LIMIT);
        match called {
            Ok(called) => {
                self.seen.busy += began.elapsed();
                self.seen.ran += lanes as u64;
                Some(called)
            }
            Err(failure) => {
                self.seen.failure = Some(failure);
                None
            }
        }
    }
}

/// The floats of a lane.
fn singles<'c>(
    called: &'c DrivenCalled,
    floats: &'c [(usize, usize)],
    lane: usize,
) -> impl Iterator<Item = f32> + 'c {
    floats.iter().map(move |&(nth, at)| f32::from_bits(called.results[nth][at][lane] as u32))
}

/// How far finite results are off; none where an `f32` cannot hold what they should be.
pub(super) fn error(count: usize, pair: impl Fn(usize) -> (f32, f64)) -> Option<Off> {
    let held = |nth| pair(nth).1.abs() <= f64::from(f32::MAX);
    match outcome_of(count, &pair) {
        Outcome::Off(off, _) if (0..count).all(held) => Some(off),
        Outcome::Off(..) | Outcome::Discarded | Outcome::NotANumber | Outcome::Infinite => None,
    }
}

/// What a driver's results come to by themselves, and against the truth.
enum Verdict {
    NotFinite(Outcome),
    /// Finite; the error where there is a truth.
    Finite(Option<Off>),
}

impl Seen {
    fn judge(&mut self, batch: &Batch, called: &DrivenCalled, judge: &Judge<'_>) -> Vec<Outcome> {
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
            match verdict(called, floats, batch, lane) {
                Verdict::NotFinite(outcome) => {
                    self.tally.add(outcome);
                    outcomes.push(outcome);
                    if finite {
                        let severity = if outcome == Outcome::NotANumber { 2.0 } else { 1.0 };
                        let severity = rank(severity, &batch.sample(lane));
                        self.keep(Why::NotFinite, severity, at, sample);
                    }
                }
                Verdict::Finite(off) => {
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
                    let fine = own.steps < *steps && own.ulp < *ulp;
                    // A little more than what is just allowed is no other kind of error.
                    let far = off.steps >= *steps && off.steps > 2.0 * own.steps
                        || off.ulp >= *ulp && off.ulp > 2.0 * own.ulp;
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

fn verdict(
    called: &DrivenCalled,
    floats: &[(usize, usize)],
    batch: &Batch,
    lane: usize,
) -> Verdict {
    let mut infinite = false;
    for single in singles(called, floats, lane) {
        if single.is_nan() {
            return Verdict::NotFinite(Outcome::NotANumber);
        }
        infinite |= single.is_infinite();
    }
    if infinite {
        return Verdict::NotFinite(Outcome::Infinite);
    }
    let pair = |nth: usize| {
        let (result, at) = floats[nth];
        let single = f32::from_bits(called.results[result][at][lane] as u32);
        (single, batch.doubles[nth][lane])
    };
    Verdict::Finite(error(floats.len(), pair))
}
