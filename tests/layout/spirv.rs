//! SPIR-V modules: those of glslang against the texts they were compiled from, and against two other
//! readers of their decorations.

mod disassembly;
mod forms;
mod hostile;
mod slang;

use std::collections::HashMap;
use std::fs;

use landfall_layout::layout::Leaf;
use landfall_layout::shape::Type;
use landfall_layout::{Options, ShaderLayout, Source, Stage, Target, layout};

use crate::support::files::shaders;
use crate::support::generate::{COMMON, Diet, VULKAN, random};
use crate::support::glslang::{self, Client, compiled};
use crate::support::known::{Oracle, Subject, explains};
use crate::support::leaf::{Difference, OracleBlock, What, differences};
use crate::support::run::Batch;
use crate::support::sample::sample;
use crate::support::{landfall, spirv};

/// Random blocks of one module.
const BLOCKS: usize = 100;

/// The bytes of a module in the byte order of most files.
fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

fn read(words: &[u32]) -> ShaderLayout {
    let source = Source::from_bytes("a.spv", bytes(words)).expect("it has the magic number");
    layout(&source, &Options::default())
}

/// The layout of a module without errors.
fn laid_out(words: &[u32]) -> ShaderLayout {
    let shader = read(words);
    assert!(!shader.has_errors(), "{:#?}", shader.diagnostics);
    shader
}

/// The table of a module, without what no decoration says.
fn decorated(shader: &ShaderLayout) -> Vec<OracleBlock> {
    let mut blocks = landfall::table(shader);
    for block in &mut blocks {
        (block.size, block.data_size) = (None, None);
    }
    blocks
}

/// What a second reader of the module's words says otherwise.
fn of_second_reader(words: &[u32], shader: &ShaderLayout) -> Vec<Difference> {
    let theirs = spirv::blocks(words).expect("it is a module of glslang's");
    let is_address = |d: &Difference| d.what == What::Type && d.right == "\"reference\"";
    let found = differences(&decorated(shader), &theirs);
    found.into_iter().filter(|difference| !is_address(difference)).collect()
}

#[test]
fn modules_of_random_blocks_are_laid_out_as_their_texts() {
    for seed in sample(0..10, 10) {
        random_blocks(seed, &COMMON);
        random_blocks(seed, &VULKAN);
    }
}

/// Random blocks, and their module by glslang.
fn random_module(seed: u64, diet: &Diet) -> (Batch, Vec<u32>) {
    let (standing, blocks) = random(seed, BLOCKS, diet);
    let batch = Batch { name: format!("seed {seed}"), standing, blocks };
    let options =
        glslang::Options { target_env: Some("vulkan1.2"), ..glslang::Options::unlisted() };
    let text = batch.text();
    let (words, _) = compiled(&text, "comp", &options).unwrap_or_else(|e| panic!("{e}\n{text}"));
    (batch, words)
}

fn random_blocks(seed: u64, diet: &Diet) {
    let (batch, words) = random_module(seed, diet);
    let text = batch.text();
    let shader = laid_out(&words);
    assert_eq!(shader.stage, Some(Stage::Compute));
    assert_eq!(of_second_reader(&words, &shader), [], "seed {seed}");
    let of_text = landfall::glsl_blocks(&text, Target::Vulkan);
    assert_eq!(of_text.len(), BLOCKS);
    let subjects: HashMap<&str, Subject<'_>> = batch
        .blocks
        .iter()
        .map(|block| (block.name.as_str(), Subject { block, standing: &batch.standing }))
        .collect();
    for difference in differences(&of_text, &decorated(&shader)) {
        let known = explains(subjects[&*difference.block], &difference, Some(Oracle::Glslang));
        assert!(known.is_some(), "{difference}\n{}", batch.text_of(&difference.block));
    }
    // The rules that are found are those of the text, or give the same numbers.
    for block in &shader.blocks {
        assert!(block.rules.name() != "explicit", "{}", batch.text_of(&block.name));
    }
}

