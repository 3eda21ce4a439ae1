//! Layout of blocks whose offsets and strides a SPIR-V module gives, and the rules these follow.
//!
//! A block whose numbers are those of std140, std430 or scalar is laid out by that, so that it is the
//! block of the text that was compiled; [`Rules::Explicit`] is for the rest. Its structures and arrays
//! end with their last component: no padding after it is known.

use crate::diagnostic::{Code, Diagnostic};
use crate::shape::{
    AddressSpace, ArrayLen, Block, MatrixLayout, Member, MemberPlace, Packing, Rules, Struct, Type,
    Written,
};
use crate::text::counts::bytes;

use super::measure::{element_size, fixed, matrix_vector, reach};
use super::packing;
use super::{
    BlockLayout, LARGEST_BLOCK, Leaf, MemberLayout, by_rules, empty, is_matrix, leaves_of, overlap,
    too_large,
};

/// Lays out a block of a module.
///
/// # Errors
/// Members that overlap, a runtime-sized array before the end, a size past [`LARGEST_BLOCK`].
pub(super) fn lay_out(block: &Block) -> Result<BlockLayout, Vec<Diagnostic>> {
    let written = as_written(block)?;
    // Of several rules that give the same numbers the first counts: the one that GLSL for Vulkan
    // defaults to in the address space (GLSL 4.60 §4.4.5).
    let orders: [Rules; 3] = match block.space {
        AddressSpace::Uniform => [Rules::Std140, Rules::Std430, Rules::Scalar],
        _ => [Rules::Std430, Rules::Std140, Rules::Scalar],
    };
    let with_gaps = Block { members: with_offsets(&block.members), ..block.clone() };
    let by = |block: &Block, rules: &[Rules]| {
        let found =
            rules.iter().filter_map(|&rules| by_rules(&Block { rules, ..block.clone() }).ok());
        found.into_iter().find(|found| are_equal(&found.leaves, &written.leaves))
    };
    // A text may place members itself, by `offset = N`. Scalar then takes nearly all offsets.
    if let Some(found) = by(block, &orders).or_else(|| by(&with_gaps, &orders[..2])) {
        return Ok(found);
    }
    let packing = packing::of(block.space, &written.members);
    let scalar = if packing == Packing::Free { by(&with_gaps, &orders[2..]) } else { None };
    let size = match packing {
        // Constants of Direct3D are 16 bytes, and a buffer holds whole ones.
        Packing::D3d => written.size.map(|size| size.next_multiple_of(packing::REGISTER)),
        Packing::Relaxed | Packing::Free => written.size,
    };
    Ok(scalar.unwrap_or(BlockLayout { rules: Rules::Explicit(packing), size, ..written }))
}

// Sizes are not compared: a module records none, and names and types are the same block's.
fn are_equal(a: &[Leaf], b: &[Leaf]) -> bool {
    let numbers =
        |leaf: &Leaf| (leaf.offset, leaf.matrix_stride, leaf.row_major, leaf.strides.clone());
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| numbers(a) == numbers(b))
}

/// Returns members with their offsets as `offset = N` of GLSL.
fn with_offsets(members: &[Member]) -> Vec<Member> {
    let one = |member: &Member| {
        let offset = member.place.as_ref().map(|place| place.offset);
        let offset = offset.map(|value| Written { value, span: member.span });
        Member { offset, ty: type_with_offsets(&member.ty), ..member.clone() }
    };
    members.iter().map(one).collect()
}

fn type_with_offsets(ty: &Type) -> Type {
    match ty {
        Type::Array { element, len } => {
            Type::Array { element: type_with_offsets(element).into(), len: len.clone() }
        }
        Type::Struct(s) => {
            let members = with_offsets(&s.members);
            Type::Struct(Struct::new(s.name.clone(), members, s.opaque.clone(), s.span).into())
        }
        leaf => leaf.clone(),
    }
}

/// Lays out a block by the numbers of the module alone.
fn as_written(block: &Block) -> Result<BlockLayout, Vec<Diagnostic>> {
    let members = placed(block, &block.members, true).map_err(|error| vec![error])?;
    let end = members.iter().filter_map(|m| Some(m.offset? + reach(m))).max().unwrap_or(0);
    let mut result = empty(block);
    result.align = Some(members.iter().filter_map(|member| member.align).max().unwrap_or(1));
    result.data_size = Some(end);
    result.size = Some(end);
    result.leaves = leaves_of(&members, block.rules);
    result.members = members;
    Ok(result)
}

/// Places members of a structure or, if `is_block`, of the block itself.
fn placed(
    block: &Block,
    members: &[Member],
    is_block: bool,
) -> Result<Vec<MemberLayout>, Diagnostic> {
    let last = members.len().saturating_sub(1);
    let one = |(index, member): (usize, &Member)| {
        let layout = placed_member(block, member)?;
        let mut lengths = layout.dims.iter().enumerate();
        // Vulkan: a runtime-sized array is the last member of a `Block`, and in no structure below
        // it.
        let is_wrong = lengths.any(|(dim, len)| {
            let is_tail = is_block && index == last && dim == 0;
            fixed(len).is_none() && !is_tail
        });
        if is_wrong {
            let message = format!(
                "`{}` is a runtime-sized array, but not the last member of block `{}`",
                member.name, block.name
            );
            return Err(Diagnostic::error(Code::RuntimeSizedArray, member.span, message));
        }
        Ok(layout)
    };
    let layouts = members.iter().enumerate().map(one).collect::<Result<Vec<_>, Diagnostic>>()?;
    check_overlaps(block, members, &layouts)?;
    Ok(layouts)
}

