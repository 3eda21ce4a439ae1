//! Constants and macros that lengths of arrays are written with: their values against glslang and
//! naga, and as they stand in generated code.

use std::fmt::Write as _;

use landfall_codegen::languages::{C, CSHARP, GDSCRIPT, PYTHON, RUST, TYPESCRIPT, ZIG};
use landfall_codegen::{CodeOptions, OutputLanguage};
use landfall_layout::ShaderLayout;

use super::support;
use support::landfall::laid_out;
use support::leaf::OracleBlock;
use support::{c, glslang, naga_wgsl, rustc, sample};

fn constants(shader: &ShaderLayout) -> Vec<(&str, u32)> {
    shader.constants.iter().map(|constant| (&*constant.name, constant.value)).collect()
}

fn code(language: OutputLanguage, shaders: &[&ShaderLayout]) -> String {
    let output = language.generate(shaders, &CodeOptions::default());
    assert!(output.diagnostics.is_empty(), "{:?}", output.diagnostics);
    output.text
}

const LIGHTS: &str = "#version 450\n#define MAX_LIGHTS 16\n#define UNUSED 3\n\
    const int cascades = MAX_LIGHTS / 4;\nlayout(constant_id = 0) const int SPECIAL = 5;\n\
    struct Other { float lone[UNUSED]; };\nstruct Light { vec4 position; float split[cascades]; };\n\
    layout(std140, binding = 0) uniform Lights { Light lights[MAX_LIGHTS]; vec4 of[SPECIAL]; } l;\n\
    void main() {}\n";

#[test]
fn only_what_lengths_of_blocks_name_is_exported() {
    assert_eq!(constants(&laid_out("a.frag", LIGHTS)), [("cascades", 4), ("MAX_LIGHTS", 16)]);
    let wgsl = "const MAX = 4u; const HALF = MAX / 2; const UNUSED = 7; override SPECIAL = 3u;\n\
        struct Light { a: array<vec4f, HALF + 1> } struct Other { a: array<f32, UNUSED> }\n\
        alias Lights = array<Light, MAX>;\n\
        @group(0) @binding(0) var<storage> lights: Lights;\n\
        var<workgroup> shared_: array<f32, SPECIAL>;\n";
    assert_eq!(constants(&laid_out("a.wgsl", wgsl)), [("HALF", 2), ("MAX", 4)]);
    // A macro with parameters is no constant, and one name has one value.
    let others = "#version 450\n#define TWICE(n) (2 * n)\n#define N 3\n\
        layout(std140, binding = 0) uniform A { vec4 a[TWICE(2)]; vec4 b[TWICE(N)]; vec4 c[N]; } a;\n\
        #define M 4\nlayout(std140, binding = 1) uniform B { vec4 d[M]; } b[N];\n#undef M\n#define M 5\n\
        layout(std140, binding = 9) uniform C { vec4 e[M]; } c;\nuniform float loose[TWICE(1)];\n\
        void main() {}\n";
    assert_eq!(constants(&laid_out("b.frag", others)), [("N", 3)]);
}

/// A random expression of a positive integer, of these names.
fn expression(random: &mut impl FnMut(u64) -> u64, names: &[String], suffix: &str) -> String {
    let name = match names.len() {
        0 => format!("1{suffix}"),
        count => names[random(count as u64) as usize].clone(),
    };
    let number = random(5) + 1;
    match random(4) {
        0 => format!("{number}{suffix}"),
        1 => format!("({name} + {number}{suffix})"),
        2 => format!("({name} * 2{suffix} - {name})"),
        _ => format!("max({name}, {number}{suffix})"),
    }
}

/// Compares the constants of a shader, of which each is the length of one member of its name, with an
/// oracle's dimensions.
fn hold(shader: &ShaderLayout, oracle: &[OracleBlock], count: usize, text: &str) {
    let leaves = oracle.iter().flat_map(|block| &block.leaves);
    let dims: Vec<(String, u64)> = leaves
        .map(|leaf| {
            let name = leaf.path.split('[').next().expect("a first part").replace("of_", "");
            (name, leaf.dims[0].expect("a fixed length"))
        })
        .collect();
    let ours: Vec<(String, u64)> =
        constants(shader).iter().map(|(name, value)| (name.to_string(), (*value).into())).collect();
    assert_eq!(ours.len(), count, "{text}");
    assert_eq!(ours, dims, "{text}");
}

