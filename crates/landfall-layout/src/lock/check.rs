//! Consistency checks of a lock's numbers.
//!
//! Called by [`super::read`], so that the blocks of a lock are as trustworthy as those of a
//! shader.

use super::place::JsonText;
use crate::error::Error;
use crate::layout::measure::{fixed, matrix_vector, reach, structure};
use crate::layout::{BlockLayout, MemberLayout, occupied};
use crate::shape::{AddressSpace, Rules, Type};
use crate::source::Language;

/// The block whose members are being read.
pub(super) struct MemberContext<'n> {
    pub language: Language,
    /// Whether these are loose uniforms, which have no offsets or sizes.
    pub loose: bool,
    /// The paths of its leaves, if the JSON lists them.
    pub leaves: Option<&'n [&'n str]>,
}

/// Checks that no two blocks share name, instance, address space, set and binding.
pub(super) fn blocks(place: &JsonText<'_>, blocks: &[BlockLayout]) -> Result<(), Error> {
    // Two blocks may share a name: in GLSL those of several stages, in WGSL several variables of
    // one structure.
    let key = |b: &BlockLayout| (b.name.clone(), b.instance.clone(), b.space, b.group, b.binding);
    let mut seen = std::collections::HashSet::new();
    match blocks.iter().find(|block| !seen.insert(key(block))) {
        None => Ok(()),
        Some(block) => {
            let message = format!("the block `{}` is listed twice", block.name);
            Err(place.contradiction(block.span.start, &message))
        }
    }
}

/// Checks a block against its members.
pub(super) fn block(place: &JsonText<'_>, block: &BlockLayout) -> Result<(), Error> {
    let refuse = |message: String| Err(place.contradiction(block.span.start, &message));
    let name = &block.name;
    siblings(place, &block.members)?;
    if block.space == AddressSpace::Default {
        return match block.size.or(block.data_size).or(block.align) {
            None => Ok(()),
            Some(_) => refuse("loose uniforms have no bytes, so no size".to_string()),
        };
    }
    let (Some(size), Some(data_size), Some(align)) = (block.size, block.data_size, block.align)
    else {
        return refuse(format!("`{name}` lacks `size`, `data_size` or `align`"));
    };
    // `data_size` and the offsets state the same: code that uses either must agree.
    let end = end(&block.members);
    if end != data_size {
        return refuse(format!(
            "`{name}` has `data_size` {data_size}, but its members end at {end}"
        ));
    }
    if size < data_size {
        return refuse(format!("`{name}` is {size} bytes, but its members end at {data_size}"));
    }
    // Alignments come from rules, so that each is a power of two; other code divides by them.
    if !align.is_power_of_two() {
        return refuse(format!("`{name}` is aligned to {align}, which is not a power of two"));
    }
    Ok(())
}

/// Checks a member against its type and its own members.
pub(super) fn member(
    place: &JsonText<'_>,
    member: &MemberLayout,
    within: &MemberContext<'_>,
) -> Result<(), Error> {
    let refuse = |message: String| Err(place.contradiction(member.span.start, &message));
    let name = &member.name;
    siblings(place, &member.members)?;
    // Loose uniforms have a type and no numbers.
    if within.loose {
        let numbers = [member.offset, member.size, member.align, member.matrix_stride];
        if numbers.iter().any(Option::is_some) || !member.strides.is_empty() {
            return refuse(format!("`{name}` is a loose uniform, which has no offset or size"));
        }
        return Ok(());
    }
    // Then each number of its own, and last what the type needs against what is recorded.
    let (Some(offset), Some(align)) = (member.offset, member.align) else {
        return refuse(format!("`{name}` lacks `offset` or `align`"));
    };
    if !align.is_power_of_two() {
        return refuse(format!("`{name}` is aligned to {align}, which is not a power of two"));
    }
    if offset % align != 0 {
        return refuse(format!("`{name}` is at offset {offset}, but aligned to {align}"));
    }
    if member.strides.len() != member.dims.len() {
        let (strides, dims) = (member.strides.len(), member.dims.len());
        return refuse(format!("`{name}` has {dims} array dimensions and {strides} strides"));
    }
    let is_matrix = matches!(member.ty.innermost(), Type::Matrix { .. });
    if is_matrix != member.matrix_stride.is_some() {
        let message = match is_matrix {
            true => format!("`{name}` holds matrices, but lacks `matrix_stride`"),
            false => format!("`{name}` holds no matrices, but has `matrix_stride`"),
        };
        return refuse(message);
    }
    // From the innermost dimension outwards, `needed` is what one element of it takes at least. The
    // sum of strides and lengths up to 2^32 fits 128 bits, but not 64.
    let mut needed = element(member);
    for (len, stride) in member.dims.iter().zip(&member.strides).rev() {
        if u128::from(*stride) < needed {
            return refuse(format!(
                "`{name}` has an array stride of {stride}, but an element takes {needed} bytes"
            ));
        }
        // The last element need not be padded to the stride: in scalar layout it is not.
        let before_last = fixed(len).map_or(0, |n| n.saturating_sub(1));
        needed += u128::from(before_last) * u128::from(*stride);
    }
    match member.size {
        Some(size) if u128::from(size) >= needed => Ok(()),
        Some(size) => refuse(format!("`{name}` is {size} bytes, but its contents take {needed}")),
        // Only a runtime-sized member has no size.
        None if member.dims.iter().any(|len| fixed(len).is_none()) => Ok(()),
        None => refuse(format!("`{name}` lacks `size`")),
    }
}

/// The bytes of one element, up to the end of its last member.
fn element(member: &MemberLayout) -> u128 {
    if let Some(vector) = matrix_vector(member) {
        let stride = u128::from(member.matrix_stride.unwrap_or(0));
        return stride * u128::from(vector.count - 1) + u128::from(vector.bytes);
    }
    match member.ty.innermost() {
        Type::Struct(_) => end(&member.members).into(),
        plain => occupied(plain).into(),
    }
}

/// The end of the last member.
fn end(members: &[MemberLayout]) -> u64 {
    // Where a structure ends depends on no rules, only its padding does.
    structure(members, Rules::Scalar).data_size
}

/// Checks that members differ in name and do not overlap.
fn siblings(place: &JsonText<'_>, members: &[MemberLayout]) -> Result<(), Error> {
    let mut seen = std::collections::HashSet::new();
    if let Some(twice) = members.iter().find(|member| !seen.insert(&member.name)) {
        let message = format!("the member `{}` is listed twice", twice.name);
        return Err(place.contradiction(twice.span.start, &message));
    }
    let mut placed: Vec<&MemberLayout> =
        // Members without bytes overlap nothing. In the order of their starts, neighbours suffice.
        members.iter().filter(|m| m.offset.is_some() && reach(m) > 0).collect();
    placed.sort_by_key(|member| member.offset);
    for pair in placed.windows(2) {
        let (start, next) = (pair[0].offset.unwrap_or(0), pair[1].offset.unwrap_or(0));
        let end = start + reach(pair[0]);
        if next < end {
            let message = format!(
                "`{}` at offset {next} overlaps `{}`, which occupies {start} to {}",
                pair[1].name,
                pair[0].name,
                end - 1
            );
            return Err(place.contradiction(pair[1].span.start, &message));
        }
    }
    Ok(())
}
