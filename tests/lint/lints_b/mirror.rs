//! Hand-written Rust structures against blocks, and their layout against rustc's.

use std::fmt::Write;

use landfall_layout::Options;
use landfall_layout::finding::Finding;
use landfall_lint::Settings;
use landfall_lint::rust_mirror::{laid_out, readable};
use landfall_lint::settings::{RustFile, RustMirror};
use snapbox::str;

use crate::lints_b::rustc::{Math, crates, run, scratch};
use crate::lints_b::{help, said};
use crate::support::command::golden;

pub(super) fn rust(text: &str) -> RustFile {
    RustFile { path: "src/light.rs".to_string(), text: text.into() }
}

/// What the lint of that code finds of Rust texts and shaders.
pub(super) fn asked(code: &str, settings: &Settings, shaders: &[(&str, &str)]) -> Vec<Finding> {
    crate::asked::asked(code, shaders, &Options::default(), settings)
}

/// A structure named by a comment, against one block.
pub(super) fn held(text: &str, shader: &str) -> Vec<Finding> {
    let settings = Settings { rust_files: vec![rust(text)], ..Settings::default() };
    let unknown = asked("rust-mirror-unknown", &settings, &[("a.frag", shader)]);
    assert_eq!(unknown, [], "everything here is known");
    asked("rust-mirror", &settings, &[("a.frag", shader)])
}

/// `struct Light` of those fields, its first on line 4, against a std140 block of those members,
/// its first on line 3.
fn light(fields: &str, members: &str) -> Vec<Finding> {
    held(
        &format!("// landfall: mirror(Light)\n#[repr(C)]\nstruct Light {{\n{fields}\n}}\n"),
        &format!(
            "#version 430\nlayout(std140) uniform Light {{\n{members}\n}};\nvoid main() {{}}\n"
        ),
    )
}

fn lines(found: &[Finding]) -> Vec<String> {
    found.iter().map(said).collect()
}

#[test]
fn a_field_before_its_byte_is_reported_with_both_numbers_and_the_padding() {
    let found = light(
        "    direction: [f32; 3],\n    color: [f32; 3],\n    gain: f32,",
        "    vec3 direction;\n    vec3 color;\n    float gain;",
    );
    assert_eq!(lines(&found), ["5:5 `color` is at byte 12 of `Light`, the shader reads it at 16"]);
    assert_eq!(help(&found[0]), "put `_pad_12: [u8; 4]` before `color`");
    assert_eq!(
        found[0].notes[0],
        "`gain` is shifted by the same 4 bytes: fixing this field fixes it"
    );
    assert_eq!((found[0].place().path.as_str(), found[0].place().end_column), ("src/light.rs", 10));
    let member = &found[0].related()[0].at;
    assert_eq!((member.path.as_str(), member.line, member.column), ("a.frag", 4, 10));
    assert_eq!(found[0].about, "Light.color");
}

#[test]
fn the_same_with_the_padding_is_right() {
    let fields = "direction: [f32; 3], _pad_12: [u8; 4], color: [f32; 3], gain: f32,";
    assert_eq!(light(fields, "vec3 direction; vec3 color; float gain;"), []);
}

#[test]
fn a_scalar_behind_an_aligned_vec3_is_reported() {
    let found =
        light("    color: glam::Vec3A,\n    gain: f32,", "    vec3 color;\n    float gain;");
    assert_eq!(lines(&found), ["5:5 `gain` is at byte 16 of `Light`, the shader reads it at 12"]);
    assert_eq!(help(&found[0]), "make `color` `[f32; 3]`: `gain` follows directly in the shader");
    assert_eq!(light("color: glam::Vec3, gain: f32,", "vec3 color; float gain;"), []);
}