#[test]
fn modules_of_the_shaders_are_laid_out_as_their_texts() {
    let mut compared = 0;
    for path in shaders() {
        let name = path.display().to_string();
        let Ok(text) = fs::read_to_string(&path) else { continue };
        let Some(stage) = path.extension().and_then(|end| end.to_str()) else { continue };
        if !["vert", "frag", "comp"].contains(&stage) {
            continue;
        }
        for (client, target) in [(Client::Vulkan, Target::Vulkan), (Client::OpenGl, Target::OpenGl)]
        {
            let options = glslang::Options { client, ..glslang::Options::unlisted() };
            let Ok((words, _)) = compiled(&text, stage, &options) else { continue };
            let shader = laid_out(&words);
            assert_eq!(of_second_reader(&words, &shader), [], "{name}");
            let mut read = Options::default();
            read.read.target = Some(target);
            let of_text = layout(&Source::new(name.as_str(), text.as_str()), &read);
            assert!(!of_text.has_errors(), "{name}: {:#?}", of_text.diagnostics);
            // A block whose rules the driver chooses has those that glslang chooses in the module.
            let is_declared = |block: &OracleBlock| {
                of_text.blocks.iter().any(|b| *b.name == *block.name && b.rules_declared)
            };
            let keep = |blocks: Vec<OracleBlock>| -> Vec<OracleBlock> {
                blocks.into_iter().filter(is_declared).collect()
            };
            let (ours, theirs) = (keep(landfall::table(&of_text)), keep(decorated(&shader)));
            compared += theirs.len();
            let found = differences(&ours, &theirs);
            let is_bool = |d: &Difference| d.what == What::Type && d.left.contains("b");
            let found: Vec<_> = found.into_iter().filter(|d| !is_bool(d)).collect();
            assert_eq!(found, [], "{name}");
        }
    }
    assert!(compared >= 60, "{compared} blocks of modules were compared");
}

/// naga's module of a WGSL text, with names; `None` for what naga refuses.
fn module_of_naga(text: &str) -> Option<Vec<u32>> {
    let module = naga::front::wgsl::parse_str(text).ok()?;
    let capabilities = naga::valid::Capabilities::all();
    let info = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
        .validate(&module)
        .ok()?;
    let options = naga::back::spv::Options {
        flags: naga::back::spv::WriterFlags::DEBUG,
        ..naga::back::spv::Options::default()
    };
    naga::back::spv::write_vec(&module, &info, &options, None).ok()
}

/// Each leaf of each block by its binding: path, offset, strides and size, as naga places it where it
/// places it otherwise. Without matrices of two rows, of which naga makes a member for each column.
fn bound(shader: &ShaderLayout) -> Vec<(u32, u32, Vec<LeafNumbers>)> {
    let bound = shader.blocks.iter().filter_map(|block| {
        let is_divided = |leaf: &&Leaf| {
            matches!(leaf.ty, Type::Matrix { rows: 2, .. })
                || leaf.path.trim_end_matches(|c: char| c.is_ascii_digit()).ends_with("_col")
        };
        let leaves = block.leaves.iter().filter(|leaf| !is_divided(leaf)).map(|leaf| {
            let naga = leaf.naga.as_ref();
            let offset = naga.map_or(leaf.offset, |naga| Some(naga.offset));
            let strides = naga.map_or(&leaf.strides, |naga| &naga.strides).clone();
            // naga gives no name to the one member that it wraps a variable in.
            let path = leaf.path.strip_prefix(&*block.name);
            let path = path.or(leaf.path.strip_prefix("member_0")).unwrap_or(&leaf.path);
            (path.to_string(), offset, strides, leaf.size, leaf.matrix_stride)
        });
        Some((block.group?, block.binding?, leaves.collect()))
    });
    let mut bound: Vec<_> = bound.collect();
    bound.sort();
    bound
}

type LeafNumbers = (String, Option<u64>, Vec<u64>, Option<u64>, Option<u64>);

#[test]
fn modules_of_naga_are_laid_out_as_their_wgsl() {
    let mut compared = 0;
    for path in shaders() {
        if path.extension().is_none_or(|end| end != "wgsl") {
            continue;
        }
        let name = path.display().to_string();
        let Ok(text) = fs::read_to_string(&path) else { continue };
        let Some(words) = module_of_naga(&text) else { continue };
        let options = Options::default().with_naga(true);
        let of_text = layout(&Source::new(name.as_str(), text.as_str()), &options);
        assert!(!of_text.has_errors(), "{name}: {:#?}", of_text.diagnostics);
        let of_module = bound(&laid_out(&words));
        compared += of_module.len();
        assert_eq!(of_module, bound(&of_text), "{name}");
    }
    assert!(compared >= 20, "{compared} blocks of modules were compared");
}
