//! Writes the blocks, textures and inputs of a shader by a binding map.
//!
//! Reads an [`Upload`] and fragments; [`render`](crate::render) passes the results to
//! [`fragments`](landfall_exec::harness::fragments). `write` locates members in their blocks,
//! `values` evaluates sources, `varying` makes textures and inputs.

mod mark;
mod values;
mod varying;
mod write;

use super::quantity::{Kind, MaterialPart, Quantity};
use super::{BindError, BindingMap, Source};
use crate::Upload;
use crate::plan::{LightSet, TileLists};
use crate::scene::{Lights, Material, Surface};
use landfall_exec::harness::fragments::FragmentShader;
use landfall_layout::buffer::Buffer;
use values::{FilledNumber, ValueSources, surface};
pub(crate) use varying::FragmentInputs;
use write::{Write, slots, write};

/// The treatment of lights for which a shader has no slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum OverflowPolicy {
    /// They are an error.
    #[default]
    Refuse,
    /// They are left out, the last first.
    LeaveOut,
}

/// A binding map prepared for writing many uploads.
#[derive(Clone, Debug)]
pub struct BlockWriter {
    writes: Vec<Write>,
    /// The zeros of each block; empty for a block that ends in a runtime-sized array.
    blocks: Vec<Vec<u8>>,
    layouts: Vec<landfall_layout::BlockLayout>,
    /// The slots of each kind, and the member with the fewest.
    slots: [(usize, Option<String>); 3],
    textures: Vec<Source>,
    inputs: Vec<Source>,
    /// Whether a texture carries the ambient, the diffuse or the specular colour.
    textured: [bool; 3],
    rows_from_bottom: bool,
}

impl BlockWriter {
    /// Prepares a map.
    ///
    /// # Errors
    /// A member that does not fit its source.
    pub fn new(shader: &FragmentShader, map: &BindingMap) -> Result<BlockWriter, BindError> {
        let layouts: Vec<_> = shader.blocks().iter().map(|block| block.layout.clone()).collect();
        let mut writes = Vec::new();
        // Unknown members keep the zeros of their block.
        for member in &map.members {
            if member.source != Source::Unknown {
                writes.push(write(member, &layouts[member.block])?);
            }
        }
        // A single element overrides its array.
        // The sort is stable: arrays, then single elements, each in the order of the map.
        writes.sort_by_key(|write| !write.components.is_array());
        let blocks = layouts.iter().map(|layout| match Buffer::new(layout) {
            Ok(buffer) => buffer.into_bytes(),
            Err(_) => Vec::new(),
        });
        let textures: Vec<Source> = map.textures.iter().map(|bound| bound.source.clone()).collect();
        let carries = |part| {
            let wanted = Some(Quantity::Material(part));
            textures.iter().any(|source| source.quantity() == wanted)
        };
        Ok(BlockWriter {
            blocks: blocks.collect(),
            slots: Kind::ALL.map(|kind| slots(&writes, kind)),
            writes,
            layouts,
            textured: [MaterialPart::Ambient, MaterialPart::Diffuse, MaterialPart::Specular]
                .map(carries),
            textures,
            inputs: map.inputs.iter().map(|bound| bound.source.clone()).collect(),
            rows_from_bottom: shader.rows_from_bottom(),
        })
    }

    /// Returns the lights of an upload for which the shader has slots.
    ///
    /// # Errors
    /// More lights of a kind than slots, unless the policy leaves them out.
    pub fn lights(&self, lights: &Lights, excess: OverflowPolicy) -> Result<LightSet, BindError> {
        let counts = lights.counts();
        if excess == OverflowPolicy::Refuse {
            self.have_slots(counts)?;
        }
        Ok(LightSet::first(Kind::ALL.map(|kind| counts[kind as usize].min(self.slots(kind)))))
    }

    fn have_slots(&self, counts: [usize; 3]) -> Result<(), BindError> {
        for kind in Kind::ALL {
            let (lights, (slots, member)) = (counts[kind as usize], &self.slots[kind as usize]);
            if lights > *slots {
                let (slots, member) = (*slots, member.clone());
                return Err(BindError::TooManyLights { kind, lights, slots, member });
            }
        }
        Ok(())
    }

