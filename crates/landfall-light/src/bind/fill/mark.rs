//! Sets the colours of one light to NaN, to find the fragments that it affects.
//!
//! Changes the output of [`BlockWriter`]; `bench` uses it to count
//! the lights a shader evaluates at a fragment: NaN passes through every product, also with black,
//! but not from skipped lights.

use super::BlockWriter;
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
            // A slot past the array's end is no slot.
            let inside = write.components.elements().is_none_or(|elements| slot < elements);
            let index = match at {
                Slot::One(number) if number as usize == slot => 0,
                Slot::Each if write.components.is_array() && inside => slot,
                Slot::One(_) | Slot::Each => continue,
            };
            if of != kind || !coloured || write.components.scalar().kind != ScalarKind::Float {
                continue;
            }
            if let Some(bytes) = blocks.get_mut(write.block) {
                marked |= write.components.write(bytes, index, &[f64::NAN; 3]) > 0;
            }
        }
        marked
    }
}
