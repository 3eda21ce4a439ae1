//! A function of a shader as the subject of a bench: its arguments and the expected results.
//!
//! Draws the parameters, stage inputs and block members of a [`PureFunction`] by the sampler of its
//! domain, and a part more at ends of their ranges. Used by the workloads of
//! [`called`](super::called).

use landfall_layout::diagnostic::Code;
use std::borrow::Cow;
use std::time::{Duration, Instant};

use serde_json::{Map, Value};

use super::errors::Results;
use super::report::SampledInputs;
use super::truth::{Evaluated, most_accurate};
use crate::inputs::sampler::Sampler;
use crate::inputs::{
    DistributedInput, Input, Inputs, Sample, columns, distributions, domain, matched,
};
use crate::measure::floats;
use landfall_exec::harness::call::Refusal;
use landfall_exec::harness::call::pure::{PureCallResult, PureFunction};
use landfall_interp::{Precision, Settings};
use landfall_layout::Diagnostic;
use landfall_layout::source::Source;

#[derive(Clone, Debug)]
pub struct Sampling {
    /// The domain of the inputs as JSON; comments of the shader add to it.
    pub domain: Option<Value>,
    pub seed: u64,
    /// The calls whose errors are measured; by default 2^20, fewer for long functions and for many
    /// inputs.
    pub samples: Option<usize>,
    /// The time limit of a run.
    pub limit: Duration,
}

impl Default for Sampling {
    fn default() -> Sampling {
        Sampling { domain: None, seed: 1, samples: None, limit: Duration::from_secs(120) }
    }
}

/// The most loop iterations in one call.
/// Enough for any lighting loop; a function without an end is an error of the bench, not a wait.
const BUDGET: u32 = 1 << 16;

/// The most calls of a timed run; those for which truths are compared.
/// The interpreter takes milliseconds for them, so a sample is several runs.
const TIMED: usize = 1 << 14;

/// The most calls whose errors are measured by default, and the scalar operations and the words of
/// arguments that these may have together: a bound of time and one of memory.
const SAMPLES: usize = 1 << 20;
const OPERATIONS: u64 = 1 << 26;
const WORDS: usize = 1 << 23;

/// The calls with inputs at ends of their ranges, as a part of the others.
const ENDS: usize = 16;

/// Calls and their expected results.
#[derive(Clone, Debug, Default)]
pub(super) struct CallSet {
    /// The words of each scalar, in the parameter order of the first function.
    pub columns: Vec<Vec<u64>>,
    pub lanes: usize,
    /// The expected results; `None` where not finite or missing.
    pub truth: Vec<Option<Results>>,
}

/// The arguments of calls and their expected results.
#[derive(Clone, Debug)]
pub struct Calls {
    /// Inputs as they are distributed.
    pub(super) drawn: CallSet,
    /// Inputs at ends of their ranges and special values.
    pub(super) ends: CallSet,
    /// The first of those drawn, on which times are measured.
    timed: Vec<Vec<u64>>,
    limit: Duration,
    inputs: Inputs,
    distributions: Vec<DistributedInput>,
    /// The number of the form whose `f64` results are expected.
    truth: usize,
}

