//! Compares two copies of one block, or of one structure, leaf by leaf.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::walk::dimensions;
use landfall_layout::layout::measure::fixed;
use landfall_layout::layout::{BlockLayout, Leaf};
use landfall_layout::shape::{ArrayLen, Type};
use landfall_layout::source::{Language, Span};

/// A copy: leaves with the names by which they are compared.
pub(super) struct View<'a> {
    /// Its leaves, in the order of the text.
    pub leaves: Vec<NamedLeaf<'a>>,
    /// The size of the copy, or of one element, in bytes.
    pub size: Option<u64>,
    pub language: Language,
}

pub(super) struct NamedLeaf<'a> {
    /// The name in every copy.
    pub name: String,
    /// The offset from the start of the copy; `None` for loose uniforms.
    pub offset: Option<u64>,
    /// Dimensions and strides below the start of the copy.
    pub dims: &'a [ArrayLen],
    pub strides: &'a [u64],
    pub leaf: &'a Leaf,
    /// The array that each dimension belongs to.
    pub arrays: Vec<Span>,
}

/// A way in which two copies differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct CopyDifference {
    /// The difference, with both numbers, this copy first.
    pub text: String,
    /// The leaf in this copy, and in the other.
    pub here: Option<Span>,
    pub there: Option<Span>,
    /// Whether only a name differs and every byte has the same meaning.
    pub cosmetic: bool,
}

/// Returns a whole block as a copy.
pub(super) fn view(block: &BlockLayout, language: Language) -> View<'_> {
    let leaves = block.leaves.iter().map(|leaf| NamedLeaf {
        name: leaf.path.clone(),
        offset: leaf.offset,
        dims: &leaf.dims,
        strides: &leaf.strides,
        leaf,
        arrays: dimensions(&block.members, &leaf.path),
    });
    View { leaves: leaves.collect(), size: block.size, language }
}

/// Returns whether two blocks have the same layout.
pub(super) fn alike(a: &BlockLayout, b: &BlockLayout) -> bool {
    a.leaves.len() == b.leaves.len()
        && a.leaves.iter().zip(&b.leaves).all(|(a, b)| {
            a.offset == b.offset
                && a.path == b.path
                && a.ty == b.ty
                && a.dims == b.dims
                && a.strides == b.strides
                && a.matrix_stride == b.matrix_stride
                && a.row_major == b.row_major
        })
}

/// Returns the number of leaves that two copies share by name and type.
pub(super) fn shared(a: &View<'_>, b: &View<'_>) -> usize {
    let theirs = by_name(b);
    let is_shared = |leaf: &&NamedLeaf<'_>| {
        theirs.get(leaf.name.as_str()).is_some_and(|twin| twin.leaf.ty == leaf.leaf.ty)
    };
    a.leaves.iter().filter(is_shared).count()
}

fn by_name<'v>(view: &'v View<'_>) -> FxHashMap<&'v str, &'v NamedLeaf<'v>> {
    view.leaves.iter().map(|leaf| (leaf.name.as_str(), leaf)).collect()
}

/// Returns whether one copy is the start of the other: its leaves are the other's first ones, at
/// the same offsets.
pub(super) fn is_head(a: &View<'_>, b: &View<'_>) -> bool {
    let (short, long) = if a.leaves.len() <= b.leaves.len() { (a, b) } else { (b, a) };
    !short.leaves.is_empty()
        && short.leaves.iter().zip(&long.leaves).all(|(a, b)| a.name == b.name && same(a, b))
}

