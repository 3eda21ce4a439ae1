//! The quantities of a scene by name: `camera.position`, `point[].color`, `material.shininess`.

use std::fmt;

pub use crate::scene::Kind;
use landfall_layout::named;

/// A number or vector of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// The position of the camera.
    Camera,
    /// The colour, intensity or radiance of the ambient light.
    Ambient(LightPart),
    /// A property of one light, or of each of a kind.
    Light {
        /// The kind of light.
        kind: Kind,
        /// The light of that kind.
        slot: Slot,
        /// The property.
        part: LightPart,
    },
    /// The number of lights of a kind.
    Count(Kind),
    /// A property of the fragments' material.
    Material(MaterialPart),
    /// The lists of lights per tile of the picture.
    Tiles(TilePart),
    /// The position of the fragment.
    Position,
    /// The interpolated normal of the fragment.
    Normal,
    /// The texture coordinates of the fragment.
    Uv,
    /// The pixel position, as in `gl_FragCoord`.
    Pixel,
}

/// The lights of a kind that a quantity selects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Slot {
    /// The light with the index of the array element: `point[]`.
    Each,
    /// The light with that index: `point[2]`.
    One(u32),
}

named! {
    /// A property of a light.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum LightPart {
        /// The position.
        Position = "position",
        /// The direction of travel.
        Direction = "direction",
        /// The single colour.
        Color = "color",
        /// The factor of the single colour.
        Intensity = "intensity",
        /// The colour times the intensity.
        Radiance = "radiance",
        /// The colour of the ambient term.
        Ambient = "ambient",
        /// The colour of the diffuse term.
        Diffuse = "diffuse",
        /// The colour of the specular term.
        Specular = "specular",
        /// The constant attenuation coefficient.
        Constant = "constant",
        /// The linear attenuation coefficient.
        Linear = "linear",
        /// The quadratic attenuation coefficient.
        Quadratic = "quadratic",
        /// All three attenuation coefficients.
        Attenuation = "attenuation",
        /// The range; 1e18 if unlimited.
        Range = "range",
        /// The square of the range.
        RangeSquared = "range_squared",
        /// One divided by the range.
        InverseRange = "inverse_range",
        /// One divided by the square of the range.
        InverseRangeSquared = "inverse_range_squared",
        /// The cosine of the angle up to which the cone has full intensity.
        InnerCos = "inner_cos",
        /// The cosine of the angle beyond which the cone has none.
        OuterCos = "outer_cos",
        /// The inner angle in degrees.
        InnerDegrees = "inner_degrees",
        /// The outer angle in degrees.
        OuterDegrees = "outer_degrees",
        /// The inner angle in radians.
        InnerRadians = "inner_radians",
        /// The outer angle in radians.
        OuterRadians = "outer_radians",
        /// 1 for a light, 0 for an empty slot.
        Enabled = "enabled",
    }

    const ALL;
    fn from_name;
}

named! {
    /// A property of a material.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum MaterialPart {
        /// The colour of ambient reflection.
        Ambient = "ambient",
        /// The colour of diffuse reflection.
        Diffuse = "diffuse",
        /// The colour of specular reflection.
        Specular = "specular",
        /// The exponent of the highlight.
        Shininess = "shininess",
        /// The factor or gate of the highlight in some models.
        Reflectance = "reflectance",
    }

    const ALL;
}

named! {
    /// A part of the light lists of tiles.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum TilePart {
        /// The side of a tile in pixels.
        Size = "size",
        /// The tiles in a row.
        Columns = "columns",
        /// The start of each tile's list of point lights.
        First = "first",
        /// The length of each tile's list of point lights.
        Count = "count",
        /// The start of each tile's list of spotlights.
        SpotFirst = "spot_first",
        /// The length of each tile's list of spotlights.
        SpotCount = "spot_count",
        /// The directional lights of each tile: bit `n` for light `n`, up to 32.
        DirectionalMask = "directional_mask",
        /// The lists: indices of point lights and of spotlights.
        Index = "index",
        /// The height of the picture in pixels.
        Height = "height",
    }

    const ALL;
}

impl TilePart {
    /// Whether it has a value for each tile, or for each index.
    fn is_each(self) -> bool {
        match self {
            TilePart::First
            | TilePart::Count
            | TilePart::SpotFirst
            | TilePart::SpotCount
            | TilePart::DirectionalMask
            | TilePart::Index => true,
            TilePart::Size | TilePart::Columns | TilePart::Height => false,
        }
    }

    /// Returns the kind of light whose lists it is a part of.
    pub(crate) fn kind(self) -> Option<Kind> {
        match self {
            TilePart::First | TilePart::Count => Some(Kind::Point),
            TilePart::SpotFirst | TilePart::SpotCount => Some(Kind::Spot),
            TilePart::DirectionalMask => Some(Kind::Directional),
            TilePart::Index | TilePart::Size | TilePart::Columns | TilePart::Height => None,
        }
    }
}

