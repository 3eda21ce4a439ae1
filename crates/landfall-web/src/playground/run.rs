//! What `landfall run` prints for a function of a shader.

use landfall_exec::harness::call::{Request, call, signatures, stage_inputs};
use landfall_layout::buffer::read_json;
use landfall_layout::diagnostic::Code;
use landfall_layout::format::{Paint, diagnostics};
use landfall_layout::source::Files;
use landfall_layout::text::escape;
use landfall_layout::text::escape::Styles;
use landfall_layout::{Diagnostic, Error, Options, Source, layout};
use serde::Deserialize;
use serde_json::{Map, Value};

use super::{Output, unknown};
use landfall_exec::report::run as print;

/// The functions of a shader that may be called, as they are spelled in `--fn`, with arguments as in
/// `--args`.
pub(super) fn functions(source: &Source, options: &Options) -> Vec<(String, String)> {
    let all = signatures(source, options).into_iter();
    all.map(|(name, arguments)| (name, super::json(&arguments))).collect()
}

/// The inputs of a stage of GLSL by name, each with a value that fits in JSON.
pub(super) fn inputs(source: &Source, options: &Options) -> Vec<(String, String)> {
    let all = stage_inputs(source, options).into_iter();
    all.map(|(name, value)| (name, super::json(&value))).collect()
}

/// A call: the values of the options of `landfall run` that have these names.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RunRequest {
    function: String,
    args: String,
    data: String,
    /// Names of inputs and their values in JSON.
    inputs: Vec<(String, String)>,
    format: String,
}

/// What `landfall run` prints.
pub(super) fn run(source: &Source, options: &Options, given: &RunRequest) -> Result<Output, Error> {
    let is_json = match given.format.as_str() {
        "human" => false,
        "json" => true,
        other => return Err(unknown("--format", other)),
    };
    let text = |found: &[Diagnostic], files: &Files| match is_json {
        true => diagnostics::json(found, files),
        false => diagnostics::human(found, files, Paint::Plain),
    };
    let request = match request(given) {
        Ok(request) => request,
        Err(error) => {
            let found = Diagnostic { code: Code::BadRequest, ..error.into() };
            let stderr = text(&[found], &Files::default());
            return Ok(Output { stderr, code: 2, ..Output::default() });
        }
    };
    let shader = layout(source, options);
    let mut assumed = shader.diagnostics;
    assumed.retain(|found| found.code == Code::TargetChangesLayout);
    let mut stderr = text(&assumed, &shader.files);
    match call(source, options, &request, None) {
        Ok(report) if is_json => {
            let stdout = escape::json(&print::json(&report)).into_owned();
            Ok(Output { stdout, stderr, code: 0 })
        }
        Ok(report) => {
            let stdout = print::text(&report, Paint::Plain);
            let stdout = escape::output(&stdout, Styles::Shown).into_owned();
            stderr.push_str(&text(&report.findings(), &report.files));
            Ok(Output { stdout, stderr, code: 0 })
        }
        Err(refusal) => {
            stderr.push_str(&text(&refusal.found, &refusal.files));
            Ok(Output { stderr, code: 2, ..Output::default() })
        }
    }
}

fn request(RunRequest { function, args, data, inputs, .. }: &RunRequest) -> Result<Request, Error> {
    let value = |about: &str, text: &str| {
        read_json(text).map_err(|error| Error::new(about, format!("is not JSON: {error}")))
    };
    let Value::Array(arguments) = value("--args", args)? else {
        return Err(
            Error::new("--args", "is not an array of arguments").with_help("write `[1, 2]`")
        );
    };
    let data = match data.trim() {
        "" => Map::new(),
        text => match value("--data", text)? {
            Value::Object(map) => map,
            _ => {
                return Err(Error::new("--data", "is not a JSON object of blocks by name")
                    .with_help("write `{\"Lights\": {\"count\": 1}}`"));
            }
        },
    };
    let inputs = inputs.iter().map(|(name, text)| Ok((name.clone(), value("--input", text)?)));
    let inputs = inputs.collect::<Result<_, Error>>()?;
    Ok(Request { function: function.clone(), arguments, data, inputs, ..Request::default() })
}