/// Returns whether a byte has different meanings in two copies: overlapping leaves differ in more
/// than the name.
pub(super) fn collide(a: &View<'_>, b: &View<'_>) -> bool {
    // The number of pairs is bounded; realistic blocks are far smaller.
    if a.leaves.len().saturating_mul(b.leaves.len()) > 1_000_000 {
        return false;
    }
    // Only first elements overlap here: dimensions and strides are part of `same`.
    let first = |leaf: &NamedLeaf<'_>| Some((leaf.offset?, leaf.offset? + leaf.leaf.size?));
    a.leaves.iter().any(|a| {
        b.leaves.iter().any(|b| match (first(a), first(b)) {
            (Some((a0, a1)), Some((b0, b1))) => a0 < b1 && b0 < a1 && !same(a, b),
            (None, _) | (_, None) => false,
        })
    })
}

/// Returns whether two leaves have the same bytes.
fn same(a: &NamedLeaf<'_>, b: &NamedLeaf<'_>) -> bool {
    a.offset == b.offset
        && a.leaf.ty == b.leaf.ty
        && a.dims == b.dims
        && a.strides == b.strides
        && a.leaf.matrix_stride == b.leaf.matrix_stride
        && a.leaf.row_major == b.leaf.row_major
}

/// Returns every difference in the order of this copy, then the leaves that only the other has.
pub(super) fn differences(here: &View<'_>, there: &View<'_>) -> Vec<CopyDifference> {
    let mut found = Vec::new();
    let ours = by_name(here);
    let theirs = by_name(there);
    let mut by_offset: FxHashMap<Option<u64>, Vec<&NamedLeaf<'_>>> = FxHashMap::default();
    for leaf in &there.leaves {
        by_offset.entry(leaf.offset).or_default().push(leaf);
    }
    let other = |name: &str| theirs.get(name).copied();
    let known = |name: &str| ours.contains_key(name);
    let mut renamed: FxHashSet<&str> = FxHashSet::default();
    // By name first: leaves that moved, or that are of another type.
    for leaf in &here.leaves {
        if let Some(twin) = other(&leaf.name) {
            if let Some(array) = resized(leaf, twin) {
                // Once for all members of its structure.
                if !found.contains(&array) {
                    found.push(array);
                }
            } else if let Some(text) = moved(leaf, twin, here.language, there.language) {
                found.push(difference(text, Some(leaf), Some(twin)));
            }
            continue;
        }
        // Then by byte: the same leaf under another name.
        let there = by_offset.get(&leaf.offset).map_or(&[][..], Vec::as_slice);
        // Loose uniforms all lack an offset: a name is all that tells them apart.
        let twin = there.iter().find(|t| leaf.offset.is_some() && !known(&t.name) && same(leaf, t));
        match twin {
            Some(twin) => {
                renamed.insert(&twin.name);
                let text = format!(
                    "the {} is named `{}` here and `{}` there",
                    described(leaf, here.language),
                    leaf.name,
                    twin.name
                );
                let difference = difference(text, Some(leaf), Some(twin));
                found.push(CopyDifference { cosmetic: true, ..difference });
            }
            None => {
                let what = described(leaf, here.language);
                let text = format!("`{}` ({what}) is only here", leaf.name);
                found.push(difference(text, Some(leaf), None));
            }
        }
    }
    // A leaf that is missing here is reported at the leaf that follows it there, else at the last.
    let mut next = here.leaves.last();
    let mut missing = Vec::new();
    for leaf in there.leaves.iter().rev() {
        match ours.get(leaf.name.as_str()).copied() {
            Some(twin) => next = Some(twin),
            None if renamed.contains(leaf.name.as_str()) => {}
            None => {
                let what = described(leaf, there.language);
                let text = format!("`{}` ({what}) is only there", leaf.name);
                missing.push(difference(text, next, Some(leaf)));
            }
        }
    }
    found.extend(missing.into_iter().rev());
    found
}

fn difference(
    text: String,
    here: Option<&NamedLeaf<'_>>,
    there: Option<&NamedLeaf<'_>>,
) -> CopyDifference {
    CopyDifference {
        text,
        here: here.map(|leaf| leaf.leaf.span),
        there: there.map(|leaf| leaf.leaf.span),
        cosmetic: false,
    }
}

