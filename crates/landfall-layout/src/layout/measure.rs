//! Sizes derived from placed members: of one element, of one column, of the inner dimensions of an
//! array.
//!
//! Reads the [model](super), feeds [`padding`](super::padding), [`byte`](super::byte) and
//! [`explain`](super::explain).

use super::MemberLayout;
use crate::shape::{ArrayLen, Rules, Type};

/// The columns of a matrix (rows, if row-major), counting only bytes that hold components.
#[derive(Clone, Copy, Debug)]
pub struct MatrixVector {
    /// Size of one vector in bytes.
    pub bytes: u64,
    /// Number of vectors.
    pub count: u64,
}

/// Returns the columns (rows, if row-major) of a matrix member or array of matrices.
pub fn matrix_vector(member: &MemberLayout) -> Option<MatrixVector> {
    let Type::Matrix { scalar, columns, rows } = member.ty.innermost() else { return None };
    let (count, length) = if member.row_major { (*rows, *columns) } else { (*columns, *rows) };
    Some(MatrixVector { bytes: u64::from(scalar.width) * u64::from(length), count: count.into() })
}

/// Returns the number of elements of all dimensions together; a runtime-sized one counts as one.
pub fn elements(dims: &[ArrayLen]) -> u64 {
    dims.iter().map(|len| fixed(len).unwrap_or(1)).product()
}

/// Returns the number of elements of all dimensions together, if the text determines all lengths.
pub fn fixed_elements(dims: &[ArrayLen]) -> Option<u64> {
    dims.iter().try_fold(1u64, |product, len| Some(product.saturating_mul(fixed(len)?)))
}

/// Returns the length if the text determines it.
pub fn fixed(len: &ArrayLen) -> Option<u64> {
    match len {
        ArrayLen::Fixed(n) => Some(u64::from(*n)),
        ArrayLen::Runtime | ArrayLen::Override(_) => None,
    }
}

/// Returns the bytes from a member's start to its end; a runtime-sized one counts as one element.
pub fn reach(member: &MemberLayout) -> u64 {
    member.size.or_else(|| member.strides.first().copied()).unwrap_or(0)
}

/// Returns the size of a member's type in bytes, without `@size`.
pub(crate) fn own_size(member: &MemberLayout, rules: Rules) -> u64 {
    match (member.dims.first(), member.strides.first()) {
        (Some(len), Some(stride)) => {
            array_size(member, 0, rules).unwrap_or(stride * fixed(len).unwrap_or(1))
        }
        _ => element_size(member, rules),
    }
}

/// Returns the size of an array from dimension `dim` inwards; `None` if runtime-sized.
pub(crate) fn array_size(member: &MemberLayout, dim: usize, rules: Rules) -> Option<u64> {
    let (stride, len) = (member.strides.get(dim)?, fixed(member.dims.get(dim)?)?);
    let whole = stride * len;
    // What each innermost element is padded by, which the last one does not need.
    let last = member.strides.last()?.saturating_sub(element_size(member, rules));
    match rules {
        Rules::Std140 | Rules::Std430 | Rules::Wgsl => Some(whole),
        // GL_EXT_scalar_block_layout: the padding after the last element is not part of the array.
        Rules::Scalar => Some(whole.saturating_sub(last)),
        Rules::Explicit(_) => {
            Some(stride * len.saturating_sub(1) + size_in_dimension(member, dim, rules))
        }
    }
}

/// Returns the size of one element of dimension `dim`: an array of the inner dimensions, or one below
/// all of them. A runtime-sized array counts as one element.
pub(crate) fn size_in_dimension(member: &MemberLayout, dim: usize, rules: Rules) -> u64 {
    match member.strides.get(dim + 1) {
        Some(stride) => array_size(member, dim + 1, rules).unwrap_or(*stride),
        None => element_size(member, rules),
    }
}

/// Returns the size of one element below all array dimensions, a structure's tail padding included.
pub fn element_size(member: &MemberLayout, rules: Rules) -> u64 {
    let Type::Struct(_) = member.ty.innermost() else { return leaf_size(member, rules) };
    let StructureEnd { align, data_size } = structure(&member.members, rules);
    match rules {
        Rules::Std140 | Rules::Std430 | Rules::Wgsl => data_size.next_multiple_of(align),
        // GL_EXT_scalar_block_layout: a structure ends with its last member.
        Rules::Scalar | Rules::Explicit(_) => data_size,
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

/// Returns the alignment and the end of the last member of a structure.
pub fn structure(members: &[MemberLayout], rules: Rules) -> StructureEnd {
    // Rule 9: std140 rounds a structure's alignment up to that of a vec4.
    let least = match rules {
        Rules::Std140 => 16,
        Rules::Std430 | Rules::Scalar | Rules::Wgsl | Rules::Explicit(_) => 1,
    };
    let align = members.iter().filter_map(|m| m.align).fold(least, u64::max);
    let ends = members.iter().filter_map(|m| Some(m.offset? + reach(m)));
    StructureEnd { align, data_size: ends.max().unwrap_or(0) }
}

/// Returns the size in bytes of one element of a member that is not a structure.
pub(super) fn leaf_size(member: &MemberLayout, rules: Rules) -> u64 {
    let Some(MatrixVector { bytes, count }) = matrix_vector(member) else {
        return occupied(member.ty.innermost());
    };
    let stride = member.matrix_stride.expect("a placed matrix has a stride");
    match rules {
        Rules::Std140 | Rules::Std430 | Rules::Scalar | Rules::Wgsl => stride * count,
        // Another member may lie in the padding after the last vector.
        Rules::Explicit(_) => stride * (count - 1) + bytes,
    }
}

/// Returns the bytes of a scalar, vector or matrix that hold components, without matrix padding.
pub fn occupied(ty: &Type) -> u64 {
    match ty {
        Type::Scalar(s) | Type::Atomic(s) => s.width.into(),
        Type::Vector { scalar, rows } => u64::from(scalar.width) * u64::from(*rows),
        Type::Matrix { scalar, columns, rows } => {
            u64::from(scalar.width) * u64::from(*columns) * u64::from(*rows)
        }
        Type::Address(_) => 8,
        Type::Struct(_) | Type::Array { .. } => 0,
    }
}
