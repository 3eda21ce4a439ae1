//! Padding of blocks: holes between members, and tail padding of blocks, structures, array
//! elements, columns and rows.
//!
//! Reads the [model](super), feeds [`format`](mod@crate::format) and [`byte`](super::byte).

use std::sync::Arc;

use super::measure::{
    element_size, elements, fixed, matrix_vector, own_size, reach, size_in_dimension,
};
use super::{BlockLayout, MemberLayout};
use crate::shape::{Rules, Type};

/// The position of padding within its owner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum PaddingKind {
    /// Between two members, or before the first.
    Hole,
    /// After the last member or component of its owner.
    #[serde(rename = "tail padding")]
    Tail,
}

impl PaddingKind {
    /// Returns the name used in messages: `hole` or `tail padding`.
    pub fn name(self) -> &'static str {
        match self {
            PaddingKind::Hole => "hole",
            PaddingKind::Tail => "tail padding",
        }
    }
}

/// The kind of thing that padding belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)]
#[non_exhaustive]
pub enum PaddingOwner {
    Block,
    Structure,
    /// A member enlarged with `@size`.
    Member,
    /// An element of an array that is smaller than the array's stride.
    Element,
    /// A column of a matrix that is smaller than the matrix stride.
    Column,
    /// A row of a row-major matrix that is smaller than the matrix stride.
    Row,
}

impl PaddingOwner {
    /// Returns the noun used in messages.
    pub fn noun(self) -> &'static str {
        match self {
            PaddingOwner::Block => "block",
            PaddingOwner::Structure => "structure",
            PaddingOwner::Member => "member",
            PaddingOwner::Element => "element",
            PaddingOwner::Column => "column",
            PaddingOwner::Row => "row",
        }
    }
}

/// Unused bytes of a block; those in the elements of an array are one entry.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Padding {
    /// Hole or tail padding.
    pub kind: PaddingKind,
    /// The kind of owner.
    pub owner: PaddingOwner,
    /// The path of the owner as a pattern: `data[]`, `view`; empty for the block.
    pub path: String,
    /// The name of the owner's structure, if any.
    pub structure: Option<Arc<str>>,
    /// Offset from the start of the owner.
    pub offset: u64,
    /// Offset of the first occurrence from the start of the block.
    pub block_offset: u64,
    /// Size of one occurrence in bytes.
    pub size: u64,
    /// Number of occurrences: one per element of every array around it, runtime-sized ones counted
    /// as one element.
    pub times: u64,
    /// The member directly before the padding.
    pub after: Option<Arc<str>>,
    /// The member directly after the padding.
    pub before: Option<Arc<str>>,
}

/// The used bytes and the padding of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Summary {
    /// Bytes a buffer must hold, as [`BlockLayout::size`].
    pub size: u64,
    /// Bytes that hold components.
    pub used: u64,
    /// Bytes of padding: `size - used`.
    pub padding: u64,
}

impl Summary {
    /// Returns the share of padding in percent; 0 for an empty block.
    pub fn percent(&self) -> f64 {
        if self.size == 0 { 0.0 } else { self.padding as f64 * 100.0 / self.size as f64 }
    }
}

/// Summarises the bytes of a block; `None` for loose uniforms.
pub fn summary(block: &BlockLayout) -> Option<Summary> {
    let size = block.size?;
    let used = block.used();
    Some(Summary { size, used, padding: size.saturating_sub(used) })
}

/// Returns all holes and tail padding of a block, owners before their members; empty for loose
/// uniforms.
pub fn padding(block: &BlockLayout) -> Vec<Padding> {
    let mut found = Vec::new();
    if let Some(size) = block.size {
        let scope = PaddingScope { path: String::new(), base: 0, times: 1, rules: block.rules };
        let owner = (PaddingOwner::Block, None);
        of_members(&block.members, size, owner, &scope, &mut found);
    }
    found
}

/// A position in the tree of members: the pattern, the offset of its first occurrence, and the
/// number of occurrences.
struct PaddingScope {
    path: String,
    base: u64,
    times: u64,
    rules: Rules,
}

