//! Divides what a shader and its variants declare by the variants that have it, so that each distinct
//! block is shown once.

use rustc_hash::FxHashMap;

use super::variants::{Macros, name};
use crate::layout::{BlockLayout, Leaf};
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

/// The most variants that a condition names.
const MAX_NAMED: usize = 3;

/// A shader and its variants.
struct AllVariants<'a> {
    sets: Vec<&'a Macros>,
    layouts: Vec<&'a ShaderLayout>,
    /// The macros of the sets, and which variants have each.
    macros: Vec<(&'a (String, String), Vec<bool>)>,
}

/// A block, the first layout that has it, and the variants that do.
struct DistinctBlock<'a> {
    layout: &'a ShaderLayout,
    block: &'a BlockLayout,
    having: Vec<usize>,
}

impl ShaderLayout {
    /// Returns the shader without its variants: first the blocks that every variant has, then those
    /// that some have, each once and with what tells these variants from the others. Variants with
    /// errors are left out. `own` are the macros of the shader itself.
    pub fn divided(self, own: &Macros) -> Vec<ShaderLayout> {
        if self.variants.is_empty() {
            return vec![self];
        }
        let all = AllVariants::new(&self, own);
        // The first part is what all variants have; each other group of variants gets a part as its
        // first block is met.
        let mut parts: Vec<(Vec<usize>, ShaderLayout)> =
            vec![((0..all.sets.len()).collect(), self.without_blocks())];
        for DistinctBlock { layout, block, having } in all.distinct_blocks().0 {
            let known = parts.iter().position(|(of, _)| *of == having);
            let at = known.unwrap_or_else(|| {
                let condition = Some(all.condition(&having));
                parts.push((having, ShaderLayout { condition, ..layout.without_blocks() }));
                parts.len() - 1
            });
            parts[at].1.blocks.push(block.clone());
        }
        // Nothing is shared by all.
        let is_needless = parts.len() > 1 && parts[0].1.blocks.is_empty();
        parts.into_iter().skip(usize::from(is_needless)).map(|(_, part)| part).collect()
    }

    /// Returns the shader and those variants whose blocks differ from all before them, each named
    /// after its macros. Variants with errors are left out. `own` are the macros of the shader
    /// itself.
    pub fn distinct_variants(&self, own: &Macros) -> Vec<ShaderLayout> {
        let all = AllVariants::new(self, own);
        let mut known: FxHashMap<Vec<usize>, usize> = FxHashMap::default();
        let mut distinct: Vec<(ShaderLayout, Vec<usize>)> = Vec::new();
        let of_variants = all.distinct_blocks().1;
        for (number, (layout, mut blocks)) in all.layouts.iter().zip(of_variants).enumerate() {
            // By the numbers of their distinct blocks, whose order does not matter.
            blocks.sort_unstable();
            let at = *known.entry(blocks).or_insert_with(|| {
                let layout = ShaderLayout { variants: Vec::new(), ..(*layout).clone() };
                distinct.push((layout, Vec::new()));
                distinct.len() - 1
            });
            distinct[at].1.push(number);
        }
        // A single one needs no name.
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
        ShaderLayout { blocks: Vec::new(), variants: Vec::new(), ..self.clone() }
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
    fn new(shader: &'a ShaderLayout, own: &'a Macros) -> AllVariants<'a> {
        let mut all = AllVariants { sets: vec![own], layouts: vec![shader], macros: Vec::new() };
        for variant in &shader.variants {
            let layout = variant.layout.as_deref().unwrap_or(shader);
            if !layout.has_errors() {
                all.sets.push(&variant.macros);
                all.layouts.push(layout);
            }
        }
        // Which variants have which macro: one bit for each, in the order of the sets.
        let mut known: FxHashMap<&(String, String), usize> = FxHashMap::default();
        for (number, set) in all.sets.iter().enumerate() {
            for one in set.iter() {
                let at = *known.entry(one).or_insert_with(|| {
                    all.macros.push((one, vec![false; all.sets.len()]));
                    all.macros.len() - 1
                });
                all.macros[at].1[number] = true;
            }
        }
        all
    }