#[test]
fn elements_too_close_together_are_reported_with_both_strides() {
    let found = light("    w: [f32; 64],", "    float w[64];");
    assert_eq!(
        lines(&found),
        ["4:5 `w` of `Light` has elements 4 bytes apart, the shader's `float`s are 16 apart"]
    );
    assert_eq!(help(&found[0]), "make it `[[f32; 4]; 64]`");
    let found = light("    s: [[f32; 3]; 7],", "    vec3 s[7];");
    golden().eq(
        said(&found[0]),
        str!["4:5 `s` of `Light` has elements 12 bytes apart, the shader's `vec3`s are 16 apart"],
    );
    for fields in ["w: [[f32; 4]; 64],", "w: [glam::Vec4; 64],", "w: [f32; 256],", "w: [u8; 1024],"]
    {
        assert_eq!(light(fields, "float w[64];"), [], "{fields}");
    }
}

#[test]
fn lengths_are_compared_with_their_constants() {
    let text = |len: &str| {
        format!(
            "const HALF: usize = 1 << 2;\nconst LIGHTS: usize = HALF * 2;\n\
             // landfall: mirror(Light)\n#[repr(C)] struct Light {{ at: [[f32; 4]; {len}] }}\n"
        )
    };
    let shader = "#version 330\nlayout(std140) uniform Light { vec4 at[8]; };\nvoid main() {}\n";
    assert_eq!(held(&text("LIGHTS"), shader), []);
    let found = held(&text("LIGHTS + 1"), shader);
    golden().eq(said(&found[0]), str!["4:27 `at` of `Light` has 9 elements, the shader's has 8"]);
}

#[test]
fn a_packed_mat3_is_reported_with_both_sizes() {
    let wrong = ["normal: glam::Mat3,", "normal: [[f32; 3]; 3],", "normal: cgmath::Matrix3<f32>,"];
    for fields in wrong {
        let found = light(fields, "mat3 normal;");
        golden().eq(said(&found[0]), str!["4:1 `normal` of `Light` is 36 bytes with columns 12 apart, the shader's `mat3` is 48 with columns 16 apart"]);
        assert_eq!(help(&found[0]), "make it `[[f32; 4]; 3]`");
    }
    for fields in ["normal: glam::Mat3A,", "normal: [[f32; 4]; 3],", "normal: [f32; 12],"] {
        assert_eq!(light(fields, "mat3 normal;"), [], "{fields}");
    }
}

#[test]
fn a_rust_bool_is_too_small() {
    let found = light("    on: bool,", "    bool on;");
    assert_eq!(said(&found[0]), "4:5 `on` of `Light` is 1 byte, the shader's `bool` is 4");
    assert_eq!(help(&found[0]), "make it `u32`, and end the structure with `_pad_4: [u8; 12]`");
    assert_eq!(light("on: u32, _pad: [u32; 3],", "bool on;"), []);
}

#[test]
fn bits_of_another_kind_are_reported() {
    let found = light("    count: f32,\n    _p: [u32; 3],", "    int count;");
    assert_eq!(
        lines(&found),
        ["4:5 `count` of `Light` is a float, the shader reads its bits as `int`"]
    );
    assert_eq!(light("count: u32, _p: [u32; 3],", "int count;"), []);
}

#[test]
fn missing_and_extra_fields_are_told_from_renamed_ones() {
    let found =
        light("    color: [f32; 3],\n    gain: f32,", "    vec3 color;\n    float intensity;");
    assert_eq!(lines(&found), ["5:5 `Light` has no field `intensity`; at its byte 12 is `gain`"]);
    let found = light("    color: [f32; 4],", "    vec4 color;\n    float intensity;");
    assert_eq!(
        lines(&found),
        ["3:8 `Light` has no field `intensity`, which the shader reads at 16"]
    );
    let found = light("    color: [f32; 4],\n    gain: [f32; 4],", "    vec4 color;");
    assert_eq!(
        lines(&found),
        ["5:5 `gain` of `Light`, 16 bytes at 16, is not a member in the shader"]
    );
    // Padding has no counterpart and needs none.
    assert_eq!(light("color: [f32; 4], _end: [f32; 4],", "vec4 color;"), []);
    assert_eq!(light("color: [f32; 3], last: f32,", "vec3 color; float last;"), []);
}

