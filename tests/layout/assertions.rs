//! Assertions about structures of a program, judged by its compilers: a structure that lies as the
//! shader reads it compiles without a warning, one that drifted does not, and is named.

use std::path::{Path, PathBuf};
use std::process::Command;

use landfall_codegen::languages::{C, CSHARP, PYTHON, RUST, ZIG};
use landfall_codegen::{CodeOptions, OutputLanguage};
use landfall_layout::shape::ArrayLen;
use landfall_layout::{BlockLayout, Options, Rules, ShaderLayout};

use crate::support::generate::{COMMON, random};
use crate::support::landfall::laid_out_for_vulkan as lay_out;
use crate::support::run::Batch;
use crate::support::sample::{everything, sampled};

const SHADER: &str = "#version 450
struct PointLight { vec3 position; float range; vec3 color; bool on; mat3 basis; float power[2]; };
layout(std140, binding = 0) uniform Lights { PointLight data[4]; vec4 ambient; uint count; } lights;
void main() {}
";

#[derive(Clone, Copy, PartialEq)]
enum FieldType {
    Float,
    Double,
    Uint,
    Bool,
}

/// A field of the program's structure: its name, its type, and how many of it, 0 for no array.
type Field = (&'static str, FieldType, u64);

/// As a program has to write the structure: a matrix of three columns of 16 bytes, an array with 16
/// bytes for each element.
const RIGHT: [Field; 6] = [
    ("pos", FieldType::Float, 3),
    ("range", FieldType::Float, 0),
    ("color", FieldType::Float, 3),
    ("on", FieldType::Uint, 0),
    ("basis", FieldType::Float, 12),
    ("power", FieldType::Float, 8),
];

/// Structures that drifted: each with the fields of which a compiler has to name one.
fn drifts() -> Vec<(Vec<Field>, Vec<&'static str>)> {
    let mut all = Vec::new();
    let mut add = |fields: Vec<Field>, names: &[&'static str]| all.push((fields, names.to_vec()));
    for at in 0..RIGHT.len() {
        let name = RIGHT[at].0;
        let with = |ty, count| {
            let mut fields = RIGHT.to_vec();
            fields[at] = (name, ty, count);
            fields
        };
        // Left out, and misspelt.
        let mut fields = RIGHT.to_vec();
        fields.remove(at);
        add(fields, &[name]);
        let mut fields = RIGHT.to_vec();
        fields[at].0 = "misspelt";
        add(fields, &[name]);
        // Something new before it.
        let mut fields = RIGHT.to_vec();
        fields.insert(at, ("fresh", FieldType::Float, 0));
        add(fields, &[name]);
        // In the other order.
        if at > 0 {
            let mut fields = RIGHT.to_vec();
            fields.swap(at - 1, at);
            add(fields, &[name, RIGHT[at - 1].0]);
        }
        add(with(FieldType::Double, RIGHT[at].2), &[name]);
        match RIGHT[at].2 {
            0 => {
                add(with(FieldType::Bool, 0), &[name]);
                add(with(RIGHT[at].1, 2), &[name]);
            }
            count => {
                add(with(RIGHT[at].1, count + 1), &[name]);
                add(with(RIGHT[at].1, count - 1), &[name]);
                add(with(RIGHT[at].1, 0), &[name]);
            }
        }
    }
    // As one would write them without the shader's padding.
    add(
        RIGHT.map(|(n, ty, count)| (n, ty, if n == "basis" { 9 } else { count })).to_vec(),
        &["basis"],
    );
    add(
        RIGHT.map(|(n, ty, count)| (n, ty, if n == "power" { 2 } else { count })).to_vec(),
        &["power"],
    );
    all
}

fn options(host: &str) -> CodeOptions {
    let mut options = CodeOptions::default();
    options.assertions.structures.push((host.to_string(), "PointLight".to_string()));
    options.assertions.fields.push(("PointLight.position".to_string(), "pos".to_string()));
    options
}

fn assertions(language: OutputLanguage, options: &CodeOptions) -> String {
    let output = language.assertions(&[&lay_out("lights.frag", SHADER)], options);
    assert_eq!(output.diagnostics, []);
    output.text
}

/// A directory of a test's own.
fn directory(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("assertions").join(name);
    std::fs::create_dir_all(&path).expect("the target directory can be written");
    path
}

/// What a compiler said of a file, if it refused it.
fn compiled(command: &mut Command) -> Result<(), String> {
    let output = command.output().expect("tests/run installs the compilers");
    let said = [output.stdout, output.stderr].concat();
    match output.status.success() {
        true => Ok(()),
        false => Err(String::from_utf8_lossy(&said).into_owned()),
    }
}

/// Whether the compiler takes the right structure, and refuses those that drifted with a name.
fn hold(name: &str, one_in: u64, compile: impl Fn(&[Field]) -> Result<(), String>) {
    compile(&RIGHT).unwrap_or_else(|log| panic!("{name}: {log}"));
    let drifts = drifts();
    assert!(drifts.len() >= 40);
    for (fields, names) in sampled(&drifts, one_in) {
        let list: Vec<&str> = fields.iter().map(|field| field.0).collect();
        let log = compile(fields).expect_err(&format!("{name} takes {list:?}"));
        assert!(names.iter().any(|field| log.contains(field)), "{name}, {list:?}: {log}");
    }
}

/// What the types of fields are called, in their order.
type TypeNames = [&'static str; 4];

const C_TYPES: TypeNames = ["float", "double", "uint32_t", "bool"];
const SHORT_TYPES: TypeNames = ["f32", "f64", "u32", "bool"];
const CSHARP_TYPES: TypeNames = ["float", "double", "uint", "bool"];

/// Fields as a language has them; `field` gets a name, and a type with its count.
fn printed(
    fields: &[Field],
    types: TypeNames,
    field: impl Fn(&str, (&str, u64)) -> String,
) -> String {
    fields.iter().map(|&(name, ty, count)| field(name, (types[ty as usize], count))).collect()
}

fn c_structure(fields: &[Field]) -> String {
    let fields = printed(fields, C_TYPES, |name, ty| match ty {
        (ty, 0) => format!("{ty} {name};\n"),
        (ty, count) => format!("{ty} {name}[{count}];\n"),
    });
    format!("#include <stdbool.h>\n#include <stdint.h>\nstruct PointLight {{\n{fields}}};\n")
}

const WARNINGS: [&str; 7] =
    ["-Wall", "-Wextra", "-pedantic", "-Werror", "-Wconversion", "-fsyntax-only", "-I."];

#[test]
fn drifted_structures_do_not_compile_in_c() {
    let directory = directory("c");
    std::fs::write(directory.join("asserts.h"), assertions(C, &options("struct PointLight")))
        .expect("written");
    for (compiler, one_in) in [("gcc", 1), ("clang", 4)] {
        hold(compiler, one_in, |fields| {
            let text = format!("{}#include \"asserts.h\"\n", c_structure(fields));
            std::fs::write(directory.join("a.c"), text).expect("written");
            let mut c = Command::new(compiler);
            compiled(c.current_dir(&directory).arg("-std=c11").args(WARNINGS).arg("a.c"))
        });
    }
}

#[test]
fn drifted_structures_do_not_compile_in_cpp() {
    let directory = directory("cpp");
    std::fs::write(directory.join("asserts.hpp"), assertions(C, &options("engine::PointLight")))
        .expect("written");
    for compiler in ["g++", "clang++"] {
        hold(compiler, 4, |fields| {
            let structure = c_structure(fields)
                .replace("struct PointLight", "namespace engine {\nstruct PointLight");
            let text = format!("{structure}}}\n#include \"asserts.hpp\"\n");
            std::fs::write(directory.join("a.cpp"), text).expect("written");
            let mut cpp = Command::new(compiler);
            cpp.current_dir(&directory).arg("-std=c++17").args(WARNINGS).arg("-Wold-style-cast");
            compiled(cpp.arg("a.cpp"))
        });
    }
}

#[test]
fn a_class_without_a_standard_layout_does_not_compile() {
    let directory = directory("virtual");
    let structure = c_structure(&RIGHT).replace("};", "virtual ~PointLight() {}\n};");
    let text = format!("{structure}\n{}", assertions(C, &options("PointLight")));
    std::fs::write(directory.join("a.cpp"), text).expect("written");
    let log =
        compiled(Command::new("g++").current_dir(&directory).args(["-fsyntax-only", "a.cpp"]))
            .expect_err("its members have no fixed place");
    assert!(log.contains("PointLight have no fixed place"), "{log}");
}

#[test]
fn drifted_structures_do_not_compile_in_rust() {
    let directory = directory("rust");
    let asserts = assertions(RUST, &options("crate::engine::PointLight"));
    hold("rustc", 4, |fields| {
        let fields = printed(fields, SHORT_TYPES, |name, ty| match ty {
            (ty, 0) => format!("pub {name}: {ty},\n"),
            (ty, count) => format!("pub {name}: [{ty}; {count}],\n"),
        });
        let text = format!(
            "#![deny(warnings)]\npub mod engine {{\n#[repr(C)]\npub struct PointLight {{\n{fields}}}\n}}\n{asserts}"
        );
        std::fs::write(directory.join("a.rs"), text).expect("written");
        let mut rustc = Command::new("rustc");
        rustc.current_dir(&directory).args(["--edition", "2024", "--crate-type", "lib"]);
        // Assertions in constants are evaluated where code is generated.
        compiled(rustc.args(["--emit", "metadata", "a.rs"]))
    });
}

#[test]
fn drifted_structures_do_not_compile_in_zig() {
    let directory = directory("zig");
    let mut options = options("engine.PointLight");
    options.c.includes.push("engine.zig".to_string());
    std::fs::write(directory.join("asserts.zig"), assertions(ZIG, &options)).expect("written");
    hold("zig", 12, |fields| {
        let fields = printed(fields, SHORT_TYPES, |name, ty| match ty {
            (ty, 0) => format!("{name}: {ty},\n"),
            (ty, count) => format!("{name}: [{count}]{ty},\n"),
        });
        let text = format!("pub const PointLight = extern struct {{\n{fields}}};\n");
        std::fs::write(directory.join("engine.zig"), text).expect("written");
        let zig = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/languages/zig/ziglang/zig");
        let mut command = Command::new(zig);
        command.current_dir(&directory).args(["build-obj", "-fno-emit-bin"]);
        command.args(["--cache-dir", "cache", "--global-cache-dir", "cache"]);
        compiled(command.arg("asserts.zig"))
    });
}

#[test]
fn drifted_structures_fail_their_test_in_csharp() {
    let directory = directory("csharp");
    let all: Vec<(Vec<Field>, Vec<&str>)> =
        [(RIGHT.to_vec(), Vec::new())].into_iter().chain(drifts()).collect();
    let (mut text, mut calls) = (String::new(), String::new());
    for (number, (fields, _)) in all.iter().enumerate() {
        let fields = printed(fields, CSHARP_TYPES, |name, ty| match ty {
            (ty, 0) => format!("public {ty} {name};\n"),
            (ty, count) => format!("public fixed {ty} {name}[{count}];\n"),
        });
        text.push_str(&format!("public unsafe struct Light{number}\n{{\n{fields}}}\n"));
        let mut options = options(&format!("Light{number}"));
        options.prefix = format!("Of{number}");
        let asserts = assertions(CSHARP, &options);
        std::fs::write(directory.join(format!("a{number}.cs")), asserts).expect("written");
        calls.push_str(&format!(
            "try {{ Of{number}LayoutAssertions.Check(); Console.WriteLine(\"right\"); }}\n\
             catch (InvalidOperationException e) {{ Console.WriteLine(e.Message.Replace(\"\\n\", \" \")); }}\n"
        ));
    }
    text = format!(
        "using System;\n{text}static class Program\n{{\nstatic void Main()\n{{\n{calls}}}\n}}\n"
    );
    std::fs::write(directory.join("main.cs"), text).expect("written");
    let mut mcs = Command::new("mcs");
    // Their fields are given no value.
    mcs.current_dir(&directory).args([
        "-unsafe",
        "-warnaserror",
        "-nowarn:0649",
        "-nologo",
        "-out:a.exe",
    ]);
    mcs.arg("main.cs").args((0..all.len()).map(|number| format!("a{number}.cs")));
    compiled(&mut mcs).unwrap_or_else(|log| panic!("{log}"));
    let output = Command::new("mono").arg("a.exe").current_dir(&directory).output().expect("mono");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(said.lines().count(), all.len(), "{said}");
    for (line, (_, names)) in said.lines().zip(&all) {
        match names.as_slice() {
            [] => assert_eq!(line, "right"),
            names => assert!(names.iter().any(|name| line.contains(name)), "{names:?}: {line}"),
        }
    }
}

/// A message has the bytes of both, the place in the shader, and what to do.
#[test]
fn a_failed_assertion_says_what_to_do() {
    let directory = directory("message");
    let mut fields = RIGHT.to_vec();
    fields[4].2 = 9;
    let structure = c_structure(&fields);
    for (compiler, host, numbers) in
        [("gcc", "struct PointLight", "char (*)[36]"), ("g++", "PointLight", "(36 == 48)")]
    {
        let text = format!("{structure}\n{}", assertions(C, &options(host)));
        let language = if compiler == "gcc" { "-xc" } else { "-xc++" };
        std::fs::write(directory.join("a.c"), text).expect("written");
        let mut command = Command::new(compiler);
        command.env("LC_ALL", "C").current_dir(&directory);
        let log = compiled(command.args(["-fsyntax-only", language, "a.c"])).expect_err("36 bytes");
        for part in [
            "basis: `basis` (mat3) takes 48 bytes in the shader: 16 for each column",
            "power: the shader reads `power` at byte 80 (lights.frag:2): right behind `basis`",
            numbers,
        ] {
            assert!(log.contains(part), "{compiler}: no {part:?} in {log}");
        }
    }
}

/// The blocks of one shader by the rules that it declares and by others.
fn by_rules(batch: &Batch, rules: Option<Rules>) -> ShaderLayout {
    let source = landfall_layout::Source::new("random.comp", batch.text());
    let mut options = Options::default();
    options.rules = rules;
    landfall_layout::layout(&source, &options)
}

/// Assertions for the mirror of a block hold; those of the same block by rules that place a member
/// elsewhere do not.
#[test]
fn assertions_hold_for_mirrors_and_for_no_other_layout() {
    let directory = directory("mirrors");
    let (mut held, mut refused) = (0, 0);
    for seed in 0..if everything() { 30 } else { 3 } {
        let (standing, blocks) = random(seed, 10, &COMMON);
        let batch = Batch { name: format!("assertions {seed}"), standing, blocks };
        let right = by_rules(&batch, None);
        for block in right.blocks.iter().filter(|block| block.size.is_some()) {
            let mut one = right.clone();
            one.blocks = vec![block.clone()];
            let mirror = C.generate(&[&one], &CodeOptions::default());
            // No member stands for a runtime-sized array.
            let is_open = block.leaves.iter().any(|leaf| leaf.dims.contains(&ArrayLen::Runtime));
            if !mirror.diagnostics.is_empty() || is_open {
                continue;
            }
            for rules in [None, Some(Rules::Std140), Some(Rules::Scalar)] {
                let layout = by_rules(&batch, rules);
                let other = layout.blocks.iter().find(|other| other.name == block.name);
                let other = other.expect("the same blocks");
                let starts = |block: &BlockLayout| -> Vec<_> {
                    block.members.iter().map(|m| (m.name.clone(), m.offset)).collect()
                };
                let differs = starts(block) != starts(other);
                let is_same =
                    block.members.iter().zip(&other.members).all(|(a, b)| a.size == b.size)
                        && [other.size, other.data_size].contains(&block.size)
                        && !differs;
                let mut options = CodeOptions::default();
                options
                    .assertions
                    .structures
                    .push((format!("struct {}", block.name), block.name.to_string()));
                let asserts = C.assertions(&[&layout], &options);
                assert_eq!(asserts.diagnostics, []);
                let text = format!("{}\n{}", mirror.text, asserts.text);
                std::fs::write(directory.join("a.c"), text).expect("written");
                let mut gcc = Command::new("gcc");
                gcc.current_dir(&directory).args(["-std=c11", "-fsyntax-only", "-w", "a.c"]);
                let result = compiled(&mut gcc);
                // The size of a structure inside may be with or without the padding at its end.
                assert!(!is_same || result.is_ok(), "{seed} {} {rules:?}: {result:?}", block.name);
                assert!(!differs || result.is_err(), "{seed} {} {rules:?}", block.name);
                held += usize::from(is_same);
                refused += usize::from(differs);
            }
        }
    }
    assert!(held > 20 && refused > 5, "{held} held, {refused} refused");
}

#[test]
fn what_is_not_there_is_one_clear_error() {
    let shader = lay_out("lights.frag", SHADER);
    let errors = |language: OutputLanguage, change: fn(&mut CodeOptions)| -> Vec<String> {
        let mut options = options("PointLight");
        change(&mut options);
        let output = language.assertions(&[&shader], &options);
        let found = output.diagnostics.iter();
        found.map(|d| format!("{} ({})", d.message, d.help.as_deref().unwrap_or(""))).collect()
    };
    assert_eq!(
        errors(C, |o| o.assertions.structures.push(("Spot".into(), "PointLigth".into()))),
        ["no block has or is a structure `PointLigth` (did you mean `PointLight`?)"]
    );
    assert_eq!(
        errors(C, |o| o.assertions.structures.push(("PointLight".into(), "Lights".into()))),
        ["`PointLight` has two assertions (one structure is read in one way)"]
    );
    assert_eq!(
        errors(C, |o| o.assertions.fields.push(("PointLight.rnage".into(), "r".into()))),
        [
            "`PointLight.rnage` is no member of a structure with an assertion (did you mean `PointLight.range`?)"
        ]
    );
    assert_eq!(
        errors(C, |o| o.assertions.structures.push(("Light<float>".into(), "PointLight".into()))),
        [
            "`Light<float>` cannot be the name of a structure (write it as the program does: `engine::PointLight` or `struct point_light`)"
        ]
    );
    assert_eq!(
        errors(C, |o| o.assertions.structures.push(("L".into(), "Lights.dat[]".into()))),
        ["`Lights.dat[]`: no member of `Lights` has the path `dat` ()"]
    );
    assert_eq!(
        errors(C, |o| o.assertions.fields.push(("PointLight.range".into(), "a b".into()))),
        ["`a b` cannot be the name of a member ()"]
    );
    assert_eq!(errors(PYTHON, |_| ()).len(), 1);
}
