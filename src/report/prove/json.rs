//! The JSON report of a proof.

use serde::Serialize;
use serde_json::Value;

use landfall_accuracy::demand::{DemandVerdict, ProveReport};
use landfall_accuracy::inputs::Input;
use landfall_accuracy::prove::Class;
use landfall_accuracy::stress::{Case, Operation, OperationVerdict, command};
use landfall_layout::format::SCHEMA_VERSION;
use landfall_layout::format::json::{Tool, to_lines};
use landfall_layout::source::{Files, Target};

#[derive(Serialize)]
struct ProveObject<'a> {
    schema_version: u32,
    tool: Tool,
    path: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    assumed_target: Option<Target>,
    function: &'a str,
    inputs: Vec<InputObject<'a>>,
    parts: u64,
    too_large: bool,
    operations: Vec<OperationObject>,
    error: Option<ProvedBoundObject>,
    worst: WorstSampleObject,
    absent: NonFiniteObject,
    demands: Vec<DemandObject>,
    notes: &'a [String],
}

/// An input of the function and its domain.
#[derive(Serialize)]
pub struct InputObject<'a> {
    path: &'a str,
    domain: &'a str,
}

/// An operation that can break, and its verdict.
#[derive(Serialize)]
pub struct OperationObject {
    fault: &'static str,
    class: &'static str,
    verdict: &'static str,
    function: String,
    path: String,
    line: u32,
    column: u32,
    excerpt: String,
    input: Option<Value>,
    command: Option<String>,
    open: Option<Value>,
}

#[derive(Serialize)]
struct ProvedBoundObject {
    absolute: Option<f64>,
    ulp: Option<f64>,
    steps: Option<f64>,
    results: [Option<f64>; 2],
}

#[derive(Serialize)]
struct WorstSampleObject {
    ulp: Option<f64>,
    steps: Option<f64>,
}

#[derive(Serialize)]
struct NonFiniteObject {
    nan: &'static str,
    infinity: &'static str,
}

fn verdict(verdict: &DemandVerdict) -> &'static str {
    match verdict {
        DemandVerdict::Shown => "shown",
        DemandVerdict::Broken(_) => "broken",
        DemandVerdict::Open => "open",
    }
}

#[derive(Serialize)]
struct DemandObject {
    demand: &'static str,
    verdict: &'static str,
    input: Option<Value>,
    command: Option<String>,
}

/// Returns the report as JSON, in the form of `landfall schema prove`.
pub fn json(proved: &ProveReport) -> String {
    let object = ProveObject {
        schema_version: SCHEMA_VERSION,
        tool: Tool::LANDFALL,
        path: &proved.path,
        assumed_target: proved.assumed_target,
        function: &proved.function,
        inputs: inputs(&proved.inputs),
        parts: proved.parts,
        too_large: proved.too_large,
        operations: operations(&proved.operations, &proved.files),
        error: proved.error.as_ref().map(|bound| ProvedBoundObject {
            absolute: finite(bound.absolute),
            ulp: finite(bound.ulp),
            steps: finite(bound.steps),
            results: bound.results.map(finite),
        }),
        worst: WorstSampleObject { ulp: proved.worst[0], steps: proved.worst[1] },
        absent: NonFiniteObject {
            nan: verdict(&proved.non_finite[0]),
            infinity: verdict(&proved.non_finite[1]),
        },
        demands: proved
            .demands
            .iter()
            .map(|(demand, shown)| {
                let case = match shown {
                    DemandVerdict::Broken(case) => Some(case),
                    DemandVerdict::Shown | DemandVerdict::Open => None,
                };
                DemandObject {
                    demand: demand.name(),
                    verdict: verdict(shown),
                    input: case.map(|case| case_inputs(case)),
                    command: case.map(|case| command(&case.arguments)),
                }
            })
            .collect(),
        notes: &proved.notes,
    };
    format!("{}\n", to_lines(&object, 0))
}

/// Returns the inputs with their domains.
pub fn inputs(inputs: &[(Input, String)]) -> Vec<InputObject<'_>> {
    inputs.iter().map(|(input, domain)| InputObject { path: &input.path, domain }).collect()
}

/// Returns the operations with their verdicts.
pub fn operations(operations: &[Operation], files: &Files) -> Vec<OperationObject> {
    let each = operations.iter().map(|operation| {
        let place = files.locate(operation.place.span);
        let case = match &operation.known {
            OperationVerdict::Found(case) => Some(case),
            OperationVerdict::Absent | OperationVerdict::Open(_) => None,
        };
        OperationObject {
            fault: operation.fault.text(),
            class: match operation.class() {
                Class::Undefined => "undefined",
                Class::Accuracy => "accuracy",
                Class::Magnitude => "magnitude",
            },
            verdict: operation.verdict(),
            function: operation.place.function.clone(),
            path: place.path,
            line: place.line,
            column: place.column,
            excerpt: files.text(operation.place.span).to_string(),
            input: case.map(|case| case_inputs(case)),
            command: case.map(|case| command(&case.arguments)),
            open: match &operation.known {
                OperationVerdict::Open(ranges) => {
                    let ranges =
                        ranges.iter().map(|(path, ends)| (path.clone(), ends.to_vec().into()));
                    Some(Value::Object(ranges.collect()))
                }
                OperationVerdict::Found(_) | OperationVerdict::Absent => None,
            },
        }
    });
    each.collect()
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

/// Returns the inputs of a sample by path.
pub fn case_inputs(case: &Case) -> Value {
    let inputs = case.inputs.iter();
    let value = |text: &str| serde_json::from_str(text).unwrap_or(Value::Null);
    Value::Object(inputs.map(|(path, text)| (path.clone(), value(text))).collect())
}
