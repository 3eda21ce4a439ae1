//! A function of a shader with everything it reads as a parameter: arguments, inputs of the stage,
//! members of blocks. Variables that it writes are returned beside its result.
//!
//! Built by `make` from a shader's text; `landfall_accuracy::stress` calls it over many
//! samples at a time.

use serde_json::{Map, Value};

use super::report::ReturnedValue;
use super::{arguments, caller};
use crate::backend::{Failure, Resource};
use crate::harness::bindings::Data;
use crate::harness::origins::{Names, ReadValue};
use landfall_interp::graph::{self, Given, Graph, Range};
use landfall_interp::{
    Call, Called, Floats, Numbers, Program, Settings, SourceLocation, Trace, TracedOperation,
    ValueType,
};
use landfall_ir::Module;
use landfall_ir::module::FunctionInfo;
use landfall_layout::Options;
use landfall_layout::source::{Files, Language, Source, Span as TextSpan};

/// A function to make pure, with its fixed resources.
#[derive(Clone, Debug, Default)]
pub struct PureRequest {
    /// The function: `phong`, or `phong(vec3, Light)` where several have the name.
    pub function: String,
    /// Contents of blocks; the members of others become parameters.
    pub data: Data,
    /// Colours of textures by name; the others are white.
    pub textures: Vec<(String, [f32; 4])>,
    /// The precision to which floats are rounded.
    pub floats: Floats,
}

/// A function that depends on its parameters alone.
#[derive(Debug)]
pub struct PureFunction {
    /// The name with the types of its parameters.
    pub shown: String,
    /// The span of the name in the text.
    pub(super) name_span: TextSpan,
    pub parameters: Vec<PureParameter>,
    pub results: Vec<PureResult>,
    /// Notes on defaults taken for missing values.
    pub notes: Vec<String>,
    /// The shader's files.
    pub files: Files,
    /// The shader's language.
    pub language: Language,
    pub(super) program: Program,
    pub(super) resources: Vec<Resource>,
    /// By parameter of the caller: the source of its value.
    pub(super) slots: Vec<ParameterSlot>,
    /// Given contents of blocks, for repeating a call.
    pub(super) data: Data,
    /// Given colours of textures.
    pub(super) textures: Vec<(String, [f32; 4])>,
    /// The module; its last function is the caller.
    pub(super) module: Module,
    /// The function as declared in the text.
    pub(super) info: FunctionInfo,
    /// The stage's inputs, used or not, which are the caller's first parameters.
    pub(super) inputs: Vec<(String, ValueType)>,
    /// The text and how it is read, for drivers with their own compiler.
    pub(super) source: Source,
    pub(super) options: Options,
    pub(super) purpose: CallPurpose,
}

/// The purpose for which a function is prepared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CallPurpose {
    /// Calls over many lanes, which allow no effects beyond the lane.
    Pure,
    /// A single call by one invocation.
    Call,
}

/// A parameter of a pure function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PureParameter {
    /// The path as users write it: `light`, `material` of a block.
    pub path: String,
    pub origin: Origin,
    pub ty: ValueType,
    /// The path of each scalar in the text.
    pub scalars: Vec<String>,
    /// Whether it is read; only some members of a block may be. The others may have any value.
    pub read: bool,
    /// For a member of a block: the index among the module's blocks.
    pub(super) block: Option<usize>,
}

/// The source of a parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// An argument of the function, by position.
    Argument(usize),
    /// An input of the stage.
    Input,
    /// A member of a block: the block's name, and the member's.
    Block(String, String),
}

/// A result of a pure function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PureResult {
    /// `result`, or the name of the parameter or variable.
    pub name: String,
    pub ty: ValueType,
    /// The caller's parameter that receives it; `None` for the return value.
    pub(super) at: Option<usize>,
}

#[derive(Clone, Debug)]
pub(super) enum ParameterSlot {
    /// Public parameters, concatenated.
    Given(Vec<usize>),
    /// This many zero scalars.
    Zero(usize),
    /// Output only.
    Out,
}

/// The results of a call over many lanes.
#[derive(Clone, Debug)]
pub struct PureCallResult {
    /// By result: its numbers.
    pub results: Vec<Numbers>,
    /// The remaining results.
    pub called: Called,
}

impl PureFunction {
    /// Calls the function over lanes, given the words of each scalar of all parameters in order.
    ///
    /// # Errors
    /// Those of [`Program::call`].
    pub fn call(
        &self,
        columns: &[Vec<u64>],
        lanes: usize,
        settings: &Settings,
    ) -> Result<PureCallResult, Failure> {
        let arguments = self.arguments(&vec![0; lanes], |column| columns[column].clone());
        let call = Call { function: caller::NAME, lanes, arguments, resources: &self.resources };
        let mut called = self.program.call(&call, settings)?;
        let results = self.results.iter().map(|result| match result.at {
            // Taken, as over many lanes a copy is large: `called.result` is empty afterwards.
            None => std::mem::take(&mut called.result),
            Some(at) => called.returned[at].clone().unwrap_or_default(),
        });
        let results = results.collect();
        Ok(PureCallResult { results, called })
    }