#[test]
fn names_meet_whatever_their_case_and_prefix() {
    let fields = "sun_color: [f32; 3], sun_gain: f32, view_pos: [f32; 3], _pad: f32,";
    assert_eq!(light(fields, "vec3 sunColor; float u_sunGain; vec3 ViewPos;"), []);
}

#[test]
fn a_structure_shorter_than_its_block_is_reported_with_both_sizes() {
    let found = light("    color: [f32; 4],\n    gain: f32,", "    vec4 color;\n    float gain;");
    assert_eq!(lines(&found), ["3:8 `Light` is 20 bytes, `Light` is 32"]);
    assert_eq!(help(&found[0]), "end it with `_pad_20: [u8; 12]`");
    // A larger one is uploaded whole and read in part.
    assert_eq!(light("color: [f32; 4], gain: f32, _pad: [f32; 7],", "vec4 color; float gain;"), []);
}

#[test]
fn a_structure_in_an_array_must_be_as_long_as_its_stride() {
    let shader = "#version 330
struct Point { vec3 at; vec3 color; float gain; };
layout(std140) uniform Points { Point data[8]; int count; };
void main() {}
";
    let text = |end: &str| {
        format!(
            "// landfall: mirror(Point)\n#[repr(C)]\npub struct Point {{ at: [f32; 3], _a: f32, \
             color: [f32; 3], gain: f32, {end} }}\n"
        )
    };
    assert_eq!(held(&text(""), shader), []);
    let found = held(&text("_end: [f32; 2],"), shader);
    assert_eq!(lines(&found), ["3:12 `Point` is 40 bytes, elements in the shader are 32 apart"]);
    assert_eq!(help(&found[0]), "remove `_end`");
}

#[test]
fn nested_structures_are_held_at_their_own_fields() {
    let shader = "#version 330
struct Falloff { float linear; float quadratic; };
layout(std140) uniform Lamp { float gain; Falloff falloff; };
void main() {}
";
    let bad = "#[repr(C)]
struct Falloff { quadratic: f32, linear: f32 }
// landfall: mirror(Lamp)
#[repr(C)]
struct Lamp { gain: f32, falloff: Falloff, }
";
    let found = held(bad, shader);
    assert_eq!(
        lines(&found),
        [
            // std140 rounds the structure up to 16: `gain` 0, `falloff` 16.
            "5:26 `falloff` is at byte 4 of `Lamp`, the shader reads it at 16",
            "2:34 `linear` is at byte 4 of `Falloff`, the shader reads it at 0",
            "2:18 `quadratic` is at byte 0 of `Falloff`, the shader reads it at 4",
        ]
    );
    let good = "#[repr(C, align(16))]
struct Falloff { linear: f32, quadratic: f32 }
// landfall: mirror(Lamp)
#[repr(C)]
struct Lamp { gain: f32, falloff: Falloff, }
";
    assert_eq!(held(good, shader), []);
}

#[test]
fn a_structure_without_repr_c_is_reported() {
    let shader = "#version 330\nlayout(std140) uniform Light { vec4 color; };\nvoid main() {}\n";
    let found = held("// landfall: mirror(Light)\nstruct Light { color: [f32; 4] }\n", shader);
    assert_eq!(lines(&found), ["2:8 `Light` is a mirror without `#[repr(C)]`"]);
    let good = "// landfall: mirror(Light)\n#[derive(Clone)]\n#[repr(C)]\nstruct Light { color: [f32; 4] }\n";
    assert_eq!(held(good, shader), []);
}

#[test]
fn a_header_before_a_runtime_sized_tail_needs_no_tail() {
    let shader = "#version 430
struct Point { vec4 at; };
layout(std430) buffer Points { uint count; Point data[]; };
void main() {}
";
    let header =
        "// landfall: mirror(Points)\n#[repr(C)] struct Points { count: u32, _p: [u32; 3] }\n";
    assert_eq!(held(header, shader), []);
    let tail = "#[repr(C)] struct Point { at: [f32; 4] }
// landfall: mirror(Points)
#[repr(C)] struct Points { count: u32, _p: [u32; 3], data: [Point; 3] }
";
    assert_eq!(held(tail, shader), []);
    let bad = tail.replace("[f32; 4]", "[f32; 3]");
    let found = held(&bad, shader);
    // The array's stride is wrong for no other reason.
    assert_eq!(lines(&found), ["1:27 `at` of `Point` is 12 bytes, the shader's `vec4` is 16"]);
}

