//! SARIF keeps to the schema OASIS published, and says what the findings say.

use std::path::Path;
use std::process::Command;

use landfall_layout::finding::{Finding, Place};
use landfall_lint::LINTS;
use landfall_lint::render::ReportFormat;
use serde_json::Value;

use crate::findings::{plain, sample};

/// The schema of the standard; cargo fetches the crate that ships it.
fn schema() -> Value {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/sarif/Cargo.toml");
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--format-version", "1", "--manifest-path"])
        .arg(manifest)
        .output()
        .expect("cargo runs this test");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("metadata is JSON");
    let packages = metadata["packages"].as_array().expect("packages are listed");
    let package = packages.iter().find(|package| package["name"] == "serde-sarif");
    let manifest = package.and_then(|package| package["manifest_path"].as_str());
    let folder = Path::new(manifest.expect("the fixture needs it")).parent().expect("a folder");
    let text =
        std::fs::read_to_string(folder.join("src/schema.json")).expect("it ships the schema");
    let mut schema: Value = serde_json::from_str(&text).expect("a schema is JSON");
    // The stray `]` in two patterns, mended by errata 01, is no regex to everybody.
    for of in ["run", "toolComponent"] {
        let pattern = &mut schema["definitions"][of]["properties"]["language"]["pattern"];
        assert_eq!(*pattern, "^[a-zA-Z]{2}|^[a-zA-Z]{2}-[a-zA-Z]{2}]?$");
        *pattern = "^[a-zA-Z]{2}(-[a-zA-Z]{2})?$".into();
    }
    schema
}

fn sarif(findings: &[Finding]) -> Value {
    serde_json::from_str(&plain(findings, ReportFormat::Sarif)).expect("SARIF is JSON")
}

#[test]
fn reports_keep_to_the_schema_of_the_standard() {
    let schema = schema();
    assert_eq!(schema["title"], "Static Analysis Results Format (SARIF) Version 2.1.0 JSON Schema");
    let id = schema["$id"].as_str().expect("it has a name");
    assert!(id.contains("/oasis-tcs/sarif-spec/"), "{id}");
    let validator = jsonschema::validator_for(&schema).expect("a schema can be used");
    for findings in [sample::findings(), sample::hostile(), Vec::new()] {
        let value = sarif(&findings);
        let errors: Vec<String> = validator
            .iter_errors(&value)
            .map(|error| format!("{}: {error}", error.instance_path()))
            .collect();
        assert!(errors.is_empty(), "{}", errors.join("\n"));
        assert_eq!(value["runs"][0]["results"].as_array().map(Vec::len), Some(findings.len()));
    }
    let mut bad = sarif(&sample::findings());
    bad["runs"][0]["results"][0]["level"] = "deny".into();
    assert!(!validator.is_valid(&bad));
}

#[test]
fn a_result_has_its_rule_its_place_the_other_copy_and_the_fix() {
    let mut findings = sample::findings();
    findings.push(Finding::at("syntax", "", Place::file("a.frag"), "not a lint"));
    let value = sarif(&findings);
    let run = &value["runs"][0];
    let rules = run["tool"]["driver"]["rules"].as_array().expect("rules");
    assert_eq!(rules.len(), LINTS.len() + 1);
    for (result, finding) in run["results"].as_array().expect("results").iter().zip(&findings) {
        assert_eq!(result["ruleId"], *finding.code);
        let index = result["ruleIndex"].as_u64().expect("an index") as usize;
        assert_eq!(rules[index]["id"], *finding.code);
    }
    let [stale, mismatch, orphan] = [0, 1, 2].map(|i| &run["results"][i]);
    assert_eq!(stale["level"], "warning");
    assert_eq!(mismatch["level"], "error");
    let region = &stale["locations"][0]["physicalLocation"]["region"];
    let numbers = ["startLine", "startColumn", "endLine", "endColumn", "byteLength"];
    assert_eq!(numbers.map(|name| region[name].as_u64()), [4, 33, 4, 35, 2].map(Some));
    let at = region["byteOffset"].as_u64().expect("a byte") as usize;
    assert_eq!(&sample::LIGHTS[at..at + 2], "12");
    let change = &stale["fixes"][0]["artifactChanges"][0];
    assert_eq!(change["artifactLocation"]["uri"], "shaders/lights.frag");
    assert_eq!(change["replacements"][0]["deletedRegion"], *region);
    assert_eq!(change["replacements"][0]["insertedContent"]["text"], "16");
    let other = &mismatch["relatedLocations"][0];
    assert_eq!(other["physicalLocation"]["artifactLocation"]["uri"], "shaders/copy.vert");
    assert_eq!(other["message"]["text"], "4112 bytes");
    assert_eq!(orphan["locations"][0]["physicalLocation"].get("region"), None);
}

#[test]
fn braces_of_a_message_are_no_placeholders() {
    let place = Place::file("a.frag");
    let finding = Finding::at("x", "", place, "`struct {0} {}` is empty").with_help("fill {1}");
    let value = sarif(&[finding]);
    let text = &value["runs"][0]["results"][0]["message"]["text"];
    assert_eq!(*text, "`struct {{0}} {{}}` is empty\nhelp: fill {{1}}");
}

fn fingerprints(findings: &[Finding]) -> Vec<String> {
    let value = sarif(findings);
    let results = value["runs"][0]["results"].as_array().expect("results").clone();
    let print =
        |result: &Value| result["partialFingerprints"]["landfall/v1"].as_str().map(str::to_string);
    results.iter().map(|result| print(result).expect("a fingerprint")).collect()
}

#[test]
fn fingerprints_stay_when_lines_move_and_tell_findings_apart() {
    let before = sample::findings();
    let mut after = before.clone();
    for finding in &mut after {
        finding.labels[0].at.line += 7;
        finding.labels[0].at.start += 70;
        finding.message = finding.message.replace("6160", "6176");
    }
    assert_eq!(fingerprints(&before), fingerprints(&after));
    let mut twice = before.clone();
    twice.extend(after);
    let mut prints = fingerprints(&twice);
    assert_eq!(prints[..3], fingerprints(&before)[..]);
    prints.sort_unstable();
    prints.dedup();
    assert_eq!(prints.len(), twice.len());
}

/// What anybody's percent-decoder makes of a URI.
fn decoded(uri: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = uri.bytes();
    while let Some(byte) = rest.next() {
        let mut digit = || rest.next().and_then(|b| char::from(b).to_digit(16)).expect("a digit");
        bytes.push(if byte == b'%' { (digit() * 16 + digit()) as u8 } else { byte });
    }
    String::from_utf8(bytes).expect("paths are UTF-8")
}

#[test]
fn uris_are_ascii_and_lead_back_to_the_path() {
    let findings = sample::hostile();
    let value = sarif(&findings);
    for (result, finding) in value["runs"][0]["results"].as_array().unwrap().iter().zip(&findings) {
        let artifact = &result["locations"][0]["physicalLocation"]["artifactLocation"];
        let uri = artifact["uri"].as_str().expect("a URI");
        assert!(uri.bytes().all(|b| b.is_ascii_graphic() && !b"<>\"{}|\\^`".contains(&b)), "{uri}");
        let path = finding.place().path.as_str();
        match artifact.get("uriBaseId") {
            Some(base) => {
                assert_eq!((base.as_str(), decoded(uri).as_str()), (Some("%SRCROOT%"), path))
            }
            None => assert_eq!(decoded(uri), format!("file:///{}", path.trim_start_matches('/'))),
        }
    }
}
