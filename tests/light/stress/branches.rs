//! Branches that `f32` and `f64` take differently, and NaN that is hidden.

use crate::support::command::golden;
use landfall_accuracy::stress::{Outcome, Report};
use landfall_ir::analysis::hazard::Hazard;
use landfall_layout::Source;
use snapbox::str;

use super::{all, domain, line, request, run};

fn report(code: &str, json: &str) -> Report {
    let source = Source::new("branch.frag", format!("#version 450\n{code}\nvoid main() {{}}\n"));
    let mut request = request("f");
    request.domain = domain(json);
    run(&source, &request)
}

/// The range of one `f32`.
fn only(x: f32) -> String {
    format!("[{0:?}, {0:?}]", f64::from(x))
}

#[test]
fn a_comparison_that_rounding_decides_is_a_finding_of_its_own() {
    // 0.1f + 0.2f is below 0.3f in exact arithmetic, and equal to it in f32.
    let report = report(
        "float f(float a, float b, float c) {
    if (a + b >= c) return 1.0;
    return 0.0;
}",
        &format!(r#"{{"a": {0}, "b": {1}, "c": {2}}}"#, only(0.1), only(0.2), only(0.3)),
    );
    let found = report.findings.iter().find(|f| f.hazard == Hazard::BranchDivergence);
    let found = found.unwrap_or_else(|| panic!("{}", all(&report)));
    assert_eq!(line(&report, found).trim(), "if (a + b >= c) return 1.0;");
    // The whole scale: from 0 to 1.
    assert_eq!(found.breach, Some(255.0));
    golden().eq(
        found.label(),
        str!["0.3 >= 0.3 is true in f32, but 0.30000000447034836 >= 0.30000001192092896 is false in f64"],
    );
    // Along the branches of the f32 the result is exact.
    assert!(matches!(found.outcome, Outcome::Finite(off, _) if off.ulp == 0.0), "{found:?}");
}

#[test]
fn a_branch_without_a_jump_is_no_finding() {
    let report = report(
        "float f(float a, float b) {
    if (a * a > b) return a * a;
    return b;
}",
        r#"{"a": [0.5, 2], "b": [0.5, 2]}"#,
    );
    let found = report.findings.iter().find(|f| f.hazard == Hazard::BranchDivergence);
    assert!(found.is_none(), "{}", all(&report));
}

#[test]
fn nan_that_a_maximum_hides_is_a_finding() {
    let code = "float f(float x) {
    float root = sqrt(x);
    return max(0.25, root);
}";
    let report = report(code, r#"{"x": [-1, 1]}"#);
    let hidden = report.findings.iter().any(|found| {
        let kind = found.kind.map(|kind| kind.name());
        kind == Some("root of a negative number") && matches!(found.outcome, Outcome::Finite(..))
    });
    assert!(hidden, "{}", all(&report));
    let operations = report.findings.iter().filter_map(|found| found.operation.as_ref());
    let hides = |name: &str| {
        operations.clone().any(|o| landfall_accuracy::stress::messages::name(o.operation) == name)
    };
    assert!(hides("max"), "{}", all(&report));
}
