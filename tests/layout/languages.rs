//! Generated code in the languages of the table beside Rust and C. Each is compiled where it is
//! compiled, and run: every leaf of random blocks is filled by its name and found in the bytes where
//! glslang's SPIR-V says it is, and where landfall writes it by name.

mod csharp;
mod gdscript;
mod python;
mod renderdoc;
mod typescript;
mod zig;

use std::path::{Path, PathBuf};
use std::process::Command;

use landfall_codegen::{CodeOptions, CodeOutput, OutputLanguage, languages};
use landfall_layout::buffer::Components;
use landfall_layout::shape::{Scalar, ScalarKind};
use landfall_layout::{BlockLayout, Options, ShaderLayout, Source, Target};

use crate::c_header::{CORPUS, lay_out, misread};
use crate::support;
use support::generate::{COMMON, Diet, VULKAN, random};
use support::glslang;
use support::image::{self, Truth};
use support::leaf::{OracleBlock, OracleLeaf};
use support::run::{Batch, ask_glslang};
use support::sample::{everything, sampled};

/// A generated file and the blocks in it.
struct Case {
    name: String,
    output: CodeOutput,
    blocks: Vec<Block>,
}

/// A block as the oracle places it.
struct Block {
    name: String,
    leaves: Vec<Leaf>,
    has_tail: bool,
    /// As landfall lays it out.
    ours: BlockLayout,
}

struct Leaf {
    oracle: OracleLeaf,
    /// Whether the shader declares it as `bool`; SPIR-V has unsigned integers there.
    is_bool: bool,
}

impl Leaf {
    /// The names of its path, each with the number of its dimensions.
    fn segments(&self) -> Vec<(&str, usize)> {
        let parts = self.oracle.path.split('.');
        parts
            .map(|part| (part.split('[').next().unwrap_or(part), part.matches('[').count()))
            .collect()
    }

    fn counts(&self) -> Vec<u64> {
        image::counts(&self.oracle)
    }

    fn is_in_tail(&self) -> bool {
        self.oracle.dims.first() == Some(&None)
    }
}

impl Case {
    fn new(
        name: &str,
        language: OutputLanguage,
        shader: &ShaderLayout,
        oracle: Vec<OracleBlock>,
    ) -> Case {
        let output = generate(language, &[shader]);
        let left_out = |block: &OracleBlock| {
            let text = format!("block `{}` is left out", block.name);
            output.diagnostics.iter().any(|found| found.message.starts_with(&text))
        };
        let blocks = oracle.into_iter().filter(|block| !left_out(block)).map(|block| {
            let ours = shader.blocks.iter().find(|b| *b.name == block.name).expect("the same");
            let leaves: Vec<Leaf> = block
                .leaves
                .into_iter()
                .map(|oracle| {
                    let leaf = ours.leaves.iter().find(|leaf| leaf.path == oracle.path);
                    let ty = leaf.expect("the same leaves").ty.spelled(shader.language).to_string();
                    Leaf { oracle, is_bool: ty.starts_with('b') }
                })
                .collect();
            let has_tail = leaves.iter().any(Leaf::is_in_tail);
            Block { name: block.name, leaves, has_tail, ours: ours.clone() }
        });
        Case { name: name.to_string(), blocks: blocks.collect(), output }
    }
}

fn generate(language: OutputLanguage, shaders: &[&ShaderLayout]) -> CodeOutput {
    let output = language.generate(shaders, &CodeOptions::default());
    let again = language.generate(shaders, &CodeOptions::default());
    assert_eq!(again.text, output.text, "the same text every time");
    output
}

/// A directory of a test's own.
fn directory(language: OutputLanguage, name: &str) -> PathBuf {
    let directory =
        Path::new(env!("CARGO_TARGET_TMPDIR")).join("languages").join(language.name).join(name);
    std::fs::create_dir_all(&directory).expect("the target directory can be written");
    directory
}

/// What `tests/run` installed for a language.
fn installed(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("target/languages").join(path)
}

/// The output of a program that must succeed.
fn output_of(command: &mut Command) -> Vec<u8> {
    match said(command) {
        Ok(output) => output,
        Err(log) => panic!("{command:?}: {log}"),
    }
}

/// The output of a program, or what it said if it failed.
fn said(command: &mut Command) -> Result<Vec<u8>, String> {
    let output = command.output().unwrap_or_else(|e| {
        panic!("cannot run {}: {e}: tests/run installs it", command.get_program().display())
    });
    match output.status.success() {
        true => Ok(output.stdout),
        false => Err(format!(
            "{}{}",
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        )),
    }
}

fn write(directory: &Path, file: &str, text: &str) {
    std::fs::write(directory.join(file), text).expect("the directory can be written");
}

