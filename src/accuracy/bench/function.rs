//! A function of a shader over random arguments on the evaluator, as a workload.
//!
//! Only for functions of floats that read nothing else; [`run::call`](crate::run::call) and
//! readers call the others one at a time. Arguments are of either sign and log-uniform from
//! 2^-10 to 2^10; the truth is the first function's own `f64`, where that is finite.

use std::time::Duration;

use super::errors::Errors;
use super::report::Work;
use super::rounds::{Part, Workload};
use crate::run::Module;
use crate::run::eval::{Call, FunctionSignature, Numbers, Precision, Program, Settings, Words};
use crate::shape::{Scalar, ScalarKind};
use crate::source::{Source, Span};
use crate::{Diagnostic, Options};

/// Calls of one run.
const LANES: usize = 1 << 14;

/// Exponents of arguments: none so large that a square of a length overflows.
const EXPONENTS: [f64; 2] = [-10.0, 10.0];

/// A function ready to be called.
#[derive(Debug)]
pub struct Function {
    program: Program,
    signature: FunctionSignature,
}

impl Function {
    /// A shader's function by its name.
    ///
    /// # Errors
    /// What is wrong with the shader; no such function, or one that takes what is no float.
    pub fn new(
        source: &Source,
        options: &Options,
        name: &str,
    ) -> Result<Function, Vec<Diagnostic>> {
        let module = Module::new(source, &Options { gather: true, ..options.clone() })?;
        let program = Program::new(&module, &[]);
        let refuse = |message: String| {
            let mut found = Diagnostic::error("cannot-bench", Span::default(), message);
            found.labels.clear();
            found.path = Some(source.path.clone());
            vec![found]
        };
        let all = program.functions();
        let Some(signature) = all.iter().find(|function| function.name == name) else {
            let names: Vec<String> = all.iter().map(|f| format!("`{}`", f.name)).collect();
            let has = format!("there is no function `{name}`; there are {}", names.join(", "));
            return Err(refuse(has));
        };
        let taken = signature.parameters.iter().map(|parameter| (&parameter.name, &parameter.ty));
        for (what, ty) in taken {
            if ty.scalars().iter().any(|scalar| !is_float(*scalar)) {
                let has = format!("`{what}` of `{name}` is no float, vector or structure of them");
                return Err(refuse(has));
            }
        }
        let gives = signature.result.as_ref().map(|ty| ty.scalars()).unwrap_or_default();
        if gives.is_empty() || gives.iter().any(|scalar| !is_float(*scalar)) {
            return Err(refuse(format!("`{name}` returns no float, vector or structure of them")));
        }
        let signature = signature.clone();
        Ok(Function { program, signature })
    }

    fn call(&self, arguments: &[Words], precision: Precision) -> Result<(Numbers, u64), String> {
        let call = Call {
            function: &self.signature.name,
            lanes: LANES,
            arguments: arguments.to_vec(),
            resources: &[],
        };
        let settings = Settings { precision, threads: 1, ..Settings::default() };
        let called = self.program.call(&call, &settings).map_err(|failure| failure.message)?;
        Ok((called.result, called.notes.counts.operations()))
    }

    fn scalars(&self) -> Vec<usize> {
        self.signature.parameters.iter().map(|parameter| parameter.ty.scalars().len()).collect()
    }
}

fn is_float(scalar: Scalar) -> bool {
    scalar.kind == ScalarKind::Float && scalar.width == 4
}

/// Arguments, and what a function gives for them in `f64`.
#[derive(Clone, Debug)]
pub struct Calls {
    arguments: Vec<Words>,
    scalars: Vec<usize>,
    truth: Vec<Option<Vec<f64>>>,
}

impl Calls {
    /// Random arguments of a function.
    ///
    /// # Errors
    /// Why it cannot be called: it reads buffers, or does not end.
    pub fn new(function: &Function, seed: u64) -> Result<Calls, String> {
        let mut state = seed;
        let scalars = function.scalars();
        let arguments: Vec<Words> = scalars
            .iter()
            .map(|count| {
                (0..*count).map(|_| (0..LANES).map(|_| argument(&mut state)).collect()).collect()
            })
            .collect();
        let (numbers, _) = function.call(&arguments, Precision::Double)?;
        let truth = (0..LANES)
            .map(|lane| {
                let values: Vec<f64> = numbers.doubles.iter().map(|lanes| lanes[lane]).collect();
                values.iter().all(|value| value.is_finite()).then_some(values)
            })
            .collect();
        Ok(Calls { arguments, scalars, truth })
    }

    /// How many calls a run makes.
    pub fn count(&self) -> usize {
        LANES
    }

    /// A function over these arguments, how far it is from the truth, and its work.
    ///
    /// Errors are steps of 1/255 of the truth, or of 1 where that is more.
    ///
    /// # Errors
    /// It takes or gives something else, or cannot be called.
    pub fn workload<'a>(
        &'a self,
        function: &'a Function,
    ) -> Result<(Called<'a>, Errors, Work), String> {
        if function.scalars() != self.scalars {
            return Err("it takes other parameters than the function it is compared with".into());
        }
        let (numbers, operations) = function.call(&self.arguments, Precision::Single)?;
        let given = numbers.words.len();
        let wanted = self.truth.iter().flatten().map(Vec::len).next().unwrap_or(given);
        if given != wanted {
            let name = &function.signature.name;
            return Err(format!("`{name}` gives {given} numbers, and {wanted} are compared with"));
        }
        let mut rows: Vec<(Vec<f32>, Option<Vec<f64>>)> = Vec::with_capacity(LANES);
        for (lane, truth) in self.truth.iter().enumerate() {
            let single = |words: &Vec<u64>| f32::from_bits(words[lane] as u32);
            let ours: Vec<f32> = numbers.words.iter().map(single).collect();
            let sized = |at: usize| truth.as_ref().map_or(1.0, |t| t[at].abs().max(1.0));
            let ours = ours.iter().enumerate().map(|(i, x)| (f64::from(*x) / sized(i)) as f32);
            let exact =
                truth.as_ref().map(|t| t.iter().enumerate().map(|(i, x)| x / sized(i)).collect());
            rows.push((ours.collect(), exact));
        }
        let errors = Errors::each(rows.iter().map(|(a, b)| (&a[..], b.as_deref())));
        let work = Work { operations: Some(operations as f64 / LANES as f64), ..Work::default() };
        Ok((Called { calls: self, function }, errors, work))
    }
}

/// The bits of a random float.
fn argument(state: &mut u64) -> u64 {
    let mut unit = || {
        // SplitMix64 (Steele, Lea and Flood).
        *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = *state;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    };
    let [low, high] = EXPONENTS;
    let size = (low + (high - low) * unit()).exp2();
    let signed = if unit() < 0.5 { -size } else { size };
    u64::from((signed as f32).to_bits())
}

/// A function over arguments.
pub struct Called<'a> {
    calls: &'a Calls,
    function: &'a Function,
}

impl Workload for Called<'_> {
    fn has(&self, part: Part) -> bool {
        match part {
            Part::Whole => true,
            Part::Unlit | Part::Trivial => false,
        }
    }

    fn run(&mut self, _part: Part) -> Result<Option<Duration>, String> {
        std::hint::black_box(self.function.call(&self.calls.arguments, Precision::Single)?);
        Ok(None)
    }
}
