//! A function of a shader as the subject of a bench: its arguments and the expected results.
//!
//! Samples the parameters, stage inputs and block members of a [`PureFunction`] with values like
//! those of published scenes within the domain. Used by the workloads of [`called`](super::called).

use landfall_layout::diagnostic::Code;
use std::borrow::Cow;
use std::time::{Duration, Instant};

use serde_json::Value;

use super::errors::Results;
use crate::accuracy::inputs::{Inputs, columns, domain, matched, published};
use crate::accuracy::measure::floats;
use landfall_exec::harness::call::Refusal;
use landfall_exec::harness::call::pure::{PureCallResult, PureFunction};
use landfall_exec::interp::{Precision, Settings};
use landfall_layout::Diagnostic;
use landfall_layout::source::Source;

/// The options of sampling the arguments of a function.
#[derive(Clone, Debug)]
pub struct Sampling {
    /// The domain of the inputs as JSON; comments of the shader add to it.
    pub domain: Option<Value>,
    /// The seed of the random numbers.
    pub seed: u64,
    /// The calls of one run.
    pub calls: usize,
    /// The time limit of a run.
    pub limit: Duration,
}

impl Default for Sampling {
    fn default() -> Sampling {
        Sampling { domain: None, seed: 1, calls: 1 << 14, limit: Duration::from_secs(120) }
    }
}

/// The most loop iterations in one call.
const BUDGET: u32 = 1 << 16;

/// The arguments of calls and their expected results.
#[derive(Clone, Debug)]
pub struct Calls {
    /// The words of each scalar, in the parameter order of the first function.
    columns: Vec<Vec<u64>>,
    lanes: usize,
    limit: Duration,
    /// The expected results; `None` where not finite or missing.
    truth: Vec<Option<Results>>,
    /// The sampled inputs of the first function.
    inputs: Inputs,
}

impl Calls {
    /// Samples the inputs that a function and its variants read; the `f64` results of that
    /// function, or of another one, are the truth.
    ///
    /// # Errors
    /// A domain that names other inputs or excludes every sample; a truth function with other
    /// parameters, or one that does not terminate.
    pub fn new(
        source: &Source,
        pure: &PureFunction,
        variants: &[&PureFunction],
        truth: &PureFunction,
        sampling: &Sampling,
    ) -> Result<Calls, Box<Refusal>> {
        let refused =
            |found: Diagnostic| Box::new(Refusal { found: vec![found], files: pure.files.clone() });
        let failed = |message: String| refused(finding(message, &source.path));
        let inputs = matched::shared(pure, &[variants, &[truth]].concat());
        let domain = domain(source, pure, &inputs, sampling.domain.as_ref()).map_err(&refused)?;
        let samples = published(&inputs, &domain, sampling.seed, sampling.calls);
        if samples.len() < sampling.calls {
            let (given, wanted) = (samples.len(), sampling.calls);
            let message =
                format!("only {given} of {wanted} samples lie in the domain: widen the domain");
            return Err(failed(message));
        }
        let mut calls = Calls {
            columns: columns(&samples),
            lanes: samples.len(),
            limit: sampling.limit,
            truth: Vec::new(),
            inputs,
        };
        let given = calls.columns_for(pure, truth).map_err(&failed)?;
        let called = truth
            .call(&given, calls.lanes, &calls.settings(Precision::Double))
            .map_err(|failure| failed(format!("`{}`: {}", truth.shown, failure.summary())))?;
        let kinds = Kinds::of(truth);
        let each = (0..calls.lanes).map(|lane| {
            let results = kinds.results(&called, lane, Precision::Double);
            let defined = !results.missing && results.floats.iter().all(|x| x.is_finite());
            defined.then_some(results)
        });
        calls.truth = each.collect();
        Ok(calls)
    }

    /// Returns the number of calls of a run.
    pub fn count(&self) -> usize {
        self.lanes
    }

    /// Returns the columns in the parameter order of another function, zeros for others. Where the
    /// order is the same it is the same memory, so that it does not affect times.
    pub(super) fn columns_for(
        &self,
        first: &PureFunction,
        other: &PureFunction,
    ) -> Result<Cow<'_, [Vec<u64>]>, String> {
        let order = matched::matched(first, &self.inputs, other)?;
        let column = |at: Option<usize>| match at {
            Some(at) => self.columns[at].clone(),
            None => vec![0; self.lanes],
        };
        Ok(match order.iter().copied().eq((0..self.columns.len()).map(Some)) {
            true => Cow::Borrowed(&self.columns),
            false => order.into_iter().map(column).collect(),
        })
    }

    /// Returns the expected result of each call; `None` where it is undefined.
    pub(super) fn truth(&self) -> &[Option<Results>] {
        &self.truth
    }

    pub(super) fn limit(&self) -> Duration {
        self.limit
    }

    /// Returns the interpreter's settings: one thread, since time is measured.
    pub(super) fn settings(&self, precision: Precision) -> Settings {
        Settings {
            precision,
            budget: BUDGET,
            deadline: Instant::now().checked_add(self.limit),
            threads: 1,
            ..Settings::default()
        }
    }
}

/// The scalars of a function's results by kind: floats, or integers and booleans.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Kinds {
    /// The index of the result and of the scalar in it.
    pub floats: Vec<(usize, usize)>,
    pub wholes: Vec<(usize, usize)>,
}

impl Kinds {
    pub(super) fn of(pure: &PureFunction) -> Kinds {
        let floats = floats(pure);
        let results = pure.results.iter().enumerate();
        let all = results.flat_map(|(nth, r)| (0..r.ty.scalars().len()).map(move |at| (nth, at)));
        let wholes = all.filter(|place| !floats.contains(place)).collect();
        Kinds { floats, wholes }
    }

    /// Returns the results of one lane.
    pub(super) fn results(
        &self,
        called: &PureCallResult,
        lane: usize,
        precision: Precision,
    ) -> Results {
        let float = |&(nth, at): &(usize, usize)| {
            let numbers = &called.results[nth];
            match precision {
                Precision::Double => numbers.doubles[at][lane],
                Precision::Single | Precision::Both | Precision::Permitted => {
                    f64::from(f32::from_bits(numbers.words[at][lane] as u32))
                }
            }
        };
        Results {
            floats: self.floats.iter().map(float).collect(),
            wholes: self.wholes.iter().map(|&(n, at)| called.results[n].words[at][lane]).collect(),
            missing: called.called.discarded.get(lane) == Some(&true),
        }
    }
}

fn finding(message: String, about: &str) -> Diagnostic {
    Diagnostic::about(Code::CannotBench, message, None, about)
}
