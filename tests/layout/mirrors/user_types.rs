//! Mirrors with types of the program in them: the same bytes, and a compiler that says what differs.

use landfall_codegen::rust::{RustOptions, Vectors, rust};

use super::support::rustc::{Math, Target, check, crates, run, shown};
use super::{laid_out, written};

const TEXT: &str = "#version 450
struct Light { vec3 position; float power; vec3 color; float weights[3]; mat4 view; };
struct Pair { float a; float b; };
layout(std140) uniform Lights { Light data[2]; vec2 tight[2]; Pair pair; vec3 last; } lights;
layout(std430) buffer Points { uint count; vec3 at[]; } points;
void main() {}
";

/// Types as an engine has them; `Pos3` has other fields than an array.
const ENGINE: &str = "use mirrors::*;
pub mod engine {
    use bytemuck::{Pod, Zeroable};
    #[repr(C)]
    #[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
    pub struct Pos3 { pub x: f32, pub y: f32, pub z: f32 }
    #[repr(transparent)]
    #[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
    pub struct Vector<const N: usize>(pub [f32; N]);
    #[repr(C)]
    #[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
    pub struct Two { pub first: f32, pub second: f32, pub rest: [f32; 2] }
    #[repr(C, align(16))]
    #[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
    pub struct Wide(pub [f32; 4]);
    #[repr(C, align(8))]
    #[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
    pub struct Aligned(pub [f32; 2]);
}
";

const MAPPED: &[(&str, &str)] = &[
    ("Light.position", "crate::engine::Pos3"),
    ("vec3", "crate::engine::Vector<3>"),
    ("vec2<f32>", "crate::engine::Vector<2>"),
    ("Pair", "crate::engine::Two"),
    ("mat4", "crate::engine::Vector<16>"),
];

fn options(types: &[(&str, &str)]) -> RustOptions {
    let mut options = RustOptions::default();
    options.vectors = Vectors::Array;
    options.types = types.iter().map(|(of, path)| (of.to_string(), path.to_string())).collect();
    options
}

/// A program's root with the mirrors in a module.
fn root(name: &str, types: &[(&str, &str)], rest: &str) -> std::path::PathBuf {
    let output = rust(&[&laid_out("a.frag", TEXT)], &options(types));
    assert!(output.diagnostics.is_empty(), "{:?}", output.diagnostics);
    with_engine(name, &output.text, rest)
}

/// The same of mirrors that are given.
fn with_engine(name: &str, mirrors: &str, rest: &str) -> std::path::PathBuf {
    let text = format!(
        "pub mod mirrors {{ include!(\"mirrors.rs\"); }}\n#[allow(unused_imports)]\n{ENGINE}\n{rest}"
    );
    written(&format!("user-types-{name}"), mirrors, &text)
}

/// A program that writes the bytes of a block and of a tail.
fn program(pos: &str, three: &str, two: &str, pair: &str, view: &str) -> String {
    format!(
        "fn main() {{
    let light = |n: f32| Light::new(LightInit {{
        position: {pos}, power: n + 3.0, color: {three}, weights: [n, n + 1.0, n + 2.0], view: {view},
    }});
    let n = 9.0;
    let block = Lights::new(LightsInit {{
        data: [light(1.0), light(50.0)], tight: [{two}, {two}], pair: {pair}, last: {three},
    }});
    let mut bytes = bytemuck::bytes_of(&block).to_vec();
    let mut tail = vec![0; PointsHeader::size_for(2)];
    let points = [{three}; 2].map(PointsElement::from);
    PointsHeader::new(PointsHeaderInit {{ count: 2 }}).write_to(&points, &mut tail).unwrap();
    bytes.extend(tail);
    std::io::Write::write_all(&mut std::io::stdout(), &bytes).unwrap();
}}
"
    )
}

