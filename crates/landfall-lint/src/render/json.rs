//! Reports as JSON, one line per finding, written and parsed for `merge`.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use landfall_layout::error::Error;
use landfall_layout::finding::Finding;
pub use landfall_layout::format::json::Tool;

/// Version of the JSON report; a change that could break a reader raises it.
pub const REPORT_VERSION: u32 = 1;

/// A JSON report that was read.
#[derive(Clone, Debug)]
pub struct ReadReport {
    /// Shaders that were checked.
    pub shaders: usize,
    /// Its findings, in their order.
    pub findings: Vec<Finding>,
    /// The rest of the report, without its findings: the data that a shard leaves for `merge`.
    pub document: Value,
}

#[derive(Deserialize)]
struct Findings {
    findings: Vec<Finding>,
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

pub(super) fn read(path: &str, text: &str) -> Result<ReadReport, Error> {
    let again = "run `landfall check --format json` again";
    let fail = |message: String| Error::new(path, message).with_help(again);
    let mut document: Value =
        serde_json::from_str(text).map_err(|cause| match cause.classify() {
            serde_json::error::Category::Eof if text.trim().is_empty() => {
                fail("is empty".to_string())
            }
            serde_json::error::Category::Eof => {
                fail(format!("is cut off: its JSON ends in the middle of line {}", cause.line()))
            }
            serde_json::error::Category::Syntax
            | serde_json::error::Category::Data
            | serde_json::error::Category::Io => fail(format!("is not JSON: {cause}")),
        })?;
    let Value::Object(object) = &mut document else {
        return Err(fail(format!("is not a report: it holds {}", kind(&document))));
    };
    let version = match object.get("schema_version") {
        None => return Err(fail("is not a report: it has no `schema_version`".to_string())),
        Some(version) => version.as_u64().ok_or_else(|| {
            fail(format!("is not a report: `schema_version` is {}", kind(version)))
        })?,
    };
    if version > u64::from(REPORT_VERSION) {
        let message = format!(
            "has schema version {version}; this landfall ({}) reads up to {REPORT_VERSION}",
            env!("CARGO_PKG_VERSION")
        );
        return Err(Error::new(path, message).with_help(
            "use the version of landfall that wrote it, or write it again with this one",
        ));
    }
    let shaders = match object.get("shaders") {
        Some(Value::Number(number)) => number.as_u64().and_then(|n| usize::try_from(n).ok()),
        Some(_) | None => None,
    };
    let shaders = shaders.ok_or_else(|| {
        let has = object.get("shaders").map_or("nothing", kind);
        fail(format!("is not a report: `shaders` is a number, and here it is {has}"))
    })?;
    match object.get_mut("findings") {
        Some(Value::Array(list)) => list.clear(),
        other => {
            let has = other.map_or("nothing", |other| kind(other));
            return Err(fail(format!(
                "is not a report: `findings` is an array, and here it is {has}"
            )));
        }
    }
    // Read from the text again, so that errors have a line and a column.
    let Findings { findings } = serde_json::from_str(text)
        .map_err(|cause| fail(format!("is not a report: its findings: {cause}")))?;
    Ok(ReadReport { shaders, findings, document })
}

/// The name of a JSON value's type, for messages.
fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "a bool",
        Value::Number(_) => "another number",
        Value::String(_) => "a string",
        Value::Array(_) => "an array",
        Value::Object(_) => "an object",
    }
}
