//! Which lighting is computed: a family of shaders and where it may differ from its kin.
//!
//! Written in a scene as `"multi"`, or as `{"family": "multi", "highlight": "blinn"}`; what is
//! not said is as the family has it. [`light`](super::light) reads nothing else.

use std::fmt;

use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde::{Deserialize as Derive, Serialize};

/// The four ways of lighting a fragment that the reference knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// Suns, lamps and flashlights with three colours each; all of a light's terms weaken
    /// together (M1).
    Multi,
    /// Arrays of lights with one colour and an intensity, and one ambient light (M2).
    Array,
    /// The same with a cone of one angle, a material of its own colours, and the power 10 (M3).
    ViewSpace,
    /// One light at a time with three colours, whose cone does not cut its ambient term (M4).
    Casters,
}

/// What a highlight's mirror is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Normal {
    /// The normal at unit length.
    Unit,
    /// The normal as it was interpolated, which dulls or blows up highlights.
    AsInterpolated,
}

/// Where ambient light comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AmbientTerm {
    /// From each light.
    PerLight,
    /// From the one ambient light.
    Once,
    /// From nowhere.
    None,
}

/// When a light has a highlight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SpecularGate {
    /// Always, even from behind the surface.
    None,
    /// Only where the surface faces the light.
    Facing,
}

/// The shape of a highlight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Highlight {
    /// A power of the cosine between the view and the mirrored light.
    Phong,
    /// A power of the cosine between the normal and the half vector.
    Blinn,
}

/// Whether lights end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Window {
    /// Never; ranges are ignored.
    None,
    /// At their range, by `(1 - (d / range)^4)^2`.
    Quartic,
}

/// What a cone's edge is like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ConeEdge {
    /// Linear in the cosine from the outer angle to the inner, or to the axis.
    Soft,
    /// Whole inside the inner angle, nothing outside.
    Hard,
}

/// Which numbers a cone is computed from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ConeNumbers {
    /// The cosines as uploaded, with their rounding.
    Cosines,
    /// The angles in degrees, where the scene gave any.
    Angles,
}

/// What a caster's attenuation weakens, outside of point lights, whose every term it weakens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CasterAttenuation {
    /// Nothing.
    None,
    /// What the light sends straight: diffuse and specular.
    Direct,
    /// Everything.
    All,
}

/// What a highlight of the `array` family is coloured with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ArraySpecular {
    /// Colour, intensity and the specular texel.
    Fixed,
    /// As first published: colour, the specular texel's red and the diffuse texel.
    AsPublished,
}

/// What a material's reflectance does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reflectance {
    /// Nothing.
    Ignored,
    /// No highlight where it is not above zero.
    Gate,
    /// The highlight is multiplied with it.
    Factor,
}

/// The power of a highlight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Power {
    /// The material's shininess.
    Material,
    /// Ten.
    Ten,
}

/// How a vertex's normal comes to view space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NormalTransform {
    /// By the inverse transpose of the 3 by 3 part, to unit length.
    Mat3,
    /// By that of the whole matrix, its four components to unit length together: as first
    /// published, and wrong wherever the camera is away from the origin.
    Vec4,
}

macro_rules! model {
    ($($(#[$doc:meta])* $name:ident: $ty:ty,)*) => {
        /// Everything in which lighting may differ.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
        pub struct Model {
            /// The family.
            pub family: Family,
            $($(#[$doc])* pub $name: $ty,)*
        }

        /// A model as written.
        #[derive(Derive)]
        #[serde(deny_unknown_fields)]
        struct Written {
            family: Family,
            $($name: Option<$ty>,)*
        }

        impl From<Written> for Model {
            fn from(written: Written) -> Model {
                let mut model = Model::of(written.family);
                if written.array_specular == Some(ArraySpecular::AsPublished) {
                    model.normal = Normal::AsInterpolated;
                }
                $(if let Some(value) = written.$name {
                    model.$name = value;
                })*
                model
            }
        }
    };
}

model! {
    /// What highlights mirror at.
    normal: Normal,
    /// Where ambient light comes from.
    ambient: AmbientTerm,
    /// When a light has a highlight.
    specular_gate: SpecularGate,
    /// The shape of highlights.
    highlight: Highlight,
    /// Whether lights end.
    window: Window,
    /// What cones' edges are like.
    cone_edge: ConeEdge,
    /// What cones are computed from.
    cone_numbers: ConeNumbers,
    /// What the attenuation of a spotlight of `casters` weakens.
    caster_attenuation: CasterAttenuation,
    /// Colour of highlights of `array`; as published, `normal` is as interpolated unless said.
    array_specular: ArraySpecular,
    /// What reflectance does.
    reflectance: Reflectance,
    /// The power of highlights.
    power: Power,
    /// What the frame's normals were made with: lighting takes them as they come.
    normal_transform: NormalTransform,
}

impl Model {
    /// A family as our own shaders have it.
    pub fn of(family: Family) -> Model {
        let model = Model {
            family,
            normal: Normal::Unit,
            ambient: AmbientTerm::PerLight,
            specular_gate: SpecularGate::None,
            highlight: Highlight::Phong,
            window: Window::None,
            cone_edge: ConeEdge::Soft,
            cone_numbers: ConeNumbers::Cosines,
            caster_attenuation: CasterAttenuation::Direct,
            array_specular: ArraySpecular::Fixed,
            reflectance: Reflectance::Ignored,
            power: Power::Material,
            normal_transform: NormalTransform::Mat3,
        };
        match family {
            Family::Multi | Family::Casters => model,
            Family::Array => Model { ambient: AmbientTerm::Once, ..model },
            Family::ViewSpace => Model {
                ambient: AmbientTerm::Once,
                reflectance: Reflectance::Gate,
                power: Power::Ten,
                ..model
            },
        }
    }
}

impl Default for Model {
    fn default() -> Model {
        Model::of(Family::Multi)
    }
}

impl<'de> Deserialize<'de> for Model {
    /// From the name of a family, or a map with `family` and what differs from it.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Model, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = Model;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("the name of a model's family, or a map with `family`")
            }
            fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<Model, E> {
                Family::deserialize(StrDeserializer::new(name)).map(Model::of)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Model, A::Error> {
                Written::deserialize(MapAccessDeserializer::new(map)).map(Model::from)
            }
        }
        deserializer.deserialize_any(Either)
    }
}