#[test]
fn a_mirror_with_types_of_the_program_has_the_same_bytes() {
    let columns = "[n, 1.0, 2.0, 3.0], [4.0, 5.0, 6.0, 7.0], [8.0, 9.0, 10.0, 11.0], [0.5; 4]";
    let plain = program(
        "[n, n + 1.0, n + 2.0]",
        "[n + 5.0, 6.0, 7.0]",
        "[n, 4.0]",
        "Pair::new(PairInit { a: 1.5, b: 2.5 })",
        &format!("[{columns}]"),
    );
    let mapped = program(
        "engine::Pos3 { x: n, y: n + 1.0, z: n + 2.0 }",
        "engine::Vector([n + 5.0, 6.0, 7.0])",
        "engine::Vector([n, 4.0])",
        "engine::Two { first: 1.5, second: 2.5, rest: [0.0; 2] }",
        &format!("engine::Vector(bytemuck::cast([{columns}]))"),
    );
    let plain = run(crates(Math::Simd), &root("plain", &[], &plain), "2021");
    let mapped = run(crates(Math::Simd), &root("mapped", MAPPED, &mapped), "2021");
    assert_eq!(plain.len(), 2 * 144 + 2 * 16 + 16 + 16 + 48);
    assert_eq!(plain, mapped);
}

#[test]
fn a_type_of_another_size_or_alignment_does_not_compile_and_is_named() {
    let cases = [
        (
            ("vec3", "crate::engine::Wide"),
            "size of `crate::engine::Wide`, the type for `color` of `Light` in a.frag: 12 bytes in \
             the shader, 16 in its mirror",
        ),
        (
            ("Light.power", "crate::engine::Two"),
            "size of `crate::engine::Two`, the type for `power` of `Light` in a.frag: 4 bytes in \
             the shader, 16 in its mirror",
        ),
        (
            ("Pair", "crate::engine::Pos3"),
            "size of `crate::engine::Pos3`, the type for `pair` of `Lights` in a.frag: 16 bytes in \
             the shader, 12 in its mirror",
        ),
    ];
    for (case, message) in cases {
        let path = root("wrong", &[case], "fn main() {}\n");
        let out = check("rustc", crates(Math::Simd), &path, "2021", Target::Program);
        let log = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(!out.status.success() && log.contains(message), "{message}:\n{log}");
    }
    // Room for 8 bytes at a multiple of 4.
    let text = TEXT.replace("uint count; vec3 at[];", "uint count; Pair pairs[];");
    let output =
        rust(&[&laid_out("a.frag", &text)], &options(&[("Pair", "crate::engine::Aligned")]));
    let path = with_engine("align", &output.text, "fn main() {}\n");
    let out = check("rustc", crates(Math::Simd), &path, "2021", Target::Program);
    let log = String::from_utf8_lossy(&out.stderr).into_owned();
    let message = "alignment of `crate::engine::Aligned`, the type for `pairs` of `Points` in a.frag, \
                   is more than 4";
    assert!(!out.status.success() && log.contains(message), "{}", shown(&out.stderr));
}

#[test]
fn a_type_that_is_none_or_fits_nothing_is_named() {
    let given = [("vec3", "a::b; mod c {}"), ("Light.positoin", "a::B"), ("float", "f32")];
    let output = rust(&[&laid_out("a.frag", TEXT)], &options(&given));
    let messages: Vec<&str> = output.diagnostics.iter().map(|d| d.message.as_str()).collect();
    assert_eq!(
        messages,
        [
            "`vec3` cannot have the type `a::b; mod c {}`: it is no path in Rust",
            "the type for `Light.positoin` has no effect: no member is one",
        ]
    );
    assert!(!output.text.contains("mod c"));
}