#[test]
fn the_configuration_names_mirrors_aliases_and_shaders() {
    let shader =
        "#version 330\nlayout(std140) uniform Light { vec4 color; vec4 at; };\nvoid main() {}\n";
    let other = "#version 330\nlayout(std140) uniform Light { vec4 other; };\nvoid main() {}\n";
    let mirror = RustMirror {
        file: "src/light.rs".to_string(),
        structure: "Lamp".to_string(),
        block: "Light".to_string(),
        shader: "shaders/*.frag".to_string(),
        aliases: vec![("at".to_string(), "position".to_string())],
        ..RustMirror::default()
    };
    let file = rust("#[repr(C)] struct Lamp { color: [f32; 4], position: [f32; 4] }\n");
    let settings =
        Settings { rust_mirrors: vec![mirror], rust_files: vec![file], ..Settings::default() };
    let shaders = [("shaders/sun.frag", shader), ("old/sun.frag", other)];
    assert_eq!(asked("rust-mirror", &settings, &shaders), []);
    assert_eq!(asked("rust-mirror-unknown", &settings, &shaders), []);
    // A run without that shader says nothing of its mirror.
    assert_eq!(asked("rust-mirror-unknown", &settings, &shaders[1..]), []);
}

const UNKNOWN_LENGTH: &str = "field `color`: its array's length is not known";

#[test]
fn what_cannot_be_judged_is_said_and_not_blamed() {
    let shader = "#version 330\nlayout(std140) uniform Light { vec4 color; };\nvoid main() {}\n";
    let cases = [
        ("color: Colour,", "field `color`: the layout of `Colour` is not known"),
        ("color: Option<f32>,", "field `color`: the layout of `Option` is not known"),
        ("color: [f32; SIZE],", "field `color`: constant `SIZE` is not known"),
        ("color: [f32; if true { 4 } else { 3 }],", UNKNOWN_LENGTH),
        ("color: [f32; 2 * match 2 { n => n }],", UNKNOWN_LENGTH),
        ("color: [[f32; { unsafe { 4 } }]; 1],", UNKNOWN_LENGTH),
        ("color: nalgebra::SVector<f32, { loop { break 4 } }>,", UNKNOWN_LENGTH),
        ("#[cfg(unix)] color: [f32; 4],", "field `color` exists only under a `cfg`"),
        (
            "color: [crate::lints_b::math::Vec4; 2],",
            "field `color`: the layout of `crate::lints_b::math::Vec4` is not known",
        ),
    ];
    for (field, cause) in cases {
        let text = format!("// landfall: mirror(Light)\n#[repr(C)]\nstruct Light {{ {field} }}\n");
        let settings = Settings { rust_files: vec![rust(&text)], ..Settings::default() };
        let found = asked("rust-mirror-unknown", &settings, &[("a.frag", shader)]);
        assert_eq!(
            lines(&found),
            [format!("3:8 `Light` cannot be compared with `Light`: {cause}")]
        );
        assert_eq!(asked("rust-mirror", &settings, &[("a.frag", shader)]), []);
    }
}

#[test]
fn a_mirror_of_nothing_is_said() {
    let shader = "#version 330\nlayout(std140) uniform Light { vec4 color; };\nvoid main() {}\n";
    let settings = |text: &str| Settings { rust_files: vec![rust(text)], ..Settings::default() };
    let text = "// landfall: mirror(Lihgt)\n#[repr(C)] struct Light { color: [f32; 4] }\n";
    let found = asked("rust-mirror-unknown", &settings(text), &[("a.frag", shader)]);
    assert_eq!(
        lines(&found),
        ["1:1 `Light` mirrors `Lihgt`, but none of the 1 shaders checked has such a block"]
    );
    let text = "// landfall: mirror(Light)\nfn nothing() {}\nstruct Light { color: [f32; 4] }\n";
    let found = asked("rust-mirror-unknown", &settings(text), &[("a.frag", shader)]);
    assert_eq!(lines(&found), ["1:1 mirror comment without a structure below it"]);
}

