//! Sets the colours of one light to NaN, to find the fragments that it affects.
//!
//! Changes the output of [`BlockWriter`]; [`bench`](mod@crate::accuracy::bench) uses it to count
//! the lights a shader evaluates at a fragment: NaN passes through every product, also with black,
//! but not from skipped lights.

use super::BlockWriter;
use super::write::Len;
use crate::bind::quantity::{Kind, LightPart, Quantity, Slot};
use landfall_layout::shape::ScalarKind;

impl BlockWriter {
    /// Sets the colours of the light in a slot to NaN, except the ambient one, which shaders add
    /// before they test the light. Returns false if the shader has no such colours.
    pub fn mark(&self, blocks: &mut [Vec<u8>], kind: Kind, slot: usize) -> bool {
        let mut marked = false;
        for write in &self.writes {
            let Some(Quantity::Light { kind: of, slot: at, part }) = write.source.quantity() else {
                continue;
            };
            let coloured = matches!(
                part,
                LightPart::Color | LightPart::Radiance | LightPart::Diffuse | LightPart::Specular
            );
            let index = match (at, write.len) {
                (Slot::One(number), _) if number as usize == slot => 0,
                (Slot::Each, Len::Fixed(len)) if slot < len => slot,
                (Slot::Each, Len::Runtime) => slot,
                (Slot::One(_), _) | (Slot::Each, Len::Fixed(_) | Len::One) => continue,
            };
            if of != kind || !coloured || write.kind != ScalarKind::Float {
                continue;
            }
            let first = write.offset + index * write.stride;
            for at in (0..write.rows.min(3)).map(|row| first + 4 * row) {
                let to = blocks.get_mut(write.block).and_then(|bytes| bytes.get_mut(at..at + 4));
                if let Some(to) = to {
                    to.copy_from_slice(&f32::NAN.to_ne_bytes());
                    marked = true;
                }
            }
        }
        marked
    }
}
