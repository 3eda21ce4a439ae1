//! Generated C headers, compiled by gcc as C11 and by g++ as C++17 with every
//! warning an error, and run: each leaf is filled through the structure and
//! found in the bytes where glslang's SPIR-V says it is.

mod support;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use landfall::emit::c::{CLeaf, COptions, COutput, c};
use landfall::{Options, ReadOptions, ShaderLayout, Source, Target};
use support::generate::{COMMON, Diet, VULKAN, random};
use support::glslang;
use support::known::{Oracle, Subject, explains};
use support::leaf::{OracleBlock, OracleLeaf, What, differences};
use support::run::{Batch, ask_glslang};

/// Elements a runtime-sized dimension is given.
const TAIL: u64 = 3;

fn lay_out(path: &str, text: &str) -> ShaderLayout {
    let read = ReadOptions { target: Some(Target::Vulkan), ..ReadOptions::default() };
    let layout =
        landfall::layout(&Source::new(path, text), &Options { read, ..Options::default() });
    assert!(!layout.has_errors(), "{path}: {:#?}\n{text}", layout.diagnostics);
    layout
}

/// A directory of this test's own.
fn directory(name: &str) -> PathBuf {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("c_header").join(name);
    std::fs::create_dir_all(&directory).expect("the target directory can be written");
    directory
}

#[derive(Clone, Copy, Debug)]
enum Compiler {
    C11,
    Cpp17,
}

const BOTH: [Compiler; 2] = [Compiler::C11, Compiler::Cpp17];

/// Compiles a program without a warning.
fn compile(compiler: Compiler, directory: &Path, file: &str) -> Result<PathBuf, String> {
    let (name, flags) = match compiler {
        Compiler::C11 => ("gcc", ["-std=c11", "-xc"]),
        Compiler::Cpp17 => ("g++", ["-std=c++17", "-xc++"]),
    };
    let program = directory.join(format!("{file}.{compiler:?}"));
    let output = Command::new(name)
        .args(["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O0"])
        .args(flags)
        .arg(directory.join(file))
        .arg("-o")
        .arg(&program)
        .output()
        .unwrap_or_else(|e| panic!("cannot run {name} ({e}): install the Debian package `{name}`"));
    let log = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.success() { Ok(program) } else { Err(log) }
}

fn compile_and_run(compiler: Compiler, directory: &Path, file: &str) -> Vec<u8> {
    let program = compile(compiler, directory, file).unwrap_or_else(|log| {
        panic!("{compiler:?} refuses {}/{file}:\n{log}", directory.display())
    });
    let output = Command::new(&program).output().expect("what was just compiled runs");
    assert!(
        output.status.success(),
        "{}: {}: {}",
        program.display(),
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    output.stdout
}

/// A leaf as C reaches it and as the oracle places it.
struct Filled<'a> {
    c: &'a CLeaf,
    oracle: &'a OracleLeaf,
}

