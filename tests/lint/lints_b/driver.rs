//! Findings of a report of `verify`.

use landfall_layout::finding::Finding;
use landfall_layout::{Options, Source, layout};
use landfall_lint::driver_disagrees::read;
use snapbox::str;

use crate::lints_b::said;
use crate::support::command::golden;

const SHADER: &str = "\
#version 330 core
uniform Light {
    vec3 color;
    float gain;
} light;
void main() {}
";

/// A read of `leaf`, of a report in the form of `landfall schema verify`.
fn read_of(path: &str, leaf: &str, way: &str, expected: u32, read: &str) -> String {
    format!(
        r#"{{"path":"{path}","leaf":"{leaf}","way":"{way}","expected_byte":{expected},"byte_read":{read}}}"#
    )
}

fn report(reads: &[String], causes: &str) -> String {
    let reads = reads.join(",");
    format!(
        r#"{{"schema_version":1,"tool":{{"name":"landfall","version":"0.1.0"}},"backends":[],
        "shaders":[{{"path":"a.frag","language":"glsl","blocks":[{{"name":"Light",
        "instance":"light","rules":"std140","size":16,"leaves":2,"backends":[{{"backend":"gl",
        "stage":"fragment","form":"original","outcome":"disagrees","reads":[{reads}],
        "causes":[{causes}]}}],"unprobed":[]}}]}}]}}"#
    )
}

fn gain(byte_read: &str) -> String {
    let reads = [
        read_of("color.x", "color", "constant", 0, "0"),
        read_of("gain", "gain", "constant", 12, byte_read),
        read_of("gain", "gain", "copied", 12, byte_read),
    ];
    report(&reads, r#"{"leaf":"gain","cause":"no std140"}"#)
}

fn found(report: &str) -> Vec<Finding> {
    let shader = layout(&Source::new("a.frag", SHADER), &Options::default());
    let report = read("verify.json", report).expect("a report");
    report.findings(&|path| (path == "a.frag").then_some(&shader))
}

#[test]
fn reports_of_these_tests_keep_to_the_schema_of_verify() {
    let schema: serde_json::Value =
        serde_json::from_str(landfall::report::schema::VERIFY_SCHEMA).expect("JSON");
    let report = serde_json::from_str(&gain("16")).expect("JSON");
    jsonschema::validate(&schema, &report).expect("of the form that verify writes");
}

#[test]
fn a_leaf_read_elsewhere_is_reported_once_with_both_bytes_at_its_member() {
    let found = found(&gain("16"));
    assert_eq!(
        found.iter().map(said).collect::<Vec<_>>(),
        ["4:11 `gl` reads `gain` of block `Light` from byte 16 instead of 12"]
    );
    assert!(found[0].notes.contains(&"no std140".to_string()));
    assert_eq!(found[0].notes.len(), 2, "{:?}", found[0].notes);
    assert_eq!(found[0].help.as_deref(), Some("declare `layout(std140)`"));
}

#[test]
fn a_leaf_that_is_no_byte_of_the_block_is_said_so() {
    let found = found(&gain("null"));
    golden().eq(
        &found[0].message,
        str!["`gl` reads `gain` of block `Light` from no byte of the block; it is at 12"],
    );
}

#[test]
fn a_reader_that_agrees_is_no_finding_nor_is_a_shader_that_is_not_checked() {
    assert_eq!(found(&gain("12")), []);
    assert_eq!(found(&gain("16").replace("a.frag", "b.frag")), []);
}

#[test]
fn values_of_one_leaf_are_one_finding() {
    let reads = [
        read_of("color.y", "color", "constant", 4, "8"),
        read_of("color.z", "color", "constant", 8, "12"),
    ];
    let found = found(&report(&reads, ""));
    assert_eq!(found.len(), 1);
    golden().eq(
        &found[0].message,
        str!["`gl` reads `color.y` of block `Light` from byte 8 instead of 4"],
    );
    golden()
        .eq(&found[0].notes[1], str!["1 further value of `color` is read from other bytes too"]);
}

#[test]
fn what_is_no_report_is_refused_with_its_place() {
    let whole = gain("16");
    let cut = read("verify.json", &whole[..whole.len() / 2]).expect_err("cut off");
    golden().eq(
        &cut.message,
        str!["is no report of `landfall verify`: EOF while parsing a string at line 4 column 70"],
    );
    let newer = whole.replace("\"schema_version\":1", "\"schema_version\":2");
    let newer = read("verify.json", &newer).expect_err("of a newer version");
    golden().eq(&newer.message, str!["is a report of schema version 2; this landfall reads 1"]);
}
