//! A function of a shader with everything it reads as a parameter: arguments, inputs of the
//! stage, members of blocks. What it writes besides its result comes back too.
//!
//! Made by `make` of a shader's text; `landfall_light::accuracy::stress` calls it over
//! many samples at a time.

use serde_json::{Map, Value};

use super::report::Given;
use super::{Refusal, arguments, caller, make};
use crate::backend::{Failure, Resource};
use crate::harness::bindings::Data;
use crate::interp::{
    Call, Called, Floats, Numbers, Place, Program, Settings, Step, Trace, ValueType, Words,
};
use landfall_ir::Module;
use landfall_ir::module::FunctionInfo;
use landfall_layout::source::{Files, Language, Source, Span as TextSpan};
use landfall_layout::{Diagnostic, Options};

/// What is to be called, and what of it stays fixed.
#[derive(Clone, Debug, Default)]
pub struct PureRequest {
    /// The function: `phong`, or `phong(vec3, Light)` where several have the name.
    pub function: String,
    /// What blocks hold; the others are parameters.
    pub data: Data,
    /// Colours of textures by name; the others are white.
    pub textures: Vec<(String, [f32; 4])>,
    /// What its floats are rounded to.
    pub floats: Floats,
}

/// A function that depends on its parameters alone.
#[derive(Debug)]
pub struct Pure {
    /// Its name with the types of its parameters.
    pub shown: String,
    /// Its name in the text.
    pub(super) name_span: TextSpan,
    /// What it reads.
    pub parameters: Vec<PureParameter>,
    /// What it gives.
    pub results: Vec<PureResult>,
    /// What was taken for what was not given.
    pub notes: Vec<String>,
    /// The files the shader is made of.
    pub files: Files,
    /// The language the shader is written in.
    pub language: Language,
    pub(super) program: Program,
    pub(super) resources: Vec<Resource>,
    /// By parameter of the caller: which of ours, or what stands there.
    pub(super) slots: Vec<Slot>,
    /// Data that was given, for repeating a call.
    pub(super) data: Data,
    /// Colours of textures that were given.
    pub(super) textures: Vec<(String, [f32; 4])>,
    /// The module; its last function is the caller.
    pub(super) module: Module,
    /// The function as its text declares it.
    pub(super) info: FunctionInfo,
    /// The inputs of the stage, which the caller takes first, whether they are read or not.
    pub(super) inputs: Vec<(String, ValueType)>,
    /// The text, and how it is read: a driver may have a compiler of its own.
    pub(super) source: Source,
    pub(super) options: Options,
    pub(super) asks: Asks,
}

/// What is to be done with the function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Asks {
    /// It is called over many lanes, and so may do nothing that is not of its own lane.
    Pure,
    /// It is called once, by one invocation.
    Call,
}

/// Something the function reads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PureParameter {
    /// The way to it as people write it: `light`, `material` of a block.
    pub path: String,
    /// Where it comes from.
    pub origin: Origin,
    /// What it is.
    pub ty: ValueType,
    /// The way to each of its scalars, and what the scalar is in the text.
    pub scalars: Vec<String>,
    /// Whether it is read: of a block, only some members may be. The others may be anything.
    pub read: bool,
    /// Of a member of a block: which of the module's.
    pub(super) block: Option<usize>,
}

/// Where a parameter comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// An argument of the function, by position.
    Argument(usize),
    /// An input of the stage.
    Input,
    /// A member of a block: the block's name, and the member's.
    Block(String, String),
}

/// Something the function gives.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PureResult {
    /// `result`, or the name of the parameter or variable.
    pub name: String,
    /// What it is.
    pub ty: ValueType,
    /// The parameter of the caller it is left in; none for what is returned.
    pub(super) at: Option<usize>,
}

#[derive(Clone, Debug)]
pub(super) enum Slot {
    /// Parameters of ours, one after the other.
    Given(Vec<usize>),
    /// Zeros, as many.
    Zero(usize),
    /// Only written.
    Out,
}

/// What a call of many lanes gave.
#[derive(Clone, Debug)]
pub struct PureCalled {
    /// By result: its numbers.
    pub results: Vec<Numbers>,
    /// All else.
    pub called: Called,
}

impl Pure {
    /// Makes a function of a shader pure.
    ///
    /// # Errors
    /// A shader that does not run; a function it does not have; one that cannot be called by
    /// itself, by what it does.
    pub fn new(
        source: &Source,
        options: &Options,
        request: &PureRequest,
    ) -> Result<Pure, Box<Refusal>> {
        Pure::asked(source, options, request, Asks::Pure)
    }

    /// The same of a function that need not be pure, if it is only called.
    pub(super) fn asked(
        source: &Source,
        options: &Options,
        request: &PureRequest,
        asks: Asks,
    ) -> Result<Pure, Box<Refusal>> {
        let options = &Options { gather: true, naga: false, ..options.clone() };
        let module = Module::for_calls(source, options).map_err(|found| {
            Box::new(Refusal { found, files: landfall_layout::layout(source, options).files })
        })?;
        let files = module.files().clone();
        let refused =
            |found: Diagnostic| Box::new(Refusal { found: vec![found], files: files.clone() });
        make::make(source, options, module, request, asks).map_err(|found| refused(*found))
    }

