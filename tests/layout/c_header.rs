//! Generated C headers, compiled by gcc as C11 and by g++ as C++17 with every
//! warning an error, and run: each leaf is filled through the structure and
//! found in the bytes where glslang's SPIR-V says it is.

use crate::support;

use std::path::Path;

use landfall_codegen::c::{COptions, c};
use landfall_layout::{Options, ShaderLayout, Source, Target};
use support::c::{BOTH, Compiler, compile, compile_and_run, directory, hold_by};
use support::generate::{COMMON, Diet, VULKAN, random};
use support::glslang;
use support::known::{Oracle, Subject, explains};
pub use support::landfall::laid_out_for_vulkan as lay_out;
use support::leaf::{OracleBlock, What, differences};
use support::run::{Batch, ask_glslang};
use support::sample::{everything, sample};

/// Whether glslang departs from the specification in a block, in a way that is known.
pub fn misread(batch: &Batch, oracle: &[OracleBlock], block: &str) -> bool {
    let ours = support::landfall::glsl_blocks(&batch.text(), Target::Vulkan);
    let block = batch.blocks.iter().find(|b| b.name == block).expect("asked of its blocks");
    let subject = Subject { block, standing: &batch.standing };
    differences(&ours, oracle)
        .iter()
        .filter(|difference| difference.block == block.name && difference.what != What::Type)
        .any(|difference| explains(subject, difference, Some(Oracle::Glslang)).is_some())
}

/// One header for random blocks; how many were held and how many refused.
fn random_blocks(name: &str, seed: u64, count: usize, diet: &Diet) -> (usize, usize) {
    random_blocks_by(&BOTH, &named("blocks.h", ""), name, (seed, count, diet))
}

/// The same by some compilers and with options of the header.
pub fn random_blocks_by(
    compilers: &[Compiler],
    options: &COptions,
    name: &str,
    (seed, count, diet): (u64, usize, &Diet),
) -> (usize, usize) {
    let (standing, blocks) = random(seed, count, diet);
    let batch = Batch { name: format!("{name} {seed}"), standing, blocks };
    let mut oracle = ask_glslang(&batch);
    let all = oracle.clone();
    oracle.retain(|block| !misread(&batch, &all, &block.name));
    let layout = lay_out("shaders/random.comp", &batch.text());
    let output = c(&[&layout], options);
    assert_eq!(c(&[&layout], options).text, output.text, "the same header every time");
    let held = hold_by(compilers, &format!("{name}_{seed}"), &output, &oracle);
    (held, output.diagnostics.len())
}

#[test]
fn random_blocks_are_filled_where_glslang_reads_them() {
    let mut held = 0;
    for seed in sample(0..5, 5) {
        let (some, refused) = random_blocks("common", seed, 60, &COMMON);
        assert_eq!(refused, 0, "std140 and std430 fit C");
        held += some;
    }
    assert!(held >= if everything() { 250 } else { 40 }, "{held} held");
}

/// Scalar layout reuses the padding at the end of structures, which C cannot.
#[test]
fn random_vulkan_blocks_are_filled_where_glslang_reads_them() {
    let (mut held, mut refused) = (0, 0);
    for seed in sample(0..3, 3) {
        let (some, others) = random_blocks("vulkan", seed, 60, &VULKAN);
        held += some;
        refused += others;
    }
    let least = if everything() { 160 } else { 40 };
    assert!(held >= least && refused <= 20, "{held} held, {refused} refused");
}

