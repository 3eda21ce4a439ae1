//! The values that vary over the surface: material textures and fragment inputs.
//!
//! Reads fragments and materials by the sources of a binding map.

use std::ops::Range;

use super::values::surface;
use super::{BlockWriter, Source};
use crate::bind::quantity::{MaterialPart, Quantity};
use crate::scene::{Material, Surface};
use crate::{Chosen, sample};
use landfall_exec::harness::fragments::{Image, Inputs};

impl BlockWriter {
    /// Returns the textures for fragments of one material.
    pub fn textures(&self, material: &Material) -> Vec<Image> {
        let each = self.textures.iter().map(|source| match source {
            Source::Scene { quantity: Quantity::Material(part), .. } => {
                self.texture(material, *part)
            }
            Source::Number(numbers) => {
                // One number is a grey; missing channels repeat the last one.
                let channel = |at: usize| numbers.get(at).or(numbers.last()).copied();
                let alpha = if numbers.len() == 4 { numbers[3] } else { 1.0 };
                let rgb = [0, 1, 2].map(|at| channel(at).unwrap_or(0.0));
                single_texel([rgb[0], rgb[1], rgb[2], alpha].map(|c| c as f32))
            }
            Source::Scene { .. } | Source::Unknown => single_texel([0.0, 0.0, 0.0, 1.0]),
        });
        each.collect()
    }

    fn texture(&self, material: &Material, part: MaterialPart) -> Image {
        let Some(surface) = surface(material, part) else { return single_texel([0.0; 4]) };
        match surface {
            Surface::Texture(texture) => {
                let color = |texel: &[u8; 3]| {
                    let [r, g, b] = sample::color(*texel, texture.srgb).as_vec3().to_array();
                    [r, g, b, 1.0]
                };
                let texels = texture.texels.iter().map(color).collect();
                Image { width: texture.width, height: texture.height, texels }
            }
            // A member holds the colour, which multiplies this.
            Surface::Constant(_) if self.colours(part) => single_texel([1.0; 4]),
            Surface::Constant(color) => {
                let [r, g, b] = color.as_vec3().to_array();
                single_texel([r, g, b, 1.0])
            }
        }
    }

    /// Whether a member of the shader holds that colour.
    fn colours(&self, part: MaterialPart) -> bool {
        let wanted = Some(Quantity::Material(part));
        self.writes.iter().any(|write| write.source.quantity() == wanted)
    }

    /// Returns the values of each input for fragments of a picture.
    pub fn inputs(&self, fragments: Chosen<'_>, size: [u32; 2]) -> Vec<Vec<[f32; 4]>> {
        let inputs = FragmentInputs { writer: self, fragments, size };
        let each = (0..self.inputs.len()).map(|input| {
            let count = fragments.numbers.len();
            let mut values = Vec::with_capacity(count);
            inputs.append(input, 0..count, &mut values);
            values
        });
        each.collect()
    }
}

/// The inputs of a shader for fragments of a picture.
#[derive(Debug)]
pub(crate) struct FragmentInputs<'a> {
    pub writer: &'a BlockWriter,
    pub fragments: Chosen<'a>,
    pub size: [u32; 2],
}

impl Inputs for FragmentInputs<'_> {
    fn counts(&self) -> Vec<usize> {
        vec![self.fragments.numbers.len(); self.writer.inputs.len()]
    }

    fn append(&self, input: usize, fragments: Range<usize>, to: &mut Vec<[f32; 4]>) {
        let [width, height] = self.size.map(|n| n.max(1));
        let Chosen { all, numbers } = self.fragments;
        let (from, start) = (Chosen { all, numbers: &numbers[fragments] }.iter(), to.len());
        let (quantity, negated) = match &self.writer.inputs[input] {
            Source::Scene { quantity, negated, .. } => (Some(quantity), *negated),
            Source::Number(numbers) => {
                let at = |at: usize| numbers.get(at).copied().unwrap_or(0.0) as f32;
                return to.extend(from.map(|_| [at(0), at(1), at(2), at(3)]));
            }
            Source::Unknown => (None, false),
        };
        // A loop for each, as there may be millions of fragments.
        match quantity {
            Some(Quantity::Position) => to.extend(from.map(|fragment| {
                let [x, y, z] = fragment.position;
                [x, y, z, 1.0]
            })),
            Some(Quantity::Normal) => to.extend(from.map(|fragment| {
                let [x, y, z] = fragment.normal;
                [x, y, z, 0.0]
            })),
            Some(Quantity::Uv) => to.extend(from.map(|fragment| {
                let [u, v] = fragment.uv;
                [u, v, 0.0, 0.0]
            })),
            Some(Quantity::Pixel) => to.extend(from.map(|fragment| {
                // Pixel centres; rows of GL count from the bottom.
                let (column, row) = (fragment.pixel % width, fragment.pixel / width);
                let row = if self.writer.rows_from_bottom { height - 1 - row } else { row };
                [column as f32 + 0.5, row as f32 + 0.5, 0.0, 1.0]
            })),
            Some(
                Quantity::Camera
                | Quantity::Ambient(_)
                | Quantity::Light { .. }
                | Quantity::Count(_)
                | Quantity::Material(_)
                | Quantity::Tiles(_),
            )
            | None => to.extend(from.map(|_| [0.0; 4])),
        }
        if negated {
            to[start..].as_flattened_mut().iter_mut().for_each(|value| *value = -*value);
        }
    }
}

fn single_texel(texel: [f32; 4]) -> Image {
    Image { width: 1, height: 1, texels: vec![texel] }
}
