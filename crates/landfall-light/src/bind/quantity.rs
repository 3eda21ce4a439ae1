//! The numbers of a scene by name: `camera.position`, `point[].color`, `material.shininess`.

use std::fmt;

/// A number of a scene, or a vector of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Where the camera is.
    Camera,
    /// Of the ambient light: its colour, its intensity, or the product.
    Ambient(LightPart),
    /// Of one light, or of each of a kind.
    Light {
        /// Its kind.
        kind: Kind,
        /// Which of the kind.
        slot: Slot,
        /// What of it.
        part: LightPart,
    },
    /// How many lights of a kind there are.
    Count(Kind),
    /// Of the material of the fragments.
    Material(MaterialPart),
    /// Of the lists of point lights by tiles of the picture.
    Tiles(TilePart),
    /// Where a fragment is.
    Position,
    /// Its normal, interpolated.
    Normal,
    /// Its texture coordinates.
    Uv,
    /// Where its pixel is, as `gl_FragCoord` says it.
    Pixel,
}

/// The kinds of lights a scene may have several of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Kind {
    Directional,
    Point,
    Spot,
}

/// Which light of a kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Slot {
    /// The one whose number is that of the array's element: `point[]`.
    Each,
    /// One by its number: `point[2]`.
    One(u32),
}

macro_rules! parts {
    ($(#[$doc:meta])* $name:ident { $($(#[$part_doc:meta])* $part:ident = $word:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name {
            $($(#[$part_doc])* $part,)*
        }

        impl $name {
            /// All of them.
            pub const ALL: &'static [$name] = &[$($name::$part,)*];

            /// As it is written behind the dot.
            pub fn word(self) -> &'static str {
                match self {
                    $($name::$part => $word,)*
                }
            }
        }
    };
}

parts! {
    /// What of a light.
    LightPart {
        /// Where it is.
        Position = "position",
        /// Where it travels.
        Direction = "direction",
        /// Its one colour.
        Color = "color",
        /// What the one colour is multiplied with.
        Intensity = "intensity",
        /// The product of the two.
        Radiance = "radiance",
        /// Colour of its ambient term.
        Ambient = "ambient",
        /// Colour of its diffuse term.
        Diffuse = "diffuse",
        /// Colour of its specular term.
        Specular = "specular",
        /// Attenuation per nothing.
        Constant = "constant",
        /// Attenuation per distance.
        Linear = "linear",
        /// Attenuation per distance squared.
        Quadratic = "quadratic",
        /// The three of them.
        Attenuation = "attenuation",
        /// Where it ends; 1e18 where it does not.
        Range = "range",
        /// Cosine of the angle inside which it is whole.
        InnerCos = "inner_cos",
        /// Cosine of the angle outside which there is none.
        OuterCos = "outer_cos",
        /// The first angle in degrees.
        InnerDegrees = "inner_degrees",
        /// The second.
        OuterDegrees = "outer_degrees",
        /// The first angle in radians.
        InnerRadians = "inner_radians",
        /// The second.
        OuterRadians = "outer_radians",
        /// 1 for a light, 0 for an empty slot.
        Enabled = "enabled",
    }
}

parts! {
    /// What of a material.
    MaterialPart {
        /// Colour of ambient reflection.
        Ambient = "ambient",
        /// Colour of diffuse reflection.
        Diffuse = "diffuse",
        /// Colour of specular reflection.
        Specular = "specular",
        /// The power of the highlight.
        Shininess = "shininess",
        /// What some models gate or multiply the highlight with.
        Reflectance = "reflectance",
    }
}

parts! {
    /// What of the lists of tiles.
    TilePart {
        /// Pixels along a tile's side.
        Size = "size",
        /// Tiles in a row.
        Columns = "columns",
        /// For each tile, its first place in the list.
        First = "first",
        /// For each tile, how many places.
        Count = "count",
        /// The list: numbers of point lights.
        Index = "index",
    }
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 3] = [Kind::Directional, Kind::Point, Kind::Spot];

    /// As it is written: `point`.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Directional => "directional",
            Kind::Point => "point",
            Kind::Spot => "spot",
        }
    }

    /// Whether a light of the kind has such a part.
    pub fn takes(self, part: LightPart) -> bool {
        use LightPart::*;
        match part {
            Color | Intensity | Radiance | Ambient | Diffuse | Specular | Enabled => true,
            Direction => self != Kind::Point,
            Position | Constant | Linear | Quadratic | Attenuation | Range => {
                self != Kind::Directional
            }
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
            Quantity::Ambient(part) => write!(f, "ambient.{}", part.word()),
            Quantity::Light { kind, slot: Slot::Each, part } => {
                write!(f, "{}[].{}", kind.name(), part.word())
            }
            Quantity::Light { kind, slot: Slot::One(number), part } => {
                write!(f, "{}[{number}].{}", kind.name(), part.word())
            }
            Quantity::Count(kind) => write!(f, "{}.count", kind.name()),
            Quantity::Material(part) => write!(f, "material.{}", part.word()),
            Quantity::Tiles(part) => match part {
                TilePart::Size | TilePart::Columns => write!(f, "tiles.{}", part.word()),
                TilePart::First | TilePart::Count => write!(f, "tiles[].{}", part.word()),
                TilePart::Index => f.write_str("tiles.index[]"),
            },
            Quantity::Position => f.write_str("position"),
            Quantity::Normal => f.write_str("normal"),
            Quantity::Uv => f.write_str("uv"),
            Quantity::Pixel => f.write_str("pixel"),
        }
    }
}

