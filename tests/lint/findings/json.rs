//! A report as JSON keeps to its schema and comes back as it was.

use landfall_layout::finding::Finding;
use landfall_lint::render::{CHECK_SCHEMA, ReportFormat};
use serde_json::Value;

use crate::findings::{plain, sample};
use crate::support::schema;

#[test]
fn reports_keep_to_their_schema() {
    let validator = schema::validator(CHECK_SCHEMA);
    for findings in [sample::findings(), sample::hostile(), Vec::new()] {
        let text = plain(&findings, ReportFormat::Json);
        let value = schema::holds(&validator, &text, "a report");
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
        let mut report: Value = serde_json::from_str(&text).expect("a report is JSON");
        let read: Vec<Finding> =
            serde_json::from_value(report["findings"].take()).expect("written just now");
        assert_eq!(read, findings);
    }
}
