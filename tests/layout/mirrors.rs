//! Holds the Rust mirrors to the layout that glslang gives: every leaf is
//! filled through the mirror and found in the bytes where the oracle has it.
//! And the output is what a project can take in as it is: no warning from
//! rustc or clippy, nothing for rustfmt to change, alone or in `no_std`.

use crate::support;

mod corpus;
mod fill;
mod user_types;
use crate::support::rustc;

use std::collections::HashMap;
use std::fs;

use landfall_codegen::rust::{RustOptions, Tables, Vectors, Visibility, rust};
use landfall_layout::diagnostic::Code;
use landfall_layout::{Options, ShaderLayout, Source, layout};
use rustc::{Math, Target, assert_formatted, check, crates, run, scratch, shown};
use support::blocks::{Block, Type, declared};
use support::generate::{COMMON, Diet, VULKAN, random};
use support::landfall::laid_out;
use support::leaf::OracleBlock;
use support::run::{Batch, ask_glslang};
use support::sample::{everything, sampled};

/// Random blocks to a shader; four shaders.
const BATCH: usize = 90;

/// As many, or a third where inputs are sampled.
fn batch() -> usize {
    if everything() { BATCH } else { BATCH / 3 }
}

#[test]
fn every_leaf_of_random_opengl_blocks_is_found_through_glam_mirrors() {
    random_blocks_hold(&[1, 2], &COMMON, Vectors::Glam);
}

#[test]
fn every_leaf_of_random_opengl_blocks_is_found_through_array_mirrors() {
    random_blocks_hold(&[1, 2], &COMMON, Vectors::Array);
}

#[test]
fn every_leaf_of_random_vulkan_blocks_is_found_through_glam_mirrors() {
    random_blocks_hold(&[3, 4], &VULKAN, Vectors::Glam);
}

#[test]
fn every_leaf_of_random_vulkan_blocks_is_found_through_array_mirrors() {
    random_blocks_hold(&[3, 4], &VULKAN, Vectors::Array);
}

fn random_blocks_hold(seeds: &[u64], diet: &Diet, vectors: Vectors) {
    let mut held = 0;
    for &seed in sampled(seeds, 2) {
        let (standing, mut blocks) = random(seed, batch(), diet);
        blocks.retain(glslang_is_right);
        held += blocks.len();
        let batch = Batch { name: format!("mirrors seed {seed}"), standing, blocks };
        mirrors_hold(&batch, &ask_glslang(&batch), vectors);
    }
    assert!(held >= if everything() { 150 } else { 20 }, "{held} blocks");
}

/// glslang ignores `align` under a default-layout statement (`support::known`).
fn glslang_is_right(block: &Block) -> bool {
    block.rules_written || block.align.is_none() && block.members.iter().all(|m| m.align.is_none())
}

fn mirrors_hold(batch: &Batch, oracle: &[OracleBlock], vectors: Vectors) {
    let layouts = laid_out("random.comp", &batch.text());
    let mut options = RustOptions::default();
    options.vectors = vectors;
    let output = rust(&[&layouts], &options);
    assert!(output.diagnostics.is_empty(), "{:?}", output.diagnostics);

    let blocks: Vec<fill::Block> =
        batch.blocks.iter().map(|block| to_fill(block, oracle)).collect();
    let name = format!("{}-{}", batch.name.replace(' ', "-"), vectors.name());
    let program = fill::program(&blocks, &output.text, "mirrors.rs", vectors);
    let root = written(&name, &output.text, &program);
    assert_formatted(&root.with_file_name("mirrors.rs"), "2021");
    let mut bytes_of_all = &run(crates(Math::Simd), &root, "2024")[..];
    for block in &blocks {
        let (len, rest) = bytes_of_all.split_at(8);
        let len = u64::from_le_bytes(len.try_into().expect("eight bytes")) as usize;
        let (bytes, rest) = rest.split_at(len);
        bytes_of_all = rest;
        let expected = fill::expected(block, len);
        if let Some(at) = (0..len).find(|&at| bytes[at] != expected[at]) {
            panic!(
                "{} {}: byte {at} of {len} is {:#x}, glslang has {:#x} there\n{}",
                batch.name,
                block.name,
                bytes[at],
                expected[at],
                batch.text_of(&block.name)
            );
        }
    }
}

