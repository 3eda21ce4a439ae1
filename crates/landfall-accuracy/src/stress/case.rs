//! A sample in readable form, with the command that reproduces it.
//!
//! Built for each finding of the [`report`](super::report) and each worst sample of a driver;
//! printed by the report of `landfall stress`.

use serde::{Serialize, Serializer};
use serde_json::Value;

use super::input::{Input, Sample};
use super::measure::{JsonNumber, floats, json_number};
use super::plan::columns;
use landfall_exec::harness::bindings::Data;
use landfall_exec::harness::call::pure::{Origin, PureFunction, PureRequest};
use landfall_interp::{Floats, Precision, Settings};
use landfall_layout::Options;
use landfall_layout::layout::targets;
use landfall_layout::source::{Language, Source, kind_of_path};

/// A sample in readable form.
#[derive(Clone, Debug)]
pub struct Case {
    /// The inputs by path, as JSON.
    pub inputs: Vec<(String, String)>,
    /// The inputs by path, flattened to vectors and scalars; integers as numbers.
    pub flat: Vec<(String, Vec<f64>)>,
    pub results: Vec<ResultScalar>,
    /// The arguments of `landfall run` that reproduce it.
    pub arguments: Vec<String>,
    /// The same inputs as values: arguments, block contents, stage inputs.
    pub values: (Vec<Value>, Data, Vec<(String, Value)>),
    pub(super) words: Sample,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "ResultObject"))]
pub struct ResultScalar {
    // `result.x`.
    pub path: String,
    #[serde(rename = "f32", serialize_with = "json_single")]
    #[cfg_attr(feature = "schema", schemars(with = "JsonNumber"))]
    pub single: f32,
    #[serde(rename = "f64", serialize_with = "json_number")]
    #[cfg_attr(feature = "schema", schemars(with = "JsonNumber"))]
    pub double: f64,
}

fn json_single<S: Serializer>(single: &f32, serializer: S) -> Result<S::Ok, S::Error> {
    JsonNumber::from(*single).serialize(serializer)
}

/// Converts samples of a function to cases.
#[derive(Clone)]
pub(crate) struct CaseWriter<'a> {
    source: &'a Source,
    pure: &'a PureFunction,
    inputs: &'a [Input],
    /// The arguments of `landfall run` for the shader and its textures, from [`fixed`].
    fixed: Vec<String>,
    /// The most loop iterations of one invocation.
    budget: u32,
    /// The precision of floats.
    floats: Floats,
}

impl<'a> CaseWriter<'a> {
    pub fn new(
        source: &'a Source,
        options: &Options,
        request: &PureRequest,
        pure: &'a PureFunction,
        inputs: &'a [Input],
        budget: u32,
    ) -> CaseWriter<'a> {
        let fixed = fixed(source, options, &request.textures);
        CaseWriter { source, pure, inputs, fixed, budget, floats: request.floats }
    }

    /// Returns the writer for drivers, which run the code as written.
    pub fn for_drivers(self) -> CaseWriter<'a> {
        CaseWriter { floats: Floats::AsWritten, ..self }
    }

    pub fn case(&self, sample: &Sample) -> Case {
        let CaseWriter { source, pure, inputs: all, fixed, .. } = self;
        let (arguments, data, given) = pure.json(sample);
        let values = (arguments.clone(), data.clone(), given.clone());
        let mut inputs = Vec::new();
        let mut words = arguments.iter();
        let mut named = given.iter();
        // Values in the order of the parameters, whatever they are bound to.
        for parameter in &pure.parameters {
            let value = match &parameter.origin {
                Origin::Argument(_) => words.next().cloned(),
                Origin::Input => named.next().map(|(_, value)| value.clone()),
                Origin::Block(block, member) => {
                    data.get(block).and_then(|block| block.get(member)).cloned()
                }
            };
            inputs.push((parameter.path.clone(), value.unwrap_or_default().to_string()));
        }
        let mut line = vec!["run".to_string(), source.path.clone()];
        line.extend(["--fn".to_string(), pure.shown.clone()]);
        if !arguments.is_empty() {
            line.extend(["--args".to_string(), Value::from(arguments).to_string()]);
        }
        // Omitted values are zero.
        let data = Value::from(data);
        if let Some(data) = without_zeros(&data) {
            line.extend(["--data".to_string(), data.to_string()]);
        }
        for (name, value) in given.into_iter().filter(|(_, value)| without_zeros(value).is_some()) {
            line.extend(["--input".to_string(), format!("{name}={value}")]);
        }
        line.extend(fixed.iter().cloned());
        // A rerun has to round as this run did.
        match self.floats {
            Floats::AsWritten => {}
            Floats::Half => line.push("--half".to_string()),
            Floats::Mediump => line.push("--mediump".to_string()),
        }
        let settings = Settings {
            precision: Precision::Both,
            budget: self.budget,
            threads: 1,
            ..Settings::default()
        };
        let called = pure.call(&columns(std::slice::from_ref(sample)), 1, &settings);
        let mut results = Vec::new();
        if let Ok(called) = &called {
            for (nth, at) in floats(pure) {
                let result = &pure.results[nth];
                results.push(ResultScalar {
                    path: format!("{}{}", result.name, pure.result_path(nth, at)),
                    single: f32::from_bits(called.results[nth].words[at][0] as u32),
                    double: called.results[nth].doubles[at][0],
                });
            }
        }
        let numbers = |input: &Input| input.range().map(|at| input.number(sample[at])).collect();
        let flat = all.iter().map(|input| (input.path.clone(), numbers(input))).collect();
        Case { inputs, flat, results, arguments: line, values, words: sample.clone() }
    }

    /// Returns the path of a scalar of the inputs.
    pub fn path(&self, at: usize) -> Option<String> {
        let scalars = self.pure.parameters.iter().flat_map(|parameter| &parameter.scalars);
        scalars.clone().nth(at).cloned()
    }
}

