//! A finding can be had again: the same numbers for a seed, and the command it prints.

use std::time::Duration;

use landfall_accuracy::stress::{Outcome, Report};
use landfall_layout::format as emit;
use snapbox::str;

use super::{request, run, shader};
use crate::support::command::{self, golden};
use crate::support::sample::sampled;

#[test]
fn one_seed_gives_one_report() {
    let path = "shaders/seed/caster_spot_soft_330.frag";
    let mut request = request("cone");
    request.samples = 8_000;
    request.time = None;
    let reports = [1, 1, 2].map(|seed| {
        request.seed = seed;
        let report = run(&shader(path), &request);
        let found: Vec<_> = report
            .findings
            .iter()
            .map(|found| (found.hazard.code(), found.case.inputs.clone()))
            .collect();
        (report.total.samples, report.total.ulp.max, found)
    });
    assert_eq!(reports[0], reports[1]);
    assert_ne!(reports[0].2, reports[2].2);
}

/// The report in JSON, without what it took.
fn without_time(report: &Report) -> serde_json::Value {
    let json = landfall::report::stress::json(report);
    let mut json: serde_json::Value = serde_json::from_str(&json).expect("it is JSON");
    let all = json.as_object_mut().expect("it is an object");
    for key in ["seconds", "threads", "samples_per_second"] {
        assert!(all.remove(key).is_some(), "{key}");
    }
    json
}

#[test]
fn threads_change_nothing() {
    let functions = [
        ("shaders/seed/caster_spot_soft_330.frag", "attenuation"),
        ("shaders/seed/caster_spot_soft_330.frag", "cone"),
        ("shaders/six_lights/phong_450.frag", "CalcPointLight"),
    ];
    for &(path, function) in sampled(&functions, 3) {
        let mut request = request(function);
        request.samples = 6_000;
        request.time = None;
        let [one, two, five] = [1, 2, 5].map(|threads| {
            request.threads = threads;
            run(&shader(path), &request)
        });
        assert!(!one.operations.is_empty(), "{function}");
        assert_eq!(without_time(&one), without_time(&two), "{function}");
        assert_eq!(without_time(&one), without_time(&five), "{function}");
    }
}

#[test]
#[cfg(feature = "cli")]
fn the_command_of_a_finding_gives_the_same_bits() {
    let path = "shaders/seed/six_lights_330.frag";
    let mut request = request("CalcSpotLight");
    request.samples = 20_000;
    let report = run(&shader(path), &request);
    assert!(report.findings.len() > 5);
    for found in &report.findings {
        let arguments: Vec<&str> = found.case.arguments.iter().map(String::as_str).collect();
        let ran = command::run(&[&arguments[..], &["--format", "json"]].concat());
        let json = ran.code(0).json();
        let scalars = json["result"]["scalars"].as_array().expect("it has a result");
        assert_eq!(scalars.len(), found.case.results.len());
        for (scalar, result) in scalars.iter().zip(&found.case.results) {
            let value = &scalar["value"];
            let got = match value.as_str() {
                Some(text) if text.contains("nan") => f32::NAN,
                Some("inf") => f32::INFINITY,
                Some("-inf") => f32::NEG_INFINITY,
                _ => value.as_f64().expect("it is a number") as f32,
            };
            let same =
                got.to_bits() == result.single.to_bits() || got.is_nan() && result.single.is_nan();
            assert!(same, "{}: {got} is not {}", found.hazard.code(), result.single);
        }
    }
}

#[test]
fn what_is_found_is_written_for_people_programs_and_tools() {
    let path = "shaders/seed/six_lights_330.frag";
    let mut request = request("attenuation");
    request.samples = 8_000;
    // Time enough on a busy machine, so that the samples are the same in every run.
    request.time = Some(Duration::from_secs(300));
    let report = run(&shader(path), &request);
    let text = landfall::report::stress::text(
        &report,
        landfall::report::prove::Listed::All,
        emit::Paint::Plain,
    );
    golden().eq(
        text.split_once(" in ").expect("it has a time").0,
        str![[r#"
attenuation(float, float, float, float)  shaders/seed/six_lights_330.frag
  37,862 samples
"#]],
    );
    let found = text.find("[attenuation-unset]").map(|at| text[at..].split("\n\n").next());
    golden().eq(found.flatten().unwrap_or(&text), str![[r#"
[attenuation-unset]: an attenuation whose coefficients were never set divides by zero: the result is infinite
  --> shaders/seed/six_lights_330.frag:91:12
   |
91 |     return 1.0 / (constant + linear * d + quadratic * (d * d));
   |            ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ divide(1, 0) = inf
   |
   = note: with all inputs zero
   = note: comes from constant = 0, linear = 0, quadratic = 0
   = note: to reproduce: landfall run shaders/seed/six_lights_330.frag --fn 'attenuation(float, float, float, float)' --args '[0.0,0.0,0.0,0.0]'
   = help: write `1.0 / max(constant + linear * d + quadratic * (d * d), 0.0001)` instead of `1.0 / (constant + linear * d + quadratic * (d * d))` (guard: defined in all of 254 samples, and no other result changes)
"#]]);
    let sarif: serde_json::Value =
        serde_json::from_str(&landfall::report::stress::sarif(&report)).expect("SARIF is JSON");
    let results = sarif["runs"][0]["results"].as_array().expect("it has results");
    assert!(results.iter().any(|result| result["ruleId"] == "attenuation-unset"));
    let json: serde_json::Value =
        serde_json::from_str(&landfall::report::stress::json(&report)).expect("it is JSON");
    assert_eq!(json["findings"].as_array().map(Vec::len), Some(report.findings.len()));
    let finite = report.findings.iter().any(|found| matches!(found.outcome, Outcome::Finite(..)));
    assert!(finite || report.has_non_finite());
}