impl Calls {
    /// Samples the inputs that a function and its variants read, the function first. The expected
    /// results are the `f64` results of the form with that number, or of the most accurate one.
    ///
    /// # Errors
    /// A domain that names other inputs or excludes every sample; a truth function with other
    /// parameters, or one that does not terminate.
    pub fn new(
        source: &Source,
        forms: &[&PureFunction],
        truth: Option<usize>,
        sampling: &Sampling,
    ) -> Result<Calls, Box<Refusal>> {
        let pure = forms[0];
        let refused =
            |found: Diagnostic| Box::new(Refusal { found: vec![found], files: pure.files.clone() });
        let failed = |message: String| refused(finding(message, &source.path));
        // The inputs of all forms together: a variant may read one that the first function does
        // not.
        let inputs = matched::shared(pure, &forms[1..]);
        let domain = domain(source, pure, &inputs, sampling.domain.as_ref()).map_err(&refused)?;
        let sampler = Sampler::new(&inputs, &domain);
        let drawn = |count: usize| {
            let samples = sampler.all_drawn(sampling.seed, count);
            // Rejection sampling gives up: the domain is too narrow to be hit.
            match samples.len() {
                drawn if drawn < count => Err(failed(format!(
                    "only {drawn} of {count} samples lie in the domain: widen the domain"
                ))),
                _ => Ok(CallSet::new(&samples, inputs.scalars)),
            }
        };
        // A few samples decide which form is the truth and how long a call is, and so how many
        // follow.
        let few = drawn(sampling.samples.unwrap_or(TIMED).min(TIMED))?;
        let mut calls = Calls {
            drawn: few.clone(),
            ends: CallSet::default(),
            timed: few.columns,
            limit: sampling.limit,
            distributions: distributions(&inputs, &domain),
            truth: 0,
            inputs: inputs.clone(),
        };
        let (chosen, operations) = calls.evaluated(forms);
        calls.truth = truth.unwrap_or(chosen);
        let count = sampling.samples.unwrap_or_else(|| {
            let most = (OPERATIONS / operations.max(1)) as usize;
            // The limit of operations first, then that of memory, but always those of a timed run.
            SAMPLES.min(most).min(WORDS / calls.inputs.scalars.max(1)).max(TIMED)
        });
        let ends = sampler.at_ends(sampling.seed, count.div_ceil(ENDS));
        let ends = CallSet::new(&ends, inputs.scalars);
        // The same seed: the few are the first of the many.
        let drawn = drawn(count)?;
        (calls.drawn, calls.ends) = (drawn, ends);
        calls.drawn.truth =
            calls.expected(pure, forms[calls.truth], &calls.drawn).map_err(&failed)?;
        calls.ends.truth =
            calls.expected(pure, forms[calls.truth], &calls.ends).map_err(&failed)?;
        Ok(calls)
    }

    /// Returns the number of the form with the most accurate `f64`, and the scalar operations of a
    /// call of the longest one.
    fn evaluated(&self, forms: &[&PureFunction]) -> (usize, u64) {
        let mut longest = 0;
        let evaluated = |form: &&PureFunction| {
            let kinds = Kinds::new(form);
            let given = self.columns_for(forms[0], form, &self.drawn).ok()?;
            let mut results = |precision| -> Option<Vec<Results>> {
                let settings = self.settings(precision);
                let called = form.call(&given, self.drawn.lanes, &settings).ok()?;
                let operations = called.called.notes.counts.operations();
                longest = longest.max(operations.div_ceil(self.drawn.lanes.max(1) as u64));
                let of = |lane| kinds.results(&called, lane, precision);
                Some((0..self.drawn.lanes).map(of).collect())
            };
            // A form that does not run in either precision is no candidate.
            let (single, double) = (results(Precision::Single)?, results(Precision::Double)?);
            Some(Evaluated { single, double })
        };
        let all: Vec<Option<Evaluated>> = forms.iter().map(evaluated).collect();
        (most_accurate(&all), longest)
    }

    /// Returns the results of a form in `f64`.
    fn expected(
        &self,
        first: &PureFunction,
        truth: &PureFunction,
        set: &CallSet,
    ) -> Result<Vec<Option<Results>>, String> {
        if set.lanes == 0 {
            return Ok(Vec::new());
        }
        let given = self.columns_for(first, truth, set)?;
        let called = truth
            .call(&given, set.lanes, &self.settings(Precision::Double))
            .map_err(|failure| format!("`{}`: {}", truth.shown, failure.summary()))?;
        let kinds = Kinds::new(truth);
        let each = (0..set.lanes).map(|lane| {
            let results = kinds.results(&called, lane, Precision::Double);
            // `f64` overflows and divides by zero as well: there is no truth at such inputs.
            let defined = !results.missing && results.floats.iter().all(|x| x.is_finite());
            defined.then_some(results)
        });
        Ok(each.collect())
    }