#[test]
fn a_comment_is_no_comment_in_a_string_or_in_documentation() {
    let text = "const TEXT: &str = \"\n// landfall: mirror(Nothing)\n\";\n/// // landfall: mirror(Nothing)\nstruct A;\n";
    let settings = Settings { rust_files: vec![rust(text)], ..Settings::default() };
    let shader = "#version 330\nlayout(std140) uniform Light { vec4 color; };\nvoid main() {}\n";
    assert_eq!(asked("rust-mirror-unknown", &settings, &[("a.frag", shader)]), []);
}

#[test]
fn a_text_that_is_no_rust_is_refused_with_its_place() {
    let cases = [
        ("struct Light {\n    color: [f32; 4],\n", "line"),
        ("struct Light {\n    color [f32; 4],\n}\n", "line 2, column 11"),
        ("struct Light { a: \u{1}u32 }", "line 1"),
    ];
    for (text, place) in cases {
        let error = readable(&rust(text)).expect_err(text);
        assert!(error.message.contains(place), "{text}: {error}");
    }
    assert!(
        readable(&rust("fn f() { anything goes [here] }\nmacro_rules! m { () => {} }")).is_ok()
    );
}

#[test]
fn hostile_rust_is_answered() {
    let deep = format!("struct A {{ a: {}u8{} }}", "[".repeat(100_000), "; 1]".repeat(100_000));
    let references = format!("struct A {{ a: {}u8 }}", "&".repeat(100_000));
    let doubling: String = (1..60)
        .map(|n| format!("#[repr(C)] struct S{n} {{ a: S{}, b: S{} }}\n", n - 1, n - 1))
        .collect();
    let doubling = format!("#[repr(C)] struct S0 {{ a: u8 }}\n{doubling}");
    let constants: String =
        (1..60).map(|n| format!("const C{n}: usize = C{} + C{};\n", n - 1, n - 1)).collect();
    let constants = format!("{constants}struct A {{ a: [u8; C59] }}");
    let empty = format!(
        "struct A {{ a: {}u8; 0{} }}",
        "[".repeat(20),
        "; 64]".repeat(20).replacen("; 64", "", 1)
    );
    let endless = "type A = B; type B = A; struct S59 { a: A }";
    let binary = "\u{0}\u{1}\u{2}";
    let braces = "{".repeat(10_000_000);
    for text in [&deep, &references, &doubling, &constants, &empty, endless, binary, &braces] {
        let file = rust(text);
        let _ = readable(&file);
        let name = if text.contains("S59") { "S59" } else { "A" };
        let _ = laid_out(&file, name);
    }
    assert!(laid_out(&rust(&doubling), "S59").is_err());
    assert!(laid_out(&rust("#[repr(C, align(3))] struct A { a: u8 }"), "A").is_ok());
    assert!(laid_out(&rust("#[repr(C)] struct A { a: [u64; 9223372036854775807] }"), "A").is_err());
}

