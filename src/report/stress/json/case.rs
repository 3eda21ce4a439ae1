//! A sample in JSON: its inputs, results and errors.

use serde::Serialize;
use serde_json::Value;

use crate::report::prove::case_inputs;
use landfall_accuracy::stress::messages::number;
use landfall_accuracy::stress::{Case, Condition, SampleError, command};

/// A number, or `nan`, `inf`, `-inf`.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub(super) enum JsonNumber {
    Finite(f64),
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["nan", "inf", "-inf"])))]
    NonFinite(String),
}

/// The worst component of the result: f32 against f64.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct OffObject {
    /// In units of the last place of an f32.
    ulp: JsonNumber,
    /// Relative to the value, or to 2^-10 of full scale if larger.
    relative: JsonNumber,
    /// In 1/255 of full scale, which is 1 or the largest component.
    steps: JsonNumber,
}

/// The effect of changing an input by a unit of its last place, in f64.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct ConditionObject<'a> {
    /// The input.
    path: &'a str,
    /// The change of the result in 1/255 of full scale.
    steps: JsonNumber,
    /// The condition number: the relative change of the result per relative change of the input.
    number: JsonNumber,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct CaseObject<'a> {
    /// The inputs by path, in the notation of `landfall run`.
    #[cfg_attr(feature = "schema", schemars(with = "serde_json::Map<String, Value>"))]
    inputs: Value,
    results: Vec<ResultObject<'a>>,
    /// The command that reproduces it.
    command: String,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct ResultObject<'a> {
    path: &'a str,
    f32: JsonNumber,
    f64: JsonNumber,
}

pub(super) fn json_number(x: f64) -> JsonNumber {
    match x.is_finite() {
        true => JsonNumber::Finite(x),
        false => JsonNumber::NonFinite(number(x).to_lowercase()),
    }
}

pub(super) fn single(x: f32) -> JsonNumber {
    match x.is_finite() {
        // The shortest digits that round to this f32.
        true => json_number(format!("{x:?}").parse().unwrap_or(f64::from(x))),
        false => json_number(f64::from(x)),
    }
}

pub(super) fn off(off: &SampleError) -> OffObject {
    OffObject {
        ulp: json_number(off.ulp),
        relative: json_number(off.relative),
        steps: json_number(off.steps),
    }
}

pub(super) fn condition(condition: &Condition) -> ConditionObject<'_> {
    ConditionObject {
        path: &condition.path,
        steps: json_number(condition.steps),
        number: json_number(condition.number),
    }
}

pub(super) fn case(case: &Case) -> CaseObject<'_> {
    CaseObject {
        inputs: case_inputs(case),
        results: case
            .results
            .iter()
            .map(|r| ResultObject {
                path: &r.path,
                f32: single(r.single),
                f64: json_number(r.double),
            })
            .collect(),
        command: command(&case.arguments),
    }
}
