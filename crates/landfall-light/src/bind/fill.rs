//! Writes the blocks, textures and inputs of a shader by a binding map.
//!
//! Reads an [`Upload`] and fragments; [`render`](crate::render) passes the results to
//! [`fragments`](landfall_exec::harness::fragments). `write` locates members in their blocks,
//! `values` evaluates sources, `varying` makes textures and inputs.

mod mark;
mod values;
mod varying;
mod write;

use super::quantity::{Kind, MaterialPart, Quantity, TilePart};
use super::{BindError, BindingMap, Source};
use crate::Upload;
use crate::scene::{Lights, Material, Surface};
use landfall_exec::harness::fragments::FragmentShader;
use landfall_layout::buffer::Buffer;
use values::{FilledNumber, ValueSources, surface};
pub(crate) use varying::FragmentInputs;
use write::{Write, slots, write};

/// The lights of a list of fragments: indices into the upload, in the order of the sum.
#[derive(Clone, Copy, Debug, Default)]
pub struct FragmentLights<'a> {
    /// Whether ambient light is added.
    pub ambient: bool,
    pub directional: &'a [u32],
    pub point: &'a [u32],
    pub spot: &'a [u32],
}

impl<'a> FragmentLights<'a> {
    pub fn of(&self, kind: Kind) -> &'a [u32] {
        match kind {
            Kind::Directional => self.directional,
            Kind::Point => self.point,
            Kind::Spot => self.spot,
        }
    }
}

/// The lights of a [`FragmentLights`] for each tile of the picture, for shaders that use them; the
/// fields are those of [`TileLists`](crate::plan::TileLists).
#[derive(Clone, Copy, Debug)]
pub struct Tiles<'a> {
    /// The side of a tile in pixels.
    pub size: u32,
    pub columns: u32,
    /// The height of the picture in pixels.
    pub height: u32,
    /// The start of each tile's list of point lights in `indices`, and its length.
    pub tiles: &'a [[u32; 2]],
    /// The same of spotlights.
    pub spots: &'a [[u32; 2]],
    /// The directional lights of each tile, a bit each.
    pub directional: &'a [u32],
    /// The indices of point lights and of spotlights.
    pub indices: &'a [u32],
}

impl Tiles<'_> {
    /// Returns the number of a part, of those that have several the one at an index.
    fn number(&self, part: TilePart, index: usize) -> u32 {
        let pair = |pairs: &[[u32; 2]], at: usize| pairs.get(index).map_or(0, |pair| pair[at]);
        match part {
            TilePart::Size => self.size,
            TilePart::Columns => self.columns,
            TilePart::Height => self.height,
            TilePart::First => pair(self.tiles, 0),
            TilePart::Count => pair(self.tiles, 1),
            TilePart::SpotFirst => pair(self.spots, 0),
            TilePart::SpotCount => pair(self.spots, 1),
            TilePart::DirectionalMask => self.directional.get(index).copied().unwrap_or(0),
            TilePart::Index => self.indices.get(index).copied().unwrap_or(0),
        }
    }
}

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
    pub fn lights(
        &self,
        lights: &Lights,
        excess: OverflowPolicy,
    ) -> Result<[Vec<u32>; 3], BindError> {
        let counts = [lights.directional.len(), lights.point.len(), lights.spot.len()];
        let mut chosen: [Vec<u32>; 3] = Default::default();
        for (kind, chosen) in Kind::ALL.into_iter().zip(&mut chosen) {
            let (lights, (slots, member)) = (counts[kind as usize], &self.slots[kind as usize]);
            if lights > *slots && excess == OverflowPolicy::Refuse {
                let (slots, member) = (*slots, member.clone());
                return Err(BindError::TooManyLights { kind, lights, slots, member });
            }
            *chosen = (0..lights.min(*slots) as u32).collect();
        }
        Ok(chosen)
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
        lit: &FragmentLights<'_>,
        material: &Material,
        tiles: Option<&Tiles<'_>>,
    ) -> Result<Vec<Vec<u8>>, BindError> {
        // Checked again, since a plan may list more lights for a tile than the shader has slots
        // for.
        for kind in Kind::ALL {
            let (lights, (slots, member)) = (lit.of(kind).len(), &self.slots[kind as usize]);
            if lights > *slots {
                let (slots, member) = (*slots, member.clone());
                return Err(BindError::TooManyLights { kind, lights, slots, member });
            }
        }
        // A single tile with all lights, for a shader that uses tiles and a plan without them.
        let [points, spots] = [lit.point.len() as u32, lit.spot.len() as u32];
        // Never empty, since no shader language has empty buffers.
        // Points, then spots, in one list: each counts from the start of its own kind.
        let all: Vec<u32> = (0..points.max(u32::from(spots == 0))).chain(0..spots).collect();
        let whole = Tiles {
            size: u32::MAX,
            columns: 1,
            height: 1,
            tiles: &[[0, points]],
            spots: &[[points, spots]],
            directional: &[u32::MAX],
            indices: &all,
        };
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
                    part.word(),
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
