//! Advice is code that was measured: forms that the literature gives are found, what no form mends
//! has none.

use landfall_accuracy::stress::{Advice, Report};
use landfall_layout::Source;

use super::{all, domain, request, run};

fn report(source: &Source, json: &str) -> Report {
    let mut request = request("f");
    request.domain = domain(json);
    request.ulp = Some(1024.0);
    run(source, &request)
}

fn fragment(code: &str) -> Source {
    Source::new("f.frag", format!("#version 450\n{code}\nvoid main() {{}}\n"))
}

/// The advice for a function.
fn advice(source: &Source, json: &str) -> Advice {
    let report = report(source, json);
    let found = report.findings.iter().find_map(|found| found.advice.clone());
    found.unwrap_or_else(|| panic!("no advice:\n{}", all(&report)))
}

#[test]
fn a_form_of_the_catalogue_is_printed_with_its_measured_gain() {
    let cases = [
        (
            "float f(float x) {\n    return x - sqrt(x * x - 1.0);\n}",
            r#"{"x": [1, 10000]}"#,
            "1.0 / (x + sqrt(x * x - 1.0))",
        ),
        (
            "float f(float x) {\n    return 1.0 - cos(x);\n}",
            r#"{"x": [0.00001, 1]}"#,
            "2.0 * sin(0.5 * x) * sin(0.5 * x)",
        ),
        (
            "float f(float a, float b, float c) {
    float d = sqrt(b * b - 4.0 * a * c);
    return (-b + d) / (2.0 * a);
}",
            r#"{"a": [0.5, 2], "b": [1, 1000], "c": [0.0001, 0.1]}"#,
            "4.0 * a * c / (-b - d)",
        ),
        (
            "float f(float n, float a) {
    float a2 = a * a;
    return n * n * (a2 - 1.0) + 1.0;
}",
            r#"{"n": [0.9, 1], "a": [0.0001, 1]}"#,
            "(1.0 - n) * (1.0 + n) + n * n * a * a",
        ),
        (
            "float f(float x) {\n    return exp(x) - 1.0;\n}",
            r#"{"x": [0.000001, 1]}"#,
            "(abs(x) < 0.1 ? ",
        ),
    ];
    for (code, json, form) in cases {
        let advice = advice(&fragment(code), json);
        println!("{}", advice.text());
        assert!(advice.code.starts_with(form), "{code}: {}", advice.code);
        let before = advice.ulp_before.expect("its result is defined");
        assert!(advice.ulp_after < 16.0 && before > 1000.0, "{}", advice.text());
        let notes = report(&fragment(code), json).findings[0].notes().join("\n");
        assert!(!notes.contains("ill-conditioned"), "{notes}");
    }
}

#[test]
fn advice_for_wgsl_is_wgsl() {
    let code = "fn f(x: f32) -> f32 {\n    return exp(x) - 1.0;\n}\n";
    let advice = advice(&Source::new("f.wgsl", code), r#"{"x": [0.000001, 1]}"#);
    assert!(advice.code.starts_with("select("), "{}", advice.code);
}

/// The form is taken as it is printed: the function with it is as accurate as was said.
#[test]
fn the_form_put_into_the_shader_mends_it() {
    let code = "float f(float x) {\n    return sqrt(x + 1.0) - sqrt(x);\n}";
    let json = r#"{"x": [1, 1000000]}"#;
    let advice = advice(&fragment(code), json);
    let mended = fragment(&code.replace(&advice.before, &advice.code));
    let most = report(&mended, json).total.ulp.max;
    assert!(most < 4.0, "{}: {most} ULP", advice.code);
}

#[test]
fn a_clamp_that_changes_nothing_else_is_advised_for_what_is_undefined() {
    // Of a unit vector the difference is 0, but for rounding.
    let code = "float f(vec3 n) {\n    return sqrt(1.0 - dot(n, n));\n}";
    let advice = advice(&fragment(code), r#"{"n": "unit"}"#);
    assert_eq!((&*advice.code, advice.ulp_before), ("sqrt(max(1.0 - dot(n, n), 0.0))", None));
}

#[test]
fn what_no_form_mends_has_no_advice() {
    // Near a zero the difference is ill-conditioned: its digits are not in the inputs.
    let code = "float f(float x, float y) {\n    return sin(x) - y;\n}";
    let report = report(&fragment(code), r#"{"x": [0.5, 0.6], "y": [0.48, 0.56]}"#);
    assert!(!report.findings.is_empty());
    for found in &report.findings {
        assert_eq!(found.advice, None, "{}", found.message());
        let notes = found.notes().join("\n");
        assert!(!notes.contains("the formula is unstable"), "{notes}");
    }
}