/// Returns the difference of an array of structures that a leaf is in: its length or stride.
fn resized(here: &NamedLeaf<'_>, there: &NamedLeaf<'_>) -> Option<CopyDifference> {
    if here.dims.len() != there.dims.len() || here.offset != there.offset {
        return None;
    }
    // The dimensions before the last `.` are those of structures around the leaf.
    let outer = here.name.rsplit_once('.').map_or(0, |(outer, _)| outer.matches("[]").count());
    let at = (0..outer.min(here.dims.len())).find(|&at| {
        here.dims[at] != there.dims[at] || here.strides.get(at) != there.strides.get(at)
    })?;
    // The path up to that dimension.
    let end = here.name.match_indices("[]").nth(at).map(|(end, _)| end)?;
    let name = here.name[..end].trim_end_matches("[]");
    let count = |len: &ArrayLen| match fixed(len) {
        Some(n) => n.to_string(),
        None => "any number of".to_string(),
    };
    let mut parts = Vec::new();
    let (a, b) = (&here.dims[at], &there.dims[at]);
    if a != b {
        parts.push(format!("has {} elements here and {} there", count(a), count(b)));
    }
    if let (Some(a), Some(b)) = (here.strides.get(at), there.strides.get(at)) {
        if a != b {
            parts.push(format!("has an array stride of {a} here and {b} there"));
        }
    }
    Some(CopyDifference {
        text: format!("`{name}` {}", parts.join(", ")),
        here: here.arrays.get(at).copied(),
        there: there.arrays.get(at).copied(),
        cosmetic: false,
    })
}

/// Returns the differences of a leaf that both copies have.
fn moved(
    here: &NamedLeaf<'_>,
    there: &NamedLeaf<'_>,
    ours: Language,
    theirs: Language,
) -> Option<String> {
    let mut parts = Vec::new();
    let name = &here.name;
    if here.leaf.ty != there.leaf.ty || here.dims != there.dims {
        let (a, b) = (spelled(here, ours), spelled(there, theirs));
        parts.push(format!("is a {a} here and a {b} there"));
    }
    // A loose uniform has no offset to differ.
    if let (Some(a), Some(b)) = (here.offset, there.offset) {
        if a != b {
            parts.push(format!("is at offset {a} here and {b} there"));
        }
    }
    let strides = |leaf: &NamedLeaf<'_>| {
        leaf.strides.iter().map(u64::to_string).collect::<Vec<_>>().join(" and ")
    };
    if here.strides.len() == there.strides.len() && here.strides != there.strides {
        let (a, b) = (strides(here), strides(there));
        parts.push(format!("has an array stride of {a} here and {b} there"));
    }
    if here.leaf.ty == there.leaf.ty {
        if let (Some(a), Some(b)) = (here.leaf.matrix_stride, there.leaf.matrix_stride) {
            if a != b {
                parts.push(format!("has a matrix stride of {a} here and {b} there"));
            }
        }
        if here.leaf.row_major != there.leaf.row_major {
            let word = |row: bool| if row { "row-major" } else { "column-major" };
            let (a, b) = (word(here.leaf.row_major), word(there.leaf.row_major));
            parts.push(format!("is {a} here and {b} there"));
        }
    }
    (!parts.is_empty()).then(|| format!("`{name}` {}", parts.join(", ")))
}

/// Returns a leaf's type and offset: `vec3` at offset 16.
fn described(leaf: &NamedLeaf<'_>, language: Language) -> String {
    let ty = spelled(leaf, language);
    leaf.offset.map_or_else(|| ty.clone(), |offset| format!("{ty} at offset {offset}"))
}

fn spelled(leaf: &NamedLeaf<'_>, language: Language) -> String {
    let mut ty: Type = leaf.leaf.ty.clone();
    for len in leaf.dims.iter().rev() {
        ty = Type::Array { element: std::sync::Arc::new(ty), len: len.clone() };
    }
    format!("`{}`", ty.spelled(language))
}
