//! The parameters of a run, and the settings of its calls.

pub(super) use super::super::inputs::columns;
use super::deadline::Deadline;
use super::measure::SampleError;
use landfall_interp::{Precision, Settings};

#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub samples: u64,
    pub until: Deadline,
    pub threads: usize,
    /// The error limits beyond which a sample is kept.
    pub steps: f64,
    pub ulp: f64,
    /// The error in steps below which no number of units of the last place is a finding: those
    /// of a result near zero are many.
    pub least_steps: f64,
    pub budget: u32,
}

impl Plan {
    /// Whether an error is beyond the limits.
    pub fn is_large(&self, off: &SampleError) -> bool {
        off.steps > self.steps || off.ulp > self.ulp && off.steps >= self.least_steps
    }
}

/// Returns the settings of a call with many lanes.
pub(super) fn settings(plan: &Plan, watch: bool) -> Settings {
    Settings {
        precision: Precision::Both,
        watch,
        // The interpreter reads the clock itself, so a call with many lanes ends in time.
        budget: plan.budget,
        deadline: plan.until.end(),
        stop: plan.until.flag(),
        threads: 1,
        ..Settings::default()
    }
}
