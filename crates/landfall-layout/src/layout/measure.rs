//! Sizes the model does not spell out: of one element, one column, an array from some dimension
//! inwards, all computed from what was laid out.
//!
//! Reads the [model](super), feeds [`padding`](super::padding), [`byte`](super::byte) and
//! [`explain`](super::explain).

use super::MemberLayout;
use super::leaves::leaf_size;
use crate::shape::{ArrayLen, Rules, Type};

/// A column of a matrix, or a row of a row-major one: the bytes that hold components.
#[derive(Clone, Copy, Debug)]
pub struct MatrixVector {
    /// Size of one vector in bytes.
    pub bytes: u64,
    /// Number of vectors.
    pub count: u64,
}

/// The columns (rows) of a member that is a matrix or an array of them.
pub fn matrix_vector(member: &MemberLayout) -> Option<MatrixVector> {
    match member.ty.innermost() {
        Type::Matrix { scalar, columns, rows } => {
            let (count, length) =
                if member.row_major { (*rows, *columns) } else { (*columns, *rows) };
            Some(MatrixVector {
                bytes: u64::from(scalar.width) * u64::from(length),
                count: count.into(),
            })
        }
        Type::Scalar(_)
        | Type::Atomic(_)
        | Type::Vector { .. }
        | Type::Address(_)
        | Type::Struct(_)
        | Type::Array { .. } => None,
    }
}

/// Number of elements of all dimensions together, runtime-sized ones counted with one.
pub fn elements(dims: &[ArrayLen]) -> u64 {
    dims.iter().map(|len| fixed(len).unwrap_or(1)).product()
}

/// The length, if the text says it.
pub fn fixed(len: &ArrayLen) -> Option<u64> {
    match len {
        ArrayLen::Fixed(n) => Some(u64::from(*n)),
        ArrayLen::Runtime | ArrayLen::Override(_) => None,
    }
}

/// Bytes from a member's start to its end, a runtime-sized one counted with one element.
pub fn reach(member: &MemberLayout) -> u64 {
    member.size.or_else(|| member.strides.first().copied()).unwrap_or(0)
}

/// Bytes a member's type takes up by itself, before `@size`.
pub(crate) fn own_size(member: &MemberLayout, rules: Rules) -> u64 {
    match (member.dims.first(), member.strides.first()) {
        (Some(len), Some(stride)) => {
            array_size(member, 0, rules).unwrap_or(stride * fixed(len).unwrap_or(1))
        }
        _ => element_size(member, rules),
    }
}

/// Bytes of an array from that dimension inwards; `None` when runtime-sized.
pub(crate) fn array_size(member: &MemberLayout, dim: usize, rules: Rules) -> Option<u64> {
    let whole = member.strides.get(dim)? * fixed(member.dims.get(dim)?)?;
    let last = member.strides.last()?.saturating_sub(element_size(member, rules));
    match rules {
        Rules::Std140 | Rules::Std430 | Rules::Wgsl => Some(whole),
        // GL_EXT_scalar_block_layout: the padding after the last element is not the array's.
        Rules::Scalar => Some(whole.saturating_sub(last)),
    }
}

/// Bytes of one element below all array dimensions, a structure's tail padding included.
pub fn element_size(member: &MemberLayout, rules: Rules) -> u64 {
    match member.ty.innermost() {
        Type::Struct(_) => {
            let structure = structure(&member.members, rules);
            match rules {
                Rules::Std140 | Rules::Std430 | Rules::Wgsl => {
                    structure.data_size.next_multiple_of(structure.align)
                }
                // GL_EXT_scalar_block_layout: a structure ends with its last member.
                Rules::Scalar => structure.data_size,
            }
        }
        Type::Scalar(_)
        | Type::Atomic(_)
        | Type::Vector { .. }
        | Type::Matrix { .. }
        | Type::Address(_)
        | Type::Array { .. } => leaf_size(member),
    }
}

/// The alignment of a structure and where its last member ends.
#[derive(Clone, Copy, Debug)]
pub struct StructureEnd {
    /// Alignment in bytes.
    pub align: u64,
    /// End of the last member, in bytes.
    pub data_size: u64,
}

/// What the members of a structure make of it.
pub fn structure(members: &[MemberLayout], rules: Rules) -> StructureEnd {
    // Rule 9: std140 rounds a structure's alignment up to that of a vec4.
    let least = match rules {
        Rules::Std140 => 16,
        Rules::Std430 | Rules::Scalar | Rules::Wgsl => 1,
    };
    let align = members.iter().filter_map(|m| m.align).fold(least, u64::max);
    let ends = members.iter().filter_map(|m| Some(m.offset? + reach(m)));
    StructureEnd { align, data_size: ends.max().unwrap_or(0) }
}
