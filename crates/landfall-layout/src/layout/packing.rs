//! What the offsets and strides of a SPIR-V module keep to, where they follow no rules of a text.

use super::measure::{element_size, matrix_vector, reach};
use super::{MemberLayout, occupied, rules};
use crate::shape::{AddressSpace, ArrayLen, Packing, Rules, Type};

/// A register of Direct3D, and what a vector in relaxed block layout does not straddle.
pub(super) const REGISTER: u64 = 16;

/// Returns the packing that members of a block keep to.
pub(super) fn of(space: AddressSpace, members: &[MemberLayout]) -> Packing {
    let of_text = match space {
        AddressSpace::Uniform => Rules::Std140,
        _ => Rules::Std430,
    };
    if is_relaxed(members, of_text) {
        return Packing::Relaxed;
    }
    if is_d3d(members) {
        return Packing::D3d;
    }
    // With `uniformBufferStandardLayout` uniform buffers have the alignments of storage buffers.
    if is_relaxed(members, Rules::Std430) { Packing::Relaxed } else { Packing::Free }
}

/// Whether members keep to Vulkan's Offset and Stride Assignment with relaxed block layout, their
/// alignments being those of `base`.
fn is_relaxed(members: &[MemberLayout], base: Rules) -> bool {
    let mut order: Vec<&MemberLayout> = members.iter().collect();
    order.sort_by_key(|member| member.offset);
    // The first byte that the members before leave to the next one.
    let mut least = 0;
    order.into_iter().all(|member| {
        let offset = member.offset.unwrap_or(0);
        let whole = rules::type_layout(&member.ty, base, member.matrix_layout());
        let Ok(whole) = whole else { return false };
        let is_free = offset >= least;
        // Relaxed block layout lets a vector begin at any multiple of its component, unless it
        // straddles 16 bytes; scalars and all else keep to the alignment of their type.
        let is_aligned = match component_vector(member) {
            Some(width) => offset.is_multiple_of(width) && is_in_registers(member),
            None => {
                let mut numbers = member.strides.iter().chain(&member.matrix_stride);
                whole.align.divides(offset) && numbers.all(|stride| whole.align.divides(*stride))
            }
        };
        // Nothing lies in the padding after an array, a structure or a matrix.
        let end = offset + reach(member);
        least = if is_aggregate(member) { whole.align.round_up(end).unwrap_or(end) } else { end };
        is_free && is_aligned && is_relaxed(&member.members, base)
    })
}

/// Whether members fill registers as those of a constant buffer of Direct3D do.
// Each array, structure and matrix begins a register, and so does each element and column; scalars
// and vectors are packed, but none straddles two registers. The last element is not padded, so that
// a scalar may follow in its register.
fn is_d3d(members: &[MemberLayout]) -> bool {
    members.iter().all(|member| {
        let offset = member.offset.unwrap_or(0);
        if !is_aggregate(member) {
            let width = component_vector(member).unwrap_or_else(|| occupied(&member.ty));
            return offset.is_multiple_of(width) && is_in_registers(member);
        }
        let mut size = element_size(member, Rules::Explicit(Packing::D3d));
        let mut strides_fit = true;
        for (len, stride) in member.dims.iter().zip(&member.strides).rev() {
            strides_fit &= *stride == size.next_multiple_of(REGISTER);
            let ArrayLen::Fixed(count) = len else { break };
            size += stride * u64::from(count.saturating_sub(1));
        }
        let vector = matrix_vector(member).map(|vector| vector.bytes.next_multiple_of(REGISTER));
        offset.is_multiple_of(REGISTER)
            && strides_fit
            && vector == member.matrix_stride
            && is_d3d(&member.members)
    })
}

/// Whether a member is an array, a structure or a matrix.
fn is_aggregate(member: &MemberLayout) -> bool {
    matches!(member.ty, Type::Array { .. } | Type::Struct(_) | Type::Matrix { .. })
}

/// The bytes of a component, if a member is a vector.
fn component_vector(member: &MemberLayout) -> Option<u64> {
    let Type::Vector { scalar, .. } = &member.ty else { return None };
    Some(scalar.width.into())
}

/// Whether a scalar or vector does not straddle a register, or fills whole ones.
fn is_in_registers(member: &MemberLayout) -> bool {
    let (offset, size) = (member.offset.unwrap_or(0), occupied(&member.ty));
    // A `dvec3` or `dvec4` needs two registers, and begins one.
    match size > REGISTER {
        true => offset.is_multiple_of(REGISTER),
        false => offset / REGISTER == (offset + size - 1) / REGISTER,
    }
}
