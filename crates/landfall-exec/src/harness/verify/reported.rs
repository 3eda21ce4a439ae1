//! Compares the OpenGL driver's reflection of a block with the layout: offset, strides and size of
//! each active member.
//!
//! Reads a [`Reflection`] of the unchanged text.

use rustc_hash::FxHashMap;

use super::report::ElementReport;
use crate::backend::reflection::{ReflectedBlock, ReflectedMember, Reflection};
use crate::harness::probe::plan::byte_of;
use landfall_layout::layout::{BlockLayout, Leaf};
use landfall_layout::shape::{AddressSpace, Type};

/// Returns every active leaf that the driver lists, with the offset of its listed element.
pub(super) fn elements(
    block: &BlockLayout,
    expected: &BlockLayout,
    reflection: &Reflection,
) -> Vec<ElementReport> {
    let Some(listed) = reflected_block(block, reflection) else { return Vec::new() };
    let leaves = by_path(expected);
    listed.members.iter().flat_map(|member| of_member(member, &leaves)).collect()
}

/// Returns the reflected block of that name.
fn reflected_block<'r>(
    block: &BlockLayout,
    reflection: &'r Reflection,
) -> Option<&'r ReflectedBlock> {
    let listed = match block.space {
        AddressSpace::Storage => &reflection.storage_blocks,
        _ => &reflection.uniform_blocks,
    };
    let named = |name: &str| name.split('[').next() == Some(&*block.name);
    listed.iter().find(|other| named(&other.name))
}

fn by_path(block: &BlockLayout) -> FxHashMap<&str, &Leaf> {
    block.leaves.iter().map(|leaf| (leaf.path.as_str(), leaf)).collect()
}

/// Returns the second column and the second row of every listed matrix.
pub(super) fn matrices(
    block: &BlockLayout,
    expected: &BlockLayout,
    reflection: &Reflection,
) -> Vec<ElementReport> {
    let Some(listed) = reflected_block(block, reflection) else { return Vec::new() };
    let leaves = by_path(expected);
    let steps = |member: &ReflectedMember| {
        let (name, indices) = pattern(&member.name);
        let leaf = leaves.get(name.as_str())?;
        let Type::Matrix { scalar, .. } = leaf.ty else { return None };
        let mut element: Vec<u32> = indices.iter().map(|index| *index as u32).collect();
        element.resize(leaf.strides.len(), 0);
        let (stride, width) = (member.matrix_stride, u64::from(scalar.width));
        // The stride is between the columns or, in row-major order, between the rows.
        let (column, row) = if member.row_major { (width, stride) } else { (stride, width) };
        let step = |name: &str, at: (u8, u8), away: u64| {
            Some(ElementReport {
                path: format!("{}{name}", member.name),
                leaf: leaf.path.clone(),
                way: "reported",
                expected_byte: byte_of(leaf, &element, Some(at.0), Some(at.1), scalar)?,
                byte_read: Some(member.offset + away),
            })
        };
        Some([step("[1].x", (1, 0), column)?, step("[0].y", (0, 1), row)?])
    };
    listed.members.iter().filter_map(steps).flatten().collect()
}

/// Returns the offset of a listed element, and of the next one by the listed stride.
fn of_member(member: &ReflectedMember, leaves: &FxHashMap<&str, &Leaf>) -> Vec<ElementReport> {
    let (pattern, indices) = pattern(&member.name);
    let find = |pattern: &str| leaves.get(pattern).copied();
    // An array of scalars is listed by its first element, with or without `[0]`.
    let found = find(&pattern).or_else(|| find(&format!("{pattern}[]")));
    let Some(leaf) = found.filter(|leaf| leaf.offset.is_some()) else { return Vec::new() };
    let mut elements = vec![report(leaf, &member.name, &indices, member.offset)];
    if member.array_stride > 0 && !leaf.strides.is_empty() {
        let mut next = indices.clone();
        next.resize(leaf.strides.len(), 0);
        if let Some(last) = next.last_mut() {
            *last += 1;
        }
        let name = format!("{}[1]", member.name.strip_suffix("[0]").unwrap_or(&member.name));
        elements.push(report(leaf, &name, &next, member.offset + member.array_stride));
    }
    elements
}

fn report(leaf: &Leaf, name: &str, indices: &[u64], byte: u64) -> ElementReport {
    let away: u64 = indices.iter().zip(&leaf.strides).map(|(index, stride)| index * stride).sum();
    ElementReport {
        path: name.to_string(),
        leaf: leaf.path.clone(),
        way: "reported",
        expected_byte: leaf.offset.unwrap_or(0) + away,
        byte_read: Some(byte),
    }
}

/// Splits `lights[2].pos` into `lights[].pos` and its indices.
fn pattern(name: &str) -> (String, Vec<u64>) {
    let (mut pattern, mut indices) = (String::with_capacity(name.len()), Vec::new());
    let mut rest = name;
    while let Some((before, after)) = rest.split_once('[') {
        pattern.push_str(before);
        pattern.push_str("[]");
        let (index, after) = after.split_once(']').unwrap_or((after, ""));
        indices.push(index.parse().unwrap_or(0));
        rest = after;
    }
    pattern.push_str(rest);
    (pattern, indices)
}
