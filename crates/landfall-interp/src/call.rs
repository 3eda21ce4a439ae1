//! Calls one function with the arguments of many invocations.
//!
//! Used by `stress` and `landfall run --fn`; runs on [`drive`](super::drive).

use super::code::LANES;
use super::numbers::{Numbers, Words};
use super::permitted::Permitted;
use super::program::{FunctionCode, Program};
use super::real::Real;
use super::shadow::Shadow;
use super::stage::{Notes, Precision, Settings, bits, failure, mask, refused_for, set_register};
use crate::backend::{Failure, FailureKind, Resource};

/// A call of a function.
#[derive(Clone, Debug, Default)]
pub struct Call<'a> {
    pub function: &'a str,
    /// The number of invocations.
    pub lanes: usize,
    /// The words of each parameter; may be empty for an `out` parameter.
    pub arguments: Vec<Words>,
    /// The buffers and textures it reads.
    pub resources: &'a [Resource],
}

#[derive(Clone, Debug, Default)]
pub struct Called {
    pub result: Numbers,
    /// By parameter: its value after the call if it is a pointer, `out` or `inout`.
    pub returned: Vec<Option<Numbers>>,
    /// The invocations that executed a `discard`.
    pub discarded: Vec<bool>,
    /// With [`Precision::Permitted`]: the invocations in which a comparison, or an integer
    /// converted from a float, may differ on another device.
    pub unsure: Vec<bool>,
    /// By resource: the contents of a writable buffer after the call.
    pub buffers: Vec<Option<Vec<u8>>>,
    pub notes: Notes,
}

impl Program {
    /// Calls a function.
    ///
    /// # Errors
    /// Fails if the function does not exist, the arguments do not fit its parameters, it uses
    /// unsupported features, or it does not end.
    pub fn call(&self, call: &Call, settings: &Settings) -> Result<Called, Failure> {
        match settings.precision {
            Precision::Single => self.call_in::<f32>(call, settings),
            Precision::Double => self.call_in::<f64>(call, settings),
            Precision::Both => self.call_in::<Shadow>(call, settings),
            Precision::Permitted => {
                self.knows_permitted()?;
                self.call_in::<Permitted>(call, settings)
            }
        }
    }

    fn call_in<R: Real>(&self, call: &Call, settings: &Settings) -> Result<Called, Failure> {
        let refuse = |message: String| Err(failure(FailureKind::Refused, message));
        let named = |f: &&FunctionCode| f.name == call.function && f.interface.is_none();
        // Functions may be overloaded by their parameters.
        let fits = |f: &FunctionCode| {
            f.arguments.len() == call.arguments.len()
                && f.arguments.iter().zip(&call.arguments).all(|(argument, words)| {
                    words.len() == argument.regs.len() || words.is_empty() && argument.pointer
                })
        };
        let found = self.functions.iter().position(|f| named(&f) && fits(f));
        // If none fits, one of that name, so that the message tells what it takes.
        let found = found.or_else(|| self.functions.iter().position(|f| named(&f)));
        let Some(number) = found else {
            return refuse(format!("there is no function `{}`", call.function));
        };
        let code = &self.functions[number];
        if let Err(why) = &code.state {
            return Err(refused_for(why));
        }
        if call.arguments.len() != code.arguments.len() {
            let (has, given) = (code.arguments.len(), call.arguments.len());
            let name = call.function;
            return refuse(format!("`{name}` takes {has} arguments; {given} are given"));
        }
        for (argument, words) in code.arguments.iter().zip(&call.arguments) {
            let fits = words.len() == argument.regs.len()
                && words.iter().all(|lanes| lanes.len() == call.lanes);
            if !(fits || words.is_empty() && argument.pointer) {
                let (name, scalars) = (&argument.name, argument.regs.len());
                let lanes = call.lanes;
                return refuse(format!(
                    "argument `{name}` takes {scalars} columns of {lanes} values each"
                ));
            }
        }
        let number = number as u32;
        let bound = self.bind(number, call.resources)?;
        // The last batch may have fewer lanes.
        let batches = call.lanes.div_ceil(LANES);
        let outcome = self.drive::<R, Called>(&bound, batches, settings, |m, batch| {
            let from = batch * LANES;
            let lanes = LANES.min(call.lanes - from);
            for (argument, words) in code.arguments.iter().zip(&call.arguments) {
                for (i, &reg) in argument.regs.iter().enumerate() {
                    set_register(m, reg, words.get(i).map_or(&[], |w| &w[from..from + lanes]));
                }
            }
            if let Some(tracer) = m.watch.as_mut().and_then(|watch| watch.tracer.as_mut()) {
                tracer.begin(code);
            }
            m.invoke(number, self.starts[number as usize], mask(lanes))?;
            if let Some(tracer) = m.watch.as_mut().and_then(|watch| watch.tracer.as_mut()) {
                tracer.finish(code);
            }
            let returned = code
                .arguments
                .iter()
                .map(|argument| argument.pointer.then(|| Numbers::read(m, &argument.regs, lanes)));
            let returned = returned.collect();
            let result = Numbers::read(m, &code.result, lanes);
            let discarded = bits(m.killed, lanes);
            let unsure = if R::MANY { bits(m.unsure, lanes) } else { Vec::new() };
            Ok(Called { result, returned, discarded, unsure, ..Called::default() })
        })?;
        let mut called =
            Called { notes: outcome.notes, buffers: outcome.left, ..Called::default() };
        // Batches come in their order, and so do invocations.
        for batch in outcome.results {
            called.discarded.extend(batch.discarded);
            called.unsure.extend(batch.unsure);
            called.result.append(batch.result);
            if called.returned.is_empty() {
                called.returned = batch.returned;
                continue;
            }
            for (all, more) in called.returned.iter_mut().zip(batch.returned) {
                if let (Some(all), Some(more)) = (all, more) {
                    all.append(more);
                }
            }
        }
        Ok(called)
    }
}
