//! Compares a shader under every set of macros, and reports a change that several show once.

use super::{BlockDiff, Side, diff};
use crate::shader::{Macros, ShaderLayout, variant_name};

/// The changes that a shader shows under a set of macros, and under no set before it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct VariantDiff<'a> {
    /// The macros; empty for the shader without those of a variant.
    pub macros: &'a Macros,
    /// The old layout.
    pub old: &'a ShaderLayout,
    /// The new layout.
    pub new: &'a ShaderLayout,
    /// The changed blocks.
    pub blocks: Vec<BlockDiff>,
    /// The names of the other sets that show the same changes of a block, for each block.
    pub also: Vec<Vec<String>>,
}

impl VariantDiff<'_> {
    /// The macros as messages name them; `None` for the shader without them.
    pub fn name(&self) -> Option<String> {
        (!self.macros.is_empty()).then(|| variant_name(self.macros))
    }
}

/// Compares two shaders and their variants. The first entry is the shaders without macros of
/// variants; entries of variants have changes.
///
/// A variant of the new shader that the old one lacks is compared with the old shader without
/// macros, which it was then. A variant of the old one that the new one lacks is left out: its
/// macros are no longer configured.
pub fn diff_variants<'a>(old: &'a ShaderLayout, new: &'a ShaderLayout) -> Vec<VariantDiff<'a>> {
    let blocks = diff(Side::from_shader(old), Side::from_shader(new));
    let also = vec![Vec::new(); blocks.len()];
    let mut all = vec![VariantDiff { macros: &[], old, new, blocks, also }];
    for variant in &new.variants {
        let (before, after) = (old.under(&variant.macros), new.under(&variant.macros));
        // A variant with errors has a finding of its own.
        // Neither side depends on these macros: the first entry has the changes.
        if after.has_errors() || std::ptr::eq(before, old) && std::ptr::eq(after, new) {
            continue;
        }
        let mut blocks = diff(Side::from_shader(before), Side::from_shader(after));
        blocks.retain(|block| !is_known(&mut all, block, &variant.name()));
        if !blocks.is_empty() {
            let also = vec![Vec::new(); blocks.len()];
            let macros = &variant.macros;
            all.push(VariantDiff { macros, old: before, new: after, blocks, also });
        }
    }
    all
}

/// Whether an earlier set shows the same changes of a block, which then notes `name` as well.
fn is_known(all: &mut [VariantDiff<'_>], block: &BlockDiff, name: &str) -> bool {
    for one in all {
        let same = one
            .blocks
            .iter()
            .position(|known| known.name == block.name && known.changes == block.changes);
        if let Some(at) = same {
            // Of the shader itself they are changes of every variant, which goes without saying.
            if !one.macros.is_empty() {
                one.also[at].push(name.to_string());
            }
            return true;
        }
    }
    false
}