fn of_members(
    members: &[MemberLayout],
    whole: u64,
    (owner, structure): (PaddingOwner, Option<Arc<str>>),
    scope: &PaddingScope,
    found: &mut Vec<Padding>,
) {
    for gap in gaps(members, whole) {
        found.push(Padding {
            kind: gap.kind,
            owner,
            path: scope.path.clone(),
            structure: structure.clone(),
            offset: gap.offset,
            block_offset: scope.base + gap.offset,
            size: gap.size,
            times: scope.times,
            after: gap.after.map(|i| members[i].name.clone()),
            before: gap.before.map(|i| members[i].name.clone()),
        });
    }
    for member in members {
        let Some(offset) = member.offset else { continue };
        let mut path = scope.path.clone();
        if !path.is_empty() {
            path.push('.');
        }
        path.push_str(&member.name);
        let mut inner = PaddingScope { path, base: scope.base + offset, ..*scope };
        for tail in tails(member, scope.rules) {
            // `@size` pads the whole member; all other padding is in each of its elements.
            if tail.owner != PaddingOwner::Member && !inner.path.ends_with(']') {
                member.dims.iter().for_each(|_| inner.path.push_str("[]"));
            }
            found.push(Padding {
                kind: PaddingKind::Tail,
                owner: tail.owner,
                path: inner.path.clone(),
                structure: None,
                offset: tail.offset,
                block_offset: inner.base + tail.offset,
                size: tail.size,
                times: scope.times * tail.times,
                after: None,
                before: None,
            });
        }
        if let Type::Struct(s) = member.ty.innermost() {
            if !inner.path.ends_with(']') {
                member.dims.iter().for_each(|_| inner.path.push_str("[]"));
            }
            inner.times *= elements(&member.dims);
            let name = (!s.name.is_empty()).then(|| s.name.clone());
            let whole = element_size(member, scope.rules);
            of_members(&member.members, whole, (PaddingOwner::Structure, name), &inner, found);
        }
    }
}

/// Unused bytes between or after the members of one block or structure; members are indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct UnusedBytes {
    pub kind: PaddingKind,
    pub offset: u64,
    pub size: u64,
    pub after: Option<usize>,
    pub before: Option<usize>,
}

/// Returns the gaps of a block or structure of `whole` bytes, by offset.
pub(crate) fn gaps(members: &[MemberLayout], whole: u64) -> Vec<UnusedBytes> {
    let mut order: Vec<usize> = (0..members.len()).collect();
    order.sort_by_key(|&i| members[i].offset);
    let mut gaps = Vec::new();
    // The furthest end so far, and the member that it belongs to.
    let mut end = 0;
    let mut after = None;
    for i in order {
        let Some(offset) = members[i].offset else { continue };
        if offset > end {
            let (kind, size) = (PaddingKind::Hole, offset - end);
            gaps.push(UnusedBytes { kind, offset: end, size, after, before: Some(i) });
        }
        // A member without bytes at that end, an empty structure, is the one before the next gap,
        // too.
        if offset + reach(&members[i]) >= end {
            end = offset + reach(&members[i]);
            after = Some(i);
        }
    }
    if whole > end {
        let (kind, size) = (PaddingKind::Tail, whole - end);
        gaps.push(UnusedBytes { kind, offset: end, size, after, before: None });
    }
    gaps
}

/// A member of a block or structure, or the unused bytes behind one.
pub(crate) enum MemberOrGap<'m> {
    Member(&'m MemberLayout),
    Gap(UnusedBytes),
}

/// Returns members in the order of the text, which explicit offsets may not follow, each with the gaps
/// behind it. Without the size of the whole there are none.
pub(crate) fn in_text_order(members: &[MemberLayout], whole: Option<u64>) -> Vec<MemberOrGap<'_>> {
    let mut gaps = whole.map(|whole| gaps(members, whole)).unwrap_or_default();
    gaps.sort_by_key(|gap| gap.after);
    let mut gaps = gaps.into_iter().peekable();
    let mut all = Vec::with_capacity(members.len());
    for at in 0..=members.len() {
        let is_before = |gap: &UnusedBytes| gap.after.map_or(0, |after| after + 1) == at;
        while let Some(gap) = gaps.next_if(is_before) {
            all.push(MemberOrGap::Gap(gap));
        }
        all.extend(members.get(at).map(MemberOrGap::Member));
    }
    all
}

/// Tail padding of a member other than in its structure: of the member, its elements or columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tail {
    pub owner: PaddingOwner,
    /// Offset of the first occurrence from the start of the member.
    pub offset: u64,
    pub size: u64,
    /// Number of occurrences in one whole member.
    pub times: u64,
}