/// Structures of every kind of type there is a layout for.
const STRUCTURES: &str = "\
pub const COUNT: usize = 3;
pub const LARGER: usize = (COUNT + 2) * 4 / 2 % 7 | 8;
pub const SIDE: usize = { COUNT + 1 };
pub type Row = [f32; 4];
#[repr(C)] pub struct Blocks { pub a: u8, pub b: [f32; { SIDE * 2 }], pub c: [[u16; { 3 }]; SIDE] }
#[repr(C)] pub struct Primitives { pub a: u8, pub b: u16, pub c: u32, pub d: u64, pub e: bool, pub f: f32, pub g: i8, pub h: f64, pub i: i16 }
#[repr(C)] pub struct Arrays { pub a: [f32; 3], pub b: [[f32; 3]; COUNT], pub c: [u8; LARGER], pub d: [Row; 2], pub e: u64 }
#[repr(C)] pub struct Nested { pub a: u8, pub b: Primitives, pub c: [Arrays; 2], pub d: u8 }
#[repr(C, align(16))] pub struct Wide { pub a: f32 }
#[repr(C)] #[repr(align(64))] pub struct Wider { pub a: f32, pub b: Wide, pub c: [Wide; 2], pub d: f32 }
#[repr(C, packed)] pub struct Packed { pub a: u8, pub b: u32, pub c: u64 }
#[repr(C, packed(2))] pub struct PackedTwo { pub a: u8, pub b: u32, pub c: Packed, pub d: u64 }
#[repr(transparent)] pub struct Only { pub a: [f32; 4] }
#[repr(C)] pub struct Empty { pub a: f32, pub b: [u8; 0], pub c: [f64; 0], pub d: f32 }
#[repr(C)] pub struct Sized { pub a: [u8; 48 - core::mem::size_of::<Wide>()], pub b: Only, pub c: std::sync::atomic::AtomicU32 }
#[repr(C)] pub struct Two { pub a: f32, pub b: glam::Vec2, pub c: u8, pub d: glam::Vec3, pub e: f32, pub f: glam::Vec3A, pub g: f32 }
#[repr(C)] pub struct Four { pub a: u8, pub b: glam::Vec4, pub c: u8, pub d: glam::Quat, pub e: u8, pub f: glam::Mat2, pub g: u8 }
#[repr(C)] pub struct Matrices { pub a: u8, pub b: glam::Mat3, pub c: u8, pub d: glam::Mat3A, pub e: u8, pub f: glam::Mat4, pub g: u8, pub h: glam::Affine3A, pub i: u8 }
#[repr(C)] pub struct Integers { pub a: u8, pub b: glam::IVec2, pub c: u8, pub d: glam::IVec3, pub e: u8, pub f: glam::UVec4, pub g: u8, pub h: glam::IVec4, pub i: u8, pub j: glam::U16Vec3, pub k: u8, pub l: glam::I64Vec2, pub m: u8 }
#[repr(C)] pub struct Doubles { pub a: u8, pub b: glam::DVec2, pub c: u8, pub d: glam::DVec3, pub e: u8, pub f: glam::DVec4, pub g: u8, pub h: glam::DMat3, pub i: u8, pub j: glam::DMat4, pub k: u8, pub l: glam::DQuat, pub m: u8 }
";

/// The oracle: the same text, compiled, says where its fields are.
#[test]
fn layouts_are_those_of_rustc() {
    let file = rust(STRUCTURES);
    let mut program = format!("#![allow(dead_code, unused_braces)]\n{STRUCTURES}\nfn main() {{\n");
    let mut ours = String::new();
    let names: Vec<&str> = STRUCTURES
        .split("pub struct ")
        .skip(1)
        .map(|rest| rest.split(' ').next().expect("a name"))
        .collect();
    assert_eq!(names.len(), 16);
    for name in names {
        let laid = laid_out(&file, name).unwrap_or_else(|error| panic!("{error}"));
        writeln!(ours, "{name} {} {}", laid.size, laid.align).expect("a string takes all");
        writeln!(
            program,
            "println!(\"{name} {{}} {{}}\", size_of::<{name}>(), align_of::<{name}>());"
        )
        .expect("a string takes all");
        for (field, offset) in laid.fields {
            writeln!(ours, "  {field} {offset}").expect("a string takes all");
            writeln!(
                program,
                "println!(\"  {field} {{}}\", core::mem::offset_of!({name}, {field}));"
            )
            .expect("a string takes all");
        }
    }
    program.push_str("}\n");
    let root = scratch("lint").join("hand_written.rs");
    std::fs::write(&root, program).expect("scratch can be written to");
    let rustc = run(crates(Math::Simd), &root, "2021");
    assert_eq!(ours, String::from_utf8(rustc).expect("a program that prints text"));
}
