//! Divides what a shader and its variants declare by the variants that have it, so that each distinct
//! block is shown once.

use rustc_hash::FxHashMap;

use super::variants::{Macros, name};
use crate::layout::BlockLayout;
use crate::shader::ShaderLayout;

/// The variants that have the blocks of a layout, if not all variants of its shader have them.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct VariantCondition {
    /// Their sets of macros.
    pub sets: Vec<Vec<(String, String)>>,
    /// What tells them from the others, as it follows a path: `with SHADOWS`.
    pub text: String,
}

/// The most macros that conditions of two macros are sought among.
const MOST_PAIRED: usize = 32;

/// The most variants that a condition names.
const MOST_NAMED: usize = 3;

/// A shader and its variants.
struct AllVariants<'a> {
    sets: Vec<&'a Macros>,
    layouts: Vec<&'a ShaderLayout>,
}

impl ShaderLayout {
    /// Returns the shader without its variants: first the blocks that every variant has, then those
    /// that some have, each once and with what tells these variants from the others. Variants with
    /// errors are left out. `own` are the macros of the shader itself.
    pub fn divided(self, own: &Macros) -> Vec<ShaderLayout> {
        if self.variants.is_empty() {
            return vec![self];
        }
        let all = AllVariants::of(&self, own);
        // Which variants have each block; of equal blocks of one variant, the first, the second.
        let mut having: FxHashMap<(String, usize), usize> = FxHashMap::default();
        let mut blocks: Vec<(&ShaderLayout, &BlockLayout, Vec<usize>)> = Vec::new();
        for (number, layout) in all.layouts.iter().enumerate() {
            let mut counts: FxHashMap<String, usize> = FxHashMap::default();
            for block in &layout.blocks {
                let key = key(block);
                let count = counts.entry(key.clone()).or_default();
                *count += 1;
                let at = *having.entry((key, *count)).or_insert_with(|| {
                    blocks.push((layout, block, Vec::new()));
                    blocks.len() - 1
                });
                blocks[at].2.push(number);
            }
        }
        let is_of_all = |having: &[usize]| having.len() == all.sets.len();
        let mut parts: Vec<(Vec<usize>, ShaderLayout)> =
            vec![((0..all.sets.len()).collect(), self.without_blocks())];
        for (layout, block, having) in blocks {
            let known = parts.iter().position(|(of, _)| *of == having);
            let at = known.unwrap_or_else(|| {
                let condition = Some(all.condition(&having));
                parts.push((having, ShaderLayout { condition, ..layout.without_blocks() }));
                parts.len() - 1
            });
            parts[at].1.blocks.push(block.clone());
        }
        let is_needless = parts.len() > 1 && parts[0].1.blocks.is_empty();
        debug_assert!(is_of_all(&parts[0].0), "the first part is that of all variants");
        parts.into_iter().skip(usize::from(is_needless)).map(|(_, part)| part).collect()
    }

    /// Returns the shader and those variants whose blocks differ from all before them, each named
    /// after its macros. Variants with errors are left out. `own` are the macros of the shader
    /// itself.
    pub fn distinct_variants(&self, own: &Macros) -> Vec<ShaderLayout> {
        let all = AllVariants::of(self, own);
        let mut known: FxHashMap<Vec<String>, usize> = FxHashMap::default();
        let mut distinct: Vec<(ShaderLayout, Vec<usize>)> = Vec::new();
        for (number, layout) in all.layouts.iter().enumerate() {
            let mut keys: Vec<String> = layout.blocks.iter().map(key).collect();
            keys.sort_unstable();
            let at = *known.entry(keys).or_insert_with(|| {
                let blocks = layout.blocks.clone();
                distinct.push((ShaderLayout { blocks, ..layout.without_blocks() }, Vec::new()));
                distinct.len() - 1
            });
            distinct[at].1.push(number);
        }
        if let [_, _, ..] = distinct.as_slice() {
            for (layout, having) in &mut distinct {
                let first = all.sets[having[0]];
                layout.condition = (!first.is_empty()).then(|| VariantCondition {
                    sets: having.iter().map(|&at| all.sets[at].to_vec()).collect(),
                    text: format!("with {}", name(first)),
                });
            }
        }
        distinct.into_iter().map(|(layout, _)| layout).collect()
    }

