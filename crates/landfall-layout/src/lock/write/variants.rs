//! The blocks of all variants of a shader, each once, with the variants that have it.

use super::{Text, quoted};
use crate::ShaderLayout;
use crate::layout::BlockLayout;
use crate::shader::Macros;
use crate::source::Language;

/// The blocks of a shader and its variants.
pub(super) struct AllBlocks<'a> {
    /// The sets of macros under which the blocks are others than without macros.
    pub sets: Vec<&'a Macros>,
    pub blocks: Vec<SharedBlock<'a>>,
}

/// A block, and the variants that have it.
pub(super) struct SharedBlock<'a> {
    pub block: &'a BlockLayout,
    /// Their indices, 0 being the shader without macros.
    having: Vec<usize>,
    /// The text by which blocks are compared.
    text: String,
}

impl<'a> AllBlocks<'a> {
    pub fn of(shader: &'a ShaderLayout) -> AllBlocks<'a> {
        let language = shader.language;
        let shared = |(block, text)| SharedBlock { block, having: vec![0], text };
        let mut all = AllBlocks { sets: Vec::new(), blocks: Vec::new() };
        if shader.variants.is_empty() {
            // Most shaders: nothing is compared.
            all.blocks.extend(shader.blocks.iter().map(|block| shared((block, String::new()))));
            return all;
        }
        all.blocks.extend(texts(&shader.blocks, language).into_iter().map(shared));
        // Without regard to order: the order of blocks is no part of a layout.
        let base = sorted(all.blocks.iter().map(|shared| shared.text.clone()));
        for (variant, layout) in shader.laid_out_variants() {
            // A variant with the blocks of the shader itself needs no entry.
            let texts = texts(&layout.blocks, language);
            if sorted(texts.iter().map(|(_, text)| text.clone())) == base {
                continue;
            }
            all.sets.push(&variant.macros);
            let number = all.sets.len();
            for (block, text) in texts {
                // Two equal blocks of one variant are two blocks.
                let known = all.blocks.iter_mut();
                let mut known = known.filter(|known| !known.having.contains(&number));
                match known.find(|known| known.text == text) {
                    Some(known) => known.having.push(number),
                    None => all.blocks.push(SharedBlock { block, having: vec![number], text }),
                }
            }
        }
        all
    }

    /// The sets of macros of a block in JSON; `None` if every variant has it.
    pub fn having(&self, shared: &SharedBlock<'_>) -> Option<String> {
        if shared.having.len() == self.sets.len() + 1 {
            return None;
        }
        let sets = shared.having.iter().map(|&at| match at {
            0 => "[]".to_string(),
            at => set(self.sets[at - 1]),
        });
        Some(format!("[{}]", sets.collect::<Vec<_>>().join(", ")))
    }
}

/// Macros as they stand in `permutations` of a configuration.
pub(super) fn set(macros: &Macros) -> String {
    let one = |(name, text): &(String, String)| match text.as_str() {
        "1" => quoted(name),
        text => quoted(&format!("{name}={text}")),
    };
    format!("[{}]", macros.iter().map(one).collect::<Vec<_>>().join(", "))
}

fn texts(blocks: &[BlockLayout], language: Language) -> Vec<(&BlockLayout, String)> {
    let text = |block| {
        let mut out = Text { text: String::new(), language };
        out.block(block, None);
        out.text
    };
    blocks.iter().map(|block| (block, text(block))).collect()
}

fn sorted(texts: impl Iterator<Item = String>) -> Vec<String> {
    let mut texts: Vec<String> = texts.collect();
    texts.sort_unstable();
    texts
}
