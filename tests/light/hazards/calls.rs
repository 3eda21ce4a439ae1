//! Functions called with the inputs of a hazard, on every backend.

use std::collections::HashMap;

use landfall_exec::backend::Backend;
use landfall_exec::harness::call::{CallReport, Request, call};
use landfall_layout::{Language, Options, Source};
use serde_json::Value;

use super::backends::with_readers;
use super::{list, rows, text};
use crate::support::sample::{everything, sampled};

/// The numbers of a result or of an expected value, in order.
fn flat(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(flat).collect(),
        other => vec![other.as_f64().unwrap_or_else(|| panic!("{other} is a number"))],
    }
}

fn got(report: &CallReport) -> Vec<f64> {
    let result = report.result.as_ref().expect("the functions of the rows return something");
    let single = |bits: u64| f64::from(f32::from_bits(bits as u32));
    result.scalars.iter().map(|scalar| single(scalar.value.bits)).collect()
}

/// What is wrong with a report, if anything.
fn misfit(expect: &Value, backend: &str, report: &CallReport) -> Option<String> {
    let kinds: Vec<String> =
        report.undefined.iter().map(|u| format!("{:?}", u.seen.kind)).collect();
    match text(expect, "class") {
        "undefined" => {
            let wanted = list(expect, "kinds").iter().map(|kind| kind.as_str().expect("a kind"));
            let missing: Vec<&str> = wanted.filter(|w| !kinds.iter().any(|k| k == w)).collect();
            (!missing.is_empty()).then(|| format!("{missing:?} is not noted, only {kinds:?}"))
        }
        "finite" => {
            let (got, value) = (got(report), flat(&expect["value"]));
            let within = match (backend, &expect["drivers"]) {
                ("cpu", _) | (_, Value::Null) => &expect["within"],
                (_, drivers) => drivers,
            };
            let within = within.as_f64().expect("how near is a number");
            let off = |(a, b): (&f64, &f64)| (a - b).abs();
            let fits = got.len() == value.len() && got.iter().zip(&value).all(|p| off(p) <= within);
            let most = got.iter().zip(&value).map(off).fold(0.0, f64::max);
            if !kinds.is_empty() {
                Some(format!("{kinds:?} is noted"))
            } else if !fits {
                Some(format!("{got:?} for {value:?}"))
            } else if backend == "cpu" && expect["beyond"].as_f64().is_some_and(|x| most < x) {
                Some(format!("{got:?} is as good as {value:?}: there is no hazard"))
            } else {
                None
            }
        }
        other => panic!("`{other}` is no class"),
    }
}

/// Runs every case by one backend; how many calls that were.
fn classified(backend: &mut dyn Backend) -> usize {
    let name = backend.device().backend.name();
    let mut sources: HashMap<String, Source> = HashMap::new();
    let (mut calls, mut wrong) = (0, Vec::new());
    // Drivers compile a program for each.
    let rows = rows();
    for row in sampled(&rows, if name == "cpu" { 1 } else { 5 }) {
        let id = text(row, "id");
        for case in list(row, "cases") {
            let only = case["backends"].as_array();
            if only.is_some_and(|only| !only.iter().any(|backend| *backend == name)) {
                continue;
            }
            for run in list(case, "run") {
                let run = run.as_str().expect("a file and a function");
                let (path, function) = run.split_once(' ').expect("a file and a function");
                let source = sources
                    .entry(path.to_string())
                    .or_insert_with(|| Source::read(path).expect("the shader is there"));
                if name == "gl" && source.language == Language::Wgsl {
                    continue;
                }
                let request = Request {
                    function: function.to_string(),
                    arguments: list(case, "args").to_vec(),
                    data: case["data"].as_object().cloned().unwrap_or_default(),
                    ..Request::default()
                };
                let report = call(source, &Options::default(), &request, Some(&mut *backend));
                let why = match report {
                    Ok(report) => misfit(&case["expect"], name, &report),
                    Err(refusal) => Some(format!("{:?}", refusal.found)),
                };
                calls += 1;
                if let Some(why) = why {
                    let said = text(case, "why");
                    wrong.push(format!("{id}, {run}, {name} ({said}): {why}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {calls} calls:\n{}", wrong.len(), wrong.join("\n"));
    calls
}

fn by(name: &str, least: usize) {
    let least = if everything() || name == "cpu" { least } else { least / 10 };
    with_readers(|backends| {
        let backend = backends.iter_mut().find(|backend| backend.device().backend.name() == name);
        let calls = classified(&mut **backend.expect("every backend is there"));
        assert!(calls >= least, "{calls} calls");
    });
}

#[test]
fn the_evaluator_classifies_every_hazard() {
    by("cpu", 400);
}

#[test]
fn opengl_is_held_to_every_hazard() {
    by("gl", 200);
}

#[test]
fn vulkan_is_held_to_every_hazard() {
    by("gpu", 400);
}
