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

/// The verdict on each operation of a function that can have an undefined or inaccurate result, and
/// on each demand.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct ProveObject<'a> {
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA_VERSION)))]
    schema_version: u32,
    tool: Tool,
    path: &'a str,
    /// The API assumed for a shader that tests `VULKAN` without declaring its API, if its blocks
    /// depend on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    assumed_target: Option<Target>,
    /// The function with its parameter types.
    function: &'a str,
    inputs: Vec<InputObject<'a>>,
    /// The number of boxes into which the domain was divided.
    parts: u64,
    /// Whether the code was too large to analyse.
    too_large: bool,
    operations: Vec<OperationObject>,
    /// A bound on the error of every result, as low as it became in the time or until a demand was
    /// met; null where none is known.
    error: Option<ProvedBoundObject>,
    /// The largest errors of samples; null where none was run.
    worst: WorstSampleObject,
    /// Whether it is shown that no result is NaN, and that none is infinite.
    absent: NonFiniteObject,
    demands: Vec<DemandObject>,
    notes: &'a [String],
}

/// An input of the function and its domain.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct InputObject<'a> {
    path: &'a str,
    /// any, unit, position, color, cos, or lo..hi, and the ranges of components, as in `unit, z in
    /// 0..1`.
    domain: &'a str,
}

/// An operation that can break, and its verdict.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OperationObject {
    /// The fault, such as `division by zero`.
    fault: &'static str,
    /// Whether the result is undefined, loses half of its digits, or numbers leave the range of an
    /// f32.
    #[cfg_attr(
        feature = "schema",
        schemars(extend("enum" = ["undefined", "accuracy", "magnitude"]))
    )]
    class: &'static str,
    /// found: it breaks at the input. absent: it breaks nowhere in the domain, on any conformant
    /// device. open: neither found nor proved absent.
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["found", "absent", "open"])))]
    verdict: &'static str,
    function: String,
    path: String,
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    line: u32,
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    column: u32,
    excerpt: String,
    #[cfg_attr(feature = "schema", schemars(with = "Option<serde_json::Map<String, Value>>"))]
    input: Option<Value>,
    command: Option<String>,
    /// For each scalar of the inputs, the smallest and the largest value at which it may break.
    #[cfg_attr(
        feature = "schema",
        schemars(with = "Option<std::collections::BTreeMap<String, [f64; 2]>>")
    )]
    open: Option<Value>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct ProvedBoundObject {
    absolute: Option<f64>,
    ulp: Option<f64>,
    steps: Option<f64>,
    /// The least and greatest value that any result may have; null if infinite.
    results: [Option<f64>; 2],
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct WorstSampleObject {
    ulp: Option<f64>,
    steps: Option<f64>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct NonFiniteObject {
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["shown", "broken", "open"])))]
    nan: &'static str,
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["shown", "broken", "open"])))]
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct DemandObject {
    #[cfg_attr(
        feature = "schema",
        schemars(extend("enum" = ["no-fault", "no-nan", "no-inf", "max-ulp", "max-step"]))
    )]
    demand: &'static str,
    /// shown: proved for every conformant device. broken: the input violates it. open: neither.
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["shown", "broken", "open"])))]
    verdict: &'static str,
    /// The input that violates it, by path.
    #[cfg_attr(feature = "schema", schemars(with = "Option<serde_json::Map<String, Value>>"))]
    input: Option<Value>,
    /// Runs the function with that input.
    command: Option<String>,
}

/// The schema of [`PROVE_SCHEMA`](super::PROVE_SCHEMA).
#[cfg(feature = "schema")]
#[doc(hidden)]
pub fn schema() -> String {
    landfall_layout::schema::text::<ProveObject<'_>>("landfall prove --format json")
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
    format!("{}\n", to_lines(&object))
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