impl Filled<'_> {
    fn counts(&self) -> Vec<u64> {
        self.oracle.dims.iter().map(|dim| dim.unwrap_or(TAIL)).collect()
    }

    /// Columns, rows, and bytes of a component; whether it is a floating-point number of C.
    fn shape(&self) -> (u64, u64, u64, bool) {
        let word = self.oracle.ty.as_str();
        let digits = |c: char| c.is_ascii_digit();
        let (prefix, columns, rows) = match (word.split_once("vec"), word.split_once("mat")) {
            (Some((prefix, rows)), _) => (prefix, "1", rows),
            (_, Some((prefix, size))) => {
                let (columns, rows) = size.split_once('x').unwrap_or((size, size));
                (prefix, columns, rows)
            }
            _ => (word, "1", "1"),
        };
        let (width, float) = match prefix {
            "" | "float" => (4, true),
            "d" | "double" => (8, true),
            "i" | "u" | "int" | "uint" => (4, false),
            word => {
                let bits: String = word.chars().filter(|c| digits(*c)).collect();
                (bits.parse::<u64>().unwrap_or_else(|_| panic!("type {word}")) / 8, false)
            }
        };
        (columns.parse().expect("columns"), rows.parse().expect("rows"), width, float)
    }

    /// The C statements that fill it.
    fn fill(&self) -> String {
        let (columns, rows, width, _) = self.shape();
        let counts = self.counts();
        let mut text = String::from("    ");
        for (level, count) in counts.iter().enumerate() {
            let _ = write!(text, "for (size_t i{level} = 0; i{level} < {count}; i{level}++) ");
        }
        let mut value = match &self.c.tail {
            Some(function) => format!("{function}(bytes)[]{}", self.c.access),
            None => {
                let structure = self.c.structure.as_ref().expect("before a tail is a structure");
                format!("(({structure} *)bytes)->{}", &self.c.access[1..])
            }
        };
        for level in 0..counts.len() {
            value = value.replacen("[]", &format!("[i{level}]"), 1);
        }
        let of = match (columns, rows, self.oracle.row_major) {
            (1, 1, _) => "",
            (1, _, _) => "[r]",
            (_, _, false) => "[c][r]",
            (_, _, true) => "[r][c]",
        };
        let _ = writeln!(
            text,
            "for (size_t c = 0; c < {columns}; c++) for (size_t r = 0; r < {rows}; r++) \
             {{ (void)c; (void)r; {value}{of} = V{width}(k); k++; }}"
        );
        text
    }

    fn element_offset(&self, indices: &[u64]) -> u64 {
        let strides = self.oracle.strides.iter().map(|s| s.expect("SPIR-V has every stride"));
        self.oracle.offset + strides.zip(indices).map(|(stride, i)| stride * i).sum::<u64>()
    }

    /// Puts the same values into an image of the block, where the oracle says.
    fn expect(&self, image: &mut [u8], k: &mut u64) {
        let (columns, rows, width, float) = self.shape();
        let counts = self.counts();
        for element in 0..counts.iter().product::<u64>() {
            let mut rest = element;
            let mut indices = vec![0; counts.len()];
            for (index, count) in indices.iter_mut().zip(&counts).rev() {
                *index = rest % count;
                rest /= count;
            }
            let start = self.element_offset(&indices);
            for c in 0..columns {
                for r in 0..rows {
                    let stride = self.oracle.matrix_stride.unwrap_or(0);
                    let inside = if self.oracle.row_major && columns > 1 {
                        r * stride + c * width
                    } else {
                        c * stride + r * width
                    };
                    let at = (start + inside) as usize;
                    let bytes: Vec<u8> = match (width, float) {
                        (1, _) => vec![(*k % 251 + 1) as u8],
                        (2, _) => ((*k % 65521 + 1) as u16).to_le_bytes().to_vec(),
                        (4, true) => ((*k + 1) as f32).to_le_bytes().to_vec(),
                        (4, false) => ((*k + 1) as u32).to_le_bytes().to_vec(),
                        (_, true) => ((*k + 1) as f64).to_le_bytes().to_vec(),
                        (_, false) => (*k + 1).to_le_bytes().to_vec(),
                    };
                    image[at..at + bytes.len()].copy_from_slice(&bytes);
                    *k += 1;
                }
            }
        }
    }

    /// C that prints what the table and the macro say of its last element, and that wants
    /// every index past the end to be refused.
    fn look_up(&self) -> String {
        let last: Vec<u64> = self.counts().iter().map(|count| count - 1).collect();
        let path = |indices: &[u64]| {
            indices
                .iter()
                .fold(self.c.path.clone(), |path, i| path.replacen("[]", &format!("[{i}]"), 1))
        };
        let offset = &self.c.offset;
        let call = if last.is_empty() {
            offset.clone()
        } else {
            let list: Vec<String> = last.iter().map(u64::to_string).collect();
            format!("{offset}({})", list.join(", "))
        };
        let lookup = &self.c.lookup;
        let mut text = format!(
            "    found(k, {lookup}(\"{}\", NULL)); found(k, (int64_t)({call}));\n",
            path(&last)
        );
        for (level, dim) in self.oracle.dims.iter().enumerate() {
            if dim.is_some() {
                let mut past = last.clone();
                past[level] += 1;
                let _ = writeln!(text, "    refused({lookup}(\"{}\", NULL));", path(&past));
            }
        }
        text
    }
}