    /// Returns the slots of the shader for lights of a kind; `usize::MAX` for a runtime-sized
    /// array.
    pub fn slots(&self, kind: Kind) -> usize {
        self.slots[kind as usize].0
    }

    /// Whether the shader has a count of the lights of a kind.
    pub(super) fn counts(&self, kind: Kind) -> bool {
        self.writes.iter().any(|write| write.source.quantity() == Some(Quantity::Count(kind)))
    }

    /// Returns the bytes of every block for fragments of one material.
    ///
    /// # Errors
    /// More lights than slots.
    pub fn blocks(
        &self,
        upload: &Upload,
        lit: &LightSet,
        material: &Material,
        tiles: Option<&TileLists>,
    ) -> Result<Vec<Vec<u8>>, BindError> {
        // Checked again, since a plan may list more lights for a tile than the shader has slots
        // for.
        self.have_slots(lit.counts())?;
        // A single tile with all lights, for a shader that uses tiles and a plan without them.
        let whole = TileLists::whole(&LightSet::first(lit.counts()), 1);
        let given = ValueSources { upload, lit, material, tiles: tiles.unwrap_or(&whole) };
        let mut blocks = self.sized(&given);
        for write in &self.writes {
            let bytes = &mut blocks[write.block];
            let elements = write.components.elements_in(bytes.len());
            // Elements past the lights stay zero.
            let used = match write.source.quantity() {
                Some(quantity) if quantity.is_each() => given.count(quantity).min(elements),
                _ => elements,
            };
            let (_, rows) = write.components.shape();
            for index in 0..used {
                let number = self.number(&write.source, index, &given);
                write.components.write(bytes, index, &number.components(rows));
            }
        }
        Ok(blocks)
    }

    /// Returns zeros for each block, with runtime-sized arrays as long as their contents.
    fn sized(&self, given: &ValueSources<'_>) -> Vec<Vec<u8>> {
        let each = self.blocks.iter().enumerate().map(|(number, zeros)| {
            // A block of fixed size.
            if !zeros.is_empty() {
                return zeros.clone();
            }
            let of_block = self.writes.iter().filter(|w| w.block == number);
            // As long as the longest array of lights or lists in it, and at least one element.
            let lens = of_block.filter(|w| w.components.elements().is_none()).filter_map(|write| {
                Some(given.count(write.source.quantity().filter(|q| q.is_each())?))
            });
            let elements = lens.max().unwrap_or(0).max(1);
            let buffer = Buffer::with_tail(&self.layouts[number], elements);
            buffer.map(Buffer::into_bytes).unwrap_or_default()
        });
        each.collect()
    }

    fn number(&self, source: &Source, index: usize, given: &ValueSources<'_>) -> FilledNumber {
        match source {
            Source::Unknown => FilledNumber::one(0.0),
            Source::Number(numbers) => {
                let mut values = [0.0; 4];
                for (to, from) in values.iter_mut().zip(numbers) {
                    *to = *from;
                }
                match numbers[..] {
                    [one] => FilledNumber::one(one),
                    _ => FilledNumber { values, count: numbers.len() },
                }
            }
            Source::Scene { quantity, negated } => {
                let mut number = given.number(*quantity, index, &self.textured);
                if *negated {
                    number.values = number.values.map(|value| -value);
                }
                number
            }
        }
    }

    /// Returns notes on properties of a material that the shader cannot represent.
    pub fn notes(&self, material: &Material) -> Vec<String> {
        let mut notes = Vec::new();
        for write in &self.writes {
            let Some(Quantity::Material(part)) = write.source.quantity() else { continue };
            let textured = self.carried(part);
            if let (Some(Surface::Texture(_)), false) = (surface(material, part), textured) {
                notes.push(format!(
                    "`{}` is a single colour, but the {} of `{}` is a texture: its mean is used",
                    write.key,
                    part.name(),
                    material.name
                ));
            }
        }
        notes
    }

    fn carried(&self, part: MaterialPart) -> bool {
        // Textures multiply: a diffuse texture stands for the ambient colour as well.
        match part {
            MaterialPart::Ambient => self.textured[0] || self.textured[1],
            MaterialPart::Diffuse => self.textured[1],
            MaterialPart::Specular => self.textured[2],
            MaterialPart::Shininess | MaterialPart::Reflectance => false,
        }
    }
}
