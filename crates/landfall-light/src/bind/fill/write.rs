//! The place of a bound member in its block, and the number of lights in its array.
//!
//! Reads the layout of the block; used by [`BlockWriter`](super::BlockWriter).

use crate::bind::quantity::{Kind, Quantity, Slot};
use crate::bind::{BindError, Member, Source};
use landfall_layout::layout::Leaf;
use landfall_layout::shape::{ArrayLen, ScalarKind, Type};

/// A leaf and its source.
#[derive(Clone, Debug)]
pub(super) struct Write {
    pub key: String,
    pub block: usize,
    pub offset: usize,
    /// The stride of the only array in its path.
    pub stride: usize,
    pub len: Len,
    pub kind: ScalarKind,
    pub rows: usize,
    pub source: Source,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Len {
    One,
    Fixed(usize),
    Runtime,
}

pub(super) fn write(
    member: &Member,
    block: &landfall_layout::BlockLayout,
) -> Result<Write, BindError> {
    let key = member.key();
    let misfit = |why: String| BindError::Misfit { key: key.clone(), why };
    let (leaf, index) = leaf(&block.leaves, &member.path)
        .ok_or_else(|| misfit("is not in its block".to_string()))?;
    let (scalar, rows) = match &leaf.ty {
        Type::Scalar(scalar) | Type::Atomic(scalar) => (*scalar, 1),
        Type::Vector { scalar, rows } => (*scalar, usize::from(*rows)),
        Type::Matrix { .. } | Type::Address(_) | Type::Struct(_) | Type::Array { .. } => {
            return Err(misfit("is not a scalar or vector".to_string()));
        }
    };
    if scalar.width != 4 {
        return Err(misfit(format!(
            "has {}-bit components, but only 32-bit ones can be bound",
            scalar.width * 8
        )));
    }
    let offset = leaf.offset.unwrap_or(0) as usize;
    let (len, stride) = match (&leaf.dims[..], index) {
        ([], _) => (Len::One, 0),
        ([ArrayLen::Fixed(len)], None) => (Len::Fixed(*len as usize), leaf.strides[0] as usize),
        ([ArrayLen::Runtime], None) => (Len::Runtime, leaf.strides[0] as usize),
        ([ArrayLen::Fixed(len)], Some(index)) if index < *len as usize => (Len::One, 0),
        ([_], Some(_)) => return Err(misfit("is past the end of its array".to_string())),
        _ => return Err(misfit("is in an array of arrays or of unknown length".to_string())),
    };
    let offset = offset + index.map_or(0, |index| index * leaf.strides[0] as usize);
    let each = member.source.quantity().is_some_and(Quantity::is_each);
    if each && len == Len::One {
        let why =
            format!("is not in an array, but `{}` has a value for each element", member.source);
        return Err(misfit(why));
    }
    let (kind, source) = (scalar.kind, member.source.clone());
    Ok(Write { key, block: member.block, offset, stride, len, kind, rows, source })
}

/// Returns the leaf of a path, and the index if the path names one element of an array.
fn leaf<'l>(leaves: &'l [Leaf], path: &str) -> Option<(&'l Leaf, Option<usize>)> {
    if let Some(leaf) = leaves.iter().find(|leaf| leaf.path == path) {
        return Some((leaf, None));
    }
    let (before, rest) = path.split_once('[')?;
    let (index, after) = rest.split_once(']')?;
    let pattern = format!("{before}[]{after}");
    let leaf = leaves.iter().find(|leaf| leaf.path == pattern && leaf.dims.len() == 1)?;
    Some((leaf, Some(index.parse().ok()?)))
}

/// Returns the number of slots for lights of a kind, and the member with the fewest.
pub(super) fn slots(writes: &[Write], kind: Kind) -> (usize, Option<String>) {
    let mut fewest: Option<(usize, String)> = None;
    let mut singles = 0usize;
    for write in writes {
        let Some(Quantity::Light { kind: of, slot, .. }) = write.source.quantity() else {
            continue;
        };
        if of != kind {
            continue;
        }
        let slots = match (slot, write.len) {
            (Slot::One(number), _) => {
                singles = singles.max(number as usize + 1);
                continue;
            }
            (Slot::Each, Len::Fixed(len)) => len,
            (Slot::Each, Len::Runtime) => usize::MAX,
            (Slot::Each, Len::One) => continue,
        };
        if fewest.as_ref().is_none_or(|(known, _)| slots < *known) {
            fewest = Some((slots, write.key.clone()));
        }
    }
    match fewest {
        Some((slots, member)) => (slots, Some(member)),
        None => (singles, None),
    }
}
