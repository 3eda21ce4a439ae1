//! What made fragments NaN or infinite, from runs of single fragments that record every operation.

use super::batch::{Batch, Jobs};
use super::{FragmentShader, Image};
use crate::backend::{Backend, Failure};
use crate::harness::origins::{Cause, Names};
use crate::interp::{Cpu, Number, Operand, Precision, Settings};

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
        let mut causes = Vec::with_capacity(batch.count);
        for fragment in 0..batch.count {
            let image: Image = self.pack(batch, fragment, 1, 1);
            jobs.put(self, image);
            let color = cpu.run(jobs.shading())?.pixels.first().copied().unwrap_or_default();
            let program = cpu.program(&jobs.shading().stages[0])?;
            let names = Names {
                program: &program,
                module: &self.module,
                language: self.language,
                parameters: Vec::new(),
            };
            let color = color.map(f32::from_bits);
            let odd = |(_, x): &(usize, &f32)| !x.is_finite();
            let odd =
                color.iter().enumerate().filter(odd).max_by_key(|(at, x)| (x.is_nan(), 4 - at));
            let cause = odd.zip(cpu.notes.trace.as_ref()).and_then(|((at, x), trace)| {
                let number = Number { single: *x, double: f64::from(*x) };
                let source = *trace.results.get(at)?;
                let cause = names.cause(trace, Operand { number, source });
                Some(FragmentCause { is_nan: x.is_nan(), cause })
            });
            causes.push(cause);
        }
        Ok(causes)
    }
}
