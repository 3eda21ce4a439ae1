//! Statistics of samples, and the samples kept for examination.
//!
//! Filled by the interpreter's threads ([`worker`](super::worker)) and by the drivers
//! ([`verdict`](super::verdict)); read by [`find`](super::find) and by the report.

use rustc_hash::FxHashMap;
use serde::Serialize;

use super::generate::Family;
use super::input::Sample;
use super::measure::{Outcome, Spread};
use landfall_interp::UndefinedKind;

// The statistics of the samples of one family.
#[derive(Clone, Debug, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "TallyObject"))]
pub struct Tally {
    pub samples: u64,
    /// The samples that executed `discard`.
    pub discarded: u64,
    pub nan: u64,
    pub infinite: u64,
    /// The samples that did not end within the limit of iterations.
    pub endless: u64,
    /// The operations with an undefined result; counted in all samples of `coincidences` and
    /// `scenes`, or of `every`, and in no others.
    #[serde(rename = "undefined_operations")]
    pub undefined: u64,
    // The errors of finite results, as in `SampleError`.
    pub ulp: Spread,
    pub relative: Spread,
    pub steps: Spread,
}

impl Tally {
    pub(super) fn add(&mut self, outcome: Outcome) {
        self.samples += 1;
        match outcome {
            Outcome::Discarded => self.discarded += 1,
            Outcome::NotANumber => self.nan += 1,
            Outcome::Infinite => self.infinite += 1,
            Outcome::Finite(off, _) => {
                self.ulp.add(off.ulp);
                self.relative.add(off.relative);
                self.steps.add(off.steps);
            }
        }
    }

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

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum KeepReason {
    /// An undefined value of that kind at a byte of a file.
    Undefined(UndefinedKind, u32, u32),
    NotANumber,
    Infinite,
    Above,
    Below,
    /// The `f32` takes another branch than the `f64`, and the results differ.
    Diverged,
    Endless,
}

/// A sample kept for examination.
#[derive(Clone, Debug)]
pub(super) struct Kept<T = Sample> {
    pub sample: T,
    pub severity: f64,
    /// The chunk and the lane: ties go to the earlier one.
    pub at: (usize, usize),
}

/// Kept samples by how they were made and why they were kept.
pub(super) type Exemplars = FxHashMap<(u32, KeepReason), Kept>;

#[derive(Clone, Debug, Default)]
pub(super) struct SampledResults {
    pub families: Vec<(Family, Tally)>,
    pub exemplars: Exemplars,
    /// The worst finite samples: by units of the last place, and by steps.
    pub tops: [Vec<Kept>; 2],
    /// Whether a stop was requested, or time ran out.
    pub stopped: bool,
}

/// The worst finite samples kept.
const TOPS: usize = 3;

impl SampledResults {
    pub fn new() -> SampledResults {
        let families = Family::ALL.map(|family| (family, Tally::default())).to_vec();
        SampledResults { families, ..SampledResults::default() }
    }

    /// Returns the samples whose loops ran over the budget.
    pub fn endless(&self) -> Vec<Sample> {
        let all = self.exemplars.iter().filter(|((_, why), _)| *why == KeepReason::Endless);
        all.map(|(_, kept)| kept.sample.clone()).collect()
    }

    /// Returns the samples to climb from: 0 for units of the last place, 1 for steps.
    pub fn climb_starts(&self, which: usize) -> impl Iterator<Item = &Sample> {
        self.tops[which].iter().map(|kept| &kept.sample)
    }
}

/// Keeps a sample if it is one of the worst; ties go to the earlier one.
pub(super) fn top<T>(
    tops: &mut Vec<Kept<T>>,
    severity: f64,
    at: (usize, usize),
    sample: impl FnOnce() -> T,
) {
    // Greater severity first, then the earlier sample: the same for any number of threads.
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

/// Keeps a sample if there is none of its kind or only a less severe one; adds new kinds up to
/// `most`.
pub(super) fn keep_most_severe(
    all: &mut Exemplars,
    key: (u32, KeepReason),
    new: Kept,
    most: usize,
) {
    // New kinds only while there is room; known kinds may always get worse.
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
