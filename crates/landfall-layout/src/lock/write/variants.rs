//! The blocks of all variants of a shader, each once, with the variants that have it.

use super::{MacroTexts, RecordedBlock};
use crate::ShaderLayout;
use crate::layout::BlockLayout;
use crate::shader::Macros;
use crate::source::Language;

/// The blocks of a shader and its variants.
pub(super) struct AllBlocks<'a> {
    /// The sets of macros under which the blocks are others than without macros.
    pub sets: Vec<MacroTexts>,
    pub blocks: Vec<RecordedBlock<'a>>,
}

/// A block, and the variants that have it.
struct SharedBlock<'a> {
    block: RecordedBlock<'a>,
    /// Their indices, 0 being the shader without macros.
    having: Vec<usize>,
    /// The text by which blocks are compared.
    text: String,
}

impl<'a> AllBlocks<'a> {
    pub fn from_shader(shader: &'a ShaderLayout) -> AllBlocks<'a> {
        let language = shader.language;
        if shader.variants.is_empty() {
            // Most shaders: nothing is compared.
            let all = shader.blocks.iter().map(|block| RecordedBlock::new(block, language));
            return AllBlocks { sets: Vec::new(), blocks: all.collect() };
        }
        let mut sets = vec![MacroTexts(Vec::new())];
        let mut known = shared(&shader.blocks, language, 0);
        // Without regard to order: the order of blocks is no part of a layout.
        let base = texts(&known);
        for (variant, layout) in shader.laid_out_variants() {
            let others = shared(&layout.blocks, language, sets.len());
            // A variant with the blocks of the shader itself needs no entry.
            if texts(&others) == base {
                continue;
            }
            let number = sets.len();
            sets.push(set(&variant.macros));
            for other in others {
                // Two equal blocks of one variant are two blocks.
                let mut others = known.iter_mut().filter(|one| !one.having.contains(&number));
                match others.find(|one| one.text == other.text) {
                    Some(same) => same.having.push(number),
                    None => known.push(other),
                }
            }
        }
        let variants = |having: &[usize]| match having.len() == sets.len() {
            true => Vec::new(),
            false => having.iter().map(|&at| sets[at].clone()).collect(),
        };
        let blocks = known
            .into_iter()
            .map(|shared| RecordedBlock { variants: variants(&shared.having), ..shared.block })
            .collect();
        sets.remove(0);
        AllBlocks { sets, blocks }
    }
}

/// Macros as they stand in `permutations` of a configuration.
fn set(macros: &Macros) -> MacroTexts {
    let one = |(name, text): &(String, String)| match text.as_str() {
        "1" => name.clone(),
        text => format!("{name}={text}"),
    };
    MacroTexts(macros.iter().map(one).collect())
}

fn shared(blocks: &[BlockLayout], language: Language, variant: usize) -> Vec<SharedBlock<'_>> {
    let shared = |block| {
        let block = RecordedBlock::new(block, language);
        let text = serde_json::to_string(&block).expect("keys are strings");
        SharedBlock { block, having: vec![variant], text }
    };
    blocks.iter().map(shared).collect()
}

/// The texts of blocks in an order of their own.
fn texts(blocks: &[SharedBlock<'_>]) -> Vec<String> {
    let mut texts: Vec<String> = blocks.iter().map(|shared| shared.text.clone()).collect();
    texts.sort_unstable();
    texts
}
