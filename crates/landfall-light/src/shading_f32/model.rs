//! The switches of a lighting model, for the arithmetic here and the bounds of
//! [`culling`](crate::culling).

use glam::DVec3;

use crate::reference;
use crate::scene;

/// The switches of a model of ambient, diffuse and Phong specular terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Model {
    /// Whether a light with a range ends there, by the factor `(1 - (d / range)^4)^2`.
    pub windowed: bool,
    pub specular: SpecularTerm,
    pub ambient: AmbientTerm,
    pub terms: Terms,
    pub cone: ConeTerm,
    /// The effect of a material's reflectance on the highlight.
    pub reflectance: ReflectanceTerm,
    /// The exponent of highlights, if not the material's.
    pub shininess: Option<u16>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum SpecularTerm {
    /// None, also behind the surface, as in the published shaders.
    #[default]
    Everywhere,
    /// The surface faces the light, `n . l > 0`.
    Facing,
}

/// The source of ambient light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum AmbientTerm {
    /// Each light, attenuated like its other terms, also by its cone.
    #[default]
    PerLight,
    /// The scene's ambient light, reflected like diffuse light.
    Once,
    /// The scene's ambient light, reflected by the material's own ambient colour.
    OnceOfItsOwn,
    /// None.
    Absent,
}

/// The colours of a light's terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Terms {
    /// One for each term.
    #[default]
    Three,
    /// The single colour times its intensity, for diffuse and specular.
    Single,
    /// As `Single`, but the specular term is the colour without the intensity times the specular
    /// texel's red and the diffuse texel.
    PlainSpecular,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ConeTerm {
    /// Linear in the cosine from the outer angle to the inner.
    #[default]
    Ramp,
    /// Linear from the outer angle to the axis.
    ToAxis,
    /// Full intensity inside the inner angle, none outside.
    Hard,
}

/// The effect of a material's reflectance on the highlight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ReflectanceTerm {
    /// None.
    #[default]
    Ignored,
    /// No highlight where it is not above zero.
    Gate,
    Factor,
}

impl Model {
    /// Returns the switches of a reference model.
    ///
    /// # Errors
    /// The reason there is neither a bound nor a compiled form of it.
    pub fn new(model: &reference::Model) -> Result<Model, &'static str> {
        // Each refusal is a term whose upper bound is not known, or which the kernels cannot
        // compute.
        use reference::{
            AmbientTerm as Ambient, ArraySpecular, ConeEdge, Family, Highlight, Normal, Power,
            Reflectance, SpecularGate, Window,
        };
        if model.normal == Normal::AsInterpolated {
            return Err(
                "a highlight mirrored at a normal that is not normalised has no upper bound",
            );
        }
        if model.highlight == Highlight::Blinn {
            return Err("the compiled kernels have no Blinn-Phong highlights");
        }
        let single = match model.array_specular {
            ArraySpecular::Fixed => Terms::Single,
            ArraySpecular::AsPublished => Terms::PlainSpecular,
        };
        let (terms, to_axis) = match model.family {
            Family::Multi => (Terms::Three, false),
            // The published shaders of this family have one colour; `AsPublished` concerns only
            // their highlight.
            Family::Array => (single, false),
            Family::ViewSpace => (Terms::Single, true),
            Family::Casters => {
                return Err("the model `casters` has one light, which cannot be skipped");
            }
        };
        Ok(Model {
            windowed: model.window == Window::Quartic,
            specular: match model.specular_gate {
                SpecularGate::None => SpecularTerm::Everywhere,
                SpecularGate::Facing => SpecularTerm::Facing,
            },
            ambient: match model.ambient {
                Ambient::PerLight => AmbientTerm::PerLight,
                Ambient::Once if to_axis => AmbientTerm::OnceOfItsOwn,
                Ambient::Once => AmbientTerm::Once,
                Ambient::None => AmbientTerm::Absent,
            },
            terms,
            cone: match model.cone_edge {
                ConeEdge::Hard => ConeTerm::Hard,
                ConeEdge::Soft if to_axis => ConeTerm::ToAxis,
                ConeEdge::Soft => ConeTerm::Ramp,
            },
            reflectance: match model.reflectance {
                Reflectance::Ignored => ReflectanceTerm::Ignored,
                Reflectance::Gate => ReflectanceTerm::Gate,
                Reflectance::Factor => ReflectanceTerm::Factor,
            },
            shininess: match model.power {
                Power::Material => None,
                Power::Ten => Some(10),
            },
        })
    }

    /// Returns the colours of the ambient, diffuse and specular terms of a light.
    pub fn colors(&self, emission: &scene::Emission) -> [DVec3; 3] {
        let single = emission.color * emission.intensity;
        let [diffuse, specular] = match self.terms {
            Terms::Three => [emission.diffuse, emission.specular],
            Terms::Single => [single, single],
            Terms::PlainSpecular => [single, emission.color],
        };
        let ambient = match self.ambient {
            AmbientTerm::PerLight => emission.ambient,
            AmbientTerm::Once | AmbientTerm::OnceOfItsOwn | AmbientTerm::Absent => DVec3::ZERO,
        };
        [ambient, diffuse, specular]
    }

    /// Whether the scene's ambient light counts.
    pub fn counts_ambient(&self) -> bool {
        match self.ambient {
            AmbientTerm::Once | AmbientTerm::OnceOfItsOwn => true,
            AmbientTerm::PerLight | AmbientTerm::Absent => false,
        }
    }

    /// Returns the factor of a highlight for a reflectance.
    pub fn reflected(&self, reflectance: f64) -> f64 {
        match self.reflectance {
            ReflectanceTerm::Ignored => 1.0,
            ReflectanceTerm::Gate if reflectance > 0.0 => 1.0,
            ReflectanceTerm::Gate => 0.0,
            ReflectanceTerm::Factor => reflectance,
        }
    }
}
