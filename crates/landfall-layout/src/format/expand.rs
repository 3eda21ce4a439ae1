//! Every element of every array with its own path, for `--expand`.

use super::phrases;
use crate::diagnostic::Code;
use crate::diagnostic::Diagnostic;
use crate::layout::measure::elements;
use crate::layout::{BlockLayout, MemberLayout};
use crate::shape::Type;
use crate::{Error, ShaderLayout};

/// The most elements to which a block is expanded.
pub const MAX_OFFSETS: u64 = 1_000_000;

/// One scalar, vector or matrix with its own path.
pub(super) struct Element<'a> {
    /// `data[3].color`.
    pub path: &'a str,
    /// Bytes from the start of the block.
    pub offset: u64,
    /// The member that it is, or is an element of.
    pub member: &'a MemberLayout,
}

/// The number of elements of a block; a runtime-sized array counts as one element.
pub(super) fn count(block: &BlockLayout) -> u64 {
    block.leaves.iter().fold(0, |sum: u64, leaf| sum.saturating_add(elements(&leaf.dims)))
}

/// Whether a block has offsets, and at most [`MAX_OFFSETS`] of them.
pub(super) fn can_expand(block: &BlockLayout) -> bool {
    block.size.is_some() && count(block) <= MAX_OFFSETS
}

/// Errors for the blocks with too many elements.
pub(super) fn refused(shader: &ShaderLayout) -> Vec<Diagnostic> {
    let many = shader.blocks.iter().filter(|b| b.size.is_some() && count(b) > MAX_OFFSETS);
    many.map(|block| {
        let message = format!(
            "block `{}` has {}, `--expand` writes at most {}",
            block.name,
            phrases::numbered(count(block), "element"),
            phrases::number(MAX_OFFSETS)
        );
        Diagnostic::error(Code::TooManyElements, block.span, message)
            .with_note("the block is written as patterns: offset + index × stride")
    })
    .collect()
}

/// Calls a function for every element in source order, grouped by array element. Of a
/// runtime-sized array only the first element is visited.
pub(super) fn each<'a, E>(
    block: &'a BlockLayout,
    each: &mut dyn FnMut(Element<'_>) -> Result<(), E>,
) -> Result<(), E> {
    let mut path = String::new();
    block.members.iter().try_for_each(|member| in_member(member, 0, &mut path, each))
}

fn in_member<E>(
    member: &MemberLayout,
    base: u64,
    path: &mut String,
    each: &mut dyn FnMut(Element<'_>) -> Result<(), E>,
) -> Result<(), E> {
    // Loose uniforms have no offsets, and so no elements with one.
    let Some(offset) = member.offset else { return Ok(()) };
    let before = path.len();
    if before > 0 {
        path.push('.');
    }
    path.push_str(&member.name);
    in_elements(member, 0, base + offset, path, each)?;
    path.truncate(before);
    Ok(())
}

fn in_elements<E>(
    member: &MemberLayout,
    dim: usize,
    base: u64,
    path: &mut String,
    each: &mut dyn FnMut(Element<'_>) -> Result<(), E>,
) -> Result<(), E> {
    let before = path.len();
    if dim < member.dims.len() {
        for i in 0..elements(&member.dims[dim..=dim]) {
            path.push_str(&format!("[{i}]"));
            in_elements(member, dim + 1, base + i * member.strides[dim], path, each)?;
            path.truncate(before);
        }
        return Ok(());
    }
    match member.ty.innermost() {
        Type::Struct(_) => {
            member.members.iter().try_for_each(|inner| in_member(inner, base, path, each))
        }
        _ => each(Element { path, offset: base, member }),
    }
}

/// [`each`] for a function that cannot fail.
pub(super) fn for_each(block: &BlockLayout, mut f: impl FnMut(Element<'_>)) {
    let done: Result<(), Error> = each(block, &mut |element| {
        f(element);
        Ok(())
    });
    debug_assert!(done.is_ok());
}
