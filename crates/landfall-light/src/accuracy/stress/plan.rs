//! The parameters of a run, and the settings of its calls.

pub(super) use super::super::inputs::columns;
use super::deadline::Deadline;
use landfall_exec::interp::{Precision, Settings};

/// The parameters of a run.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub samples: u64,
    pub until: Deadline,
    pub threads: usize,
    /// The error limits beyond which a sample is kept.
    pub steps: f64,
    pub ulp: f64,
    pub budget: u32,
}

/// Returns the settings of a call with many lanes.
pub(super) fn settings(plan: &Plan, watch: bool) -> Settings {
    Settings {
        precision: Precision::Both,
        watch,
        budget: plan.budget,
        deadline: plan.until.end(),
        stop: plan.until.flag(),
        threads: 1,
        ..Settings::default()
    }
}
