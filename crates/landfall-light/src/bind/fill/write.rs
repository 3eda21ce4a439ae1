//! The place of a bound member in its block, and the number of lights in its array.
//!
//! Reads the layout of the block; used by [`BlockWriter`](super::BlockWriter).

use crate::bind::quantity::{Kind, Quantity, Slot};
use crate::bind::{BindError, Member, Source};
use landfall_layout::buffer::{BufferError, Components};

#[derive(Clone, Debug)]
pub(super) struct Write {
    pub key: String,
    pub block: usize,
    pub components: Components,
    pub source: Source,
}

pub(super) fn write(
    member: &Member,
    block: &landfall_layout::BlockLayout,
) -> Result<Write, BindError> {
    let key = member.key();
    let misfit = |why: String| BindError::Misfit { key: key.clone(), why };
    let components = Components::new(block, &member.path).map_err(|error| {
        misfit(match error {
            BufferError::OutOfRange { .. } => "is past the end of its array".to_string(),
            BufferError::MissingIndex { .. }
            | BufferError::TailTooShort { .. }
            | BufferError::Unsized { .. } => {
                "is in an array of arrays or of unknown length".to_string()
            }
            BufferError::NotALeaf { .. } => "is not a scalar or vector".to_string(),
            _ => "is not in its block".to_string(),
        })
    })?;
    // A matrix holds no quantity.
    if components.shape().0 != 1 {
        return Err(misfit("is not a scalar or vector".to_string()));
    }
    if components.scalar().width != 4 {
        return Err(misfit(format!(
            "has {}-bit components, but only 32-bit ones can be bound",
            components.scalar().width * 8
        )));
    }
    let each = member.source.quantity().is_some_and(Quantity::is_each);
    if each && !components.is_array() {
        let why =
            format!("is not in an array, but `{}` has a value for each element", member.source);
        return Err(misfit(why));
    }
    Ok(Write { key, block: member.block, components, source: member.source.clone() })
}

/// Returns the number of slots for lights of a kind, and the member with the fewest.
pub(super) fn slots(writes: &[Write], kind: Kind) -> (usize, Option<String>) {
    // Arrays of properties in parallel limit each other: the shortest decides.
    let mut fewest: Option<(usize, String)> = None;
    let mut singles = 0usize;
    for write in writes {
        let Some(Quantity::Light { kind: of, slot, .. }) = write.source.quantity() else {
            continue;
        };
        if of != kind {
            continue;
        }
        let slots = match slot {
            Slot::One(number) => {
                singles = singles.max(number as usize + 1);
                continue;
            }
            Slot::Each if !write.components.is_array() => continue,
            Slot::Each => write.components.elements().unwrap_or(usize::MAX),
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
