//! What made fragments NaN, infinite or undefined, from runs of single fragments that record every
//! operation.

use super::FragmentShader;
use super::batch::{Batch, Jobs};
use crate::backend::{Backend, Failure};
use crate::harness::origins::{Cause, Names, ReadValue};
use landfall_interp::{Cpu, Number, Operand, Precision, Settings, Trace, Undefined};

/// What made a fragment NaN or infinite.
#[derive(Clone, Debug, PartialEq)]
pub struct FragmentCause {
    /// Whether a channel is NaN; infinite otherwise.
    pub is_nan: bool,
    /// The cause of the first such channel.
    pub cause: Cause,
}

/// An undefined operation that a fragment meets.
#[derive(Clone, Debug, PartialEq)]
pub struct UndefinedInFragment {
    /// The fragment of the batch.
    pub fragment: usize,
    /// The operation, by its number among those asked for.
    pub operation: usize,
    /// The members of blocks that led there.
    pub from: Vec<ReadValue>,
}

impl FragmentShader {
    /// Returns what made each fragment of a batch NaN or infinite on the interpreter; `None` for one
    /// that is finite there. Members of blocks are named, inputs are not.
    ///
    /// # Errors
    /// As [`FragmentShader::run`].
    pub fn causes(&self, batch: &Batch<'_>) -> Result<Vec<Option<FragmentCause>>, Failure> {
        let mut causes = Vec::with_capacity(batch.count);
        self.traced(batch, |names, trace, color| {
            let odd = color.iter().enumerate().filter(|(_, x)| !x.is_finite());
            // A NaN is explained rather than an infinity, and the first channel rather than others.
            let odd = odd.max_by_key(|(at, x)| (x.is_nan(), 4 - at));
            causes.push(odd.and_then(|(at, x)| {
                let number = Number { single: *x, double: f64::from(*x) };
                let cause = names.cause(trace, Operand { number, source: *trace.results.get(at)? });
                Some(FragmentCause { is_nan: x.is_nan(), cause })
            }));
        })?;
        Ok(causes)
    }

    /// Returns where the fragments of a batch meet undefined operations.
    ///
    /// # Errors
    /// As [`FragmentShader::run`].
    pub fn undefined(
        &self,
        batch: &Batch<'_>,
        undefined: &[Undefined],
    ) -> Result<Vec<UndefinedInFragment>, Failure> {
        let (mut found, mut fragment) = (Vec::new(), 0);
        self.traced(batch, |names, trace, _| {
            let each = undefined.iter().enumerate();
            found.extend(each.filter_map(|(operation, seen)| {
                let from = names.led_to(trace, seen.kind, &seen.place)?;
                Some(UndefinedInFragment { fragment, operation, from })
            }));
            fragment += 1;
        })?;
        Ok(found)
    }

    /// Runs the fragments of a batch one by one, with a trace of each.
    fn traced(
        &self,
        batch: &Batch<'_>,
        mut each: impl FnMut(&Names<'_>, &Trace, [f32; 4]),
    ) -> Result<(), Failure> {
        self.fits(batch)?;
        let settings = Settings {
            precision: Precision::Both,
            watch: true,
            trace: true,
            threads: 1,
            ..Settings::default()
        };
        let mut cpu = Cpu::new(settings);
        let mut jobs = Jobs::new(self, false, self.for_module(batch), batch.limit)?;
        for fragment in 0..batch.count {
            jobs.put(self, self.pack(batch, fragment, 1, 1));
            let color = cpu.run(jobs.shading())?.pixels.first().copied().unwrap_or_default();
            let trace = cpu.notes.trace.take().unwrap_or_default();
            let program = cpu.program(&jobs.shading().stages[0])?;
            let names = Names {
                program: &program,
                module: &self.module,
                language: self.language,
                parameters: Vec::new(),
            };
            each(&names, &trace, color.map(f32::from_bits));
        }
        Ok(())
    }
}
