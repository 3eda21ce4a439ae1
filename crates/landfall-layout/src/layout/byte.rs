//! The component or padding that a byte of a block belongs to.
//!
//! Reads the [model](super) and [`padding`](super::padding), feeds
//! [`format`](mod@crate::format).

use std::sync::Arc;

use super::measure::{element_size, fixed, matrix_vector, own_size, reach, size_in_dimension};
use super::padding::{PaddingKind, PaddingOwner, UnusedBytes, gaps};
use super::{BlockLayout, MemberLayout};
use crate::shape::{Scalar, Type};

/// The owner of a byte; offsets are from the start of the block.
///
/// Exhaustive: a byte is in a component, in padding or in neither.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ByteOwner {
    /// A component of a scalar, vector or matrix.
    Component {
        /// The path of the leaf: `data[3].color`.
        leaf: String,
        /// The leaf's type.
        ty: Type,
        /// Offset of the leaf.
        leaf_offset: u64,
        /// Size of the leaf in bytes.
        leaf_size: u64,
        /// The path of the component: `data[3].color.x`; that of the leaf if it has one component.
        path: String,
        /// Offset of the component.
        offset: u64,
        /// Size of the component in bytes.
        size: u64,
        /// Index of the byte in the component, from 0.
        byte: u64,
    },
    /// Padding.
    Padding {
        /// Hole or tail padding.
        kind: PaddingKind,
        /// The kind of owner.
        owner: PaddingOwner,
        /// The path of the owner: `data[3]`; empty for the block.
        path: String,
        /// Offset of the padding.
        offset: u64,
        /// Size of the padding in bytes.
        size: u64,
        /// The member directly before the padding.
        after: Option<Arc<str>>,
        /// The member directly after the padding.
        before: Option<Arc<str>>,
    },
    /// Past the end of the block.
    Beyond {
        /// Size of the block in bytes.
        size: u64,
    },
    /// The block is loose uniforms, which have no bytes.
    Loose,
}

/// Returns the owner of a byte at an offset from the start of a block. A runtime-sized array counts
/// as unbounded.
pub fn owner_of_byte(block: &BlockLayout, byte: u64) -> ByteOwner {
    let Some(size) = block.size else { return ByteOwner::Loose };
    let scope = ByteScope { block, byte, path: String::new(), base: 0 };
    // Members come first: a runtime-sized tail holds bytes past the size of the block.
    if let Some(found) = in_members(&block.members, &scope) {
        return found;
    }
    if byte >= size {
        return ByteOwner::Beyond { size };
    }
    in_gap(&block.members, size, PaddingOwner::Block, &scope)
}

/// A position in the tree of members: the concrete path and the offset it starts at.
struct ByteScope<'a> {
    block: &'a BlockLayout,
    byte: u64,
    path: String,
    base: u64,
}

impl ByteScope<'_> {
    fn padding(&self, owner: PaddingOwner, path: &str, offset: u64, size: u64) -> ByteOwner {
        ByteOwner::Padding {
            kind: PaddingKind::Tail,
            owner,
            path: path.to_string(),
            offset,
            size,
            after: None,
            before: None,
        }
    }
}

fn in_members(members: &[MemberLayout], scope: &ByteScope<'_>) -> Option<ByteOwner> {
    let at = scope.byte - scope.base;
    let member = members.iter().find(|member| {
        member.offset.is_some_and(|offset| {
            at >= offset && (is_endless(member) || at < offset + reach(member))
        })
    })?;
    Some(in_member(member, scope))
}

/// Whether the member extends to the end of the buffer.
fn is_endless(member: &MemberLayout) -> bool {
    member.dims.first().is_some_and(|len| fixed(len).is_none())
}

fn in_member(member: &MemberLayout, scope: &ByteScope<'_>) -> ByteOwner {
    let rules = scope.block.rules;
    let start = scope.base + member.offset.unwrap_or(0);
    let mut path = scope.path.clone();
    if !path.is_empty() {
        path.push('.');
    }
    path.push_str(&member.name);
    let own = own_size(member, rules);
    if !is_endless(member) && scope.byte - start >= own {
        // WGSL's `@size(N)` makes the member longer than its type.
        let size = reach(member) - own;
        return scope.padding(PaddingOwner::Member, &path, start + own, size);
    }
    // At each dimension, `base` becomes the start of the element that holds the byte.
    let mut base = start;
    for (dim, (len, &stride)) in member.dims.iter().zip(&member.strides).enumerate() {
        // An array of structures without bytes has stride 0.
        let index = (scope.byte - base).checked_div(stride).unwrap_or(0);
        debug_assert!(fixed(len).is_none_or(|len| index < len) || is_endless(member));
        path.push_str(&format!("[{index}]"));
        base += index * stride;
        let element = size_in_dimension(member, dim, rules);
        // std140 pads each element to 16 bytes (rule 4), scalar and SPIR-V any way they like.
        if scope.byte - base >= element {
            return scope.padding(PaddingOwner::Element, &path, base + element, stride - element);
        }
    }
    let whole = element_size(member, rules);
    if let Type::Struct(_) = member.ty.innermost() {
        let inner = ByteScope { path, base, ..*scope };
        return in_members(&member.members, &inner)
            .unwrap_or_else(|| in_gap(&member.members, whole, PaddingOwner::Structure, &inner));
    }
    in_leaf(member, &path, base, scope)
}

