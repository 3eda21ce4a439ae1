//! The values of quantities for the lights and the material in use.
//!
//! Reads an [`Upload`]; used by [`BlockWriter`](super::BlockWriter).

use glam::DVec3;
use landfall_ir::analysis::hazard::threshold;

use crate::bind::quantity::{Kind, LightPart, MaterialPart, Quantity, Slot, TilePart};
use crate::plan::{LightSet, TileLists};
use crate::scene::{Cone, Emission, Material, PointLight, Surface};
use crate::{Upload, sample};

pub(super) struct ValueSources<'a> {
    pub upload: &'a Upload,
    pub lit: &'a LightSet,
    pub material: &'a Material,
    pub tiles: &'a TileLists,
}

/// A number or vector, with a fourth component for shaders that have one more.
#[derive(Clone, Copy)]
pub(super) struct FilledNumber {
    pub values: [f64; 4],
    pub count: usize,
}

impl FilledNumber {
    pub(super) fn one(value: f64) -> FilledNumber {
        // A number for a vector fills all of its components.
        FilledNumber { values: [value, value, value, value], count: 1 }
    }

    pub(super) fn vector(value: DVec3, fourth: f64) -> FilledNumber {
        FilledNumber { values: [value.x, value.y, value.z, fourth], count: 3 }
    }

    /// Returns the components for a leaf with that many.
    pub(super) fn components(&self, rows: usize) -> [f64; 4] {
        let [x, y, z, _] = self.values;
        match (self.count, rows) {
            // A single number for a colour: its brightest channel.
            (3, 1) => [x.max(y).max(z); 4],
            _ => self.values,
        }
    }
}

/// The range of a light without one: far enough that a window is 1 at any distance.
const ENDLESS: f64 = threshold::COORDINATE.value;

impl ValueSources<'_> {
    /// Returns the number of elements of a quantity.
    pub(super) fn count(&self, quantity: Quantity) -> usize {
        match quantity {
            Quantity::Light { kind, .. } => self.lit.of(kind).len(),
            Quantity::Tiles(part) => match part {
                TilePart::Index => self.tiles.indices.len(),
                TilePart::Size | TilePart::Columns | TilePart::Height => 1,
                TilePart::First
                | TilePart::Count
                | TilePart::SpotFirst
                | TilePart::SpotCount
                | TilePart::DirectionalMask => self.tiles.tiles.len(),
            },
            Quantity::Camera
            | Quantity::Ambient(_)
            | Quantity::Count(_)
            | Quantity::Material(_)
            | Quantity::Position
            | Quantity::Normal
            | Quantity::Uv
            | Quantity::Pixel => 1,
        }
    }

    pub(super) fn number(
        &self,
        quantity: Quantity,
        index: usize,
        textured: &[bool; 3],
    ) -> FilledNumber {
        // What is not there is black, or a slot of zeros.
        let nothing = FilledNumber::one(0.0);
        match quantity {
            Quantity::Camera => FilledNumber::vector(self.upload.camera, 1.0),
            Quantity::Ambient(part) => {
                let ambient = self.upload.lights.ambient.filter(|_| self.lit.ambient);
                let Some(ambient) = ambient else { return nothing };
                match part {
                    LightPart::Intensity => FilledNumber::one(ambient.intensity),
                    LightPart::Radiance => {
                        FilledNumber::vector(ambient.color * ambient.intensity, 1.0)
                    }
                    _ => FilledNumber::vector(ambient.color, 1.0),
                }
            }
            Quantity::Light { kind, slot, part } => {
                let at = match slot {
                    Slot::Each => index,
                    Slot::One(number) => number as usize,
                };
                match self.lit.of(kind).get(at) {
                    Some(number) => self.light(kind, *number as usize, part),
                    None => nothing,
                }
            }
            Quantity::Count(kind) => FilledNumber::one(self.lit.of(kind).len() as f64),
            Quantity::Material(part) => self.of_material(part, textured),
            Quantity::Tiles(part) => FilledNumber::one(f64::from(self.of_tiles(part, index))),
            Quantity::Position | Quantity::Normal | Quantity::Uv | Quantity::Pixel => nothing,
        }
    }

    /// Returns the number of a part, of those that have several the one at an index.
    fn of_tiles(&self, part: TilePart, index: usize) -> u32 {
        let pair = |pairs: &[[u32; 2]], at: usize| pairs.get(index).map_or(0, |pair| pair[at]);
        let tiles = self.tiles;
        match part {
            TilePart::Size => tiles.size,
            TilePart::Columns => tiles.columns,
            TilePart::Height => tiles.height,
            TilePart::First => pair(&tiles.tiles, 0),
            TilePart::Count => pair(&tiles.tiles, 1),
            TilePart::SpotFirst => pair(&tiles.spots, 0),
            TilePart::SpotCount => pair(&tiles.spots, 1),
            TilePart::DirectionalMask => tiles.directional.get(index).copied().unwrap_or(0),
            TilePart::Index => tiles.indices.get(index).copied().unwrap_or(0),
        }
    }

    fn light(&self, kind: Kind, number: usize, part: LightPart) -> FilledNumber {
        let lights = &self.upload.lights;
        let found = match kind {
            Kind::Directional => lights.directional.get(number).and_then(|light| {
                of_emission(&light.emission, part).or(match part {
                    LightPart::Direction => Some(FilledNumber::vector(light.direction, 0.0)),
                    _ => None,
                })
            }),
            Kind::Point => lights.point.get(number).and_then(|light| of_point(light, part)),
            Kind::Spot => lights.spot.get(number).and_then(|light| {
                let own = match part {
                    LightPart::Direction => Some(FilledNumber::vector(light.direction, 0.0)),
                    _ => of_cone(&light.cone, part),
                };
                own.or_else(|| of_point(&light.point, part))
            }),
        };
        found.unwrap_or(FilledNumber::one(0.0))
    }

    fn of_material(&self, part: MaterialPart, textured: &[bool; 3]) -> FilledNumber {
        let Material { diffuse, shininess, reflectance, .. } = self.material;
        let white = FilledNumber::vector(DVec3::ONE, 1.0);
        let color = |surface: &Surface| match surface {
            Surface::Constant(color) => FilledNumber::vector(*color, 1.0),
            Surface::Texture(texture) => {
                // The mean of all texels, in linear light.
                let sum: DVec3 =
                    texture.texels.iter().map(|t| sample::color(*t, texture.srgb)).sum();
                FilledNumber::vector(sum / texture.texels.len().max(1) as f64, 1.0)
            }
        };
        let [ambient, by_diffuse, specular] = *textured;
        match part {
            MaterialPart::Shininess => FilledNumber::one(*shininess),
            MaterialPart::Reflectance => FilledNumber::one(*reflectance),
            MaterialPart::Diffuse | MaterialPart::Ambient | MaterialPart::Specular => {
                let surface = surface(self.material, part).unwrap_or(diffuse);
                let is_texture = matches!(surface, Surface::Texture(_));
                let carried = match part {
                    MaterialPart::Diffuse => by_diffuse,
                    MaterialPart::Specular => specular,
                    // The diffuse texture multiplies it where there is no other.
                    MaterialPart::Ambient => ambient || (by_diffuse && surface == diffuse),
                    MaterialPart::Shininess | MaterialPart::Reflectance => false,
                };
                // Where the texture is bound, the member is white, or the colour would count
                // twice.
                if is_texture && carried { white } else { color(surface) }
            }
        }
    }
}