/// Blocks C has trouble with: keywords, clashes, one structure under several rules, padding of
/// every kind, runtime-sized tails.
pub const CORPUS: &[(&str, &str)] = &[
    (
        "names",
        "struct near { float far; float delete; float errno; };
         struct Light { vec3 Light_; float near; };
         layout(std140) uniform register_ { near linux; Light Light_[2]; float template_; int a_b; } r_;
         layout(std140) uniform MVP { mat4 mvp; float SIZE; float size; } u_mvp;
         layout(std140) uniform A { float data_size[2]; struct_t_ s; float a_b; struct_t_ a; } a_;
         layout(std140) uniform A_DATA { float size; float data; } b_;",
    ),
    (
        "one structure under three rules",
        "struct S { vec3 a; float b; mat2 c; float d[3]; };
         layout(std140) uniform B0 { S s; S t[2]; } b0;
         layout(std430) buffer B1 { S s; S t[2]; } b1;
         layout(scalar) buffer B2 { S s; S t[2]; } b2;
         layout(std140, row_major) uniform B3 { S s; S t[2]; } b3;",
    ),
    (
        "runtime-sized tails",
        "struct P { vec3 pos; float mass; vec2 uv; };
         layout(std430) buffer T0 { uint count; P all[]; } t0;
         layout(std430) buffer T1 { P all[]; } t1;
         layout(std140) buffer T2 { vec4 head; float weights[]; } t2;
         layout(std430) buffer T3 { dvec2 head; float odd; float all[][3][2]; } t3;
         layout(std140) buffer T4 { mat3x2 all[][2]; } t4;
         layout(scalar) buffer T5 { double head; float odd; vec3 all[]; } t5;
         layout(std430) buffer T6 { float head; vec4 _pad_4[]; } t6;",
    ),
    (
        "packed structures",
        "struct D { double a; float b; };
         layout(scalar) buffer K0 { D one; float next; D more; } k0;
         layout(scalar) buffer K1 { float a; f16vec3 b; int8_t c; } k1;
         layout(scalar) buffer K2 { float a; dvec3 b[3]; dmat2x3 c; } k2;",
    ),
    (
        "explicit offsets",
        "layout(std140) uniform O0 {
             layout(offset = 64) vec3 late;
             layout(offset = 0) float early;
             layout(offset = 16) mat2x3 middle;
             layout(align = 256, offset = 256) float far;
         } o0;
         layout(std430) buffer O1 {
             float a;
             layout(align = 64) struct_t_ b;
             float c[2][3][1];
         } o1[3];",
    ),
    (
        "matrices",
        "layout(std140) uniform M0 {
             mat2 a; mat2x3 b; mat3x4 c; layout(row_major) mat2x3 d; layout(row_major) mat4x2 e[2];
             mat3 f[2][2]; dmat2x3 g; bvec3 h; bool i[2]; ivec2 j; uvec4 k;
         } m0;
         layout(std430) buffer M1 { mat2 a; mat2x3 b; layout(row_major) mat3x2 c[2]; mat4 d; } m1;",
    ),
];

#[test]
fn awkward_blocks_are_filled_where_glslang_reads_them() {
    awkward_blocks_by(&BOTH, &COptions::default(), "");
}

/// The same by some compilers and with options of the header.
pub fn awkward_blocks_by(compilers: &[Compiler], options: &COptions, prefix: &str) {
    for (name, declarations) in CORPUS {
        let text = format!(
            "#version 450\n#extension GL_EXT_scalar_block_layout : require\n\
             #extension GL_EXT_shader_16bit_storage : require\n\
             #extension GL_EXT_shader_8bit_storage : require\n\
             layout(local_size_x = 1) in;\nstruct struct_t_ {{ float x; vec3 y; }};\n\
             {declarations}\nvoid main() {{}}\n"
        );
        let vulkan = glslang::Options { target_env: Some("vulkan1.2"), ..Default::default() };
        let oracle = glslang::blocks(&text, "comp", &vulkan)
            .unwrap_or_else(|e| panic!("glslang refuses {name}: {e}"));
        let layout = lay_out("corpus.comp", &text);
        let output = c(&[&layout], options);
        assert!(output.diagnostics.is_empty(), "{name}: {:?}", output.diagnostics);
        let folder = format!("{prefix}{}", name.replace(' ', "_"));
        let held = hold_by(compilers, &folder, &output, &oracle);
        assert_eq!(held, oracle.len(), "{name}");
    }
}

