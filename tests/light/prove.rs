//! Proofs: functions with a known singular set are found to break at their lines, their mended twins
//! are shown not to; no value lies outside of its bounds.

mod bounds;
mod command;
mod device;
mod devices;
mod expression;
mod functions;
mod programs;
mod soundness;

use std::time::Duration;

use landfall_accuracy::demand::{ProveReport, ProveRequest, prove};
use landfall_accuracy::prove::Class;
use landfall_accuracy::stress::{Operation, OperationVerdict as Verdict};
use landfall_exec::harness::call::pure::PureRequest;
use landfall_layout::{Options, Source};

/// A fragment shader with a function.
fn fragment(code: &str) -> Source {
    Source::new("f.frag", format!("#version 450\n{code}\nvoid main() {{}}\n"))
}

/// Asks about the function `f`.
fn request(domain: &str) -> ProveRequest {
    ProveRequest {
        pure: PureRequest { function: "f".to_string(), ..PureRequest::default() },
        domain: Some(serde_json::from_str(domain).expect("the test's domain is JSON")),
        time: Duration::from_secs(600),
        parts: 1 << 15,
        ..ProveRequest::default()
    }
}

/// Proves the function `f`, by a number of parts that is the same on every machine.
fn run(code: &str, domain: &str) -> ProveReport {
    prove(&fragment(code), &Options::default(), &request(domain))
        .unwrap_or_else(|refusal| panic!("{code}: {:?}", refusal.found))
}

#[test]
fn threads_change_nothing() {
    for known in functions::all() {
        let [one, three] = [1, 3].map(|threads| {
            let request = ProveRequest { threads, parts: 1 << 10, ..request(known.domain) };
            let report = prove(&fragment(known.code), &Options::default(), &request);
            report.unwrap_or_else(|refusal| panic!("{}: {:?}", known.name, refusal.found))
        });
        assert_eq!(one.parts, three.parts, "{}", known.name);
        let [one, three] = [one, three].map(|report| format!("{:?}", report.operations));
        assert_eq!(one, three, "{}", known.name);
    }
}

/// The lines and faults found, without numbers out of range.
fn found(report: &ProveReport) -> Vec<(u32, &'static str)> {
    let is_found = |verdict: &Verdict| matches!(verdict, Verdict::Found(_));
    let broken = report.operations.iter().filter(|operation| is_found(&operation.known));
    let line = |operation: &Operation| {
        (report.files.locate(operation.place.span).line, operation.fault.text())
    };
    let mut all: Vec<_> = broken.map(line).collect();
    all.dedup();
    all
}

#[test]
fn known_singular_sets_are_found_at_their_lines() {
    assert!(functions::all().count() >= 60);
    for known in functions::all() {
        let report = run(known.code, known.domain);
        let found = found(&report);
        for (number, line) in known.code.lines().enumerate() {
            let Some((_, fault)) = line.split_once("// ") else { continue };
            // After the line of the version.
            let expected = (number as u32 + 2, fault);
            assert!(found.contains(&expected), "{}: {expected:?} is not in {found:?}", known.name);
        }
    }
}

#[test]
fn mended_twins_are_shown_not_to_break() {
    for known in functions::all() {
        let report = run(known.twin, known.domain);
        let undefined = |class: Class| matches!(class, Class::Undefined | Class::Accuracy);
        for operation in report.operations.iter().filter(|o| undefined(o.class())) {
            let line = report.files.locate(operation.place.span).line;
            let what = format!("{}: line {line}: {}", known.name, operation.fault);
            assert!(!matches!(operation.known, Verdict::Found(_)), "{what}: {:?}", operation.known);
            if operation.class() == Class::Undefined {
                assert!(
                    matches!(operation.known, Verdict::Absent),
                    "{what}: {:?}",
                    operation.known
                );
            }
        }
    }
}

#[test]
fn an_input_that_is_found_breaks_the_function_when_it_is_run() {
    let report = run("float f(vec3 d) {\n    return 1.0 / d.x;\n}", r#"{"d": "unit"}"#);
    let Verdict::Found(case) = &report.operations[0].known else {
        panic!("{:?}", report.operations[0].known);
    };
    assert!(case.results[0].single.is_infinite(), "{case:?}");
}

#[test]
fn a_branch_excludes_what_it_tests() {
    let guarded = "float f(float a, float b) {
    if (a * a - b < 0.0) return -1.0;
    return a - sqrt(a * a - b);
}";
    let report = run(guarded, r#"{"a": [-10, 10], "b": [-10, 10]}"#);
    let root = report.operations.iter().find(|o| o.fault.text() == "root of a negative number");
    assert!(matches!(root.map(|root| &root.known), Some(Verdict::Absent)), "{root:?}");
}

/// The absolute value of a divisor is known to be above zero only once it is computed.
#[test]
fn an_absolute_value_after_a_division_is_read() {
    let after = "float f(float x, float y) {\n    return x / y + abs(y);\n}";
    let report = run(after, r#"{"x": [1, 2], "y": [-1, 1]}"#);
    assert_eq!(found(&report), [(3, "division by zero")]);
}

#[test]
fn loops_are_followed_up_to_their_bound() {
    let summed = "float f(int n, float x) {
    float sum = 1.0;
    for (int i = 0; i < n; i++) {
        sum += x * float(i);
    }
    return 1.0 / sum;
}";
    let report = run(summed, r#"{"n": [0, 12], "x": [0, 1]}"#);
    assert!(report.operations.iter().all(|o| !matches!(o.known, Verdict::Found(_))));
    let division = report.operations.iter().find(|o| o.fault.text() == "division by zero");
    assert!(matches!(division.map(|d| &d.known), Some(Verdict::Absent)), "{division:?}");
    // More iterations than the 256 that are followed are not called proved.
    let report = run(summed, r#"{"n": [0, 300], "x": [0, 1]}"#);
    let left = report.operations.iter().find(|o| o.fault.text() == "loop of many iterations");
    assert!(matches!(left.map(|left| &left.known), Some(Verdict::Open(_))), "{left:?}");
}