/// Returns the [`Tail`]s of a member, the outer ones first.
pub(crate) fn tails(member: &MemberLayout, rules: Rules) -> Vec<Tail> {
    let mut tails = Vec::new();
    let mut push = |owner, offset, end: u64, times| {
        if end > offset && times > 0 {
            tails.push(Tail { owner, offset, size: end - offset, times });
        }
    };
    push(PaddingOwner::Member, own_size(member, rules), reach(member), 1);
    let count = elements(&member.dims);
    // Where only the module gives strides, nothing is padded after the last element or vector.
    let is_explicit = matches!(rules, Rules::Explicit(_));
    if is_explicit {
        // Each dimension has a stride of its own. `outer` counts the arrays of this dimension, each
        // of which is padded after all its elements but the last.
        let mut outer = 1;
        for (dim, (len, &stride)) in member.dims.iter().zip(&member.strides).enumerate() {
            let padded = fixed(len).map_or(1, |len| len.saturating_sub(1));
            push(
                PaddingOwner::Element,
                size_in_dimension(member, dim, rules),
                stride,
                outer * padded,
            );
            outer *= fixed(len).unwrap_or(1);
        }
    // By rules of a text only the innermost elements are padded: the strides of outer dimensions
    // are whole numbers of those within.
    } else if let Some(&stride) = member.strides.last() {
        // In scalar the padding after the last element is not part of the array.
        let unpadded = u64::from(rules == Rules::Scalar && member.size.is_some());
        let times = count.saturating_sub(unpadded);
        push(PaddingOwner::Element, element_size(member, rules), stride, times);
    }
    if let (Some(stride), Some(vector)) = (member.matrix_stride, matrix_vector(member)) {
        let owner = if member.row_major { PaddingOwner::Row } else { PaddingOwner::Column };
        let padded = vector.count - u64::from(is_explicit);
        push(owner, vector.bytes, stride, count * padded);
    }
    tails
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::*;
    use crate::shape::{Member, Written};
    use crate::source::Span;

    fn rows(block: &BlockLayout) -> Vec<String> {
        let text = |p: &Padding| {
            format!(
                "{} of {} `{}` {}+{} ×{}",
                p.kind.name(),
                p.owner.noun(),
                p.path,
                p.offset,
                p.size,
                p.times
            )
        };
        padding(block).iter().map(text).collect()
    }

    #[test]
    fn point_lights_have_a_hole_and_two_tails() {
        let block = point_lights();
        assert_eq!(
            rows(&block),
            [
                "tail padding of block `` 6148+12 ×1",
                "hole of structure `data[]` 12+4 ×128",
                "tail padding of structure `data[]` 44+4 ×128",
            ]
        );
        let found = padding(&block);
        assert_eq!(found[1].after.as_deref(), Some("pos"));
        assert_eq!(found[1].before.as_deref(), Some("color"));
        assert_eq!(found[2].structure.as_deref(), Some("PointLight"));
        let summary = summary(&block).unwrap();
        assert_eq!((summary.size, summary.used, summary.padding), (6160, 5124, 1036));
        assert!((summary.percent() - 16.818).abs() < 0.001);
    }

    #[test]
    fn columns_rows_and_elements_have_tails_in_std140() {
        assert_eq!(
            rows(&padded(Rules::Std140)),
            [
                "hole of block `` 4+12 ×1",
                // `v` ends at 28, the array of floats starts at the next 16.
                "hole of block `` 28+4 ×1",
                "tail padding of block `` 820+12 ×1",
                "tail padding of element `w[]` 4+12 ×7",
                "tail padding of structure `o[][]` 84+12 ×6",
                "hole of structure `o[][].i[]` 4+4 ×12",
                "tail padding of column `o[][].m` 12+4 ×18",
                "tail padding of row `r[]` 8+8 ×6",
            ]
        );
    }

    #[test]
    fn padding_and_components_make_up_the_block() {
        for rules in [Rules::Std140, Rules::Std430, Rules::Scalar, Rules::Wgsl] {
            for block in [padded(rules), doubles(rules), point_lights(), particles()] {
                let total: u64 = padding(&block).iter().map(|p| p.size * p.times).sum();
                assert_eq!(total + block.used(), block.size.unwrap(), "{rules:?} {}", block.name);
            }
        }
    }

    #[test]
    fn size_attributes_make_tail_padding_of_the_member() {
        let size = Some(Written { value: 32, span: Span::default() });
        let b =
            block(Rules::Wgsl, vec![Member { size, ..member("a", float()) }, member("b", float())]);
        assert_eq!(rows(&b), ["tail padding of member `a` 4+28 ×1"]);
    }

    #[test]
    fn an_explicit_offset_makes_a_hole_before_the_first_member() {
        let offset = Some(Written { value: 16, span: Span::default() });
        let b = block(Rules::Std430, vec![Member { offset, ..member("a", vec(4)) }]);
        let found = padding(&b);
        assert_eq!(rows(&b), ["hole of block `` 0+16 ×1"]);
        assert_eq!(found[0].after, None);
    }

    #[test]
    fn loose_uniforms_have_no_padding() {
        assert!(padding(&loose()).is_empty());
        assert!(summary(&loose()).is_none());
    }
}