#[test]
fn values_of_random_constants_are_those_of_glslang_and_naga() {
    for seed in sample::sample(0..60, 4) {
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut random = |below: u64| rng.u64(..below);
        let (mut glsl, mut wgsl) = ("#version 450\n".to_string(), String::new());
        let mut names = Vec::new();
        for number in 0..6 {
            let name = format!("N{number}");
            let value = expression(&mut random, &names, "");
            let _ = match random(2) {
                0 => writeln!(glsl, "#define {name} {value}"),
                _ => writeln!(glsl, "const int {name} = {value};"),
            };
            let _ = writeln!(wgsl, "const {name} = {};", expression(&mut random, &names, "u"));
            names.push(name);
        }
        let members = |spelled: fn(&str) -> String| names.iter().map(|n| spelled(n)).collect();
        let glsl_members: String = members(|name| format!("float of_{name}[{name}]; "));
        let wgsl_members: String = members(|name| format!("of_{name}: array<f32, {name}>, "));
        let _ = writeln!(
            glsl,
            "layout(std430, binding = 0) buffer B {{ {glsl_members} }} b;\nvoid main() {{}}"
        );
        let _ = writeln!(
            wgsl,
            "struct B {{ {wgsl_members} }}\n@group(0) @binding(0) var<storage> b: B;"
        );
        let oracle = glslang::blocks(&glsl, "frag", &glslang::Options::default());
        hold(&laid_out("a.frag", &glsl), &oracle.expect("glslang reads it"), 6, &glsl);
        let oracle = naga_wgsl::blocks(&wgsl).expect("naga reads it");
        hold(&laid_out("a.wgsl", &wgsl), &oracle, 6, &wgsl);
    }
}

#[test]
fn constants_stand_once_in_every_language() {
    let shader = laid_out("a.frag", LIGHTS);
    for (language, line) in [
        (RUST, "pub const MAX_LIGHTS: usize = 16;"),
        (RUST, "pub const CASCADES: usize = 4;"),
        (C, "enum { MAX_LIGHTS = 16 };"),
        (CSHARP, "public const uint MAX_LIGHTS = 16;"),
        (PYTHON, "MAX_LIGHTS = 16\n"),
        (TYPESCRIPT, "export const MAX_LIGHTS = 16;"),
        (ZIG, "pub const MAX_LIGHTS: usize = 16;"),
        (GDSCRIPT, "const MAX_LIGHTS := 16"),
    ] {
        let again = laid_out("again.frag", LIGHTS);
        let text = code(language, &[&shader, &again]);
        let modules = if language == RUST { 2 } else { 1 };
        assert_eq!(text.matches(line).count(), modules, "{line}\n{text}");
        assert!(!text.contains("UNUSED") && !text.contains("SPECIAL"), "{text}");
    }
    // Of two files with different values, none is that of a name.
    let other = laid_out("b.frag", &LIGHTS.replace("MAX_LIGHTS 16", "MAX_LIGHTS 8"));
    let text = code(C, &[&shader, &other]);
    assert!(!text.contains("enum { MAX_LIGHTS") && !text.contains("enum { CASCADES"), "{text}");
    // Rust has a module for each.
    let text = code(RUST, &[&shader, &other]);
    assert!(text.contains("MAX_LIGHTS: usize = 16;") && text.contains("MAX_LIGHTS: usize = 8;"));
    // A structure keeps its name.
    let clash = "#version 450\nstruct N { vec4 a; };\n#define n 4\n\
        layout(std140, binding = 0) uniform B { N all[n]; };\nvoid main() {}\n";
    let clash = laid_out("c.frag", clash);
    for language in [RUST, C, CSHARP, PYTHON, TYPESCRIPT, ZIG, GDSCRIPT] {
        let text = code(language, &[&clash]);
        assert!(!text.contains("N: usize") && !text.contains("N = 4"), "{text}");
    }
}

#[test]
fn compilers_take_constants_as_lengths() {
    let shader = laid_out("a.frag", LIGHTS);
    let directory = c::directory("length_constants");
    std::fs::write(directory.join("a.h"), code(C, &[&shader])).expect("written");
    let program = "static float own[MAX_LIGHTS];\nint main(void) {\n    Lights all;\n    \
        (void)own;\n    return sizeof all.lights / sizeof all.lights[0] == MAX_LIGHTS &&\n    \
        sizeof own == MAX_LIGHTS * sizeof(float) ? 0 : 1;\n}\n";
    std::fs::write(directory.join("a.c"), format!("#include \"a.h\"\n{program}")).expect("written");
    // A program may have the macro already, with the value of the shader.
    let with = |value: u32| format!("#define MAX_LIGHTS {value}\n#include \"a.h\"\n{program}");
    std::fs::write(directory.join("b.c"), with(16)).expect("written");
    std::fs::write(directory.join("bad.c"), with(8)).expect("written");
    for compiler in c::BOTH {
        c::compile_and_run(compiler, &directory, "a.c");
        c::compile_and_run(compiler, &directory, "b.c");
        let log = c::compile(compiler, &directory, "bad.c").expect_err("8 is not 16");
        assert!(log.contains("`MAX_LIGHTS` is 16 in the shader"), "{log}");
    }
    let root = rustc::scratch("length_constants").join("main.rs");
    let main = "fn main() {\n    let lights = [Light::default(); MAX_LIGHTS];\n    \
        let of: Lights = Lights { lights, ..Default::default() };\n    \
        assert_eq!(of.lights.len(), MAX_LIGHTS);\n    print!(\"{MAX_LIGHTS}\");\n}\n";
    std::fs::write(&root, format!("{}\n{main}", code(RUST, &[&shader]))).expect("written");
    let crates = rustc::crates(rustc::Math::Simd);
    assert_eq!(rustc::shown(&rustc::run(crates, &root, "2021")), "16");
}
