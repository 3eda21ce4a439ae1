//! Checks whether a claim is wrong in every reading, and finds the right number.
//!
//! Uses [`claims`](super::claims) and [`owners`](super::owners).

use super::claims::LayoutClaim;
use super::owners::{Owner, PlacedComment, end_of};
use super::tokens::{CommentNumber, Kind};
use landfall_layout::layout::MemberLayout;
pub use landfall_layout::layout::measure::element_size;
use landfall_layout::shape::{ArrayLen, Type};

/// The most members whose sizes a comment may sum up.
const LONGEST_GROUP: usize = 16;

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct CorrectNumber {
    pub value: u64,
    /// The end of a range.
    pub to: Option<u64>,
}

/// Returns the right number for a claim about a member; `None` if the claim is right in some
/// reading, or if the number depends on where the structure is used.
pub(super) fn member(
    owner: &Owner<'_>,
    index: usize,
    claim: &LayoutClaim,
    from: Base,
) -> Option<CorrectNumber> {
    if owner.places.iter().any(|placed| fits(placed, index, claim)) {
        return None;
    }
    only(owner.places.iter().map(|placed| right(placed, index, claim, from)))
}

/// Returns the right number for a claim about a whole structure or block.
pub(super) fn whole(owner: &Owner<'_>, claim: &LayoutClaim) -> Option<CorrectNumber> {
    let readings = |placed: &PlacedComment<'_>| {
        let mut readings = vec![placed.size, placed.data_size, end_of_last(placed)];
        readings.extend(placed.stride);
        // A runtime-sized tail may be counted with no element at all.
        let tail = placed.members.last().filter(|member| member.size.is_none());
        readings.extend(tail.and_then(|member| member.offset));
        readings
    };
    let said = claim.number.value;
    let is_stride = matches!(claim.kind, Kind::ArrayStride | Kind::Stride);
    match claim.kind {
        Kind::Size | Kind::Total | Kind::ArrayStride | Kind::Stride => {}
        Kind::Align | Kind::Offset | Kind::MatrixStride => return None,
    }
    // `stride 44` is wrong where elements of 44 bytes are 48 apart; `44 bytes each` is not.
    let fits = |placed: &PlacedComment<'_>| match is_stride && claim.keyword {
        true => said == placed.size || placed.stride == Some(said),
        false => readings(placed).contains(&said),
    };
    if owner.places.iter().any(fits) {
        return None;
    }
    let value =
        |placed: &PlacedComment<'_>| placed.stride.filter(|_| is_stride).unwrap_or(placed.size);
    only(owner.places.iter().map(|placed| Some(CorrectNumber { value: value(placed), to: None })))
}

fn end_of_last(placed: &PlacedComment<'_>) -> u64 {
    placed.members.iter().map(end_of).max().unwrap_or(0)
}

/// Returns the value on which all agree.
fn only(mut values: impl Iterator<Item = Option<CorrectNumber>>) -> Option<CorrectNumber> {
    let first = values.next()??;
    values.all(|value| value.as_ref() == Some(&first)).then_some(first)
}

/// The origin of the offsets in a structure's comments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Base {
    Structure,
    Block,
}

/// Returns the origin that makes most of a structure's comments right.
pub(super) fn counted_from(owner: &Owner<'_>, said: &[(usize, u64)]) -> Base {
    let right = |base: fn(&PlacedComment<'_>) -> u64| {
        let fits = |&&(index, value): &&(usize, u64)| {
            owner.places.iter().any(|placed| {
                placed.members[index].offset.map(|offset| offset + base(placed)) == Some(value)
            })
        };
        said.iter().filter(fits).count()
    };
    match right(|placed| placed.base) > right(|_| 0) {
        true => Base::Block,
        false => Base::Structure,
    }
}

fn right(
    placed: &PlacedComment<'_>,
    index: usize,
    claim: &LayoutClaim,
    from: Base,
) -> Option<CorrectNumber> {
    let member = &placed.members[index];
    let value = match claim.kind {
        Kind::Offset => match from {
            Base::Structure => member.offset?,
            Base::Block => placed.base + member.offset?,
        },
        Kind::Align => member.align?,
        Kind::Size => member.size?,
        Kind::ArrayStride => *member.strides.last()?,
        Kind::MatrixStride => member.matrix_stride?,
        Kind::Stride => member.strides.last().copied().or(member.matrix_stride)?,
        Kind::Total => return None,
    };
    let to = match &claim.to {
        Some(to) => Some(value + range_length(member, &claim.number, to)?),
        None => None,
    };
    Some(CorrectNumber { value, to })
}

/// The length of a member's range, its end counted as in the claim.
fn range_length(member: &MemberLayout, from: &CommentNumber, to: &CommentNumber) -> Option<u64> {
    let size = member.size?;
    let said = to.value.checked_sub(from.value);
    // Sizes are even, so an odd end is a last byte.
    let inclusive = said == Some(size.saturating_sub(1)) || to.value % 2 == 1;
    Some(size - u64::from(inclusive))
}

fn fits(placed: &PlacedComment<'_>, index: usize, claim: &LayoutClaim) -> bool {
    let member = &placed.members[index];
    let said = claim.number.value;
    match claim.kind {
        Kind::Offset => match &claim.to {
            None => offsets(placed, member).contains(&said),
            Some(to) => ranges(placed, index).contains(&(said, to.value)),
        },
        Kind::Align => member.align == Some(said),
        Kind::Size => sizes(placed, index, claim.unit).contains(&said),
        Kind::ArrayStride => member.strides.contains(&said),
        Kind::MatrixStride => member.matrix_stride == Some(said),
        Kind::Stride => {
            let each = !claim.keyword && element_size(member, placed.rules) == said;
            each || member.strides.contains(&said) || member.matrix_stride == Some(said)
        }
        Kind::Total => true,
    }
}

