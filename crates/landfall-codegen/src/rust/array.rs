//! The Rust type of a member: an array of padded elements, or the element's type.
//!
//! [`super::plan`] calls this for every member; this calls it back for structures.

use landfall_layout::layout::{MemberLayout, measure};
use landfall_layout::shape::{ArrayLen, Rules, Type};

use super::leaf;
use super::plan::{MemberRoom, Plan};
use super::types::{GeneratedType, Padded, RustType, Sized, Tight, UserType};

/// The type of a member at `place`, without its dimensions before `dim`.
pub(super) fn member_type(
    plan: &mut Plan,
    member: &MemberLayout,
    dim: usize,
    place: &MemberRoom<'_>,
) -> Sized {
    let Some(len) = member.dims.get(dim) else {
        return element_type(plan, member, place);
    };
    let ArrayLen::Fixed(len) = *len else {
        unreachable!("runtime-sized members are tails, override-sized ones are refused")
    };
    let (len, stride) = (u64::from(len), member.strides[dim]);
    // Elements are `stride` apart: each is aligned to what divides the stride and the first one's
    // place.
    let align = place.align.min(divisor(stride));
    if stride * len <= place.room {
        let element =
            member_type(plan, member, dim + 1, &MemberRoom { room: stride, align, ..*place });
        let element = padded(plan, element, stride);
        return Sized { ty: RustType::Array(Box::new(element.ty), len), size: stride * len };
    }
    // Scalar rules let the next member begin in the padding of the last element: the array is all
    // elements but the last, padded, and one that is not.
    let before = stride * (len - 1);
    let room = place.room - before;
    let align = align.min(divisor(tight_size(member, dim + 1)));
    let element = member_type(plan, member, dim + 1, &MemberRoom { room, align, ..*place });
    let size = before + element.size;
    let ty = if len == 1 {
        RustType::Array(Box::new(element.ty), 1)
    } else {
        let head = padded(plan, element.clone(), stride).ty;
        plan.intern(GeneratedType::Tight(Tight { element: element.ty, head, len, size }))
    };
    Sized { ty, size }
}

fn element_type(plan: &mut Plan, member: &MemberLayout, place: &MemberRoom<'_>) -> Sized {
    // The program's own type takes the place of the element, whatever it is.
    if let Some(path) = plan.user_types.of(place.owner, member) {
        let size = measure::element_size(member, place.rules);
        let user = UserType { path, size, align: place.align };
        return Sized { ty: RustType::User(user), size };
    }
    match member.ty.innermost() {
        Type::Struct(s) => plan.structure(s, member, place),
        ty => leaf::leaf(plan, ty, member.matrix_stride, member.row_major, place.align),
    }
}

/// Pads an element to `stride` bytes.
pub(super) fn padded(plan: &mut Plan, element: Sized, stride: u64) -> Sized {
    if element.size == stride {
        return element;
    }
    let padded = Padded { inner: element.ty, size: element.size, stride };
    Sized { ty: plan.intern(GeneratedType::Padded(padded)), size: stride }
}

/// The bytes of a member, from dimension `dim` on, without padding after its last element.
pub(super) fn tight_size(member: &MemberLayout, dim: usize) -> u64 {
    let mut size = match member.ty.innermost() {
        // Where a structure ends depends on no rules, only its padding does.
        Type::Struct(_) => measure::structure(&member.members, Rules::Scalar).data_size,
        Type::Matrix { columns, rows, .. } => {
            let vectors = if member.row_major { *rows } else { *columns };
            member.matrix_stride.unwrap_or(0) * u64::from(vectors)
        }
        ty => landfall_layout::layout::occupied(ty),
    };
    // Of each dimension, from the innermost, all elements but the last take a stride.
    for (len, stride) in member.dims[dim..].iter().zip(&member.strides[dim..]).rev() {
        if let ArrayLen::Fixed(len) = len {
            size += stride * u64::from(len - 1);
        }
    }
    size
}

/// The largest power of two, at most 16, that divides `bytes`: no mirror type is aligned to more
/// than 16.
pub(super) fn divisor(bytes: u64) -> u64 {
    1 << bytes.trailing_zeros().min(4)
}