fn check_overlaps(
    block: &Block,
    members: &[Member],
    layouts: &[MemberLayout],
) -> Result<(), Diagnostic> {
    let interval = |index: usize| {
        let layout = &layouts[index];
        let start = layout.offset.unwrap_or(0);
        (start, layout.size.map_or(u64::MAX, |size| start + size), &members[index])
    };
    let mut order: Vec<usize> = (0..members.len()).collect();
    // If any two ranges overlap, two neighbours in the order of their starts do.
    order.sort_by_key(|index| layouts[*index].offset);
    for pair in order.windows(2) {
        let (before, after) = (interval(pair[0]), interval(pair[1]));
        if after.0 < before.1 {
            let error = overlap(after.2, after.0, &before);
            return Err(
                error.with_note(format!("in block `{}`, by its Offset decorations", block.name))
            );
        }
    }
    Ok(())
}

/// Places a member by the numbers of the module.
fn placed_member(block: &Block, member: &Member) -> Result<MemberLayout, Diagnostic> {
    let none = MemberPlace { offset: 0, strides: Vec::new(), matrix_stride: None };
    let MemberPlace { offset, strides, matrix_stride } = member.place.clone().unwrap_or(none);
    let ty = member.ty.innermost();
    let members = match ty {
        Type::Struct(s) => placed(block, &s.members, false)?,
        _ => Vec::new(),
    };
    let matrix_layout = member.matrix_layout.unwrap_or(block.matrix_layout);
    let mut layout = MemberLayout {
        name: member.name.clone(),
        ty: member.ty.clone(),
        offset: Some(offset),
        size: None,
        align: None,
        dims: member.ty.dims(),
        strides,
        matrix_stride,
        row_major: is_matrix(ty) && matrix_layout == MatrixLayout::Row,
        members,
        span: member.span,
        comment: Vec::new(),
    };
    layout.align = Some(alignment(&layout));
    layout.size = size(block, member, &layout)?;
    let end = offset.checked_add(reach(&layout)).filter(|end| *end <= LARGEST_BLOCK);
    match end {
        Some(_) => Ok(layout),
        None => Err(too_large(block, member)),
    }
}

/// Returns the size of a member; `None` if it is runtime-sized.
fn size(block: &Block, member: &Member, layout: &MemberLayout) -> Result<Option<u64>, Diagnostic> {
    let too_close = |kind: &str, stride: u64, what: &str, size: u64| {
        let message = format!(
            "`{}` of block `{}` has {kind} {stride}, but {what} takes {}",
            member.name,
            block.name,
            bytes(size)
        );
        Err(Diagnostic::error(Code::InvalidSpirv, member.span, message))
    };
    // Vectors of a matrix, or elements of an array, that overlap would share components.
    if let (Some(vector), Some(stride)) = (matrix_vector(layout), layout.matrix_stride) {
        if stride < vector.bytes {
            let what = if layout.row_major { "a row" } else { "a column" };
            return too_close("MatrixStride", stride, what, vector.bytes);
        }
    }
    let mut size = element_size(layout, block.rules);
    // From the innermost dimension outwards; `size` is that of one element of the dimension at
    // hand. The stride after the last element is not counted: another member may begin there.
    for (len, &stride) in layout.dims.iter().zip(&layout.strides).rev() {
        if stride < size {
            return too_close("ArrayStride", stride, "an element", size);
        }
        let ArrayLen::Fixed(count) = len else { return Ok(None) };
        let before_last = stride.checked_mul(u64::from(count.saturating_sub(1)));
        let whole = before_last.and_then(|before| before.checked_add(size));
        size =
            whole.filter(|size| *size <= LARGEST_BLOCK).ok_or_else(|| too_large(block, member))?;
    }
    Ok(Some(size))
}

/// Returns the alignment of a member's components, or less where its numbers are no multiples of it.
fn alignment(member: &MemberLayout) -> u64 {
    let natural = match member.ty.innermost() {
        Type::Scalar(scalar)
        | Type::Atomic(scalar)
        | Type::Vector { scalar, .. }
        | Type::Matrix { scalar, .. } => u64::from(scalar.width),
        Type::Address(_) => 8,
        Type::Struct(_) => member.members.iter().filter_map(|m| m.align).max().unwrap_or(1),
        Type::Array { .. } => 1,
    };
    let numbers = member.offset.iter().chain(&member.strides).chain(&member.matrix_stride);
    // A power of two divides a number if it has as many trailing zeros. 0 has 64: any divides it.
    let of_numbers = numbers.map(|number| number.trailing_zeros()).min().unwrap_or(0);
    natural.min(1u64.checked_shl(of_numbers).unwrap_or(u64::MAX))
}