/// A program that prints the image of each block, then offsets by name and by macro.
fn program(blocks: &[(&OracleBlock, Vec<Filled<'_>>)]) -> String {
    let mut text = String::from(
        "#include \"blocks.h\"\n#include \"blocks.h\"\n#include <stdio.h>\n#include <stdlib.h>\n\
         #define V1(k) (uint8_t)((k) % 251 + 1)\n#define V2(k) (uint16_t)((k) % 65521 + 1)\n\
         #define V4(k) (uint32_t)((k) + 1)\n#define V8(k) (uint64_t)((k) + 1)\n\
         static void found(uint64_t k, int64_t offset) { (void)k; fwrite(&offset, 8, 1, stdout); }\n\
         static void refused(int64_t offset) { if (offset != -1) { fputs(\"taken\", stderr); exit(1); } }\n",
    );
    for (number, (_, subjects)) in blocks.iter().enumerate() {
        let first = subjects[0].c;
        let runtime = subjects.iter().any(|s| s.c.tail.is_some());
        let size = if runtime {
            format!("{}_SIZE_FOR({TAIL})", first.macros)
        } else {
            format!("{}_SIZE", first.macros)
        };
        let _ = writeln!(
            text,
            "static void block{number}(void)\n{{\n    uint64_t k = 0, size = {size};\n    \
             unsigned char *bytes = (unsigned char *)calloc(1, size);"
        );
        for subject in subjects {
            text.push_str(&subject.fill());
        }
        text.push_str("    fwrite(&size, 8, 1, stdout);\n    fwrite(bytes, 1, size, stdout);\n");
        for subject in subjects {
            text.push_str(&subject.look_up());
        }
        let _ = writeln!(text, "    refused({}(\"no.such[0].path\", NULL));", first.lookup);
        text.push_str("    free(bytes);\n}\n");
    }
    text.push_str("int main(void)\n{\n");
    for number in 0..blocks.len() {
        let _ = writeln!(text, "    block{number}();");
    }
    text.push_str("    return 0;\n}\n");
    text
}

/// Compiles a header with both compilers, runs it, and holds every byte against the oracle.
/// Returns how many blocks were held.
fn hold(name: &str, output: &COutput, oracle: &[OracleBlock]) -> usize {
    let directory = directory(name);
    let mut blocks: Vec<(&OracleBlock, Vec<Filled<'_>>)> = Vec::new();
    for block in oracle {
        let subjects: Vec<Filled<'_>> = output
            .leaves
            .iter()
            .filter(|leaf| leaf.block == block.name)
            .map(|c| {
                let oracle = block.leaves.iter().find(|leaf| leaf.path == c.path);
                let oracle = oracle.unwrap_or_else(|| panic!("{}: no {}", block.name, c.path));
                Filled { c, oracle }
            })
            .collect();
        if !subjects.is_empty() {
            assert_eq!(subjects.len(), block.leaves.len(), "leaves of {}", block.name);
            blocks.push((block, subjects));
        }
    }
    std::fs::write(directory.join("blocks.h"), &output.text).expect("written");
    std::fs::write(directory.join("main.c"), program(&blocks)).expect("written");
    for compiler in BOTH {
        let printed = compile_and_run(compiler, &directory, "main.c");
        let mut rest = printed.as_slice();
        for (block, subjects) in &blocks {
            let size = number(&mut rest) as usize;
            let (image, after) = rest.split_at(size);
            rest = after;
            let mut expected = vec![0; size];
            let mut k = 0;
            for subject in subjects {
                subject.expect(&mut expected, &mut k);
            }
            let differs = image.iter().zip(&expected).position(|(a, b)| a != b);
            assert_eq!(differs, None, "{name}, {compiler:?}: first wrong byte of {}", block.name);
            for subject in subjects {
                let last: Vec<u64> = subject.counts().iter().map(|count| count - 1).collect();
                let want = subject.element_offset(&last);
                let told = [number(&mut rest), number(&mut rest)];
                assert_eq!(told, [want; 2], "{name}: {} {}", block.name, subject.c.path);
            }
        }
        assert!(rest.is_empty());
    }
    blocks.len()
}

fn number(rest: &mut &[u8]) -> u64 {
    let (head, tail) = rest.split_at(8);
    *rest = tail;
    u64::from_le_bytes(head.try_into().expect("eight bytes"))
}

/// Whether glslang departs from the specification in a block, in a way that is known.
fn misread(batch: &Batch, oracle: &[OracleBlock], block: &str) -> bool {
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
    let (standing, blocks) = random(seed, count, diet);
    let batch = Batch { name: format!("{name} {seed}"), standing, blocks };
    let mut oracle = ask_glslang(&batch);
    let all = oracle.clone();
    oracle.retain(|block| !misread(&batch, &all, &block.name));
    let layout = lay_out("shaders/random.comp", &batch.text());
    let options = COptions { file: "blocks.h".to_string(), ..COptions::default() };
    let output = c(&[&layout], &options);
    assert_eq!(c(&[&layout], &options).text, output.text, "the same header every time");
    let held = hold(&format!("{name}_{seed}"), &output, &oracle);
    (held, output.refused.len())
}

#[test]
fn random_blocks_are_filled_where_glslang_reads_them() {
    let mut held = 0;
    for seed in 0..5 {
        let (some, refused) = random_blocks("common", seed, 60, &COMMON);
        assert_eq!(refused, 0, "std140 and std430 fit C");
        held += some;
    }
    assert!(held >= 250, "{held} held");
}

/// Scalar layout reuses the padding at the end of structures, which C cannot.
#[test]
fn random_vulkan_blocks_are_filled_where_glslang_reads_them() {
    let (mut held, mut refused) = (0, 0);
    for seed in 0..3 {
        let (some, others) = random_blocks("vulkan", seed, 60, &VULKAN);
        held += some;
        refused += others;
    }
    assert!(held >= 160 && refused <= 20, "{held} held, {refused} refused");
}

/// Blocks C has trouble with: keywords, clashes, one structure under several rules, padding of
/// every kind, runtime-sized tails.
const CORPUS: &[(&str, &str)] = &[
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
         layout(scalar) buffer T5 { double head; float odd; vec3 all[]; } t5;",
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
    for (name, declarations) in CORPUS {
        let text = format!(
            "#version 450\n#extension GL_EXT_scalar_block_layout : require\n\
             #extension GL_EXT_shader_16bit_storage : require\n\
             #extension GL_EXT_shader_8bit_storage : require\n\
             layout(local_size_x = 1) in;\nstruct struct_t_ {{ float x; vec3 y; }};\n\
             {declarations}\nvoid main() {{}}\n"
        );
        let options = glslang::Options { target_env: Some("vulkan1.2"), ..Default::default() };
        let oracle = glslang::blocks(&text, "comp", &options)
            .unwrap_or_else(|e| panic!("glslang refuses {name}: {e}"));
        let layout = lay_out("corpus.comp", &text);
        let output = c(&[&layout], &COptions::default());
        assert!(output.refused.is_empty(), "{name}: {:?}", output.refused);
        let held = hold(&name.replace(' ', "_"), &output, &oracle);
        assert_eq!(held, oracle.len(), "{name}");
    }
}

/// The example: an engine in C++ that had a table of offsets written by hand.
#[test]
fn an_engine_sets_members_by_name() {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/engine");
    let text = std::fs::read_to_string(sources.join("lights.frag")).expect("the example's shader");
    let layout = lay_out("tests/engine/lights.frag", &text);
    let options = COptions { file: "lights.h".to_string(), ..COptions::default() };
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
        let options = COptions { file: file.to_string(), prefix: prefix.to_string() };
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
    assert_eq!(output.refused.len(), 1);
    let refused = &output.refused[0].diagnostic;
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
    BOTH.map(|compiler| compile_and_run(compiler, &directory, "b.c"));
}
