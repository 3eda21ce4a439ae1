//! A report as JSON keeps to its schema and comes back as it was.

use crate::support::command::golden;
use landfall_lint::render::CHECK_SCHEMA;
use landfall_lint::render::{ReportFormat, read_json, read_report};
use serde_json::Value;
use snapbox::str;

use crate::findings::{plain, sample};

#[test]
fn reports_keep_to_their_schema() {
    let schema: Value = serde_json::from_str(CHECK_SCHEMA).expect("a schema is JSON");
    jsonschema::meta::validate(&schema).expect("a schema is a schema");
    let validator = jsonschema::validator_for(&schema).expect("a schema can be used");
    for findings in [sample::findings(), sample::hostile(), Vec::new()] {
        let text = plain(&findings, ReportFormat::Json);
        let value: Value = serde_json::from_str(&text).expect("a report is JSON");
        let errors: Vec<String> = validator.iter_errors(&value).map(|e| e.to_string()).collect();
        assert!(errors.is_empty(), "{}", errors.join("\n"));
        assert_eq!(value["findings"].as_array().map(Vec::len), Some(findings.len()));
    }
    let mut bad: Value =
        serde_json::from_str(&plain(&sample::findings(), ReportFormat::Json)).unwrap();
    bad["findings"][0]["level"] = "allow".into();
    assert!(!validator.is_valid(&bad));
}

#[test]
fn a_report_comes_back_as_it_was() {
    for findings in [sample::findings(), sample::hostile(), Vec::new()] {
        let text = plain(&findings, ReportFormat::Json);
        assert_eq!(text.lines().count(), findings.len() + if findings.is_empty() { 1 } else { 2 });
        assert_eq!(read_json("report.json", &text).expect("written just now"), findings);
    }
    let more = plain(&[], ReportFormat::Json).replace("\"shaders\"", "\"blocks\":[1],\"shaders\"");
    let report = read_report("report.json", &more).expect("a report may hold more");
    assert_eq!((report.shaders, &report.document["blocks"][0]), (65, &1.into()));
}

#[test]
fn what_is_no_report_is_refused_with_the_reason() {
    let good = plain(&sample::findings(), ReportFormat::Json);
    let said = |text: &str| {
        let error = read_json("a.json", text).expect_err("this is no report");
        assert_eq!(error.path, "a.json");
        assert!(error.help.is_some());
        error.message
    };
    assert_eq!(said(""), "is empty");
    assert_eq!(said(&good[..300]), "is cut off: its JSON ends in the middle of line 2");
    assert_eq!(said("[]"), "is not a report: it holds an array");
    assert_eq!(said("{}"), "is not a report: it has no `schema_version`");
    assert_eq!(said("{\"schema_version\":\"1\"}"), "is not a report: `schema_version` is a string");
    assert_eq!(
        said(&good.replace("\"schema_version\":1", "\"schema_version\":2")),
        format!(
            "has schema version 2; this landfall ({}) reads up to 1",
            env!("CARGO_PKG_VERSION")
        )
    );
    assert_eq!(
        said(&good.replace("\"shaders\":65", "\"shaders\":null")),
        "is not a report: `shaders` is a number, and here it is null"
    );
    assert_eq!(
        said("{\"schema_version\":1,\"shaders\":1}"),
        "is not a report: `findings` is an array, and here it is nothing"
    );
    let bad = good.replace("\"level\":\"deny\"", "\"level\":\"fatal\"");
    let line = bad.lines().position(|line| line.contains("fatal")).expect("it denies");
    let column = bad.lines().nth(line).and_then(|line| line.find("\"fatal\"")).expect("there");
    assert_eq!(
        said(&bad),
        format!(
            "is not a report: its findings: unknown variant `fatal`, expected one of `allow`, \
             `warn`, `deny` at line {} column {}",
            line + 1,
            column + "\"fatal\"".len()
        )
    );
    golden().eq(
        said(&format!("<<<<<<< HEAD\n{good}")),
        str!["is not JSON: expected value at line 1 column 1"],
    );
    golden().eq(said("\u{0}\u{1}binary"), str!["is not JSON: expected value at line 1 column 1"]);
    golden().eq(
        said(&"[".repeat(10_000_000)),
        str!["is not JSON: recursion limit exceeded at line 1 column 128"],
    );
}

/// A report cut anywhere is refused, or is all of it.
#[test]
fn no_cut_passes_for_a_report() {
    let good = plain(&sample::findings(), ReportFormat::Json);
    for end in (0..good.trim_end().len()).filter(|&end| good.is_char_boundary(end)) {
        assert!(read_json("a.json", &good[..end]).is_err(), "{end} bytes");
    }
}
