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
            let odd = odd.max_by_key(|(at, x)| (x.is_nan(), 4 - at));
            causes.push(odd.and_then(|(at, x)| {
                let number = Number { single: *x, double: f64::from(*x) };
                let cause = names.cause(trace, Operand { number, source: *trace.results.get(at)? });
                Some(FragmentCause { is_nan: x.is_nan(), cause })
            }));
            true
        })?;
        Ok(causes)
    }

    /// Adds the members of blocks that led to undefined operations, where a fragment of a batch meets
    /// them and none are known: one list for each operation.
    ///
    /// # Errors
    /// As [`FragmentShader::run`].
    pub fn add_origins(
        &self,
        batch: &Batch<'_>,
        undefined: &[Undefined],
        origins: &mut [Vec<ReadValue>],
    ) -> Result<(), Failure> {
        self.traced(batch, |names, trace, _| {
            let unknown = origins.iter_mut().zip(undefined).filter(|(from, _)| from.is_empty());
            for (from, seen) in unknown {
                *from = names.led_to(trace, seen.kind, &seen.place);
            }
            origins.iter().any(Vec::is_empty)
        })
    }

    /// Runs the fragments of a batch one by one, with a trace of each, until `each` returns false.
    fn traced(
        &self,
        batch: &Batch<'_>,
        mut each: impl FnMut(&Names<'_>, &Trace, [f32; 4]) -> bool,
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
            if !each(&names, &trace, color.map(f32::from_bits)) {
                break;
            }
        }
        Ok(())
    }
}
