//! Runs the samples on all cores, a chunk at a time, and merges what the threads kept.
//!
//! Takes chunks of [`generate`](super::generate); feeds [`find`](super::find), and the
//! [`drivers`](super::drivers), which the calling thread owns.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};

use rustc_hash::FxHashMap;

pub(super) use super::super::inputs::columns;
use super::deadline::Deadline;
use super::drivers::{Batch, Drivers};
use super::generate::{Family, Generator};
use super::input::Sample;
use super::measure::{Outcome, Spread};
use super::worker::Worker;
use landfall_exec::backend::Failure;
use landfall_exec::harness::call::pure::Pure;
use landfall_exec::interp::{Precision, Settings, UndefinedKind};

/// What is known of the samples of one family.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// How many ran.
    pub samples: u64,
    /// Met a `discard`.
    pub discarded: u64,
    /// Gave NaN.
    pub nan: u64,
    /// Gave an infinity.
    pub infinite: u64,
    /// Did not end.
    pub endless: u64,
    /// Operations without a defined value, over all that were watched.
    pub undefined: u64,
    /// Errors of the finite ones.
    pub ulp: Spread,
    /// The same relative to the value, with a floor.
    pub relative: Spread,
    /// The same in steps of 1/255.
    pub steps: Spread,
}

impl Tally {
    pub(super) fn add(&mut self, outcome: Outcome) {
        self.samples += 1;
        match outcome {
            Outcome::Discarded => self.discarded += 1,
            Outcome::NotANumber => self.nan += 1,
            Outcome::Infinite => self.infinite += 1,
            Outcome::Off(off, _) => {
                self.ulp.add(off.ulp);
                self.relative.add(off.relative);
                self.steps.add(off.steps);
            }
        }
    }

    /// Adds all of another.
    pub fn merge(&mut self, other: &Tally) {
        self.samples += other.samples;
        self.discarded += other.discarded;
        self.nan += other.nan;
        self.infinite += other.infinite;
        self.endless += other.endless;
        self.undefined += other.undefined;
        self.ulp.merge(&other.ulp);
        self.relative.merge(&other.relative);
        self.steps.merge(&other.steps);
    }
}

/// Why a sample is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Why {
    /// An operation of that kind at a byte of a file.
    Undefined(UndefinedKind, u32, u32),
    NotANumber,
    Infinite,
    Above,
    Below,
    Endless,
}

/// A sample worth a closer look.
#[derive(Clone, Debug)]
pub(super) struct Kept<T = Sample> {
    pub sample: T,
    pub severity: f64,
    /// The chunk and the lane it was in: ties go to the earlier one.
    pub at: (usize, usize),
}

/// Samples by how they were made and why they are kept.
pub(super) type Exemplars = FxHashMap<(u32, Why), Kept>;

/// How samples are run.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub samples: u64,
    pub until: Deadline,
    pub threads: usize,
    /// Errors beyond which a sample is kept.
    pub steps: f64,
    pub ulp: f64,
    pub budget: u32,
}

/// What all samples came to.
#[derive(Clone, Debug, Default)]
pub(super) struct Sampled {
    pub families: Vec<(Family, Tally)>,
    pub exemplars: Exemplars,
    /// The worst finite ones: by units of the last place, and by steps.
    pub tops: [Vec<Kept>; 2],
    /// Whether somebody said stop, or the time was up.
    pub stopped: bool,
}

/// Of the worst finite samples, how many are kept.
const TOPS: usize = 3;

impl Sampled {
    /// Of no sample yet.
    pub fn new() -> Sampled {
        let families = Family::ALL.map(|family| (family, Tally::default())).to_vec();
        Sampled { families, ..Sampled::default() }
    }

    /// Where to climb from: 0 for units of the last place, 1 for steps.
    pub fn starts(&self, which: usize) -> impl Iterator<Item = &Sample> {
        self.tops[which].iter().map(|kept| &kept.sample)
    }
}

