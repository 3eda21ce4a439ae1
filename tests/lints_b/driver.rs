//! Findings of a report of `verify`.

use landfall::lint::driver_disagrees::findings;
use landfall::{Options, Source, layout};

use crate::said;

const SHADER: &str = "\
#version 330 core
uniform Light {
    vec3 color;
    float gain;
} light;
void main() {}
";

fn report(byte_read: &str) -> String {
    format!(
        r#"{{"schema_version":1,"tool":{{"name":"landfall"}},"shaders":[{{"path":"a.frag","blocks":[
        {{"name":"Light","leaves":[
            {{"path":"color","reader":"gl","expected_byte":0,"byte_read":0}},
            {{"path":"gain","element":"gain","reader":"gl","expected_byte":12,"byte_read":{byte_read},
              "cause":"no std140"}}]}}]}}]}}"#
    )
}

#[test]
fn a_leaf_read_elsewhere_is_reported_with_both_bytes() {
    let shader = layout(&Source::new("a.frag", SHADER), &Options::default());
    let found = findings("verify.json", &report("16"), &[&shader]).expect("a report");
    assert_eq!(
        found.iter().map(said).collect::<Vec<_>>(),
        ["4:11 `gl` reads `gain` of block `Light` from byte 16 instead of 12"]
    );
    assert!(found[0].notes.contains(&"no std140".to_string()));
    assert_eq!(found[0].help.as_deref(), Some("declare `layout(std140)`"));
}

#[test]
fn a_leaf_that_is_no_byte_of_the_block_is_said_so() {
    let found = findings("verify.json", &report("null"), &[]).expect("a report");
    assert!(found[0].message.contains("from no byte of the block; it is at 12"), "{found:?}");
    assert_eq!((found[0].place.path.as_str(), found[0].place.line), ("a.frag", 0));
}

#[test]
fn a_reader_that_agrees_is_no_finding() {
    assert_eq!(findings("verify.json", &report("12"), &[]).expect("a report"), []);
}

#[test]
fn elements_of_one_leaf_are_one_finding() {
    let text = r#"{"schema_version":1,"shaders":[{"path":"a.frag","blocks":[{"name":"B","leaves":[
        {"path":"w[]","element":"w[1]","reader":"gpu","expected_byte":16,"byte_read":4},
        {"path":"w[]","element":"w[2]","reader":"gpu","expected_byte":32,"byte_read":8}]}]}]}"#;
    let found = findings("verify.json", text, &[]).expect("a report");
    assert_eq!(found.len(), 1);
    assert!(
        found[0].message.contains("`w[1]` of block `B` from byte 4 instead of 16"),
        "{found:?}"
    );
    assert!(found[0].notes[0].starts_with("1 further element of `w[]` is read"), "{found:?}");
}

#[test]
fn what_is_no_report_is_refused_with_its_place() {
    let whole = report("16");
    let cut = findings("verify.json", &whole[..whole.len() / 2], &[]).expect_err("cut off");
    assert!(
        cut.message.starts_with("is no report of `landfall verify`: EOF while parsing"),
        "{cut}"
    );
    let newer = whole.replace("\"schema_version\":1", "\"schema_version\":2");
    let newer = findings("verify.json", &newer, &[]).expect_err("of a newer version");
    assert!(newer.message.contains("schema version 2; this landfall reads 1"), "{newer}");
}