/// Every block of every shader of this repository, loose uniforms gathered: the assertions in the
/// headers hold sizes and offsets when they compile.
fn named(file: &str, prefix: &str) -> COptions {
    let mut options = COptions::default();
    (options.file, options.prefix) = (file.to_string(), prefix.to_string());
    options
}

#[test]
fn the_shaders_of_this_repository_have_headers_that_compile() {
    let directory = directory("shaders");
    let options = Options::default().with_gather(true);
    let mut program = String::new();
    for (at, path) in support::files::shaders().iter().enumerate() {
        let shader =
            landfall_layout::layout(&Source::read(path).expect("a readable shader"), &options);
        let (file, prefix) = (format!("shader{at}.h"), format!("s{at}_"));
        let output = c(&[&shader], &named(&file, &prefix));
        std::fs::write(directory.join(&file), output.text).expect("the directory can be written");
        program.push_str(&format!("#include \"{file}\"\n"));
    }
    program.push_str("int main(void) { return 0; }\n");
    std::fs::write(directory.join("all.c"), program).expect("the directory can be written");
    for compiler in [Compiler::C11, Compiler::Cpp17] {
        let done = compile(compiler, &directory, "all.c");
        assert!(done.is_ok(), "{}", done.unwrap_err());
    }
}

/// The example: an engine in C++ that had a table of offsets written by hand.
#[test]
fn an_engine_sets_members_by_name() {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/cpp_engine");
    let text = std::fs::read_to_string(sources.join("lights.frag")).expect("the example's shader");
    let layout = lay_out("examples/cpp_engine/lights.frag", &text);
    let options = named("lights.h", "");
    let directory = directory("engine");
    std::fs::write(directory.join("lights.h"), c(&[&layout], &options).text).expect("written");
    std::fs::copy(sources.join("engine.cpp"), directory.join("engine.cpp")).expect("copied");
    let bytes = compile_and_run(Compiler::Cpp17, &directory, "engine.cpp");

    let (ambient, point) = (0, 16 + 4112);
    assert_eq!(bytes.len(), point + 6160);
    let float = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().expect("4 bytes"));
    assert_eq!(float(ambient + 12), 0.25);
    assert_eq!([float(point), float(point + 8), float(point + 16)], [-2.0, 5.0, 1.0]);
    let second = point + 48;
    assert_eq!([float(second), float(second + 20), float(second + 28)], [2.0, 1.0, 3.0]);
    assert_eq!([float(second + 32), float(second + 36), float(second + 40)], [1.0, 0.35, 0.44]);
    assert_eq!(bytes[point + 6144..point + 6148], 2i32.to_le_bytes());
}

const HEAD: &str = "#version 450\nlayout(local_size_x = 1) in;\n";