/// Returns the offset in its structure, and in the block.
fn offsets(placed: &PlacedComment<'_>, member: &MemberLayout) -> Vec<u64> {
    let Some(offset) = member.offset else { return Vec::new() };
    vec![offset, placed.base + offset]
}

/// Returns the byte ranges of a member: up to the last byte or one past it, with padding or without.
pub(super) fn ranges(placed: &PlacedComment<'_>, index: usize) -> Vec<(u64, u64)> {
    let member = &placed.members[index];
    let mut found = Vec::new();
    for start in offsets(placed, member) {
        let base = start - member.offset.unwrap_or(0);
        for end in [base + end_of(member), base + placed.next(index)] {
            found.push((start, end));
            found.push((start, end.saturating_sub(1)));
        }
    }
    found
}

/// Returns the numbers that may be called a member's size: its own size, with its padding, that of
/// an element or a column, together with members before it, or everything up to its end.
fn sizes(placed: &PlacedComment<'_>, index: usize, unit: bool) -> Vec<u64> {
    let member = &placed.members[index];
    let mut found = vec![element_size(member, placed.rules)];
    found.extend(member.size);
    found.extend(&member.strides);
    found.extend(member.matrix_stride);
    let ends = [end_of(member), placed.next(index)];
    let group = &placed.members[index.saturating_sub(LONGEST_GROUP)..=index];
    let starts = group.iter().filter_map(|earlier| earlier.offset);
    // With any of the members before it, up to a limit, or with all.
    for start in starts.chain([0]) {
        found.extend(ends.iter().filter_map(|end| end.checked_sub(start)));
    }
    found.extend(ends.iter().map(|end| placed.base + end));
    if !unit {
        // `size 4` of `float x[4]`, of a `vec4`: elements, components.
        found.extend(member.dims.iter().filter_map(|len| match len {
            ArrayLen::Fixed(n) => Some(u64::from(*n)),
            ArrayLen::Runtime | ArrayLen::Override(_) => None,
        }));
        match member.ty.innermost() {
            Type::Vector { rows, .. } => found.push((*rows).into()),
            Type::Matrix { columns, rows, .. } => {
                found.extend([u64::from(*columns), u64::from(*rows)]);
                found.push(u64::from(*columns) * u64::from(*rows));
            }
            Type::Scalar(_)
            | Type::Atomic(_)
            | Type::Address(_)
            | Type::Struct(_)
            | Type::Array { .. } => {}
        }
    }
    found
}

/// Whether a size without a unit may be the member's value, not its bytes:
/// `int mapSize; // size: 1024`.
pub(super) fn may_be_content(member: &MemberLayout) -> bool {
    match &member.ty {
        Type::Scalar(_) | Type::Atomic(_) | Type::Address(_) => true,
        // A width and a height.
        Type::Vector { rows, .. } => *rows == 2,
        Type::Matrix { .. } | Type::Struct(_) | Type::Array { .. } => false,
    }
}

/// Whether a structure's offsets are in another unit than bytes: none is right in bytes, all are
/// right in words or in rows of 16 bytes.
pub(super) fn other_unit(owner: &Owner<'_>, said: &[(usize, u64)]) -> bool {
    let right = |unit: u64| {
        said.iter().all(|&(index, value)| {
            owner.places.iter().any(|placed| {
                let offsets = offsets(placed, &placed.members[index]);
                value.checked_mul(unit).is_some_and(|value| offsets.contains(&value))
            })
        })
    };
    let bytes = said.iter().filter(|(index, value)| {
        let placed =
            |placed: &PlacedComment<'_>| offsets(placed, &placed.members[*index]).contains(value);
        *value > 0 && owner.places.iter().any(placed)
    });
    bytes.count() == 0 && said.iter().any(|row| row.1 > 0) && (right(4) || right(16))
}

/// Returns the right number for a line below a member, where lines continue with its columns or
/// elements. `step` counts those lines from 1.
pub(super) fn column(
    owner: &Owner<'_>,
    index: usize,
    claim: &LayoutClaim,
    step: u64,
) -> Option<CorrectNumber> {
    let stride = |member: &MemberLayout| member.matrix_stride.or(member.strides.last().copied());
    let start = |placed: &PlacedComment<'_>| {
        let member = &placed.members[index];
        let stride = stride(member)?;
        Some((member.offset?, placed.base, stride))
    };
    match claim.kind {
        Kind::Offset if claim.to.is_none() => {
            let fits = |placed: &PlacedComment<'_>| match start(placed) {
                // Any column or element may be left out.
                Some((offset, base, stride)) => [offset, offset + base].iter().any(|offset| {
                    claim.number.value.checked_sub(*offset).is_some_and(|at| at % stride == 0)
                }),
                None => true,
            };
            if owner.places.iter().any(fits) {
                return None;
            }
            only(owner.places.iter().map(|placed| {
                let (offset, _, stride) = start(placed)?;
                Some(CorrectNumber { value: offset + step * stride, to: None })
            }))
        }
        Kind::Offset
        | Kind::Align
        | Kind::Size
        | Kind::ArrayStride
        | Kind::MatrixStride
        | Kind::Stride
        | Kind::Total => None,
    }
}
