//! A function over the calls of a bench on the interpreter, as a workload.
//!
//! Takes [`Calls`]; the time subtracted is that of an empty function with the same parameters and
//! results.

use std::borrow::Cow;
use std::hint::black_box;
use std::time::Duration;

use super::clock::Elapsed;
use super::errors::{Errors, Results};
use super::function::{CallSet, Calls, Kinds};
use super::kernel::kernel;
use super::report::{ErrorMeasure, Permitted, SampleSet, Work, WorstCall};
use super::rounds::{Part, Workload};
use crate::permitted::farthest;
use landfall_exec::harness::call::pure::PureFunction;
use landfall_interp::{Floats, Precision, Settings};
use landfall_layout::format::phrases::counted;

/// The errors of a function's results on a backend.
#[derive(Clone, Debug, PartialEq)]
pub struct CallErrors {
    /// Of inputs as they are distributed.
    pub drawn: Errors,
    /// Of inputs at ends of their ranges and special values, where ranges are stated.
    pub ends: Option<Errors>,
    pub worst: Vec<WorstCall>,
}

/// A function and its arguments, for any backend.
#[derive(Debug)]
pub struct Variant<'a> {
    calls: &'a Calls,
    pure: &'a PureFunction,
    kinds: Kinds,
    /// The arguments of a timed run.
    timed: Cow<'a, [Vec<u64>]>,
    /// Those drawn, and those at ends of the inputs' ranges.
    drawn: Cow<'a, [Vec<u64>]>,
    ends: Cow<'a, [Vec<u64>]>,
    /// The empty function whose time is subtracted.
    trivial: Option<PureFunction>,
}

