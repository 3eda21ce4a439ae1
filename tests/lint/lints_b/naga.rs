//! What naga reads from another byte, and the construct to blame.
//!
//! Seen in naga 30.0.1: when one of these fails because naga and landfall agree,
//! the fault is mended there, and its cause goes from the lint.

use landfall_layout::finding::Level;
use landfall_lint::settings::Target;
use landfall_lint::{Settings, lint};
use snapbox::str;

use crate::lints_b::{found, found_with, help, one, said};
use crate::support::command::golden;

const NESTED: &str = "\
struct Inner { @align(16) value: u32 }
struct Outer { first: u32, inner: Inner, pair: array<Inner, 2> }
@group(0) @binding(0) var<storage> outer: Outer;
";

fn webgpu() -> Settings {
    Settings { targets: vec![Target::WebGpu], ..Settings::default() }
}

#[test]
fn align_in_a_nested_structure_is_blamed_with_both_bytes() {
    let finding = one("naga-disagrees", "a.wgsl", NESTED);
    assert_eq!(
        said(&finding),
        "1:27 naga, so wgpu, reads `inner.value` of block `Outer` from byte 4 instead of 16, and \
         1 more member"
    );
    golden().eq(&finding.notes[0], str!["naga ignores that `@align` on a member aligns the structure `Inner` around it (gfx-rs/wgpu#4377)"]);
    assert_eq!(finding.notes[1], "it reads `pair[].value` from byte 20 instead of 32");
}

#[test]
fn the_way_around_it_is_read_alike_by_both() {
    let good = "\
struct Inner { value: u32 }
struct Outer { first: u32, @align(16) @size(16) inner: Inner, last: u32 }
@group(0) @binding(0) var<storage> outer: Outer;
";
    assert_eq!(found("naga-disagrees", "a.wgsl", good), []);
    // What the help says, with the `@align` where it is: first the member, then its size.
    let mended = "\
struct Inner { @align(16) value: u32 }
struct Outer { first: u32, @align(16) @size(16) inner: Inner, last: u32 }
@group(0) @binding(0) var<storage> outer: Outer;
";
    golden().eq(help(&one("naga-disagrees", "a.wgsl", NESTED)), str!["put the same `@align` on the member that has the structure's type, and the same `@size`, or pad with members"]);
    assert_eq!(found("naga-disagrees", "a.wgsl", mended), []);
}

fn glsl(block: &str) -> String {
    format!("#version 450\n{block}\nvoid main() {{}}\n")
}

#[test]
fn each_fault_in_glsl_has_its_cause() {
    let cases = [
        (
            "layout(std140, binding = 0) uniform B { float f[2][3]; };",
            "swaps the dimensions",
            "with array stride 32, 16 instead of 48, 16",
        ),
        (
            "struct S { float a; };\nlayout(std140, binding = 0) uniform B { float x; S s; };",
            "does not round the alignment of structure `S` up to 16",
            "from byte 4 instead of 16",
        ),
        (
            "layout(push_constant) uniform B { vec2 g; float a[2]; };",
            "lays push constants out in std140; their default is std430",
            "from byte 16 instead of 8, with array stride 16 instead of 4",
        ),
        (
            "layout(std430, binding = 0) buffer B { bool on; bool off; };",
            "lays out a `bool` as 1 byte",
            "from byte 1 instead of 4",
        ),
    ];
    for (block, cause, numbers) in cases {
        let found = found_with("naga-disagrees", "a.frag", &glsl(block), &webgpu());
        assert_eq!(found.len(), 1, "{block}: {found:#?}");
        assert!(found[0].notes[0].contains(cause), "{block}: {found:#?}");
        assert!(found[0].message.contains(numbers), "{block}: {found:#?}");
    }
}

#[test]
fn declarations_both_read_alike_are_not_reported() {
    for block in [
        "layout(std140, binding = 0) uniform B { float f[6]; };",
        "struct S { vec4 a; };\nlayout(std140, binding = 0) uniform B { float x; S s; };",
        "layout(push_constant) uniform B { vec4 g; vec4 a[2]; };",
        "layout(std430, binding = 0) buffer B { uint on; uint off; };",
    ] {
        assert_eq!(found_with("naga-disagrees", "a.frag", &glsl(block), &webgpu()), [], "{block}");
    }
}

#[test]
fn glsl_that_never_meets_naga_is_left_alone() {
    let text = glsl("layout(std140, binding = 0) uniform B { float f[2][3]; };");
    assert_eq!(found("naga-disagrees", "a.frag", &text), []);
    let asked = Settings {
        levels: vec![("naga-disagrees".to_string(), Level::Warn)],
        ..Settings::default()
    };
    assert_eq!(found_with("naga-disagrees", "a.frag", &text, &asked).len(), 1);
}

#[test]
fn for_the_target_webgpu_it_is_a_failure() {
    let lint = lint("naga-disagrees").expect("it is listed");
    assert_eq!(lint.level_under(&Settings::default()), Level::Warn);
    assert_eq!(lint.level_under(&webgpu()), Level::Deny);
}

#[test]
fn many_leaves_are_counted_and_a_few_are_named() {
    let members: String = (0..20).map(|n| format!("m{n}: u32, ")).collect();
    let text = NESTED.replace("pair: array<Inner, 2>", &members);
    let finding = one("naga-disagrees", "a.wgsl", &text);
    golden().eq(&finding.message, str!["naga, so wgpu, reads `inner.value` of block `Outer` from byte 4 instead of 16, and 20 more members"]);
    assert_eq!(finding.notes.last().map(String::as_str), Some("and 16 more"));
}