    /// Returns the number of calls of a timed run.
    pub fn count(&self) -> usize {
        self.drawn.lanes.min(TIMED)
    }

    /// Returns the number of the form whose `f64` results are expected.
    pub fn truth(&self) -> usize {
        self.truth
    }

    /// Returns the distributions of the inputs and the numbers of samples.
    pub fn sampled(&self) -> SampledInputs {
        SampledInputs {
            distributions: self.distributions.clone(),
            drawn: self.drawn.lanes as u64,
            ends: self.ends.lanes as u64,
        }
    }

    /// Returns the inputs of a call by path.
    pub(super) fn shown(&self, set: &CallSet, lane: usize) -> Map<String, Value> {
        let of = |input: &Input| -> Value {
            let number = |at: usize| -> Value {
                let x = input.number(set.columns[at][lane]);
                // The shortest digits of an `f32` are those of its own type.
                let digits =
                    if input.is_float() { format!("{:?}", x as f32) } else { x.to_string() };
                digits.parse::<f64>().map_or(Value::Null, Value::from)
            };
            match input.len {
                1 => number(input.first),
                _ => input.range().map(number).collect(),
            }
        };
        self.inputs.iter().map(|input| (input.path.clone(), of(input))).collect()
    }

    /// Returns the arguments of a timed run in the parameter order of another function. Where the
    /// order is the same it is the same memory, so that it does not affect times.
    pub(super) fn timed_for(
        &self,
        first: &PureFunction,
        other: &PureFunction,
    ) -> Result<Cow<'_, [Vec<u64>]>, String> {
        self.ordered(first, other, &self.timed, self.count())
    }

    /// Returns the columns of calls in the parameter order of another function, zeros for others.
    pub(super) fn columns_for<'c>(
        &self,
        first: &PureFunction,
        other: &PureFunction,
        set: &'c CallSet,
    ) -> Result<Cow<'c, [Vec<u64>]>, String> {
        self.ordered(first, other, &set.columns, set.lanes)
    }

    fn ordered<'c>(
        &self,
        first: &PureFunction,
        other: &PureFunction,
        columns: &'c [Vec<u64>],
        lanes: usize,
    ) -> Result<Cow<'c, [Vec<u64>]>, String> {
        let order = matched::matched(first, &self.inputs, other)?;
        let column = |at: Option<usize>| match at {
            Some(at) => columns[at].clone(),
            None => vec![0; lanes],
        };
        Ok(match order.iter().copied().eq((0..columns.len()).map(Some)) {
            true => Cow::Borrowed(columns),
            false => order.into_iter().map(column).collect(),
        })
    }

    pub(super) fn limit(&self) -> Duration {
        self.limit
    }

    /// Returns the interpreter's settings on all threads.
    pub(super) fn settings(&self, precision: Precision) -> Settings {
        Settings {
            precision,
            budget: BUDGET,
            deadline: Instant::now().checked_add(self.limit),
            threads: 0,
            ..Settings::default()
        }
    }
}

impl CallSet {
    fn new(samples: &[Sample], scalars: usize) -> CallSet {
        // Samples that there are none of have columns, too.
        let columns = if samples.is_empty() { vec![Vec::new(); scalars] } else { columns(samples) };
        CallSet { columns, lanes: samples.len(), truth: Vec::new() }
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
    pub(super) fn new(pure: &PureFunction) -> Kinds {
        let floats = floats(pure);
        let results = pure.results.iter().enumerate();
        let all = results.flat_map(|(nth, r)| (0..r.ty.scalars().len()).map(move |at| (nth, at)));
        let wholes = all.filter(|place| !floats.contains(place)).collect();
        Kinds { floats, wholes }
    }

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