/// Returns the arguments of `landfall run` that set the options of the shader and its textures as
/// in this run.
fn fixed(source: &Source, options: &Options, textures: &[(String, [f32; 4])]) -> Vec<String> {
    let read = &options.read;
    let mut all: Vec<String> = Vec::new();
    let mut push = |flag: &str, value: String| all.extend([flag.to_string(), value]);
    for (name, colour) in textures {
        push("--texture", format!("{name}={colour:?}"));
    }
    for (name, text) in &read.defines {
        push("-D", format!("{name}={text}"));
    }
    for folder in &read.include_dirs {
        push("-I", folder.display().to_string());
    }
    for (name, value) in &read.overrides {
        push("-O", format!("{name}={value}"));
    }
    if let Some(target) = read.target {
        push("--target", targets::key(target).to_string());
    }
    // Only what the file's name does not determine.
    let (language, stage) = kind_of_path(source.path.as_ref()).unwrap_or((Language::Glsl, None));
    if source.language != language {
        push("--language", source.language.name().to_string());
    }
    if let Some(said) = source.stage.filter(|said| Some(*said) != stage) {
        push("--stage", said.name().to_string());
    }
    all
}

/// Returns a command line for a shell.
pub fn command(arguments: &[String]) -> String {
    let quoted = arguments.iter().map(|argument| {
        // Anything else is quoted for a POSIX shell; a quote inside ends the quotes, is escaped,
        // and begins them again.
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=".contains(c);
        match argument.chars().all(plain) && !argument.is_empty() {
            true => argument.clone(),
            false => format!("'{}'", argument.replace('\'', "'\\''")),
        }
    });
    format!("landfall {}", quoted.collect::<Vec<_>>().join(" "))
}

/// Returns a value without members that are zero; `None` if nothing remains.
fn without_zeros(value: &Value) -> Option<Value> {
    let kept = match value {
        Value::Object(members) => {
            let members = members
                .iter()
                .filter_map(|(key, value)| Some((key.clone(), without_zeros(value)?)));
            let members: serde_json::Map<String, Value> = members.collect();
            return (!members.is_empty()).then_some(Value::Object(members));
        }
        Value::Array(items) => items.iter().any(|item| without_zeros(item).is_some()),
        // Negative zero is kept.
        Value::Number(number) => number.as_f64().is_none_or(|x| x.to_bits() != 0),
        Value::Bool(set) => *set,
        Value::Null => false,
        Value::String(_) => true,
    };
    kept.then(|| value.clone())
}