/// The types are those declared, the places those of the oracle.
fn to_fill(block: &Block, oracle: &[OracleBlock]) -> fill::Block {
    let answer = oracle.iter().find(|b| b.name == block.name).expect("every block is answered");
    let places: HashMap<&str, _> = answer.leaves.iter().map(|l| (l.path.as_str(), l)).collect();
    let mut basics = Vec::new();
    basics_of(&block.members, &mut basics);
    let leaves = declared(block).into_iter().zip(basics).map(|(leaf, basic)| {
        let place = places[leaf.path.as_str()];
        fill::Leaf {
            basic,
            offset: place.offset,
            dims: place.dims.clone(),
            strides: place.strides.iter().map(|s| s.expect("glslang says strides")).collect(),
            matrix_stride: place.matrix_stride.unwrap_or(0),
            row_major: place.row_major,
            path: leaf.path,
        }
    });
    fill::Block { name: block.name.clone(), leaves: leaves.collect() }
}

fn basics_of(members: &[support::blocks::Member], found: &mut Vec<support::blocks::Basic>) {
    for member in members {
        match &member.ty {
            Type::Basic(basic) => found.push(*basic),
            Type::Struct(structure) => basics_of(&structure.members, found),
        }
    }
}

fn corpus() -> Vec<ShaderLayout> {
    vec![
        laid_out("names.frag", corpus::NAMES),
        laid_out("comments.frag", corpus::COMMENTS),
        laid_out("rules.comp", corpus::RULES),
        laid_out("types.comp", corpus::TYPES),
        laid_out("wgsl.wgsl", corpus::WGSL),
    ]
}

/// Every way of writing, with a name for it.
fn ways() -> Vec<(&'static str, RustOptions)> {
    let mut array = RustOptions::default();
    array.vectors = Vectors::Array;
    let mut inside = RustOptions::default();
    (inside.visibility, inside.tables) = (Visibility::Crate, Tables::Without);
    vec![("glam", RustOptions::default()), ("array", array), ("crate", inside)]
}

/// A root file with one module a text.
fn root(
    directory: &std::path::Path,
    name: &str,
    head: &str,
    texts: &[String],
) -> std::path::PathBuf {
    let mut root = format!("{head}\n");
    for (at, text) in texts.iter().enumerate() {
        let file = format!("{name}_{at}.rs");
        fs::write(directory.join(&file), text).expect("scratch can be written to");
        root.push_str(&format!("/// One.\npub mod m{at} {{\n    include!({file:?});\n}}\n"));
    }
    let path = directory.join(format!("{name}.rs"));
    fs::write(&path, root).expect("scratch can be written to");
    path
}

/// Writes mirrors and a program that includes them; returns the program's path.
fn written(name: &str, mirrors: &str, main: &str) -> std::path::PathBuf {
    let directory = scratch(name);
    fs::write(directory.join("mirrors.rs"), mirrors).expect("scratch can be written to");
    let path = directory.join("main.rs");
    fs::write(&path, main).expect("scratch can be written to");
    path
}

#[test]
fn the_output_has_no_warning_in_any_edition_and_nothing_to_format() {
    let shaders = corpus();
    for (way, options) in sampled(&ways(), 3) {
        let directory = scratch(&format!("corpus-{way}"));
        // Each alone, and all in one file.
        let mut texts: Vec<String> =
            shaders.iter().map(|shader| rust(&[shader], options).text).collect();
        texts.push(rust(&shaders.iter().collect::<Vec<_>>(), options).text);
        let library =
            root(&directory, "library", "//! All.\n#![no_std]\n#![deny(missing_docs)]", &texts);
        let program =
            root(&directory, "program", "#![no_std]\nextern crate std;\nfn main() {}", &texts);
        for edition in ["2021", "2024"] {
            for at in 0..texts.len() {
                assert_formatted(&directory.join(format!("library_{at}.rs")), edition);
            }
        }
        // Each compiler in each edition, as each kind of crate.
        for (compiler, edition, path, target) in [
            ("rustc", "2021", &library, Target::Library),
            ("rustc", "2024", &program, Target::Program),
            ("clippy-driver", "2024", &library, Target::Library),
            ("clippy-driver", "2021", &program, Target::Program),
        ] {
            let out = check(compiler, crates(Math::Simd), path, edition, target);
            assert!(out.status.success(), "{compiler} {edition}\n{}", shown(&out.stderr));
        }
    }
}

