//! Calling one function with the arguments of many invocations.
//!
//! What `stress` and `landfall run --fn` use; runs on [`stage`](super::stage).

use super::code::{Class, LANES, Reg};
use super::machine::Machine;
use super::permitted::Permitted;
use super::program::{FunctionCode, Program};
use super::real::{Real, Shadow};
use super::stage::{Notes, Precision, Settings, bits, failure, mask, put, refused_for};
use super::value::{Value, ValueType};
use crate::backend::{Failure, FailureKind, Resource};
use landfall_layout::shape::{Scalar, ScalarKind};

/// Words of a value, by scalar in the order of [`ValueType::scalars`], then by
/// invocation: the bits of an `f32` (of an `f16` too), of an integer, 0 or 1 of a bool;
/// 64 bits of what has as many.
pub type Words = Vec<Vec<u64>>;

/// A call of a function.
#[derive(Clone, Debug, Default)]
pub struct Call<'a> {
    /// Its name.
    pub function: &'a str,
    /// How many invocations.
    pub lanes: usize,
    /// Each parameter's words; of one that is only `out`, they may be empty.
    pub arguments: Vec<Words>,
    /// Buffers and textures it reads.
    pub resources: &'a [Resource],
}

/// What a value is in every invocation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Numbers {
    /// As in [`Words`]: floats rounded to `f32`.
    pub words: Words,
    /// The same as numbers; floats as `f64` where that was computed.
    pub doubles: Vec<Vec<f64>>,
    /// With [`Precision::Permitted`], of each float: the least and the greatest number that a
    /// conformant device may give; both infinite where it may give anything. Other scalars have
    /// their own value twice.
    pub permitted: Option<Vec<Vec<[f64; 2]>>>,
}

/// What a call gave.
#[derive(Clone, Debug, Default)]
pub struct Called {
    /// Its result.
    pub result: Numbers,
    /// By parameter: what is left in it, if it is a pointer, `out` or `inout`.
    pub returned: Vec<Option<Numbers>>,
    /// Invocations that met a `discard`.
    pub discarded: Vec<bool>,
    /// With [`Precision::Permitted`]: in which invocations a comparison, or an integer made of
    /// a float, may be another on another device.
    pub unsure: Vec<bool>,
    /// By resource: what is left in a writable buffer.
    pub buffers: Vec<Option<Vec<u8>>>,
    /// Notes of the run.
    pub notes: Notes,
}