/// Keeps a sample if it is one of the worst, the earlier of two that are as bad.
pub(super) fn top<T>(
    tops: &mut Vec<Kept<T>>,
    severity: f64,
    at: (usize, usize),
    sample: impl FnOnce() -> T,
) {
    let order = |a: &Kept<T>, severity: f64, at: (usize, usize)| {
        severity.total_cmp(&a.severity).then(a.at.cmp(&at))
    };
    let last = tops.last().filter(|_| tops.len() >= TOPS);
    if last.is_some_and(|last| order(last, severity, at).is_le()) {
        return;
    }
    tops.push(Kept { sample: sample(), severity, at });
    tops.sort_by(|a, b| order(a, b.severity, b.at));
    tops.truncate(TOPS);
}

/// Says how far it is.
pub(super) type Progress<'p> = &'p (dyn Fn(u64) + Sync);

/// Runs samples until there are enough, the time is up, or somebody says stop.
pub(super) fn run(
    pure: &Pure,
    generator: &Generator<'_>,
    plan: &Plan,
    drivers: &mut Drivers<'_>,
    progress: Progress<'_>,
) -> Result<Sampled, Failure> {
    // The next chunk, and the samples of those before it: the same for any number of threads.
    let claimed = Mutex::new((0usize, 0u64));
    let done = AtomicU64::new(0);
    let work = |to: Option<SyncSender<Batch>>| -> Result<Sampled, Failure> {
        let mut mine = Worker::new(pure, plan, to);
        loop {
            if plan.until.is_over() {
                mine.sampled.stopped |= done.load(Ordering::Relaxed) < plan.samples;
                break;
            }
            let (number, chunk) = {
                let mut claimed = claimed.lock().expect("making a chunk does not panic");
                if claimed.1 >= plan.samples {
                    break;
                }
                let chunk = generator.chunk(claimed.0);
                let number = claimed.0;
                // A domain may leave nothing of a family.
                *claimed = (number + 1, claimed.1 + (chunk.samples.len() as u64).max(1));
                (number, chunk)
            };
            let lanes = chunk.samples.len() as u64;
            mine.run(number, &chunk)?;
            let all = done.fetch_add(lanes.max(1), Ordering::Relaxed) + lanes;
            progress(all);
        }
        Ok(mine.sampled)
    };
    let threads = plan.threads.max(1);
    let alone = drivers.idle();
    let parts: Vec<Result<Sampled, Failure>> = if threads == 1 && alone {
        vec![work(None)]
    } else {
        std::thread::scope(|scope| {
            // Few may wait: memory stays what it is where a driver is slower than the evaluator.
            let (to, from) = sync_channel::<Batch>(threads);
            let work = &work;
            let spawn = |_| {
                let to = (!alone).then(|| to.clone());
                scope.spawn(move || work(to))
            };
            let handles: Vec<_> = (0..threads).map(spawn).collect();
            drop(to);
            from.iter().for_each(|batch| drivers.take(&batch));
            handles.into_iter().map(|h| h.join().expect("sampling does not panic")).collect()
        })
    };
    let mut all = Sampled::new();
    all.stopped = drivers.is_cut();
    for part in parts {
        let part = part?;
        all.stopped |= part.stopped;
        for ((_, sum), (_, more)) in all.families.iter_mut().zip(&part.families) {
            sum.merge(more);
        }
        for (which, tops) in part.tops.into_iter().enumerate() {
            for kept in tops {
                top(&mut all.tops[which], kept.severity, kept.at, || kept.sample);
            }
        }
        for (key, kept) in part.exemplars {
            keep(&mut all.exemplars, key, kept, usize::MAX);
        }
    }
    Ok(all)
}

/// Keeps a sample where there is none of its kind, or a less severe one; of new kinds no more than
/// `most`.
pub(super) fn keep(all: &mut Exemplars, key: (u32, Why), new: Kept, most: usize) {
    let room = all.len() < most;
    match all.get_mut(&key) {
        Some(known) => {
            let better = new.severity > known.severity
                || new.severity == known.severity && new.at < known.at;
            if better {
                *known = new;
            }
        }
        None if room => {
            all.insert(key, new);
        }
        None => {}
    }
}

/// How a call of many lanes runs.
pub(super) fn settings(plan: &Plan, watch: bool) -> Settings {
    Settings {
        precision: Precision::Both,
        watch,
        budget: plan.budget,
        deadline: plan.until.end(),
        threads: 1,
        ..Settings::default()
    }
}