    fn without_blocks(&self) -> ShaderLayout {
        ShaderLayout {
            path: self.path.clone(),
            language: self.language,
            stage: self.stage,
            blocks: Vec::new(),
            condition: self.condition.clone(),
            overrides: self.overrides.clone(),
            specialised: self.specialised.clone(),
            constants: self.constants.clone(),
            sized_by_use: self.sized_by_use.clone(),
            files: self.files.clone(),
            diagnostics: self.diagnostics.clone(),
            assumed_target: self.assumed_target,
            opengl_es: self.opengl_es,
            interface: self.interface.clone(),
            variants: Vec::new(),
        }
    }

    /// The path, with what tells the variants that have these blocks.
    pub fn title(&self) -> String {
        match &self.condition {
            Some(condition) => format!("{} {}", self.path, condition.text),
            None => self.path.clone(),
        }
    }
}

impl<'a> AllVariants<'a> {
    fn of(shader: &'a ShaderLayout, own: &'a Macros) -> AllVariants<'a> {
        let mut all = AllVariants { sets: vec![own], layouts: vec![shader] };
        for variant in &shader.variants {
            let layout = variant.layout.as_deref().unwrap_or(shader);
            if !layout.has_errors() {
                all.sets.push(&variant.macros);
                all.layouts.push(layout);
            }
        }
        all
    }

    /// What tells some variants from the others.
    fn condition(&self, having: &[usize]) -> VariantCondition {
        let sets = having.iter().map(|&at| self.sets[at].to_vec()).collect();
        let text = self.common(having).unwrap_or_else(|| self.listed(having));
        VariantCondition { sets, text }
    }

    /// One macro, or two, that these variants have or lack and no other.
    fn common(&self, having: &[usize]) -> Option<String> {
        let mut macros: Vec<&(String, String)> = Vec::new();
        for one in self.sets.iter().flat_map(|set| set.iter()) {
            if !macros.contains(&one) {
                macros.push(one);
            }
        }
        let has = |set: &Macros, literal: &(&(String, String), bool)| {
            set.contains(literal.0) == literal.1
        };
        let is_all = |literals: &[(&(String, String), bool)]| {
            let mut sets = self.sets.iter().enumerate();
            sets.all(|(at, set)| {
                literals.iter().all(|literal| has(set, literal))
                    == having.binary_search(&at).is_ok()
            })
        };
        let literals: Vec<_> =
            [true, false].iter().flat_map(|is| macros.iter().map(move |one| (*one, *is))).collect();
        let word = |is: bool| if is { "with" } else { "without" };
        let shown = |one: &(String, String)| name(std::slice::from_ref(one));
        if let Some((one, is)) = literals.iter().find(|literal| is_all(&[**literal])) {
            return Some(format!("{} {}", word(*is), shown(one)));
        }
        let paired = if macros.len() > MOST_PAIRED { &[] } else { literals.as_slice() };
        for (at, first) in paired.iter().enumerate() {
            let second = paired[at + 1..].iter().find(|second| is_all(&[*first, **second]));
            if let Some(second) = second {
                let (joint, again) = match first.1 == second.1 {
                    true => (if first.1 { "and" } else { "or" }, String::new()),
                    false => ("and", format!("{} ", word(second.1))),
                };
                let (one, other) = (shown(first.0), shown(second.0));
                return Some(format!("{} {one} {joint} {again}{other}", word(first.1)));
            }
        }
        None
    }

    /// The variants by their names.
    fn listed(&self, having: &[usize]) -> String {
        let shown = having.iter().take(MOST_NAMED).map(|&at| match self.sets[at] {
            [] => "no macros".to_string(),
            set => name(set),
        });
        let mut shown: Vec<String> = shown.collect();
        if having.len() > MOST_NAMED {
            shown.push(format!("{} other variants", having.len() - MOST_NAMED));
        }
        format!("with {}", shown.join(" or "))
    }
}

/// The text by which blocks are compared: what a program sees of them.
fn key(block: &BlockLayout) -> String {
    use std::fmt::Write as _;

    let BlockLayout { name, instance, space, rules, group, binding, count, size, .. } = block;
    let mut key =
        format!("{name} {instance:?} {space:?} {rules:?} {group:?} {binding:?} {count:?} {size:?}");
    for leaf in &block.leaves {
        let (path, ty) = (&leaf.path, &leaf.ty);
        let (dims, strides) = (&leaf.dims, &leaf.strides);
        let (stride, rows) = (leaf.matrix_stride, leaf.row_major);
        let _ =
            write!(key, "\n{path} {ty:?} {:?} {dims:?} {strides:?} {stride:?} {rows}", leaf.offset);
    }
    key
}
