//! `buffer-too-small`.

use landfall_layout::finding::{Finding, Place};
use landfall_lint::settings::{Figure, Row, Table};
use landfall_lint::{Settings, lint};
use snapbox::str;

use super::{found, messages, only};
use crate::support::command::golden;

const CODE: &str = "buffer-too-small";

/// The block of the UBO chapter: 128 lights of 48 bytes and a count.
const LIGHTS: &str = "#version 330 core
struct PointLight {
    vec3 pos;
    vec3 color;
    float intensity;
    float constant;
    float linear;
    float quadratic;
};
layout(std140) uniform PointLightBlock {
    PointLight data[128];
    int actually_used_count;
} u_point_light_array;
void main() { }
";

fn at(line: u32) -> Place {
    Place { line, column: 3, ..Place::file("landfall.toml") }
}

fn figure(bytes: u64, written: &str, line: u32) -> Figure {
    Figure { bytes, written: written.to_string(), place: at(line) }
}

fn row(path: &str, offset: u64, line: u32) -> Row {
    Row { path: path.to_string(), offset: figure(offset, "", line) }
}

fn held(block: &str, size: Option<Figure>, offsets: Vec<Row>) -> Vec<Finding> {
    let table =
        Table { block: block.to_string(), file: String::new(), size, offsets, place: at(1) };
    let settings = Settings { tables: vec![table], ..Settings::default() };
    found(CODE, &[("lights.frag", LIGHTS)], &settings)
}

#[test]
fn the_chapters_6148_bytes_are_12_too_few() {
    for block in ["PointLightBlock", "u_point_light_array"] {
        let finding = only(held(block, Some(figure(6148, "48 * 128 + 4", 5)), vec![]));
        assert_eq!(
            finding.message,
            "48 * 128 + 4 = 6,148 bytes are allocated for block `PointLightBlock`, but it needs 6,160 bytes"
        );
        assert_eq!((finding.place().path.as_str(), finding.place().line), ("landfall.toml", 5));
        let block = &finding.related()[0].at;
        assert_eq!((block.path.as_str(), block.line, block.column), ("lights.frag", 10, 24));
        assert_eq!(
            finding.notes,
            ["the last member ends at byte 6148; 12 bytes of tail padding belong to the block"]
        );
        assert_eq!(finding.help.as_deref(), Some("write 6160"));
    }
    for enough in [6160, 8192] {
        let found = held("PointLightBlock", Some(figure(enough, "", 5)), vec![]);
        assert_eq!(messages(&found), [""; 0]);
    }
}

#[test]
fn rows_that_are_off_are_told_with_both_numbers() {
    let rows = vec![
        row("data[0].pos", 0, 6),
        row("data[3].color", 160, 7),
        row("data[3].intensity", 168, 8),
        row("actually_used_count", 4096, 9),
        row("PointLightBlock.data[127].quadratic", 6136, 10),
    ];
    let findings = held("PointLightBlock", None, rows);
    assert_eq!(
        messages(&findings),
        [
            "`data[3].intensity` of block `PointLightBlock` is listed at offset 168, but it \
             is at 172",
            "`actually_used_count` of block `PointLightBlock` is listed at offset 4096, but \
             it is at 6144",
        ]
    );
    assert_eq!([findings[0].place().line, findings[1].place().line], [8, 9]);
    assert_eq!(findings[0].help.as_deref(), Some("write 172"));
}

#[test]
fn names_that_lead_nowhere_are_told_with_the_nearest() {
    let finding = only(held("PointLightBlok", Some(figure(1, "", 5)), vec![]));
    assert_eq!(finding.code, "unknown-block");
    assert_eq!(finding.message, "no shader has a block `PointLightBlok`");
    assert_eq!(finding.help.as_deref(), Some("did you mean `PointLightBlock`?"));
    assert_eq!(finding.place().line, 1);
    let rows = vec![row("data[0].colour", 16, 6), row("data[128].pos", 6144, 7)];
    let findings = held("PointLightBlock", None, rows);
    assert_eq!(findings.len(), 2, "{:#?}", messages(&findings));
    golden().eq(
        &findings[0].message,
        str!["PointLightBlock: `data[0]`, a `PointLight`, has no member `colour`"],
    );
    assert_eq!(findings[0].help.as_deref(), Some("there is a member `color`"));
    golden().eq(
        &findings[1].message,
        str!["PointLightBlock: `data[128]` is out of range: `data` has 128 elements"],
    );
}

#[test]
fn a_table_is_held_against_the_shaders_it_names() {
    let table = Table {
        block: "PointLightBlock".to_string(),
        file: "gl/*.frag".to_string(),
        size: Some(figure(6148, "", 5)),
        offsets: vec![],
        place: at(1),
    };
    let settings = Settings { tables: vec![table], ..Settings::default() };
    let elsewhere = only(found(CODE, &[("web/a.frag", LIGHTS)], &settings));
    assert_eq!(elsewhere.message, "no shader matches `gl/*.frag`");
    // Two stages declare the block; the table is wrong once, and both are named.
    let both = [("gl/a.frag", LIGHTS), ("gl/b.frag", LIGHTS)];
    let finding = only(found(CODE, &both, &settings));
    assert_eq!(finding.related().len(), 2);
    assert!(lint(CODE).unwrap().example.contains("PointLightBlock"));
}
