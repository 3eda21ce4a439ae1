//! The parameters of a run, the settings of its calls, and what each step of the search works on.

pub(super) use super::super::inputs::{columns, neighbours};
use super::deadline::Deadline;
use super::domain::Domain;
use super::generate::Generator;
use super::input::{Inputs, Sample};
use super::measure::SampleError;
use super::shrink;
use landfall_exec::harness::call::pure::PureFunction;
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

/// The function that is searched, what makes its samples, and the limits.
#[derive(Clone, Copy)]
pub(super) struct SampleSearch<'a> {
    pub pure: &'a PureFunction,
    pub generator: &'a Generator<'a>,
    pub plan: &'a Plan,
}

impl<'a> SampleSearch<'a> {
    pub fn inputs(&self) -> &'a Inputs {
        self.generator.inputs
    }

    pub fn domain(&self) -> &'a Domain {
        self.generator.domain
    }

    /// Whether a sample has values that occur in scenes.
    pub fn is_plausible(&self, sample: &Sample) -> bool {
        shrink::plausible(self.inputs(), self.domain(), sample)
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