fn of_emission(emission: &Emission, part: LightPart) -> Option<FilledNumber> {
    let Emission { ambient, diffuse, specular, color, intensity } = *emission;
    let color_of = |color| Some(FilledNumber::vector(color, 1.0));
    match part {
        LightPart::Color => color_of(color),
        LightPart::Radiance => color_of(color * intensity),
        LightPart::Ambient => color_of(ambient),
        LightPart::Diffuse => color_of(diffuse),
        LightPart::Specular => color_of(specular),
        LightPart::Intensity => Some(FilledNumber::one(intensity)),
        LightPart::Enabled => Some(FilledNumber::one(1.0)),
        LightPart::Position
        | LightPart::Direction
        | LightPart::Constant
        | LightPart::Linear
        | LightPart::Quadratic
        | LightPart::Attenuation
        | LightPart::Range
        | LightPart::RangeSquared
        | LightPart::InverseRange
        | LightPart::InverseRangeSquared
        | LightPart::InnerCos
        | LightPart::OuterCos
        | LightPart::InnerDegrees
        | LightPart::OuterDegrees
        | LightPart::InnerRadians
        | LightPart::OuterRadians => None,
    }
}

fn of_point(point: &PointLight, part: LightPart) -> Option<FilledNumber> {
    let weakening = point.attenuation;
    let (c, l, q) = (weakening.constant, weakening.linear, weakening.quadratic);
    let range = weakening.range.unwrap_or(ENDLESS);
    match part {
        LightPart::Position => Some(FilledNumber::vector(point.position, 1.0)),
        LightPart::Constant => Some(FilledNumber::one(c)),
        LightPart::Linear => Some(FilledNumber::one(l)),
        LightPart::Quadratic => Some(FilledNumber::one(q)),
        LightPart::Attenuation => Some(FilledNumber::vector(DVec3::new(c, l, q), 0.0)),
        LightPart::Range => Some(FilledNumber::one(range)),
        LightPart::RangeSquared => Some(FilledNumber::one(range * range)),
        LightPart::InverseRange => Some(FilledNumber::one(1.0 / range)),
        LightPart::InverseRangeSquared => Some(FilledNumber::one(1.0 / (range * range))),
        _ => of_emission(&point.emission, part),
    }
}

fn of_cone(cone: &Cone, part: LightPart) -> Option<FilledNumber> {
    // The angles as the scene wrote them, if it did: a cosine has lost those of a narrow cone.
    let degrees = |at: usize, cos: f64| cone.degrees.map_or(cos.acos().to_degrees(), |d| d[at]);
    let inner = || degrees(0, cone.inner_cos);
    let outer = || degrees(1, cone.outer_cos);
    match part {
        LightPart::InnerCos => Some(FilledNumber::one(cone.inner_cos)),
        LightPart::OuterCos => Some(FilledNumber::one(cone.outer_cos)),
        LightPart::InnerDegrees => Some(FilledNumber::one(inner())),
        LightPart::OuterDegrees => Some(FilledNumber::one(outer())),
        LightPart::InnerRadians => Some(FilledNumber::one(inner().to_radians())),
        LightPart::OuterRadians => Some(FilledNumber::one(outer().to_radians())),
        _ => None,
    }
}

pub(super) fn surface(material: &Material, part: MaterialPart) -> Option<&Surface> {
    match part {
        MaterialPart::Ambient => Some(&material.ambient),
        MaterialPart::Diffuse => Some(&material.diffuse),
        MaterialPart::Specular => Some(&material.specular),
        MaterialPart::Shininess | MaterialPart::Reflectance => None,
    }
}