/// What several headers share is in each of them, and once in the program.
#[test]
fn headers_that_share_a_structure_stand_beside_each_other() {
    let light = "struct Light { vec3 pos; /* meters */ float w[2]; };\n";
    let other = "struct Light { vec3 pos; float w[2]; };\n";
    let one = lay_out(
        "one.comp",
        &format!("{HEAD}{light}layout(std140) uniform One {{ Light l[2]; }} o;"),
    );
    let two =
        lay_out("two.comp", &format!("{HEAD}{other}layout(std140) uniform Two {{ Light l; }} t;"));
    let apart = lay_out(
        "apart.comp",
        &format!("{HEAD}{light}layout(std430) buffer Three {{ Light l; }} t;"),
    );
    let directory = directory("several");
    let write = |file: &str, layouts: &[&ShaderLayout], prefix: &str| {
        let options = named(file, prefix);
        std::fs::write(directory.join(file), c(layouts, &options).text).expect("written");
    };
    write("one.h", &[&one], "");
    write("two.h", &[&two], "");
    write("apart.h", &[&apart], "");
    write("prefixed.h", &[&apart], "third_");
    write("all.h", &[&one, &two, &apart], "");
    let program = |file: &str, headers: &[&str]| {
        let includes: String = headers.iter().map(|h| format!("#include \"{h}\"\n")).collect();
        let text = format!("{includes}int main(void) {{ return sizeof(One) == 96 ? 0 : 1; }}\n");
        std::fs::write(directory.join(file), text).expect("written");
    };
    program("good.c", &["one.h", "two.h", "prefixed.h", "one.h"]);
    program("all.c", &["all.h"]);
    program("bad.c", &["one.h", "apart.h"]);
    for compiler in BOTH {
        compile_and_run(compiler, &directory, "good.c");
        compile_and_run(compiler, &directory, "all.c");
        let log = compile(compiler, &directory, "bad.c").expect_err("two layouts of one name");
        assert!(log.contains("Light is different in a header included before"), "{log}");
    }
}

/// A header that is edited, or compiled where types are different, does not compile.
#[test]
fn a_field_that_moved_stops_the_compiler() {
    let text = format!("{HEAD}layout(std140) uniform B {{ vec3 a; vec3 b; }} b;");
    let header = c(&[&lay_out("b.comp", &text)], &COptions::default()).text;
    let directory = directory("moved");
    let moved = header.replace("    uint8_t _pad_12[4];\n", "");
    assert_ne!(moved, header);
    std::fs::write(directory.join("b.h"), moved).expect("written");
    std::fs::write(directory.join("b.c"), "#include \"b.h\"\nint main(void) { return 0; }\n")
        .expect("written");
    for compiler in BOTH {
        let log = compile(compiler, &directory, "b.c").expect_err("`b` moved");
        assert!(log.contains("`b` of `B` is at byte 16 in the shader"), "{log}");
    }
}

/// The padding behind the last element of a scalar array is not the array's; C has it there.
#[test]
fn a_block_that_c_cannot_mirror_is_refused_by_name() {
    let text = "#version 450\n#extension GL_EXT_scalar_block_layout : require\n\
                layout(local_size_x = 1) in;\nstruct D { double a; float b; };\n\
                layout(scalar) buffer Reused { D all[2]; float next; } r;\n\
                layout(scalar) buffer Kept { D all[2]; double next; } k;\n";
    let output = c(&[&lay_out("r.comp", text)], &COptions::default());
    assert_eq!(output.diagnostics.len(), 1);
    let refused = &output.diagnostics[0];
    assert_eq!(
        refused.message,
        "block `Reused` is left out of the C header: `all` ends at byte 32 in C, but `next` \
         begins at byte 28, inside its padding"
    );
    assert!(output.text.contains("KEPT_SIZE") && !output.text.contains("Reused"));
}

/// Nothing in a comment or a path of a shader gets out of the header's comments.
#[test]
fn comments_are_carried_and_harmless() {
    let text = format!(
        "{HEAD}layout(std140) uniform B {{\n    // ends here: */ int x; /* and ??/\n    \
         vec3 a; // in metres \\\n 漢字\n    /* first\n     * second */\n    float b;\n}} b;\n"
    );
    let layout = lay_out("odd */ path.comp", &text);
    let output = c(&[&layout], &COptions::default());
    for line in ["* / int x; / * and ? ?/", "in metres", "漢字", "first", "second"] {
        assert!(output.text.contains(line), "{line}: {}", output.text);
    }
    let directory = directory("comments");
    std::fs::write(directory.join("b.h"), &output.text).expect("written");
    std::fs::write(directory.join("b.c"), "#include \"b.h\"\nint main(void) { return 0; }\n")
        .expect("written");
    for compiler in BOTH {
        compile_and_run(compiler, &directory, "b.c");
    }
}
