//! `stale-comment`.

use super::{Fixture, Score};

/// A light at offset 16 of a std140 block: aligned to 16, 12 bytes, the next member at 32.
fn member(comment: &str) -> String {
    format!(
        "#version 330 core\nlayout(std140) uniform Fog {{\n    vec4 ambient;\n    vec3 color; // \
         {comment}\n    vec4 range;\n}} u_fog;\nout vec4 shade;\nvoid main() {{ shade = u_fog.range; }}\n"
    )
}

/// Four elements of 4 bytes, 16 apart, from byte 16 to 80.
fn array(comment: &str) -> String {
    member("").replace("vec3 color; // ", &format!("float weights[4]; // {comment}"))
}

/// An element of 48 bytes whose members end at byte 44, in a block of 208.
fn structure(comment: &str) -> String {
    format!(
        "#version 330 core\nstruct Light {{\n    vec4 position;\n    vec4 color;\n    vec3 cone;\n}}; // {comment}\n\
         layout(std140) uniform Lights {{\n    Light lights[4];\n    float count;\n}} u_lights;\n\
         out vec4 shade;\nvoid main() {{ shade = u_lights.lights[0].color; }}\n"
    )
}

fn each(
    texts: &[&str],
    shader: impl Fn(&str) -> String,
    line: Option<u32>,
) -> impl Iterator<Item = Fixture> {
    let fixture = move |text: &&str| {
        let expected: Vec<(&str, u32)> = line.map(|line| ("a.frag", line)).into_iter().collect();
        Fixture::of(*text, &[("a.frag", &shader(text))], &expected)
    };
    texts.iter().map(fixture).collect::<Vec<_>>().into_iter()
}

#[rustfmt::skip]
const WRONG_MEMBER: &[&str] = &[
    // English
    "offset 12", "offset: 12", "byte offset 12", "@ 12", "offset 0x0c", "align 8, offset 16",
    "starts at byte 12", "begins at byte 12", "at byte 12", "byte 12", "colour, starts at byte 12",
    "bytes 12-23", "bytes 36-39", "bytes 12..23", "bytes 12 to 23", "24 bytes", "takes 24 bytes",
    "size 24", "alignment 12",
    // German
    "Offset 12", "Versatz: 12", "Offset: 12 Byte", "Ausrichtung: 8", "Ausrichtung 8 Byte",
    "Größe: 24 Byte", "24 Byte", "ab Byte 12", "beginnt bei Byte 12", "Byte 12-23",
    "Bytes 12 bis 23", "belegt 24 Byte",
    // Chinese
    "偏移:12", "偏移量：12", "对齐：8，偏移：16", "24字节", "占24字节", "从字节 12 开始",
    "起始于字节 12", "字节 12-23", "位于偏移 12",
];

/// These are not read: each has another common meaning.
const MISSED_MEMBER: &[&str] = &["12: colour", "[12] colour", "+12", "12到23字节"];

#[rustfmt::skip]
const RIGHT_MEMBER: &[&str] = &[
    "offset 16", "starts at byte 16", "begins at byte 16", "byte 16", "bytes 16-27",
    "bytes 16-28", "bytes 16-31", "bytes 16..32", "bytes 16 to 27", "12 bytes", "16 bytes",
    "28 bytes", "alignment 16", "Versatz: 16", "Ausrichtung: 16", "Größe: 12 Byte",
    "ab Byte 16", "beginnt bei Byte 16", "Bytes 16 bis 27", "从字节 16 开始", "字节 16-27",
    "位于偏移 16", "占 12 字节", "对齐:16 偏移:16",
];

#[rustfmt::skip]
const OTHER_MEMBER: &[&str] = &[
    "RGB, linear", "byte order is RGBA", "8 bits each", "bytes per pixel: 4", "12 of them",
    "the host writes at byte 12 of its own buffer", "copied from byte 12", "needs 4 bytes of padding",
    "was at byte 12", "lag früher bei Byte 12, war 12 Byte", "sollte bei Byte 12 liegen",
    "tile size: 24", "uv offset: 4", "第 12 个", "最多 12 个", "total lights: 12",
    "24 bytes in C++", "offset 12 on the CPU", "in std430 at byte 12", "see issue 12",
];

#[test]
fn comments_next_to_members() {
    let each_wrong =
        &["44 bytes each", "12 bytes each", "stride 12", "每个 12 字节", "Schrittweite 12"];
    let each_right = &["16 bytes each", "4 bytes each", "stride 16", "每个 16 字节", "64 bytes"];
    let fixtures: Vec<Fixture> = each(WRONG_MEMBER, member, Some(4))
        .chain(each(MISSED_MEMBER, member, Some(4)))
        .chain(each(RIGHT_MEMBER, member, None))
        .chain(each(OTHER_MEMBER, member, None))
        .chain(each(each_wrong, array, Some(4)))
        .chain(each(each_right, array, None))
        .collect();
    Score::of("stale-comment", &fixtures).at_least(1.0, 0.91);
}