    /// The distinct blocks, and the numbers of those of each variant.
    fn distinct_blocks(&self) -> (Vec<DistinctBlock<'a>>, Vec<Vec<usize>>) {
        let mut distinct: Vec<DistinctBlock<'a>> = Vec::new();
        let mut by_name: FxHashMap<&str, Vec<usize>> = FxHashMap::default();
        let mut of_variants = Vec::with_capacity(self.layouts.len());
        for (number, &layout) in self.layouts.iter().enumerate() {
            let mut blocks = Vec::with_capacity(layout.blocks.len());
            for block in &layout.blocks {
                let same_name = by_name.entry(&block.name).or_default();
                // Of equal blocks of one variant, the first, the second.
                let known = same_name.iter().copied().find(|&at| {
                    let known = &distinct[at];
                    known.having.last() != Some(&number) && is_same(known.block, block)
                });
                let at = known.unwrap_or_else(|| {
                    same_name.push(distinct.len());
                    distinct.push(DistinctBlock { layout, block, having: Vec::new() });
                    distinct.len() - 1
                });
                distinct[at].having.push(number);
                blocks.push(at);
            }
            of_variants.push(blocks);
        }
        (distinct, of_variants)
    }

    /// What tells some variants from the others.
    fn condition(&self, having: &[usize]) -> VariantCondition {
        let sets = having.iter().map(|&at| self.sets[at].to_vec()).collect();
        let text = self.common(having).unwrap_or_else(|| self.listed(having));
        VariantCondition { sets, text }
    }

    /// One macro, or two, that these variants have or lack and no other.
    fn common(&self, having: &[usize]) -> Option<String> {
        // A condition is sought that holds for exactly these variants: a single macro that they
        // have or lack, then two. Positive ones come first, as `with A` reads easier.
        let mut wanted = vec![false; self.sets.len()];
        having.iter().for_each(|&at| wanted[at] = true);
        let literals: Vec<_> = [true, false]
            .iter()
            .flat_map(|&is| self.macros.iter().map(move |(one, sets)| (*one, sets, is)))
            .collect();
        let word = |is: bool| if is { "with" } else { "without" };
        let shown = |one: &(String, String)| name(std::slice::from_ref(one));
        let all = 0..self.sets.len();
        // Whether the literal holds exactly where wanted.
        let is_all = |sets: &[bool], is: bool| all.clone().all(|at| (sets[at] == is) == wanted[at]);
        if let Some((one, _, is)) = literals.iter().find(|(_, sets, is)| is_all(sets, *is)) {
            return Some(format!("{} {}", word(*is), shown(one)));
        }
        // Both literals of a pair hold for all of these variants.
        let holds = |sets: &[bool], is: bool| having.iter().all(|&at| sets[at] == is);
        let kept: Vec<_> = literals.iter().filter(|(_, sets, is)| holds(sets, *is)).collect();
        for (at, &&(one, sets, is)) in kept.iter().enumerate() {
            let second = kept[at + 1..].iter().find(|(_, others, other_is)| {
                all.clone().all(|at| (sets[at] == is && others[at] == *other_is) == wanted[at])
            });
            if let Some(&&(other, _, other_is)) = second {
                // `with A and B`, `without A or B` (lacking both), `with A and without B`.
                let (joint, again) = match is == other_is {
                    true => (if is { "and" } else { "or" }, String::new()),
                    false => ("and", format!("{} ", word(other_is))),
                };
                let (one, other) = (shown(one), shown(other));
                return Some(format!("{} {one} {joint} {again}{other}", word(is)));
            }
        }
        None
    }

    /// The variants by their names.
    fn listed(&self, having: &[usize]) -> String {
        let shown = having.iter().take(MAX_NAMED).map(|&at| match self.sets[at] {
            [] => "no macros".to_string(),
            set => name(set),
        });
        let mut shown: Vec<String> = shown.collect();
        if having.len() > MAX_NAMED {
            shown.push(format!("{} other variants", having.len() - MAX_NAMED));
        }
        format!("with {}", shown.join(" or "))
    }
}

/// Whether a program sees the same of two blocks.
fn is_same(a: &BlockLayout, b: &BlockLayout) -> bool {
    let declared = |block: &BlockLayout| {
        let BlockLayout { space, rules, group, binding, size, .. } = *block;
        (space, rules, group, binding, size)
    };
    let leaf = |a: &Leaf, b: &Leaf| {
        (&a.path, &a.ty, a.offset, &a.dims) == (&b.path, &b.ty, b.offset, &b.dims)
            && (&a.strides, a.matrix_stride, a.row_major)
                == (&b.strides, b.matrix_stride, b.row_major)
    };
    (&a.name, &a.instance, &a.count) == (&b.name, &b.instance, &b.count)
        && declared(a) == declared(b)
        && a.leaves.len() == b.leaves.len()
        && a.leaves.iter().zip(&b.leaves).all(|(a, b)| leaf(a, b))
}
