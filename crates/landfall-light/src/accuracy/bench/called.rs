//! A function over the calls of a bench on the interpreter, as a workload.
//!
//! Takes [`Calls`]; the time subtracted is that of an empty function with the same parameters and
//! results.

use std::borrow::Cow;
use std::hint::black_box;
use std::time::Duration;

use super::clock::Elapsed;
use super::errors::{Errors, Results};
use super::function::{Calls, Kinds};
use super::kernel::kernel;
use super::report::{Permitted, Work};
use super::rounds::{Part, Workload};
use crate::accuracy::permitted::farthest;
use landfall_exec::harness::call::pure::PureFunction;
use landfall_exec::interp::{Floats, Precision, Settings};
use landfall_layout::format::phrases::counted;

/// A function and its arguments, for any backend.
#[derive(Debug)]
pub struct Variant<'a> {
    calls: &'a Calls,
    pure: &'a PureFunction,
    kinds: Kinds,
    columns: Cow<'a, [Vec<u64>]>,
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
        let columns = calls.columns_for(first, pure)?;
        let kinds = Kinds::of(pure);
        if let Some(truth) = calls.truth().iter().flatten().next() {
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
        Ok(Variant { calls, pure, kinds, columns, trivial: kernel(pure) })
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

    /// Returns the expected result of each call; `None` where it is undefined.
    pub(super) fn truth(&self) -> &'a [Option<Results>] {
        self.calls.truth()
    }

    /// Returns the words of each scalar, the calls of a run and the time limit of a job.
    pub(super) fn call_inputs(&self) -> (&[Vec<u64>], usize, Duration) {
        (&self.columns, self.calls.count(), self.calls.limit())
    }

    /// Returns the errors of the interpreter's results against the truth, and its work.
    ///
    /// # Errors
    /// A call that does not terminate, or code that the interpreter does not support.
    pub fn measure_errors(&self) -> Result<(Errors, Work), String> {
        let Variant { calls, pure, kinds, columns, .. } = self;
        let settings = calls.settings(Precision::Single);
        let called =
            pure.call(columns, calls.count(), &settings).map_err(|failure| failure.summary())?;
        let each =
            calls.truth().iter().enumerate().map(|(lane, truth)| {
                (kinds.results(&called, lane, Precision::Single), truth.clone())
            });
        let operations = called.called.notes.counts.operations() as f64;
        let work = Work {
            operations: Some(operations / calls.count().max(1) as f64),
            bytes: Some(self.bytes()),
            ..Work::default()
        };
        Ok((Errors::of_calls(each), work))
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
        let Variant { calls, pure, kinds, columns, .. } = self;
        // Calls are independent and time is not measured: use all threads.
        let settings = Settings { threads: 0, ..calls.settings(Precision::Permitted) };
        let called = pure.call(columns, calls.count(), &settings).ok()?;
        let (mut steps, mut unsure) = (Vec::with_capacity(calls.count()), 0);
        for (lane, truth) in calls.truth().iter().enumerate() {
            let Some(truth) = truth else { continue };
            let most = farthest(&called, &kinds.floats, lane, &truth.floats)?;
            unsure += u64::from(most.unsure);
            steps.push(most.steps);
        }
        (!steps.is_empty()).then(|| Permitted::of(&mut steps, unsure))
    }
}

/// A variant on the interpreter.
#[derive(Debug)]
pub struct InterpreterVariant<'a> {
    variant: &'a Variant<'a>,
}

impl<'a> InterpreterVariant<'a> {
    /// A variant as a workload.
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
        let Variant { calls, pure, columns, trivial, .. } = self.variant;
        let pure = match (part, trivial) {
            (Part::Whole, _) => *pure,
            (Part::Trivial, Some(trivial)) => trivial,
            (Part::Trivial, None) | (Part::Unlit, _) => {
                return Err("internal error: the samples of this run were not prepared".to_string());
            }
        };
        let settings = calls.settings(Precision::Single);
        let called = pure.call(black_box(columns), calls.count(), &settings);
        black_box(called.map_err(|failure| failure.summary())?);
        Ok(None)
    }
}