/// Every block of every shader of this repository, loose uniforms gathered, in one file; the
/// assertions in it hold sizes and offsets when it compiles.
#[test]
fn the_shaders_of_this_repository_have_mirrors_that_compile() {
    let options = Options::default().with_gather(true);
    let shaders: Vec<ShaderLayout> = support::files::shaders()
        .iter()
        .map(|path| layout(&Source::read(path).expect("a readable shader"), &options))
        .collect();
    let all: Vec<&ShaderLayout> = shaders.iter().collect();
    for (way, options) in sampled(&ways(), 3) {
        let output = rust(&all, options);
        let path = root(&scratch(&format!("shaders-{way}")), "library", "//! All.", &[output.text]);
        let out = check("rustc", crates(Math::Simd), &path, "2024", Target::Library);
        assert!(out.status.success(), "{way}: {}", shown(&out.stderr));
        // Only what is sized by a constant without a value has no mirror; two directories have
        // shaders of one file name, whose modules are told apart with a warning.
        let refused = output.diagnostics.iter().filter(|d| d.code != Code::NumberedName);
        let missing: Vec<_> = refused.map(|d| &d.message).collect();
        assert!(missing.iter().all(|m| m.contains("which has no value")), "{missing:?}");
    }
}

#[test]
fn mirrors_hold_when_glam_has_no_simd() {
    let shaders = corpus();
    let (standing, blocks) = random(5, batch(), &VULKAN);
    let random = laid_out("random.comp", &Batch { name: String::new(), standing, blocks }.text());
    let options = RustOptions::default();
    let all: Vec<&ShaderLayout> = shaders.iter().chain([&random]).collect();
    let directory = scratch("scalar-math");
    let path = root(&directory, "library", "//! All.", &[rust(&all, &options).text]);
    for math in [Math::Scalar, Math::Simd] {
        let out = check("rustc", crates(math), &path, "2024", Target::Library);
        assert!(out.status.success(), "{}", shown(&out.stderr));
    }
}

fn usage() -> String {
    let shader = laid_out("usage.frag", include_str!("../mirrors/usage.frag"));
    rust(&[&shader], &RustOptions::default()).text
}

#[test]
fn a_program_can_do_with_the_output_what_it_is_for() {
    let root = written("usage", &usage(), include_str!("../mirrors/usage.rs"));
    run(crates(Math::Simd), &root, "2021");
}

/// Helpers have the same names in all files: they are no items of the module that includes them.
#[test]
fn two_files_in_one_module_do_not_clash() {
    let one = rust(
        &[&laid_out("usage.frag", include_str!("../mirrors/usage.frag"))],
        &RustOptions::default(),
    );
    let text = "#version 450\nlayout(std140) uniform Other { mat3 m; bool b; float w[3]; };\n\
                layout(std430) buffer Tail { uint n; float tail[]; };\n";
    let two = rust(&[&laid_out("shaders/other.frag", text)], &RustOptions::default());
    let shaders = corpus();
    let three = rust(&shaders.iter().collect::<Vec<_>>(), &RustOptions::default());
    let directory = scratch("two-files");
    for (name, out) in [("one", one), ("two", two), ("three", three)] {
        fs::write(directory.join(format!("{name}.rs")), out.text)
            .expect("scratch can be written to");
    }
    let root = directory.join("main.rs");
    let text = "mod gpu {
    include!(\"one.rs\");
    include!(\"two.rs\");
    include!(\"three.rs\");
}
fn main() {
    let other = gpu::Other::new(gpu::OtherInit { m: glam::Mat3::IDENTITY, b: true, w: [1.0; 3] });
    assert_eq!(bytemuck::bytes_of(&other).len(), gpu::other::SIZE);
    assert_eq!(gpu::camera::lookup(\"on\").map(|leaf| leaf.offset), Ok(240));
    assert_eq!(gpu::other::lookup(\"b\").map(|leaf| leaf.offset), Ok(48));
    assert_eq!(gpu::rules_comp::LookupError::Unknown.to_string().len(), 34);
}
";
    fs::write(&root, text).expect("scratch can be written to");
    run(crates(Math::Simd), &root, "2021");
}

#[test]
fn a_mirror_that_departs_from_the_shader_does_not_compile_and_both_numbers_are_said() {
    // As if someone had taken a pad out, which moves what follows and makes the whole smaller.
    let text = usage();
    let tampered =
        text.replacen("    pub range: f32,\n", "", 1).replacen("            range,\n", "", 1);
    assert_ne!(text, tampered);
    let tampered = tampered.replace("offset_of!(PointLight, range)", "offset_of!(PointLight, pos)");
    let directory = scratch("tampered");
    let path = root(&directory, "library", "//! All.", &[tampered]);
    let out = check("rustc", crates(Math::Simd), &path, "2021", Target::Library);
    assert!(!out.status.success());
    let said = String::from_utf8_lossy(&out.stderr);
    let expected = "offset of `color` of `PointLight` in usage.frag: \
                    16 bytes in the shader, 12 in its mirror";
    assert!(said.contains(expected), "{said}");
    let expected = "size of `PointLight` in usage.frag: \
                    32 bytes in the shader, 28 in its mirror";
    assert!(said.contains(expected), "{said}");
}