/// The corpus of C headers without that of C's names, then random blocks.
fn cases(language: OutputLanguage) -> Vec<Case> {
    let mut cases = Vec::new();
    for (name, declarations) in CORPUS.iter().filter(|(name, _)| *name != "names") {
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
        let shader = lay_out("corpus.comp", &text);
        cases.push(Case::new(&name.replace(' ', "_"), language, &shader, oracle));
    }
    let diets: [(&str, &Diet, u64); 3] =
        [("common", &COMMON, 10), ("common", &COMMON, 11), ("vulkan", &VULKAN, 12)];
    for &(name, diet, seed) in sampled(&diets, 3) {
        let (standing, blocks) = random(seed, if everything() { 60 } else { 20 }, diet);
        let batch = Batch { name: format!("{name} {seed}"), standing, blocks };
        let mut oracle = ask_glslang(&batch);
        let all = oracle.clone();
        oracle.retain(|block| !misread(&batch, &all, &block.name));
        let shader = lay_out("shaders/random.comp", &batch.text());
        cases.push(Case::new(&format!("{name}_{seed}"), language, &shader, oracle));
    }
    cases
}

/// Runs the program of each case, which prints the size of each block in 8 bytes and then its bytes,
/// and compares them with the oracle's.
fn hold(language: OutputLanguage, refuses: bool, print: impl Fn(&Path, &Case) -> Vec<u8>) {
    let mut held = 0;
    for case in cases(language) {
        let printed = print(&directory(language, &case.name), &case);
        let mut rest = printed.as_slice();
        for block in &case.blocks {
            let (size, after) = rest.split_at(8);
            let size = u64::from_le_bytes(size.try_into().expect("eight bytes")) as usize;
            let (bytes, after) = after.split_at(size);
            rest = after;
            let mut expected = vec![0; size];
            let mut k = 0;
            for leaf in &block.leaves {
                let truths = if leaf.is_bool { Truth::Bit } else { Truth::Number };
                image::fill(&leaf.oracle, &mut expected, &mut k, truths);
            }
            let differs = bytes.iter().zip(&expected).position(|(a, b)| a != b);
            let at = (language.title, &case.name, &block.name);
            assert_eq!(differs, None, "{at:?}: first wrong byte");
            assert!(by_name(block, size) == expected, "{at:?}: bytes by name");
            held += 1;
        }
        assert!(rest.is_empty());
        let is_left_out =
            |text: &str| text.starts_with("block `") && text.contains("the padding of its last");
        for found in &case.output.diagnostics {
            let known =
                found.message.contains(" is named `") || refuses && is_left_out(&found.message);
            assert!(known, "{}", found.message);
        }
    }
    assert!(held >= if everything() { 170 } else { 25 }, "{held} held");
}

/// The bytes that landfall writes by the names of the leaves, element by element.
fn by_name(block: &Block, size: usize) -> Vec<u8> {
    let mut bytes = vec![0; size];
    let mut k = 0;
    for leaf in &block.leaves {
        let counts = leaf.counts();
        for element in 0..counts.iter().product::<u64>() {
            let (mut rest, mut indices) = (element, vec![0; counts.len()]);
            for (index, count) in indices.iter_mut().zip(&counts).rev() {
                (*index, rest) = (rest % count, rest / count);
            }
            // The index of a runtime-sized array stays open.
            let open = usize::from(leaf.is_in_tail());
            let path = indices.iter().enumerate().fold(leaf.oracle.path.clone(), |path, (i, n)| {
                let text = if i < open { "[ ]".to_string() } else { format!("[{n}]") };
                path.replacen("[]", &text, 1)
            });
            let path = path.replace("[ ]", "[]");
            let element = if open == 1 { indices[0] as usize } else { 0 };
            let components = Components::new(&block.ours, &path).expect("a leaf");
            let (columns, rows) = components.shape();
            let Scalar { kind, width, .. } = components.scalar();
            let numbers: Vec<f64> = (k..k + (columns * rows) as u64)
                .map(|k| match (kind, width) {
                    (ScalarKind::Bool, _) => f64::from(u8::from(image::truth(k))),
                    (ScalarKind::Sint, 1) => f64::from((k % 251 + 1) as u8 as i8),
                    (ScalarKind::Sint, 2) => f64::from((k % 65521 + 1) as u16 as i16),
                    (ScalarKind::Float, 2) => half::f16::from_bits((k % 65521 + 1) as u16).to_f64(),
                    (_, 1) => (k % 251 + 1) as f64,
                    (_, 2) => (k % 65521 + 1) as f64,
                    _ => (k + 1) as f64,
                })
                .collect();
            assert_eq!(components.write(&mut bytes, element, &numbers), numbers.len());
            k += numbers.len() as u64;
        }
    }
    bytes
}

