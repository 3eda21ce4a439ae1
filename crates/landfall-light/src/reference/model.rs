//! Lighting models: a family of shaders and the variations within it.
//!
//! Written in a scene as `"multi"`, or as `{"family": "multi", "highlight": "blinn"}`; omitted
//! properties are those of the family. [`light`](super::light) depends on nothing else.

use std::fmt;

use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde::{Deserialize as Derive, Serialize};

/// The families of lighting models in the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// Directional, point and spot lights with three colours each; all terms of a light are
    /// attenuated together (M1).
    Multi,
    /// Arrays of lights with one colour and an intensity, and one ambient light (M2).
    Array,
    /// Like `Array`, with a cone of one angle, colours of the material, and the exponent 10 (M3).
    ViewSpace,
    /// One light at a time with three colours, whose cone does not affect its ambient term (M4).
    Casters,
}

/// The normal at which highlights mirror.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Normal {
    Unit,
    /// The interpolated normal, which dulls or amplifies highlights.
    AsInterpolated,
}

/// The source of ambient light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AmbientTerm {
    #[default]
    PerLight,
    Once,
    None,
}

/// The condition for a highlight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SpecularGate {
    /// None: also from behind the surface.
    #[default]
    None,
    Facing,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Highlight {
    /// A power of the cosine between the view and the mirrored light.
    Phong,
    /// A power of the cosine between the normal and the half vector.
    Blinn,
}

/// The window that ends a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Window {
    /// None; ranges are ignored.
    None,
    /// `(1 - (d / range)^4)^2`, which ends lights at their range.
    Quartic,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ConeEdge {
    /// Linear in the cosine from the outer angle to the inner, or to the axis.
    Soft,
    /// Full intensity inside the inner angle, none outside.
    Hard,
}

/// The numbers a cone is computed from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ConeNumbers {
    /// The uploaded cosines, with their rounding.
    Cosines,
    /// The angles in degrees, where the scene gives any.
    Angles,
}

/// The terms that a caster's attenuation affects; for point lights it affects all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CasterAttenuation {
    None,
    /// Diffuse and specular.
    Direct,
    All,
}

/// The colour of a highlight of the `array` family.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ArraySpecular {
    /// Colour, intensity and the specular texel.
    Fixed,
    /// As first published: colour, the specular texel's red and the diffuse texel.
    AsPublished,
}

/// The effect of a material's reflectance on the highlight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reflectance {
    /// None.
    #[default]
    Ignored,
    /// No highlight where it is not above zero.
    Gate,
    Factor,
}

impl Reflectance {
    /// Returns the factor of a highlight.
    pub fn factor(self, reflectance: f64) -> f64 {
        match self {
            Reflectance::Ignored => 1.0,
            Reflectance::Gate if reflectance > 0.0 => 1.0,
            Reflectance::Gate => 0.0,
            Reflectance::Factor => reflectance,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Power {
    Material,
    Ten,
}

/// The transform of a vertex's normal to view space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Derive, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NormalTransform {
    /// By the inverse transpose of the 3 by 3 part, normalised.
    Mat3,
    /// By that of the whole matrix, normalised with four components: as first published, and wrong
    /// wherever the camera is away from the origin.
    Vec4,
}

macro_rules! model {
    ($($(#[$doc:meta])* $name:ident: $ty:ty,)*) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
        pub struct Model {
            pub family: Family,
            $($(#[$doc])* pub $name: $ty,)*
        }

        #[derive(Derive)]
        #[serde(deny_unknown_fields)]
        struct Written {
            family: Family,
            $($name: Option<$ty>,)*
        }

        impl From<Written> for Model {
            fn from(written: Written) -> Model {
                let mut model = Model::new(written.family);
                // As first published, the shaders of the array family do not normalise: the
                // written properties follow and may say otherwise.
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
    normal: Normal,
    ambient: AmbientTerm,
    specular_gate: SpecularGate,
    highlight: Highlight,
    window: Window,
    cone_edge: ConeEdge,
    cone_numbers: ConeNumbers,
    /// The terms that the attenuation of a spotlight of `casters` affects.
    caster_attenuation: CasterAttenuation,
    /// The colour of highlights of `array`; `as_published` sets `normal` to interpolated by
    /// default.
    array_specular: ArraySpecular,
    reflectance: Reflectance,
    power: Power,
    /// The transform of the frame's normals, which lighting takes as they are.
    normal_transform: NormalTransform,
}

impl Model {
    /// Returns the model of a family, as in Landfall's own shaders.
    pub fn new(family: Family) -> Model {
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
        Model::new(Family::Multi)
    }
}

impl<'de> Deserialize<'de> for Model {
    /// Parses the name of a family, or a map with `family` and the properties that differ.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Model, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = Model;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("the name of a lighting model, or a map whose `family` names it")
            }
            fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<Model, E> {
                Family::deserialize(StrDeserializer::new(name)).map(Model::new)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Model, A::Error> {
                Written::deserialize(MapAccessDeserializer::new(map)).map(Model::from)
            }
        }
        deserializer.deserialize_any(Either)
    }
}