#[test]
fn comments_about_a_whole_structure() {
    #[rustfmt::skip]
    let wrong = &[
        "stride 52", "stride: 52", "stride 44", "52 bytes", "52 bytes each", "52 bytes per light",
        "total 216", "total: 216 bytes", "total size 216", "size 52", "sizeof 52",
        "Gesamt: 216 Byte", "Gesamtgröße: 216 Byte", "insgesamt 216 Byte", "Schrittweite 52",
        "总大小：216", "总共 216 字节", "步长 52", "每个 52 字节",
    ];
    let missed = &["sum 216"];
    #[rustfmt::skip]
    let right = &[
        "stride 48", "stride: 48", "48 bytes", "44 bytes", "48 bytes each", "44 bytes each",
        "48 bytes per light", "total 48", "Schrittweite 48", "Gesamtgröße: 48 Byte", "步长 48",
        "每个 48 字节", "4 of them", "mirrors Light in light.rs",
    ];
    let fixtures: Vec<Fixture> = each(wrong, structure, Some(6))
        .chain(each(missed, structure, Some(6)))
        .chain(each(right, structure, None))
        .collect();
    Score::of("stale-comment", &fixtures).at_least(1.0, 0.94);
}

/// The example of the WGSL specification's section on structure layout, in its own style: every
/// number is the specification's.
const SPECIFICATION: &str = "\
struct A {                                     //             align(8)  size(24)
    u: f32,                                    // offset(0)   align(4)  size(4)
    v: f32,                                    // offset(4)   align(4)  size(4)
    w: vec2<f32>,                              // offset(8)   align(8)  size(8)
    x: f32                                     // offset(16)  align(4)  size(4)
    // -- implicit struct size padding --      // offset(20)            size(4)
}

struct B {                                     //             align(16) size(160)
    a: vec2<f32>,                              // offset(0)   align(8)  size(8)
    // -- implicit member alignment padding -- // offset(8)             size(8)
    b: vec3<f32>,                              // offset(16)  align(16) size(12)
    c: f32,                                    // offset(28)  align(4)  size(4)
    d: f32,                                    // offset(32)  align(4)  size(4)
    // -- implicit member alignment padding -- // offset(36)            size(4)
    e: A,                                      // offset(40)  align(8)  size(24)
    f: vec3<f32>,                              // offset(64)  align(16) size(12)
    // -- implicit member alignment padding -- // offset(76)            size(4)
    g: array<A, 3>,    // element stride 24       offset(80)  align(8)  size(72)
    h: i32             //                         offset(152) align(4)  size(4)
    // -- implicit struct size padding --      // offset(156)           size(4)
}

@group(0) @binding(0) var<storage, read_write> b: B;
@compute @workgroup_size(1) fn main() { b.h = 1; }
";

/// A shader, and the listing that `landfall layout --format listing` prints of it.
fn listed() -> (String, String) {
    let text = structure("").replace("}; // ", "};");
    let shader = landfall_layout::layout(
        &landfall_layout::Source::new("a.frag", text.as_str()),
        &landfall_layout::Options::default(),
    );
    let options =
        landfall_layout::format::EmitOptions::new(landfall_layout::format::Format::Listing);
    let listing = landfall_layout::format::shader(&shader, &options);
    assert!(listing.contains("-- hole") || listing.contains("padding"), "{listing}");
    (text, listing)
}

#[test]
fn right_comments_are_never_rewritten() {
    let (text, listing) = listed();
    let commented: String = listing.lines().map(|line| format!("// {line}\n")).collect();
    let above_structure = text.replace("struct Light {", &format!("{commented}struct Light {{"));
    let above_block = text.replace("layout(std140)", &format!("{commented}layout(std140)"));
    // The listing itself is GLSL: its rows are comments in front of the members.
    let itself = format!("#version 330 core\n{listing}out vec4 shade;\nvoid main() {{ }}\n");
    let old = member("offset 16").replace(
        "    vec3 color;",
        "    // float exposure; // offset 12\n    // vec4 tint;      // offset 32, 16 bytes\n    vec3 color;",
    );
    let old_block = member("offset 16").replace(
        "    vec3 color;",
        "    /* float exposure; // offset 12\n       vec4 tint;      // offset 32 */\n    vec3 color;",
    );
    let old_wgsl = "struct Fog {\n    color: vec3f, // offset(0)\n    \
                    // density: f32,     // offset(20) size(4)\n    \
                    // old: array<f32, 4> // offset(32)\n    near: f32, // offset(12)\n}\n\
                    @group(0) @binding(0) var<uniform> fog: Fog;\n";
    let fixtures = [
        Fixture::of("specification", &[("a.wgsl", SPECIFICATION)], &[]),
        Fixture::of("listing above the structure", &[("a.frag", &above_structure)], &[]),
        Fixture::of("listing above the block", &[("a.frag", &above_block)], &[]),
        Fixture::of("the listing itself", &[("a.frag", &itself)], &[]),
        Fixture::of("commented out", &[("a.frag", &old)], &[]),
        Fixture::of("commented out in a block", &[("a.frag", &old_block)], &[]),
        Fixture::of("commented out in WGSL", &[("a.wgsl", old_wgsl)], &[]),
        // What is wrong among them is still told.
        Fixture::of(
            "specification, one number off",
            &[("a.wgsl", &SPECIFICATION.replace("offset(16)  align(16)", "offset(12)  align(16)"))],
            &[("a.wgsl", 12)],
        ),
    ];
    Score::of("stale-comment", &fixtures).at_least(1.0, 1.0);
}