impl<'a> Variant<'a> {
    /// A function called with the arguments of a bench's first function.
    ///
    /// # Errors
    /// Parameters or results that differ from those of the first function.
    pub fn new(
        calls: &'a Calls,
        first: &PureFunction,
        pure: &'a PureFunction,
    ) -> Result<Variant<'a>, String> {
        let timed = calls.timed_for(first, pure)?;
        // A form may have its parameters in another order, or lack some: columns are matched by
        // path.
        let drawn = calls.columns_for(first, pure, &calls.drawn)?;
        let ends = calls.columns_for(first, pure, &calls.ends)?;
        let kinds = Kinds::new(pure);
        // Results are compared by position, so their numbers and kinds must agree; their names
        // need not.
        if let Some(truth) = calls.drawn.truth.iter().flatten().next() {
            let given = [kinds.floats.len(), kinds.wholes.len()];
            let wanted = [truth.floats.len(), truth.wholes.len()];
            if given != wanted {
                let numbers = |[floats, wholes]: [usize; 2]| match wholes {
                    0 => counted(floats, "float"),
                    wholes => {
                        format!("{} and {}", counted(floats, "float"), counted(wholes, "integer"))
                    }
                };
                let message = format!(
                    "`{}` returns {}, but the reference function {}",
                    pure.shown,
                    numbers(given),
                    numbers(wanted)
                );
                return Err(message);
            }
        }
        Ok(Variant { calls, pure, kinds, timed, drawn, ends, trivial: kernel(pure) })
    }

    pub(super) fn pure(&self) -> &'a PureFunction {
        self.pure
    }

    pub(super) fn trivial(&self) -> Option<&PureFunction> {
        self.trivial.as_ref()
    }

    pub(super) fn kinds(&self) -> &Kinds {
        &self.kinds
    }

    /// Returns the words of each scalar, the calls of a timed run and the time limit of a job.
    pub(super) fn call_inputs(&self) -> (&[Vec<u64>], usize, Duration) {
        (&self.timed, self.calls.count(), self.calls.limit())
    }

    /// Returns the errors of a backend, which gives the results of calls with some arguments.
    ///
    /// # Errors
    /// Those of the backend.
    pub(super) fn judged<R: Fn(usize) -> Results>(
        &self,
        mut call: impl FnMut(&[Vec<u64>], usize) -> Result<R, String>,
    ) -> Result<CallErrors, String> {
        let mut worst = Vec::new();
        let mut errors = |of, set: &CallSet, columns: &[Vec<u64>]| -> Result<Errors, String> {
            let results = call(columns, set.lanes)?;
            let each = set.truth.iter().enumerate();
            let each = each.map(|(lane, truth)| (results(lane), truth.as_ref()));
            let (errors, at) = Errors::of_calls(each);
            // The inputs at the largest errors are shown to the user, by either measure.
            let largest = [
                (ErrorMeasure::Ulp, errors.max_ulp, at[0]),
                (ErrorMeasure::Steps, errors.max_steps, at[1]),
            ];
            for (measure, error, at) in largest {
                let (Some(error), Some(at)) = (error, at) else { continue };
                worst.push(WorstCall { of, measure, error, inputs: self.calls.shown(set, at) });
            }
            Ok(errors)
        };
        let Calls { drawn, ends, .. } = self.calls;
        let errors = CallErrors {
            drawn: errors(SampleSet::Drawn, drawn, &self.drawn)?,
            ends: match ends.lanes {
                0 => None,
                _ => Some(errors(SampleSet::Ends, ends, &self.ends)?),
            },
            worst: Vec::new(),
        };
        Ok(CallErrors { worst, ..errors })
    }

    /// Returns the errors of the interpreter's results against the truth, and its work.
    ///
    /// # Errors
    /// A call that does not terminate, or code that the interpreter does not support.
    pub fn measure_errors(&self) -> Result<(CallErrors, Work), String> {
        let Variant { calls, pure, kinds, .. } = self;
        let mut operations = None;
        let errors = self.judged(|columns, lanes| {
            // Errors are those of `f32`; the truth was computed before, in `f64`.
            let settings = calls.settings(Precision::Single);
            let called =
                pure.call(columns, lanes, &settings).map_err(|failure| failure.summary())?;
            // Operations are counted over all calls: the mean of a function with branches.
            let all = called.called.notes.counts.operations() as f64;
            operations.get_or_insert(all / lanes.max(1) as f64);
            Ok(move |lane| kinds.results(&called, lane, Precision::Single))
        })?;
        let work = Work { operations, bytes: Some(self.bytes()), ..Work::default() };
        Ok((errors, work))
    }

    /// Returns the bytes of the arguments of all calls of a run.
    fn bytes(&self) -> u64 {
        let scalars = self.pure.parameters.iter().flat_map(|parameter| parameter.ty.scalars());
        // Uploads hold booleans and half floats in a word each.
        let each: u64 = scalars.map(|scalar| u64::from(scalar.width.max(4))).sum();
        each * self.calls.count() as u64
    }

    /// Returns the largest error of any conformant device; `None` where that is unknown, as for
    /// floats rounded to less than `f32`.
    pub fn permitted(&self, floats: Floats) -> Option<Permitted> {
        match floats {
            Floats::AsWritten => {}
            Floats::Half | Floats::Mediump => return None,
        }
        let Variant { calls, pure, kinds, drawn, .. } = self;
        let settings = calls.settings(Precision::Permitted);
        let CallSet { lanes, truth, .. } = &calls.drawn;
        let called = pure.call(drawn, *lanes, &settings).ok()?;
        // The bound is taken around each sample's own truth, where that is defined.
        let (mut steps, mut unsure) = (Vec::with_capacity(*lanes), 0);
        for (lane, truth) in truth.iter().enumerate() {
            let Some(truth) = truth else { continue };
            let most = farthest(&called, &kinds.floats, lane, &truth.floats)?;
            unsure += u64::from(most.unsure);
            steps.push(most.steps);
        }
        (!steps.is_empty()).then(|| Permitted::new(&mut steps, unsure))
    }
}

#[derive(Debug)]
pub struct InterpreterVariant<'a> {
    variant: &'a Variant<'a>,
}

impl<'a> InterpreterVariant<'a> {
    pub fn new(variant: &'a Variant<'a>) -> InterpreterVariant<'a> {
        InterpreterVariant { variant }
    }
}

impl Workload for InterpreterVariant<'_> {
    fn has(&self, part: Part) -> bool {
        match part {
            Part::Whole => true,
            Part::Unlit => false,
            Part::Trivial => self.variant.trivial.is_some(),
        }
    }

    fn run(&mut self, part: Part) -> Result<Option<Elapsed>, String> {
        let Variant { calls, pure, timed, trivial, .. } = self.variant;
        let pure = match (part, trivial) {
            (Part::Whole, _) => *pure,
            (Part::Trivial, Some(trivial)) => trivial,
            (Part::Trivial, None) | (Part::Unlit, _) => {
                return Err("internal error: the samples of this run were not prepared".to_string());
            }
        };
        // One thread, since time is measured.
        let settings = Settings { threads: 1, ..calls.settings(Precision::Single) };
        // `black_box` keeps the optimiser from moving work out of the measured call.
        let called = pure.call(black_box(timed), calls.count(), &settings);
        black_box(called.map_err(|failure| failure.summary())?);
        // No time of its own: the clock of this process counts.
        Ok(None)
    }
}
