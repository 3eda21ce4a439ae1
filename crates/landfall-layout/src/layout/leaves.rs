//! The leaves of blocks: their scalar, vector and matrix members, nested ones included.
//!
//! Reads placed members; part of [`layout`](super).

use super::measure::leaf_size;
use super::{Leaf, MemberLayout};
use crate::shape::{ArrayLen, Rules, Type};

/// Returns the leaves of the members of a block.
pub(crate) fn leaves_of(members: &[MemberLayout], rules: Rules) -> Vec<Leaf> {
    let mut leaves = Vec::with_capacity(members.len());
    for member in members {
        // A pattern for all elements of an array: a block of 1000 lights has the leaves of one
        // light.
        let start =
            LeafPattern { path: String::new(), offset: Some(0), dims: vec![], strides: vec![] };
        collect_leaves(member, rules, start, &mut leaves);
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

fn collect_leaves(
    member: &MemberLayout,
    rules: Rules,
    mut at: LeafPattern,
    leaves: &mut Vec<Leaf>,
) {
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
            collect_leaves(child, rules, at.clone(), leaves);
        }
        return;
    }
    leaves.push(Leaf {
        size: at.offset.map(|_| leaf_size(member, rules)),
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