/// Every block of every shader of this repository, loose uniforms gathered, in one file.
fn all_shaders(language: OutputLanguage) -> CodeOutput {
    let options = Options::default().with_gather(true);
    let shaders: Vec<ShaderLayout> = support::files::shaders()
        .iter()
        .map(|path| {
            landfall_layout::layout(&Source::read(path).expect("a readable shader"), &options)
        })
        .collect();
    generate(language, &shaders.iter().collect::<Vec<_>>())
}

/// A directory with the code of every shader of this repository in `blocks`, and of one whose names
/// and comments are hostile in `hostile`.
fn write_shaders(language: OutputLanguage, extension: &str) -> PathBuf {
    let directory = directory(language, "shaders");
    write(&directory, &format!("blocks.{extension}"), &all_shaders(language).text);
    let hostile = generate(language, &[&hostile()]);
    assert!(hostile.diagnostics.is_empty(), "{:?}", hostile.diagnostics);
    write(&directory, &format!("hostile.{extension}"), &hostile.text);
    directory
}

/// Writes the code of a block to a file, with a change that moves a member.
fn write_moved(
    language: OutputLanguage,
    text: &str,
    (from, to): (&str, &str),
    file: &str,
) -> PathBuf {
    let output = generate(language, &[&lay_out("b.comp", text)]).text;
    assert!(output.contains(from), "{output}");
    let directory = directory(language, "moved");
    write(&directory, file, &output.replace(from, to));
    directory
}

/// Words that some language reserves or that generated code uses, without those of GLSL.
const WORDS: &[&str] = &[
    "None",
    "True",
    "def",
    "lambda",
    "async",
    "await",
    "yield",
    "from",
    "np",
    "max",
    "_structure",
    "constructor",
    "prototype",
    "arguments",
    "eval",
    "view",
    "at",
    "size",
    "SIZE",
    "OFFSETS",
    "of",
    "DataView",
    "toString",
    "index",
    "fits",
    "let",
    "fn",
    "pub",
    "comptime",
    "usize",
    "u7",
    "i33",
    "i0",
    "type",
    "test",
    "error",
    "var",
    "Tail",
    "strides",
    "bytes",
    "n",
    "size_for",
    "proc",
    "rawptr",
    "b32",
    "u32le",
    "when",
    "distinct",
    "matrix",
    "context",
    "map",
    "internal",
    "event",
    "object",
    "string",
    "decimal",
    "base",
    "params",
    "ByteSize",
    "Offsets",
    "Strides",
    "Check",
    "GetType",
    "Math",
    "self",
    "to",
    "value",
    "get",
    "set",
    "Padded",
    "Float3",
    "Layouts",
    "Words",
    "_",
    "T",
    "println",
    "undefined",
    "null",
    "unreachable",
    "default_",
    "data",
    "setData",
    "Data",
];

/// A shader in which types, members and comments do what they can to break the generated text.
fn hostile() -> ShaderLayout {
    let members: String = WORDS.iter().map(|word| format!("    float {word};\n")).collect();
    let structures: String =
        ["Float3", "Layouts", "DataView", "np", "Padded", "Math", "fn", "Tail"]
            .iter()
            .map(|name| format!("struct {name} {{ float {name}; vec3 data[2]; }};\n"))
            .collect();
    let text = format!(
        "#version 450\nlayout(local_size_x = 1) in;\n{structures}\
         const int null = 2, None = 1, Tail_ = 1, math = 1, size_for = 1, words_size = 1;\n\
         // */ }} ??/ @ts-ignore \u{2028} import evil \"\"\" ' ` ${{x}} \\u002a\\u002f\n\
         layout(std140) uniform Words {{\n{members}\
             // \u{202e} /* */ # // \n    Float3 f; Layouts l; DataView d; np m; Padded p; Math z;\n\
             fn q; Tail w; vec3 vector; mat3 columns;\n\
             vec4 many[null][None][Tail_][math][size_for][words_size];\n}} words_;\n\
         layout(std430) buffer data {{ float n_; Tail Tail[]; }} data_;\n\
         layout(std430) buffer n {{ vec3 bytes[]; }} n_;\nvoid main() {{}}\n"
    );
    let read = landfall_layout::ReadOptions::default().with_target(Target::Vulkan);
    let options = Options::default().with_read(read);
    let shader =
        landfall_layout::layout(&Source::new("odd \n*/ \" path.comp", text.as_str()), &options);
    assert!(!shader.has_errors(), "{:#?}", shader.diagnostics);
    shader
}

#[test]
fn every_language_has_a_name_of_its_own() {
    for language in languages::LANGUAGES {
        assert_eq!(languages::from_name(language.name), Some(*language));
    }
    assert_eq!(languages::from_name("cobol"), None);
}