    /// Calls it over lanes: the words of each scalar of all parameters, in order.
    ///
    /// # Errors
    /// As [`Program::call`].
    pub fn call(
        &self,
        columns: &[Vec<u64>],
        lanes: usize,
        settings: &Settings,
    ) -> Result<PureCalled, Failure> {
        let mut firsts = Vec::with_capacity(self.parameters.len());
        let mut next = 0;
        for parameter in &self.parameters {
            firsts.push(next);
            next += parameter.scalars.len();
        }
        let words = |slot: &Slot| -> Words {
            match slot {
                Slot::Given(parameters) => parameters
                    .iter()
                    .flat_map(|&p| firsts[p]..firsts[p] + self.parameters[p].scalars.len())
                    .map(|column| columns[column].clone())
                    .collect(),
                Slot::Zero(scalars) => vec![vec![0; lanes]; *scalars],
                Slot::Out => Words::new(),
            }
        };
        let arguments = self.slots.iter().map(words).collect();
        let call = Call { function: caller::NAME, lanes, arguments, resources: &self.resources };
        let mut called = self.program.call(&call, settings)?;
        let results = self.results.iter().map(|result| match result.at {
            None => std::mem::take(&mut called.result),
            Some(at) => called.returned[at].clone().unwrap_or_default(),
        });
        let results = results.collect();
        Ok(PureCalled { results, called })
    }

    /// The place of an operation of a trace: of what no text says, where the function is named.
    pub fn place_of(&self, step: &Step) -> Place {
        let place = self.program.place_of(step);
        if place.shown.is_empty() { self.place() } else { place }
    }

    /// Where the function is named.
    pub fn place(&self) -> Place {
        let at = self.files.locate(self.name_span);
        let shown = format!("{}:{}:{}", at.path, at.line, at.column);
        let function = self.shown.split('(').next().unwrap_or_default().to_string();
        Place { function, span: self.name_span, shown }
    }

    /// Where each scalar of each result came from, in the order of the results.
    pub fn sources(&self, trace: &Trace) -> Vec<crate::interp::Source> {
        let of = |result: &PureResult| match result.at {
            None => trace.results.clone(),
            Some(at) => trace.returned.get(at).cloned().unwrap_or_default(),
        };
        self.results.iter().flat_map(of).collect()
    }

    /// The scalar of our parameters that a scalar of the caller's is: its number in the columns.
    pub fn scalar_of(&self, parameter: u32, scalar: u32) -> Option<usize> {
        let Slot::Given(parameters) = self.slots.get(parameter as usize)? else { return None };
        let mut rest = scalar as usize;
        for &p in parameters {
            let len = self.parameters[p].scalars.len();
            if rest < len {
                let before: usize = self.parameters[..p].iter().map(|p| p.scalars.len()).sum();
                return Some(before + rest);
            }
            rest -= len;
        }
        None
    }

    /// The way from a result to one of its scalars: `.x`.
    pub fn result_path(&self, result: usize, scalar: usize) -> String {
        arguments::paths(&self.results[result].ty).get(scalar).cloned().unwrap_or_default()
    }

    /// The arguments, block contents and inputs of one sample as `landfall run` takes them.
    pub fn json(&self, words: &[u64]) -> (Vec<Value>, Data, Vec<(String, Value)>) {
        let mut arguments: Vec<(usize, Value)> = Vec::new();
        let mut data = self.data.clone();
        let mut inputs = Vec::new();
        let mut next = 0;
        for parameter in &self.parameters {
            let words = &words[next..next + parameter.scalars.len()];
            next += parameter.scalars.len();
            let value = shortest(Given::new(&parameter.ty, self.language, words, None).json());
            match &parameter.origin {
                Origin::Argument(at) => arguments.push((*at, value)),
                Origin::Input => inputs.push((parameter.path.clone(), value)),
                Origin::Block(block, member) => {
                    let members = data
                        .entry(block.clone())
                        .or_insert_with(|| Value::Object(Map::new()))
                        .as_object_mut()
                        .expect("a block that is sampled has no other data");
                    members.insert(member.clone(), value);
                }
            }
        }
        arguments.sort_by_key(|(at, _)| *at);
        (arguments.into_iter().map(|(_, value)| value).collect(), data, inputs)
    }
}

/// Floats by the fewest digits that are the same `f32`.
fn shortest(value: Value) -> Value {
    match value {
        Value::Array(items) => Value::Array(items.into_iter().map(shortest).collect()),
        Value::Object(map) => {
            Value::Object(map.into_iter().map(|(key, value)| (key, shortest(value))).collect())
        }
        Value::Number(number) if number.is_f64() => {
            let wide = number.as_f64().unwrap_or_default();
            let single = wide as f32;
            let short = format!("{single:?}").parse::<f64>();
            match short {
                Ok(short) if f64::from(single) == wide => Value::from(short),
                Ok(_) | Err(_) => Value::Number(number),
            }
        }
        Value::Number(_) | Value::String(_) | Value::Bool(_) | Value::Null => value,
    }
}
