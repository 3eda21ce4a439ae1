//! Structures that a library writes: where encase puts their fields says encase, compiled here; where
//! crevice 0.20.1 does was printed once with its `AsStd140` and `AsStd430`.

use encase::ShaderType;
use landfall_layout::Source;
use landfall_layout::layout::MemberLayout;

use crate::lints_b::mirror::{asked, held, rust};
use crate::lints_b::{help, said};
use crate::support::wgsl::{Matrix, Vector};
use landfall_lint::Settings;

/// The names that the texts use, with encase's rules.
#[allow(dead_code, reason = "the texts decide which are used")]
mod glam {
    pub type Vec2 = super::Vector<f32, 2>;
    pub type Vec3 = super::Vector<f32, 3>;
    pub type Vec4 = super::Vector<f32, 4>;
    pub type IVec3 = super::Vector<i32, 3>;
    pub type UVec4 = super::Vector<u32, 4>;
    pub type Mat2 = super::Matrix<2, 2>;
    pub type Mat3 = super::Matrix<3, 3>;
    pub type Mat4 = super::Matrix<4, 4>;
}

/// A structure's name, its text, its fields with their offsets by encase, and its size.
type Row = (&'static str, &'static str, Vec<(&'static str, u64)>, u64);

macro_rules! structs {
    ($(struct $name:ident { $($(#[$attribute:meta])* $field:ident: $ty:ty,)* } = $wgsl:literal)*) => {
        $(#[derive(ShaderType)] #[allow(dead_code)] struct $name { $($(#[$attribute])* $field: $ty,)* })*

        fn rows() -> Vec<(Row, &'static str)> {
            vec![$({
                let mut fields = Vec::new();
                $(
                    let at = fields.len();
                    fields.push((stringify!($field), <$name as ShaderType>::METADATA.offset(at)));
                )*
                let text = concat!(
                    "#[derive(encase::ShaderType)] struct ", stringify!($name), " { ",
                    $($("#[", stringify!($attribute), "] ",)* stringify!($field), ": ", stringify!($ty), ", ",)*
                    "}\n"
                );
                ((stringify!($name), text, fields, <$name as ShaderType>::min_size().get()), $wgsl)
            }),*]
        }
    };
}

structs! {
    struct Light { pos: glam::Vec3, color: glam::Vec3, power: f32, kinds: [glam::UVec4; 2], }
        = "pos: vec3f, color: vec3f, power: f32, kinds: array<vec4u, 2>"
    struct Turns { a: f32, turn: glam::Mat3, two: glam::Mat2, all: glam::Mat4, end: f32, }
        = "a: f32, turn: mat3x3f, two: mat2x2f, all: mat4x4f, end: f32"
    struct Places { count: u32, at: [glam::Vec3; 3], last: glam::Vec2, }
        = "count: u32, at: array<vec3f, 3>, last: vec2f"
    struct Attributes { #[shader(size(32))] a: f32, #[shader(align(16))] b: f32, c: glam::IVec3, }
        = "@size(32) a: f32, @align(16) b: f32, c: vec3i"
    struct Inner { at: glam::Vec3, }
        = "at: vec3f"
    struct Outer { a: f32, inner: Inner, inners: [Inner; 2], b: f32, }
        = "a: f32, inner: Inner, inners: array<Inner, 2>, b: f32"
    struct Endless { count: u32, #[shader(size(runtime))] lights: Vec<Light>, }
        = "count: u32, lights: array<Light>"
    struct Words { a: f32, w: [f32; 7], v: [glam::Vec2; 2], b: f32, }
        = "a: f32, w: array<f32, 7>, v: array<vec2f, 2>, b: f32"
}

#[test]
fn structures_of_encase_are_right_where_encase_writes_what_the_shader_reads() {
    let all = rows();
    let structures: String = all.iter().map(|((_, text, ..), _)| *text).collect();
    let declarations: String =
        all.iter().map(|((name, ..), wgsl)| format!("struct {name} {{ {wgsl} }}\n")).collect();
    for ((name, _, fields, size), _) in &all {
        let shader =
            format!("{declarations}@group(0) @binding(0) var<storage, read> held: {name};\n");
        // The shader is laid out as encase writes.
        let layout = landfall_layout::layout(
            &Source::new("a.wgsl", shader.as_str()),
            &landfall_layout::Options::default(),
        );
        let members: &[MemberLayout] = &layout.blocks[0].members;
        let offsets: Vec<(&str, u64)> =
            members.iter().map(|m| (&*m.name, m.offset.expect("it has one"))).collect();
        assert_eq!(offsets, *fields, "{name}, {size} bytes");
        let text = structures.replace(
            &format!("#[derive(encase::ShaderType)] struct {name} "),
            &format!("// landfall: mirror({name})\n#[derive(encase::ShaderType)] struct {name} "),
        );
        assert_eq!(held_wgsl(&text, &shader), [], "{name}");
    }
}

fn held_wgsl(text: &str, shader: &str) -> Vec<landfall_layout::finding::Finding> {
    let settings = Settings { rust_files: vec![rust(text)], ..Settings::default() };
    assert_eq!(asked("rust-mirror-unknown", &settings, &[("a.wgsl", shader)]), []);
    asked("rust-mirror", &settings, &[("a.wgsl", shader)])
}

const LIGHT: &str =
    "struct Light { at: vec4f, color: vec3f }\n@group(0) @binding(0) var<uniform> light: Light;\n";

#[test]
fn what_encase_refuses_is_said_with_a_type_that_it_takes() {
    // "array stride must be a multiple of 16 (current stride: 4)", says encase.
    type Floats = [f32; 4];
    assert!(std::panic::catch_unwind(Floats::assert_uniform_compat).is_err());
    let text = "// landfall: mirror(Light)\n#[derive(ShaderType)]\nstruct Light { at: [f32; 4], color: glam::Vec3 }\n";
    let found = held_wgsl(text, LIGHT);
    assert_eq!(
        found.iter().map(said).collect::<Vec<_>>(),
        [
            "3:16 encase refuses `at` of `Light` in a uniform buffer: its array stride is 4 bytes, no multiple of 16"
        ]
    );
    assert_eq!(help(&found[0]), "make it `glam::Vec4`");
    assert_eq!(held_wgsl(&text.replace("[f32; 4]", "glam::Vec4"), LIGHT), []);
    // In a storage buffer it takes them.
    assert_eq!(held_wgsl(text, &LIGHT.replace("<uniform>", "<storage>")), []);
    for (ty, cause) in [
        ("bool", "field `at`: encase does not write `bool`"),
        ("glam::Vec3A", "field `at`: encase does not write `glam::Vec3A`"),
        ("Inner", "field `at`: `Inner` does not derive `ShaderType`"),
    ] {
        let text = format!("struct Inner {{ a: f32 }}\n{}", text.replace("[f32; 4]", ty));
        let settings = Settings { rust_files: vec![rust(&text)], ..Settings::default() };
        let found = asked("rust-mirror-unknown", &settings, &[("a.wgsl", LIGHT)]);
        let message = format!("4:8 `Light` cannot be compared with `Light`: {cause}");
        assert_eq!(found.iter().map(said).collect::<Vec<_>>(), [message]);
    }
}

#[test]
fn a_wrong_structure_of_encase_gets_advice_that_encase_takes() {
    let shader = "struct Light { at: vec3f, color: vec4f, w: array<vec4f, 3> }\n\
                  @group(0) @binding(0) var<uniform> light: Light;\n";
    let text = "// landfall: mirror(Light)\n#[derive(ShaderType)]\nstruct Light {\n    at: glam::Vec2,\n    color: glam::Vec3,\n    w: [f32; 3],\n}\n";
    let found = held_wgsl(text, shader);
    let helps: Vec<&str> = found.iter().map(help).collect();
    assert_eq!(
        helps,
        ["make it `glam::Vec3`", "make it `glam::Vec4`", "make it `[glam::Vec4; 3]`"]
    );
    let right = text
        .replace("glam::Vec3", "glam::Vec4")
        .replace("glam::Vec2", "glam::Vec3")
        .replace("[f32; 3]", "[glam::Vec4; 3]");
    assert_eq!(held_wgsl(&right, shader), []);
}

/// Fields, members, and where crevice puts them by std140 and std430.
const CREVICE: &str = "use mint::*;
#[derive(AsStd140, AsStd430)] struct Inner { a: f32 }
// landfall: mirror(Light)
#[derive(AsStd140, AsStd430)] struct Light { pos: Vector3<f32>, color: Vector3<f32>, power: f32 }
// landfall: mirror(Turn)
#[derive(AsStd140, AsStd430)] struct Turn { gain: f32, turn: ColumnMatrix3<f32>, end: f32 }
// landfall: mirror(Two)
#[derive(AsStd140, AsStd430)] struct Two { gain: f32, turn: ColumnMatrix2<f32>, end: f32 }
// landfall: mirror(Flags)
#[derive(AsStd140, AsStd430)] struct Flags { a: bool, b: Vector2<i32>, c: f64, d: Vector4<u32> }
// landfall: mirror(Outer)
#[derive(AsStd140, AsStd430)] struct Outer { b: f32, inner: Inner, c: f32 }
";

#[test]
fn structures_of_crevice_are_right_by_the_rules_of_the_block() {
    let text = |rules: &str, kind: &str| {
        format!(
            "#version 450\nstruct Inner {{ float a; }};
layout({rules}, binding = 0) {kind} Light {{ vec3 pos; vec3 color; float power; }};
layout({rules}, binding = 1) {kind} Turn {{ float gain; mat3 turn; float end; }} t;
layout({rules}, binding = 2) {kind} Two {{ float gain; mat2 turn; float end; }} u;
layout({rules}, binding = 3) {kind} Flags {{ bool a; ivec2 b; double c; uvec4 d; }} f;
layout({rules}, binding = 4) {kind} Outer {{ float b; Inner inner; float c; }} o;
void main() {{}}\n"
        )
    };
    // crevice: std140 [0, 16, 28] 32, [0, 16, 64] 80, [0, 16, 48] 64, [0, 8, 16, 32] 48,
    // [0, 16, 32] 48; std430 the same for the first two and `Flags`, then [0, 8, 24] 32, [0, 4, 8] 12.
    assert_eq!(held(CREVICE, &text("std140", "uniform")), []);
    assert_eq!(held(CREVICE, &text("std430", "buffer")), []);
    let only = CREVICE.replace("AsStd140, AsStd430", "AsStd140");
    let found = held(&only, &text("std430", "buffer"));
    let mut lines: Vec<u32> = found.iter().map(|finding| finding.place().line).collect();
    lines.dedup();
    assert_eq!(lines, [8, 12], "{found:#?}");
}
