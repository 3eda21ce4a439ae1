//! Batches of samples with the interpreter's results, for the drivers to repeat.

use super::input::Sample;
use super::measure::Outcome;
use landfall_exec::harness::call::pure::PureCallResult;

/// Samples and their results on the interpreter.
#[derive(Clone, Debug, Default)]
pub(super) struct SampleBatch {
    /// The words of each scalar, by sample.
    pub columns: Vec<Vec<u64>>,
    /// The `f64` of each float of the results, by sample.
    pub doubles: Vec<Vec<f64>>,
    pub outcomes: Vec<Outcome>,
    /// Whether the inputs are not finite: such samples do not count.
    pub special: bool,
    /// The chunk, and the lane of the first sample.
    pub at: (usize, usize),
}

impl SampleBatch {
    /// Makes a batch of the interpreter's results.
    pub fn new(
        columns: Vec<Vec<u64>>,
        called: PureCallResult,
        floats: &[(usize, usize)],
        outcomes: Vec<Outcome>,
    ) -> SampleBatch {
        let mut results = called.results;
        let take = |&(nth, at): &(usize, usize)| std::mem::take(&mut results[nth].doubles[at]);
        let doubles = floats.iter().map(take).collect();
        SampleBatch { columns, doubles, outcomes, ..SampleBatch::default() }
    }

    pub fn drop_first(&mut self) {
        self.columns.iter_mut().for_each(|column| drop(column.drain(..1)));
        self.doubles.iter_mut().for_each(|column| drop(column.drain(..1)));
        self.outcomes.drain(..1);
    }

    pub fn sample(&self, lane: usize) -> Sample {
        self.columns.iter().map(|column| column[lane]).collect()
    }

    pub fn append(&mut self, more: SampleBatch) {
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