    /// Follows the function's values over a box: one range for each scalar of all parameters in
    /// order, and the scalars of each vector of length one. `None` if the code is too large.
    pub fn graph(&self, ranges: &[Range], units: &[Vec<usize>]) -> Option<Graph> {
        let arguments = self.arguments(&Given::Zero, Given::Input);
        let results: Vec<Option<usize>> = self.results.iter().map(|result| result.at).collect();
        let inputs = graph::GraphInputs {
            function: caller::NAME,
            arguments: &arguments,
            ranges,
            units,
            results: &results,
        };
        self.program.graph(&inputs, &self.resources)
    }

    /// Returns the scalars of each of the caller's parameters; those of public ones by their column.
    fn arguments<T: Clone>(&self, zero: &T, given: impl Fn(usize) -> T) -> Vec<Vec<T>> {
        let mut columns = Vec::with_capacity(self.parameters.len());
        let mut next = 0;
        for parameter in &self.parameters {
            columns.push(next..next + parameter.scalars.len());
            next += parameter.scalars.len();
        }
        let scalars = |slot: &ParameterSlot| -> Vec<T> {
            match slot {
                ParameterSlot::Given(parameters) => {
                    parameters.iter().flat_map(|&p| columns[p].clone()).map(&given).collect()
                }
                ParameterSlot::Zero(scalars) => vec![zero.clone(); *scalars],
                ParameterSlot::Out => Vec::new(),
            }
        };
        self.slots.iter().map(scalars).collect()
    }

    /// Returns the place of a traced operation; that of the function's name if it has no place in
    /// the text.
    pub fn place_of(&self, step: &TracedOperation) -> SourceLocation {
        let place = self.program.place_of(step);
        if place.shown.is_empty() { self.place() } else { place }
    }

    /// Returns the members of blocks with given contents that led to an operation's result.
    pub fn members_read(&self, trace: &Trace, step: &TracedOperation) -> Vec<ReadValue> {
        let PureFunction { program, module, language, .. } = self;
        let names = Names { program, module, language: *language, parameters: Vec::new() };
        names.values(&trace.led_to(step))
    }

    /// Returns the place of the function's name.
    pub fn place(&self) -> SourceLocation {
        let at = self.files.locate(self.name_span);
        let shown = format!("{}:{}:{}", at.path, at.line, at.column);
        let function = self.shown.split('(').next().unwrap_or_default().to_string();
        SourceLocation { function, span: self.name_span, shown }
    }

    /// Returns the source of each scalar of each result, in order.
    pub fn sources(&self, trace: &Trace) -> Vec<landfall_interp::Source> {
        let of = |result: &PureResult| match result.at {
            None => trace.results.clone(),
            Some(at) => trace.returned.get(at).cloned().unwrap_or_default(),
        };
        self.results.iter().flat_map(of).collect()
    }

    /// Returns the column of a scalar of a caller's parameter, if it is public.
    pub fn scalar_of(&self, parameter: u32, scalar: u32) -> Option<usize> {
        let ParameterSlot::Given(parameters) = self.slots.get(parameter as usize)? else {
            return None;
        };
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

    /// Returns the path of a scalar within a result, such as `.x`.
    pub fn result_path(&self, result: usize, scalar: usize) -> String {
        arguments::paths(&self.results[result].ty).get(scalar).cloned().unwrap_or_default()
    }

    /// Returns the arguments, block contents and inputs of one sample in the form `landfall run`
    /// takes.
    pub fn json(&self, words: &[u64]) -> (Vec<Value>, Data, Vec<(String, Value)>) {
        let mut arguments: Vec<(usize, Value)> = Vec::new();
        let mut data = self.data.clone();
        let mut inputs = Vec::new();
        let mut next = 0;
        for parameter in &self.parameters {
            let words = &words[next..next + parameter.scalars.len()];
            next += parameter.scalars.len();
            let value =
                shortest(ReturnedValue::new(&parameter.ty, self.language, words, None).json());
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
        // By position, which is not the order of the parameters.
        arguments.sort_by_key(|(at, _)| *at);
        (arguments.into_iter().map(|(_, value)| value).collect(), data, inputs)
    }
}

/// Shortens floats to the fewest digits that denote the same `f32`.
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
                // A double that no `f32` equals keeps all of its digits.
                Ok(_) | Err(_) => Value::Number(number),
            }
        }
        Value::Number(_) | Value::String(_) | Value::Bool(_) | Value::Null => value,
    }
}