impl Kind {
    /// Whether lights of this kind have that property.
    pub fn takes(self, part: LightPart) -> bool {
        use LightPart::*;
        match part {
            Color | Intensity | Radiance | Ambient | Diffuse | Specular | Enabled => true,
            Direction => self != Kind::Point,
            Position | Constant | Linear | Quadratic | Attenuation => self != Kind::Directional,
            Range | RangeSquared | InverseRange | InverseRangeSquared => self != Kind::Directional,
            InnerCos | OuterCos | InnerDegrees | OuterDegrees | InnerRadians | OuterRadians => {
                self == Kind::Spot
            }
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Quantity::Camera => f.write_str("camera.position"),
            Quantity::Ambient(part) => write!(f, "ambient.{}", part.name()),
            Quantity::Light { kind, slot: Slot::Each, part } => {
                write!(f, "{}[].{}", kind.name(), part.name())
            }
            Quantity::Light { kind, slot: Slot::One(number), part } => {
                write!(f, "{}[{number}].{}", kind.name(), part.name())
            }
            Quantity::Count(kind) => write!(f, "{}.count", kind.name()),
            Quantity::Material(part) => write!(f, "material.{}", part.name()),
            Quantity::Tiles(part) => match part {
                TilePart::Index => f.write_str("tiles.index[]"),
                part if part.is_each() => write!(f, "tiles[].{}", part.name()),
                part => write!(f, "tiles.{}", part.name()),
            },
            Quantity::Position => f.write_str("position"),
            Quantity::Normal => f.write_str("normal"),
            Quantity::Uv => f.write_str("uv"),
            Quantity::Pixel => f.write_str("pixel"),
        }
    }
}

impl Quantity {
    /// Returns the quantity with that name.
    pub fn parse(word: &str) -> Option<Quantity> {
        // Names without an index are compared whole; `point[2].color` is taken apart.
        if let Some(found) = Quantity::fixed().into_iter().find(|q| q.to_string() == word) {
            return Some(found);
        }
        let (light, part) = word.split_once("].")?;
        let (kind, number) = light.split_once('[')?;
        let kind = Kind::from_name(kind)?;
        let part = LightPart::from_name(part)?;
        let slot = match number {
            "" => Slot::Each,
            number => Slot::One(number.parse().ok()?),
        };
        kind.takes(part).then_some(Quantity::Light { kind, slot, part })
    }

    /// Returns all names without an index, those of lights with `[]`.
    pub fn names() -> Vec<String> {
        let lights = Kind::ALL.into_iter().flat_map(|kind| {
            let parts = LightPart::ALL.into_iter().filter(move |part| kind.takes(*part));
            parts.map(move |part| Quantity::Light { kind, slot: Slot::Each, part })
        });
        Quantity::fixed().into_iter().chain(lights).map(|q| q.to_string()).collect()
    }

    fn fixed() -> Vec<Quantity> {
        let ambient = [LightPart::Color, LightPart::Intensity, LightPart::Radiance];
        let mut all = vec![Quantity::Camera];
        all.extend(ambient.map(Quantity::Ambient));
        all.extend(Kind::ALL.map(Quantity::Count));
        all.extend(MaterialPart::ALL.map(Quantity::Material));
        all.extend(TilePart::ALL.map(Quantity::Tiles));
        all.extend([Quantity::Position, Quantity::Normal, Quantity::Uv, Quantity::Pixel]);
        all
    }

    /// Whether it has a value for each element of an array.
    pub fn is_each(self) -> bool {
        match self {
            Quantity::Light { slot, .. } => slot == Slot::Each,
            Quantity::Tiles(part) => part.is_each(),
            Quantity::Camera
            | Quantity::Ambient(_)
            | Quantity::Count(_)
            | Quantity::Material(_)
            | Quantity::Position
            | Quantity::Normal
            | Quantity::Uv
            | Quantity::Pixel => false,
        }
    }

    /// Whether it belongs to the fragment, and so only to inputs.
    pub fn is_of_fragment(self) -> bool {
        matches!(self, Quantity::Position | Quantity::Normal | Quantity::Uv | Quantity::Pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_read_as_what_it_names() {
        for name in Quantity::names() {
            let read = Quantity::parse(&name).unwrap_or_else(|| panic!("{name}"));
            assert_eq!(read.to_string(), name);
        }
        let one = Quantity::parse("spot[3].outer_cos").map(|q| q.to_string());
        assert_eq!(one.as_deref(), Some("spot[3].outer_cos"));
        for wrong in ["point[].direction", "point[-1].color", "points[].color", "point.color", ""] {
            assert_eq!(Quantity::parse(wrong), None, "{wrong}");
        }
    }
}
