//! SARIF 2.1.0, as GitHub's code scanning and editors read it.
//!
//! Lines and columns count from 1, columns in characters, as findings have them.

mod uri;

use serde_json::{Map, Value, json};

use super::{severity, stable};
use crate::definition::Lint;
use crate::registry::LINTS;
use landfall_layout::finding::{Edit, Finding, Level, Place};
pub use landfall_layout::format::json::to_lines;

const SCHEMA: &str =
    "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json";

/// The name and version of the fingerprints; a change of their input needs another version.
const FINGERPRINT: &str = "landfall/v1";

pub(super) fn report(findings: &[&Finding], shaders: usize) -> String {
    let rules = SarifRules::from_findings(findings);
    let numbers = stable::numbers(findings);
    let results: Vec<Value> = findings
        .iter()
        .zip(numbers)
        .map(|(finding, number)| result(finding, number, &rules))
        .collect();
    let log = json!({
        "$schema": SCHEMA,
        "version": "2.1.0",
        "runs": [{
            "tool": {"driver": {
                "name": landfall_layout::format::NAME,
                "version": env!("CARGO_PKG_VERSION"),
                "semanticVersion": env!("CARGO_PKG_VERSION"),
                "shortDescription": static_message(landfall_layout::format::DESCRIPTION),
                "rules": rules.objects(),
            }},
            "columnKind": "unicodeCodePoints",
            "properties": {"shaders": shaders},
            "results": results,
        }],
    });
    to_lines(&log) + "\n"
}

/// The rules: all lints, then the other codes of findings.
struct SarifRules<'a> {
    others: Vec<&'a str>,
}

impl<'a> SarifRules<'a> {
    fn from_findings(findings: &[&'a Finding]) -> SarifRules<'a> {
        // Errors of parsing and layout are no lints.
        let mut others: Vec<&str> = findings
            .iter()
            .map(|finding| finding.code.as_str())
            .filter(|code| LINTS.iter().all(|lint| lint.code != *code))
            .collect();
        others.sort_unstable();
        others.dedup();
        SarifRules { others }
    }

    fn index(&self, code: &str) -> usize {
        LINTS.iter().position(|lint| lint.code == code).unwrap_or_else(|| {
            let other = self.others.binary_search(&code);
            LINTS.len() + other.expect("every code that is no lint's was gathered")
        })
    }

    fn objects(&self) -> Vec<Value> {
        let others = self.others.iter().map(|code| json!({"id": code}));
        LINTS.iter().map(|lint| rule(lint)).chain(others).collect()
    }
}

fn rule(lint: &Lint) -> Value {
    let example = lint.example.trim_end();
    json!({
        "id": lint.code,
        "shortDescription": static_message(lint.what),
        "fullDescription": static_message(format!("{}. {}", lint.what, lint.why).trim()),
        "help": {
            "text": format!("{}\n\n{}\n\nExample:\n\n{example}", lint.why, lint.fix),
            "markdown": format!("{}\n\n{}\n\n```\n{example}\n```", lint.why, lint.fix),
        },
        "defaultConfiguration": {
            "enabled": lint.level != Level::Allow,
            "level": severity(lint.level),
        },
    })
}

fn result(finding: &Finding, number: u32, rules: &SarifRules<'_>) -> Value {
    let mut object = Map::new();
    let mut put = |key: &str, value: Value| object.insert(key.to_string(), value);
    put("ruleId", finding.code.as_str().into());
    put("ruleIndex", rules.index(&finding.code).into());
    put("level", severity(finding.level()).into());
    put("message", message(&words(finding)));
    put("locations", json!([{"physicalLocation": physical(finding.place())}]));
    if !finding.related().is_empty() {
        let related = finding.related().iter().enumerate().map(|(i, related)| {
            let mut location = json!({"id": i + 1, "physicalLocation": physical(&related.at)});
            if !related.text.is_empty() {
                location["message"] = message(&related.text);
            }
            location
        });
        put("relatedLocations", related.collect());
    }
    put("partialFingerprints", json!({FINGERPRINT: stable::fingerprint(finding, number)}));
    // A region needs a line; `--fix` does not apply edits without one either.
    if !finding.fix.is_empty() && finding.fix.iter().all(|edit| edit.at.line > 0) {
        put("fixes", json!([fix(finding)]));
    }
    Value::Object(object)
}

/// Returns the message with notes and help, since viewers show nothing else.
fn words(finding: &Finding) -> String {
    let mut lines = vec![finding.message.clone()];
    lines.extend(finding.notes.iter().map(|note| format!("note: {note}")));
    lines.extend(finding.help.iter().map(|help| format!("help: {help}")));
    lines.join("\n")
}

/// Returns a message object, in whose text braces are doubled (section 3.11.5).
fn message(text: &str) -> Value {
    json!({"text": text.replace('{', "{{").replace('}', "}}")})
}

/// Returns a message object without placeholders, as in rules.
fn static_message(text: &str) -> Value {
    json!({"text": text})
}

fn physical(place: &Place) -> Value {
    let mut location = json!({"artifactLocation": artifact(&place.path)});
    if place.line > 0 {
        location["region"] = region(place);
    }
    location
}

fn artifact(path: &str) -> Value {
    match uri::from_path(path) {
        uri::Uri::Relative(uri) => json!({"uri": uri, "uriBaseId": "%SRCROOT%"}),
        uri::Uri::Absolute(uri) => json!({"uri": uri}),
    }
}

fn region(place: &Place) -> Value {
    // SARIF counts from 1; a place without a column has 0.
    let mut region = json!({
        "startLine": place.line,
        "startColumn": place.column.max(1),
        "endLine": place.end_line.max(place.line),
        "endColumn": place.end_column.max(1),
    });
    // Bytes are zero where only line and column are known.
    if place.end > 0 {
        region["byteOffset"] = place.start.into();
        region["byteLength"] = place.end.saturating_sub(place.start).into();
    }
    region
}

fn fix(finding: &Finding) -> Value {
    let mut changes: Vec<(&str, Vec<Value>)> = Vec::new();
    for edit in &finding.fix {
        let path = edit.at.path.as_str();
        match changes.iter_mut().find(|(known, _)| *known == path) {
            Some((_, replacements)) => replacements.push(replacement(edit)),
            None => changes.push((path, vec![replacement(edit)])),
        }
    }
    let changes: Vec<Value> = changes
        .into_iter()
        .map(|(path, replacements)| {
            json!({"artifactLocation": artifact(path), "replacements": replacements})
        })
        .collect();
    let mut fix = json!({"artifactChanges": changes});
    if let Some(help) = &finding.help {
        fix["description"] = message(help);
    }
    fix
}

fn replacement(edit: &Edit) -> Value {
    let mut replacement = json!({"deletedRegion": region(&edit.at)});
    if !edit.new.is_empty() {
        replacement["insertedContent"] = json!({"text": edit.new});
    }
    replacement
}
