//! A function of a shader as the subject of a bench: what it is called with, and what the truth
//! of that is.
//!
//! Made of a [`Pure`]: arguments, inputs of the stage and members of blocks are what it is called
//! with, values like those of published scenes within the domain. Feeds the workloads of
//! [`called`](super::called).

use landfall_layout::diagnostic::Code;
use std::borrow::Cow;
use std::time::{Duration, Instant};

use serde_json::Value;

use super::errors::Results;
use crate::accuracy::inputs::{Inputs, columns, domain, matched, published};
use crate::accuracy::measure::floats;
use landfall_exec::harness::call::Refusal;
use landfall_exec::harness::call::pure::{Pure, PureCalled};
use landfall_exec::interp::{Precision, Settings};
use landfall_layout::Diagnostic;
use landfall_layout::source::Source;

/// What a function is called with.
#[derive(Clone, Debug)]
pub struct Sampling {
    /// What its inputs may be, in JSON; comments of the shader say it too.
    pub domain: Option<Value>,
    /// What random numbers start from.
    pub seed: u64,
    /// Calls of one run.
    pub calls: usize,
    /// Who is not done with a run by then has failed.
    pub limit: Duration,
}

impl Default for Sampling {
    fn default() -> Sampling {
        Sampling { domain: None, seed: 1, calls: 1 << 14, limit: Duration::from_secs(120) }
    }
}

/// Iterations of loops that one call may take.
const BUDGET: u32 = 1 << 16;

/// What functions are called with, and what the truth of that is.
#[derive(Clone, Debug)]
pub struct Calls {
    /// The words of each scalar, in the order of the function they were made for.
    columns: Vec<Vec<u64>>,
    lanes: usize,
    limit: Duration,
    /// What each call gives; none where that is not finite, or nothing.
    truth: Vec<Option<Results>>,
    /// What is sampled of that function.
    inputs: Inputs,
}

impl Calls {
    /// Samples of what a function and its variants read, and the `f64` of that function or another
    /// as the truth.
    ///
    /// # Errors
    /// A domain that is about something else, or leaves nothing; another function that takes
    /// something else; one that does not end.
    pub fn new(
        source: &Source,
        pure: &Pure,
        variants: &[&Pure],
        truth: &Pure,
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
                format!("the domain leaves {given} of {wanted} samples of a scene: widen it");
            return Err(failed(message));
        }
        let mut calls = Calls {
            columns: columns(&samples),
            lanes: samples.len(),
            limit: sampling.limit,
            truth: Vec::new(),
            inputs,
        };
        let given = calls.given(pure, truth).map_err(&failed)?;
        let called = truth
            .call(&given, calls.lanes, &calls.settings(Precision::Double))
            .map_err(|failure| failed(format!("`{}`: {}", truth.shown, failure.brief())))?;
        let kinds = Kinds::of(truth);
        let each = (0..calls.lanes).map(|lane| {
            let results = kinds.results(&called, lane, Precision::Double);
            let defined = !results.missing && results.floats.iter().all(|x| x.is_finite());
            defined.then_some(results)
        });
        calls.truth = each.collect();
        Ok(calls)
    }

    /// How many calls a run makes.
    pub fn count(&self) -> usize {
        self.lanes
    }

    /// The columns in another function's order, zeros for what it does not read: the same memory
    /// where that is the same, so that it makes no difference to anybody's time.
    pub(super) fn given(&self, first: &Pure, other: &Pure) -> Result<Cow<'_, [Vec<u64>]>, String> {
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

    /// What each call should give; none where that is undefined.
    pub(super) fn truth(&self) -> &[Option<Results>] {
        &self.truth
    }

    pub(super) fn limit(&self) -> Duration {
        self.limit
    }

    /// How the evaluator runs: on one thread, since time is counted.
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

/// Which scalars of a function's results are floats, and which whole numbers or truths.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Kinds {
    /// The number of the result, and of the scalar in it.
    pub floats: Vec<(usize, usize)>,
    pub wholes: Vec<(usize, usize)>,
}

impl Kinds {
    pub(super) fn of(pure: &Pure) -> Kinds {
        let floats = floats(pure);
        let results = pure.results.iter().enumerate();
        let all = results.flat_map(|(nth, r)| (0..r.ty.scalars().len()).map(move |at| (nth, at)));
        let wholes = all.filter(|place| !floats.contains(place)).collect();
        Kinds { floats, wholes }
    }

    /// What one lane gave.
    pub(super) fn results(
        &self,
        called: &PureCalled,
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
