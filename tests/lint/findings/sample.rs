//! Findings for the tests: those of two small shaders, and hostile ones.

use std::sync::Arc;

use landfall_layout::diagnostic::Severity;
use landfall_layout::finding::{Finding, Place};
use landfall_layout::format::Paint;
use landfall_layout::source::{Files, Span};
use landfall_lint::render::ReportOptions;

pub const LIGHTS: &str = "\
#version 330
struct PointLight {
    vec3 pos;        // offset: 0
    vec3 color;      // offset: 12
    float intensity;
};
layout(std140) uniform PointLightBlock {
    PointLight data[128];
    int count;
} lights;
";

pub const COPY: &str = "\
#version 330
layout(std140) uniform PointLightBlock {
    vec4 data[256];
    int count;
} lights;
";

const LISTING: &str = "\
// offset  size
struct PointLight {
/*  0  12 */ vec3 pos;
/* 12   4 */ // hole
/* 16  12 */ vec3 color;
};
";

/// The text of a file of the sample.
pub fn text(path: &str) -> Option<Arc<str>> {
    match path {
        "shaders/lights.frag" => Some(LIGHTS.into()),
        "shaders/copy.vert" => Some(COPY.into()),
        _ => None,
    }
}

/// Where `what` stands in a text for the first time.
pub fn place(path: &str, text: &str, what: &str) -> Place {
    let start = text.find(what).expect("the text holds it") as u32;
    let mut files = Files::default();
    let file = files.add(path, text.into());
    Place::new(&files, Span { file, start, end: start + what.len() as u32 })
}

/// A finding with all there is, one with a place in another file, one about a whole file.
pub fn findings() -> Vec<Finding> {
    let in_lights = |what| place("shaders/lights.frag", LIGHTS, what);
    let in_copy = |what| place("shaders/copy.vert", COPY, what);
    let digits =
        Place { start: in_lights("12\n").start, ..place("shaders/lights.frag", LIGHTS, "12") };
    let stale = Finding::at(
        "stale-comment",
        "PointLight.color",
        digits.clone(),
        "the comment says `PointLight.color` is at byte 12, and it is at byte 16",
    )
    .with_text("16 by std140")
    .with_label(in_lights("vec3 color"), "aligned to 16")
    .with_note("std140 rule 3: a vector of 3 components is aligned to 4 of them")
    .with_listing(LISTING)
    .with_help("write `offset: 16`")
    .with_edit(digits, "16");
    let mut mismatch = Finding::at(
        "block-mismatch",
        "PointLightBlock",
        in_lights("PointLightBlock"),
        "`PointLightBlock` has 6160 bytes here and 4112 bytes in `shaders/copy.vert`",
    )
    .with_text("6160 bytes")
    .with_label(in_copy("PointLightBlock"), "4112 bytes")
    .with_label(in_copy("vec4 data[256]"), "stride 16, not 48")
    .with_help("declare `data` as `PointLight data[128]` in `shaders/copy.vert`");
    mismatch.severity = Severity::Error;
    let orphan = Finding::at(
        "lock-orphan",
        "layouts/gone.frag.json",
        Place::file("layouts/gone.frag.json"),
        "this lock is of `shaders/gone.frag`, which is not there",
    )
    .with_help("delete the lock: `landfall lock --prune`");
    vec![stale, mismatch, orphan]
}

/// Options for the sample.
pub fn options(paint: Paint) -> ReportOptions<'static> {
    ReportOptions { paint, text: &text, shaders: 65 }
}

/// What has a meaning to some format or other.
pub const HOSTILE: &[&str] = &[
    "",
    " ",
    "a b/c:d,e.frag",
    "100 % of %0A and %25",
    "line\nbreak\r\nand\rreturn\n\n",
    "\"quoted\" 'single' `code` ``",
    "<failure message=\"x\">&amp;]]></failure><!-- -->",
    "a | b \\| c \\",
    "::error file=x::injected",
    "##[error]injected",
    "\u{1b}[31mred\u{1b}[0m \u{0} \u{7f} \u{85} \u{fffe} \t tab",
    "漢字 🙂 é e\u{301} \u{202e}reversed\u{202c}",
    "*bold* _slanted_ [link](http://example.com) # heading",
    "{0} {{1}} ${{ secrets.X }} $(id) ${HOME}",
    "../../etc/passwd",
    "C:/windows/style.frag",
    "/absolute/style.frag",
];

/// Findings with such strings everywhere.
pub fn hostile() -> Vec<Finding> {
    let one = |(i, text): (usize, &&str)| {
        let at = Place {
            path: text.to_string(),
            line: i as u32,
            column: 3,
            end_line: i as u32 + i as u32 % 2,
            end_column: 9,
            start: 10,
            end: 16,
        };
        let mut finding = Finding::at("stale-comment", *text, at.clone(), *text)
            .with_text(*text)
            .with_label(at.clone(), *text)
            .with_note(*text)
            .with_listing(*text)
            .with_help(*text)
            .with_edit(at, *text);
        finding.severity = if i % 3 == 0 { Severity::Warning } else { Severity::Error };
        finding
    };
    HOSTILE.iter().enumerate().map(one).collect()
}
