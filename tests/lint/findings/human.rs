//! What people read.

use std::sync::Arc;

use landfall_layout::finding::{Finding, Place};
use landfall_layout::format::Paint;
use landfall_lint::render::{ReportFormat, ReportOptions, report};
use snapbox::str;

use crate::findings::{plain, sample};
use crate::support::command::golden;

#[test]
fn a_finding_shows_both_places_the_layout_and_the_help() {
    assert_eq!(
        plain(&sample::findings(), ReportFormat::Human),
        "\
warning[stale-comment]: the comment says `PointLight.color` is at byte 12, and it is at byte 16
 --> shaders/lights.frag:4:33
  |
4 |     vec3 color;      // offset: 12
  |     ---------- aligned to 16    ^^ 16 by std140
  |
  = note: std140 rule 3: a vector of 3 components is aligned to 4 of them
  = note: the layout
          // offset  size
          struct PointLight {
          /*  0  12 */ vec3 pos;
          /* 12   4 */ // hole
          /* 16  12 */ vec3 color;
          };
  = help: write `offset: 16`

error[block-mismatch]: `PointLightBlock` has 6160 bytes here and 4112 bytes in `shaders/copy.vert`
 --> shaders/lights.frag:7:24
  |
7 | layout(std140) uniform PointLightBlock {
  |                        ^^^^^^^^^^^^^^^ 6160 bytes
  |
 ::: shaders/copy.vert:2:24
  |
2 | layout(std140) uniform PointLightBlock {
  |                        --------------- 4112 bytes
3 |     vec4 data[256];
  |     -------------- stride 16, not 48
  |
  = help: declare `data` as `PointLight data[128]` in `shaders/copy.vert`

warning[lock-orphan]: this lock is of `shaders/gone.frag`, which is not there
 --> layouts/gone.frag.json
  |
  = help: delete the lock: `landfall lock --prune`
"
    );
    assert_eq!(plain(&[], ReportFormat::Human), "");
}

#[test]
fn another_place_is_shown_when_the_main_one_is_a_whole_file() {
    let block = sample::place("shaders/lights.frag", sample::LIGHTS, "PointLightBlock");
    let finding = Finding::at("layout-drift", "x", Place::file("layouts/a.json"), "it drifted")
        .with_label(block, "6160 bytes, not 6144")
        .with_help("accept it");
    assert_eq!(
        plain(&[finding], ReportFormat::Human),
        "\
warning[layout-drift]: it drifted
 --> layouts/a.json
  |
 ::: shaders/lights.frag:7:24
  |
7 | layout(std140) uniform PointLightBlock {
  |                        --------------- 6160 bytes, not 6144
  |
  = help: accept it
"
    );
}

/// The text without the escapes that colour it.
fn bare(text: &str) -> String {
    let mut parts = text.split('\u{1b}');
    let first = parts.next().unwrap_or_default().to_string();
    parts.fold(first, |text, part| text + part.split_once('m').map_or("", |(_, rest)| rest))
}

#[test]
fn colours_change_nothing_else_and_no_line_ends_in_a_space() {
    let options = sample::options(Paint::Ansi);
    for findings in [sample::findings(), sample::hostile()] {
        let coloured = report(&findings, ReportFormat::Human, &options);
        let plain = plain(&findings, ReportFormat::Human);
        assert!(coloured.contains("\u{1b}["));
        let trimmed = |text: &str| text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n");
        assert_eq!(trimmed(&bare(&coloured)), trimmed(&plain));
        for line in plain.lines() {
            assert_eq!(line, line.trim_end());
        }
    }
}

fn shown(finding: Finding, text: &str) -> String {
    let text: Arc<str> = text.into();
    let text = move |path: &str| (path == "a.frag").then(|| Arc::clone(&text));
    let options = ReportOptions { paint: Paint::Plain, text: &text, shaders: 1 };
    report(&[finding], ReportFormat::Human, &options)
}

#[test]
fn a_file_that_is_gone_or_has_changed_is_named_without_an_excerpt() {
    let text = "uniform vec3 here;\n";
    let place = sample::place("a.frag", text, "here");
    let finding = Finding::at("x", "", place, "moved").with_text("no").with_help("run it again");
    let expected = "warning[x]: moved\n --> a.frag:1:14\n  |\n  = help: run it again\n";
    for now in ["", "uniform\nvec3 here;\n", "漢字漢字漢字漢字漢字漢字漢字漢字"] {
        assert_eq!(shown(finding.clone(), now), expected, "{now}");
    }
    let mut gone = finding;
    gone.labels[0].at.path = "b.frag".into();
    golden().eq(
        shown(gone, text),
        str![[r#"
warning[x]: moved
 --> b.frag:1:14
  |
  = help: run it again

"#]],
    );
}

#[test]
fn line_and_column_are_enough() {
    let place = Place { line: 2, column: 3, end_line: 2, end_column: 5, ..Place::file("a.frag") };
    let text = shown(Finding::at("x", "", place, "it"), "漢\n漢字漢字é\n");
    golden().eq(
        &text,
        str![[r#"
warning[x]: it
 --> a.frag:2:3
  |
2 | 漢字漢字é
  |     ^^^^

"#]],
    );
    let past = Place { line: 9, column: 1, end_line: 9, end_column: 2, ..Place::file("a.frag") };
    golden().eq(
        shown(Finding::at("x", "", past, "it"), "a\n"),
        str![[r#"
warning[x]: it
 --> a.frag:9:1

"#]],
    );
}

#[test]
fn a_line_of_a_megabyte_is_shown_around_its_place() {
    let line = format!("{}vec33 bad; {}\n", "float x; ".repeat(60_000), "float y; ".repeat(60_000));
    let place = sample::place("a.frag", &line, "vec33");
    let text = shown(Finding::at("x", "", place, "it"), &line);
    golden().eq(text, str![[r#"
warning[x]: it
 --> a.frag:1:540001
  |
1 | …at x; float x; float x; float x; float x; float x; float x; vec33 bad; float y; float y; float y; float y; float y; float y; float y; float y; float y; float y;…
  |                                                              ^^^^^

"#]]);
}

#[test]
fn places_at_the_ends_of_texts_are_shown() {
    for text in ["", "a", "a\n", "a\r\n", "\t\t", "漢"] {
        let end = Place::new(
            &{
                let mut files = landfall_layout::Files::default();
                files.add("a.frag", text.into());
                files
            },
            landfall_layout::Span { file: 0, start: text.len() as u32, end: text.len() as u32 },
        );
        let shown = shown(Finding::at("x", "", end, "unfinished"), text);
        assert!(shown.starts_with("warning[x]: unfinished\n --> a.frag:"), "{shown}");
    }
}