/// `PartialOrd` for floats of all kinds; nothing is derived twice.
#[test]
fn every_type_derives_what_is_asked_for() {
    let text = "#version 450\n#extension GL_EXT_shader_16bit_storage : require\n\
                struct S { bool on; mat3 m; float w[2]; };\n\
                layout(std140) uniform B { S s[2]; vec3 v; } b;\n\
                layout(std430) buffer H { float16_t h; } h;\nvoid main() {}\n";
    let mut options = options(&[]);
    options.derives = ["PartialOrd", "Debug", "crate::Marked"].map(str::to_string).to_vec();
    let output = rust(&[&laid_out("a.frag", text)], &options);
    assert!(output.diagnostics.is_empty(), "{:?}", output.diagnostics);
    // A derive of the program's own would be a crate of its own.
    let text = output.text.replace(", crate::Marked", "");
    assert_ne!(text, output.text);
    let main = "mod mirrors { include!(\"mirrors.rs\"); }
use mirrors::*;
fn is<T: PartialOrd + core::fmt::Debug + bytemuck::Pod>() {}
fn main() {
    is::<B>();
    is::<S>();
    is::<H>();
    is::<F16>();
    assert!(Bool::new(false) < Bool::new(true));
    let init = SInit { on: true, m: [[1.0; 3]; 3], w: [1.0, 2.0] };
    assert!(init < SInit { on: true, m: [[1.0; 3]; 3], w: [1.0, 3.0] });
}
";
    let path = written("derives", &text, main);
    run(crates(Math::Simd), &path, "2021");
    options.derives = vec!["Clone)] fn f() {}".to_string()];
    let bad = rust(&[&laid_out("a.frag", "layout(std140) uniform B { vec3 v; };")], &options);
    assert_eq!(
        bad.diagnostics[0].message,
        "`Clone)] fn f() {}` cannot be derived: it is no path in Rust"
    );
}

/// Against the crate `half`: every number of 16 bits, and numbers of 32 bits around all of them.
#[test]
fn sixteen_bit_floats_are_converted_as_half_does() {
    let text = "#version 450\n#extension GL_EXT_shader_16bit_storage : require\n\
                #extension GL_EXT_bfloat16 : require\n\
                layout(std430) buffer B { float16_t a; bfloat16_t b; } b_;\nvoid main() {}\n";
    let output = rust(&[&laid_out("half.comp", text)], &options(&[]));
    let main = "mod mirrors { include!(\"mirrors.rs\"); }
use mirrors::{Bf16, F16};
fn main() {
    let mut bytes = Vec::new();
    for bits in 0..=u16::MAX {
        bytes.extend(F16::from_bits(bits).to_f32().to_bits().to_le_bytes());
        bytes.extend(Bf16::from_bits(bits).to_f32().to_bits().to_le_bytes());
    }
    for at in 0..1u32 << 20 {
        let value = f32::from_bits(at << 12 | [0, 1, 0x800, 0xfff][at as usize % 4]);
        bytes.extend(F16::from_f32(value).to_bits().to_le_bytes());
        bytes.extend(Bf16::from_f32(value).to_bits().to_le_bytes());
    }
    std::io::Write::write_all(&mut std::io::stdout(), &bytes).unwrap();
}
";
    let path = written("half", &output.text, main);
    let bytes = run(crates(Math::Simd), &path, "2021");
    let mut expected = Vec::new();
    for bits in 0..=u16::MAX {
        // A signalling NaN stays one only without a computation in between.
        let quiet = |value: f32, bits: u32| if value.is_nan() { bits } else { value.to_bits() };
        let (sign, payload) = (u32::from(bits & 0x8000) << 16, u32::from(bits & 0x3ff) << 13);
        let half = quiet(half::f16::from_bits(bits).to_f32(), sign | 0x7f80_0000 | payload);
        expected.extend(half.to_le_bytes());
        let wide = u32::from(bits) << 16;
        expected.extend(quiet(half::bf16::from_bits(bits).to_f32(), wide).to_le_bytes());
    }
    for at in 0..1u32 << 20 {
        let value = f32::from_bits(at << 12 | [0, 1, 0x800, 0xfff][at as usize % 4]);
        expected.extend(half::f16::from_f32(value).to_bits().to_le_bytes());
        expected.extend(half::bf16::from_f32(value).to_bits().to_le_bytes());
    }
    let differs = bytes.chunks(2).zip(expected.chunks(2)).position(|(a, b)| a != b);
    assert_eq!((bytes.len(), differs), (expected.len(), None));
}
