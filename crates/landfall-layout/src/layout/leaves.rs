//! The leaves of blocks: their scalar, vector and matrix members, nested ones included.
//!
//! Reads placed members; part of [`layout`](super).

use super::{Leaf, MemberLayout};
use crate::shape::{ArrayLen, Type};

/// Returns the leaves of the members of a block.
pub(crate) fn leaves_of(members: &[MemberLayout]) -> Vec<Leaf> {
    let mut leaves = Vec::with_capacity(members.len());
    for member in members {
        let start =
            LeafPattern { path: String::new(), offset: Some(0), dims: vec![], strides: vec![] };
        collect_leaves(member, start, &mut leaves);
    }
    leaves
}

/// The path, offset and dimensions accumulated on the way to a leaf.
#[derive(Clone)]
struct LeafPattern {
    path: String,
    offset: Option<u64>,
    dims: Vec<ArrayLen>,
    strides: Vec<u64>,
}

fn collect_leaves(member: &MemberLayout, mut at: LeafPattern, leaves: &mut Vec<Leaf>) {
    if !at.path.is_empty() {
        at.path.push('.');
    }
    at.path.push_str(&member.name);
    for _ in &member.dims {
        at.path.push_str("[]");
    }
    at.offset = at.offset.zip(member.offset).map(|(base, offset)| base + offset);
    at.dims.extend(member.dims.iter().cloned());
    at.strides.extend(&member.strides);
    if let Type::Struct(_) = member.ty.innermost() {
        for child in &member.members {
            collect_leaves(child, at.clone(), leaves);
        }
        return;
    }
    leaves.push(Leaf {
        size: at.offset.map(|_| leaf_size(member)),
        path: at.path,
        ty: member.ty.innermost().clone(),
        offset: at.offset,
        dims: at.dims,
        strides: at.strides,
        matrix_stride: member.matrix_stride,
        row_major: member.row_major,
        span: member.span,
        naga: None,
    });
}

/// Returns the size in bytes of one element of a member that is not a structure.
pub(super) fn leaf_size(member: &MemberLayout) -> u64 {
    match member.ty.innermost() {
        Type::Matrix { columns, rows, .. } => {
            let vectors = if member.row_major { *rows } else { *columns };
            member.matrix_stride.expect("a placed matrix has a stride") * u64::from(vectors)
        }
        plain => occupied(plain),
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