impl Quantity {
    /// The quantity of that name.
    pub fn parse(word: &str) -> Option<Quantity> {
        if let Some(found) = Quantity::fixed().into_iter().find(|q| q.to_string() == word) {
            return Some(found);
        }
        let (light, part) = word.split_once("].")?;
        let (kind, number) = light.split_once('[')?;
        let kind = Kind::ALL.into_iter().find(|k| k.name() == kind)?;
        let part = LightPart::ALL.iter().copied().find(|p| p.word() == part)?;
        let slot = match number {
            "" => Slot::Each,
            number => Slot::One(number.parse().ok()?),
        };
        kind.takes(part).then_some(Quantity::Light { kind, slot, part })
    }

    /// Every name without a number in it, those of lights with `[]`.
    pub fn names() -> Vec<String> {
        let lights = Kind::ALL.into_iter().flat_map(|kind| {
            let parts = LightPart::ALL.iter().copied().filter(move |part| kind.takes(*part));
            parts.map(move |part| Quantity::Light { kind, slot: Slot::Each, part })
        });
        Quantity::fixed().into_iter().chain(lights).map(|q| q.to_string()).collect()
    }

    fn fixed() -> Vec<Quantity> {
        let ambient = [LightPart::Color, LightPart::Intensity, LightPart::Radiance];
        let mut all = vec![Quantity::Camera];
        all.extend(ambient.map(Quantity::Ambient));
        all.extend(Kind::ALL.map(Quantity::Count));
        all.extend(MaterialPart::ALL.iter().copied().map(Quantity::Material));
        all.extend(TilePart::ALL.iter().copied().map(Quantity::Tiles));
        all.extend([Quantity::Position, Quantity::Normal, Quantity::Uv, Quantity::Pixel]);
        all
    }

    /// Whether it is one for each element of an array.
    pub fn is_each(self) -> bool {
        match self {
            Quantity::Light { slot, .. } => slot == Slot::Each,
            Quantity::Tiles(part) => match part {
                TilePart::First | TilePart::Count | TilePart::Index => true,
                TilePart::Size | TilePart::Columns => false,
            },
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

    /// Whether it is of the fragment, and so for inputs alone.
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