fn in_leaf(member: &MemberLayout, leaf: &str, base: u64, scope: &ByteScope<'_>) -> ByteOwner {
    let ty = member.ty.innermost();
    let at = scope.byte - base;
    let component = |path: String, offset: u64, size: u64| ByteOwner::Component {
        leaf: leaf.to_string(),
        ty: ty.clone(),
        leaf_offset: base,
        leaf_size: element_size(member, scope.block.rules),
        path,
        offset,
        size,
        byte: scope.byte - offset,
    };
    match ty {
        Type::Vector { scalar, .. } => {
            let width = width(*scalar);
            let i = at / width;
            component(format!("{leaf}.{}", component_name(i)), base + i * width, width)
        }
        Type::Matrix { scalar, .. } => {
            let width = width(*scalar);
            let stride = member.matrix_stride.expect("a placed matrix has a stride");
            let vector = matrix_vector(member).expect("the type is a matrix");
            // Vector `i` is a column, or a row if row-major; `stride` may exceed its bytes (std140:
            // 16).
            let (i, inside) = (at / stride, at % stride);
            let start = base + i * stride;
            if inside >= vector.bytes {
                let owner = if member.row_major { PaddingOwner::Row } else { PaddingOwner::Column };
                // GLSL has no spelling for a row of a matrix: the matrix is named, the row counted.
                let path = if member.row_major { leaf.to_string() } else { format!("{leaf}[{i}]") };
                let size = stride - vector.bytes;
                return scope.padding(owner, &path, start + vector.bytes, size);
            }
            // GLSL indexes columns first, whatever the order in memory (GLSL 4.60 §5.6).
            let j = inside / width;
            let (column, row) = if member.row_major { (j, i) } else { (i, j) };
            let path = format!("{leaf}[{column}].{}", component_name(row));
            component(path, start + j * width, width)
        }
        _ => component(leaf.to_string(), base, element_size(member, scope.block.rules)),
    }
}

fn in_gap(
    members: &[MemberLayout],
    whole: u64,
    owner: PaddingOwner,
    scope: &ByteScope<'_>,
) -> ByteOwner {
    let at = scope.byte - scope.base;
    let holds = |gap: &UnusedBytes| at >= gap.offset && at < gap.offset + gap.size;
    let gap = gaps(members, whole)
        .into_iter()
        .find(holds)
        .expect("a byte of a structure that no member holds lies in a gap");
    ByteOwner::Padding {
        kind: gap.kind,
        owner,
        path: scope.path.clone(),
        offset: scope.base + gap.offset,
        size: gap.size,
        after: gap.after.map(|i| members[i].name.clone()),
        before: gap.before.map(|i| members[i].name.clone()),
    }
}

fn width(scalar: Scalar) -> u64 {
    scalar.width.into()
}

/// Returns the name of a component: `x`, `y`, `z`, `w`.
pub(crate) fn component_name(index: u64) -> &'static str {
    match index {
        0 => "x",
        1 => "y",
        2 => "z",
        _ => "w",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::*;
    use crate::shape::Rules;

    fn component(block: &BlockLayout, byte: u64) -> (String, u64) {
        match owner_of_byte(block, byte) {
            ByteOwner::Component { path, byte, .. } => (path, byte),
            other => panic!("byte {byte}: {other:?}"),
        }
    }

    #[test]
    fn bytes_of_the_point_lights_have_their_owners() {
        let block = point_lights();
        assert_eq!(component(&block, 0), ("data[0].pos.x".to_string(), 0));
        assert_eq!(component(&block, 160), ("data[3].color.x".to_string(), 0));
        assert_eq!(component(&block, 171), ("data[3].color.z".to_string(), 3));
        assert_eq!(component(&block, 172), ("data[3].intensity".to_string(), 0));
        assert_eq!(component(&block, 6147), ("actually_used_count".to_string(), 3));
        match owner_of_byte(&block, 157) {
            ByteOwner::Padding { kind, path, offset, size, after, before, .. } => {
                assert_eq!((kind, path.as_str()), (PaddingKind::Hole, "data[3]"));
                assert_eq!((offset, size), (156, 4));
                assert_eq!((after.as_deref(), before.as_deref()), (Some("pos"), Some("color")));
            }
            other => panic!("{other:?}"),
        }
        assert_eq!(owner_of_byte(&block, 6160), ByteOwner::Beyond { size: 6160 });
    }

    #[test]
    fn every_byte_of_a_block_has_an_owner_and_they_add_up() {
        for rules in [Rules::Std140, Rules::Std430, Rules::Scalar, Rules::Wgsl] {
            for block in [padded(rules), doubles(rules), point_lights(), particles()] {
                let size = block.size.unwrap();
                let used = (0..size)
                    .filter(|&byte| {
                        matches!(owner_of_byte(&block, byte), ByteOwner::Component { .. })
                    })
                    .count();
                assert_eq!(used as u64, block.used(), "{rules:?} {}", block.name);
            }
        }
    }

    #[test]
    fn rows_of_a_row_major_matrix_are_named_by_column_and_component() {
        // `r` is two row-major mat2x3 at 720: three rows of two floats, 16 bytes apart.
        let block = padded(Rules::Std140);
        assert_eq!(component(&block, 720 + 48 + 16 + 4), ("r[1][1].y".to_string(), 0));
        match owner_of_byte(&block, 720 + 8) {
            ByteOwner::Padding { owner, size, .. } => {
                assert_eq!((owner, size), (PaddingOwner::Row, 8));
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_runtime_sized_tail_goes_on() {
        assert_eq!(
            component(&particles(), 16 + 1000 * 16 + 12),
            ("particles[1000].age".to_string(), 0)
        );
    }

    #[test]
    fn loose_uniforms_own_no_bytes() {
        assert_eq!(owner_of_byte(&loose(), 0), ByteOwner::Loose);
    }
}
