//! Reports as JSON, one line per finding.

use serde::Serialize;

use landfall_layout::finding::Finding;
pub use landfall_layout::format::json::Tool;

/// Version of the JSON report; a change that could break a reader raises it.
pub const REPORT_VERSION: u32 = 1;

/// The output of `check --format json`.
#[cfg(feature = "schema")]
#[derive(schemars::JsonSchema)]
#[schemars(extend("additionalProperties" = true))]
#[expect(dead_code, reason = "findings are written one by one")]
struct CheckDocument<'a> {
    #[schemars(extend("const" = REPORT_VERSION))]
    schema_version: u32,
    tool: Tool,
    /// Shaders that were checked.
    shaders: usize,
    findings: Vec<landfall_layout::finding::FindingObject<'a>>,
}

/// The schema of [`CHECK_SCHEMA`](super::CHECK_SCHEMA).
#[cfg(feature = "schema")]
pub fn schema() -> String {
    landfall_layout::schema::text::<CheckDocument<'_>>("A landfall report")
}

pub(super) fn report(findings: &[&Finding], shaders: usize) -> String {
    let lines: Vec<String> = findings.iter().map(|f| format!("\n  {}", finding(f))).collect();
    let end = if lines.is_empty() { "" } else { "\n" };
    format!(
        "{{\"schema_version\":{REPORT_VERSION},\"tool\":{},\"shaders\":{shaders},\"findings\":[{}{end}]}}\n",
        compact(&Tool::LANDFALL),
        lines.join(",")
    )
}

/// A finding in one line.
pub(super) fn finding(finding: &Finding) -> String {
    compact(finding)
}

fn compact<T: Serialize>(value: &T) -> String {
    serde_json::to_string(value).expect("keys are strings")
}