impl Program {
    /// Calls a function.
    ///
    /// # Errors
    /// If there is no such function, its arguments are not as it takes them, it uses what
    /// is not supported, or does not end.
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
        // Functions of one name differ in their parameters.
        let fits = |f: &FunctionCode| {
            f.arguments.len() == call.arguments.len()
                && f.arguments.iter().zip(&call.arguments).all(|(argument, words)| {
                    words.len() == argument.regs.len() || words.is_empty() && argument.pointer
                })
        };
        let found = self.functions.iter().position(|f| named(&f) && fits(f));
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
                return refuse(format!("argument `{name}` is {scalars} scalars of {lanes} lanes"));
            }
        }
        let number = number as u32;
        let bound = self.bind(number, call.resources)?;
        let batches = call.lanes.div_ceil(LANES);
        let outcome = self.drive::<R, Called>(&bound, batches, settings, |m, batch| {
            let from = batch * LANES;
            let lanes = LANES.min(call.lanes - from);
            for (argument, words) in code.arguments.iter().zip(&call.arguments) {
                for (i, &reg) in argument.regs.iter().enumerate() {
                    put(m, reg, words.get(i).map_or(&[], |w| &w[from..from + lanes]));
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
            let unsure = if R::PERMITTED { bits(m.unsure, lanes) } else { Vec::new() };
            Ok(Called { result, returned, discarded, unsure, ..Called::default() })
        })?;
        let mut called =
            Called { notes: outcome.notes, buffers: outcome.left, ..Called::default() };
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

impl Numbers {
    pub(super) fn read<R: Real>(m: &mut Machine<R>, regs: &[Reg], lanes: usize) -> Numbers {
        let mut numbers = Numbers::default();
        if R::PERMITTED {
            numbers.permitted = Some(Vec::with_capacity(regs.len()));
        }
        for &reg in regs {
            let (words, doubles): (Vec<u64>, Vec<f64>) = match reg.class() {
                Class::Real => m.reals_of(reg)[..lanes]
                    .iter()
                    .map(|x| (u64::from(x.single().to_bits()), x.double()))
                    .unzip(),
                Class::Word => {
                    let words = &m.words_of(reg)[..lanes];
                    words.iter().map(|&x| (u64::from(x), f64::from(x))).unzip()
                }
                Class::Wide => {
                    m.wides_of(reg)[..lanes].iter().map(|&x| (x, f64::from_bits(x))).unzip()
                }
            };
            if let Some(permitted) = &mut numbers.permitted {
                let spans = match reg.class() {
                    Class::Real => {
                        let reals = &m.reals_of(reg)[..lanes];
                        reals.iter().map(|x| x.span().expect("it has one")).collect()
                    }
                    Class::Word | Class::Wide => doubles.iter().map(|x| [*x; 2]).collect(),
                };
                permitted.push(spans);
            }
            numbers.words.push(words);
            numbers.doubles.push(doubles);
        }
        numbers
    }

    pub(super) fn append(&mut self, more: Numbers) {
        if self.words.is_empty() {
            *self = more;
            return;
        }
        for (all, more) in self.words.iter_mut().zip(more.words) {
            all.extend(more);
        }
        for (all, more) in self.doubles.iter_mut().zip(more.doubles) {
            all.extend(more);
        }
        let permitted = self.permitted.iter_mut().flatten();
        for (all, more) in permitted.zip(more.permitted.into_iter().flatten()) {
            all.extend(more);
        }
    }

    /// The value of one invocation; floats with all their digits.
    pub fn value(&self, ty: &ValueType, lane: usize) -> Value {
        let scalars = ty.scalars();
        let mut numbers = scalars.iter().enumerate().map(|(i, scalar)| {
            let word = self.words[i][lane];
            match (scalar.kind, scalar.width) {
                (ScalarKind::Sint, 8) => word as i64 as f64,
                (ScalarKind::Uint, 8) => word as f64,
                (ScalarKind::Sint, _) => f64::from(word as u32 as i32),
                (ScalarKind::Uint | ScalarKind::Bool, _) => f64::from(word as u32),
                _ => self.doubles[i][lane],
            }
        });
        ty.build(&mut numbers)
    }
}

impl ValueType {
    /// The words of values, one an invocation; none if one is not of this type.
    pub fn words(&self, values: &[Value]) -> Option<Words> {
        let scalars = self.scalars();
        let mut words: Words = vec![Vec::with_capacity(values.len()); scalars.len()];
        for value in values {
            for ((number, scalar), to) in
                self.flatten(value)?.into_iter().zip(&scalars).zip(&mut words)
            {
                to.push(word(*scalar, number));
            }
        }
        Some(words)
    }
}

/// A number as a word of a scalar.
fn word(scalar: Scalar, number: f64) -> u64 {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Bool, _) => u64::from(number != 0.0),
        (ScalarKind::Sint, 8) => number as i64 as u64,
        (ScalarKind::Uint, 8) => number as u64,
        (ScalarKind::Sint, _) => u64::from(number as i32 as u32),
        (ScalarKind::Uint, _) => u64::from(number as u32),
        (ScalarKind::Float, 8) => number.to_bits(),
        (ScalarKind::Float | ScalarKind::Bfloat, _)
        | (ScalarKind::FloatE5m2 | ScalarKind::FloatE4m3, _) => {
            u64::from((number as f32).to_bits())
        }
    }
}
