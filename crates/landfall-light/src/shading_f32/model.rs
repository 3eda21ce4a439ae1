//! The switches of a lighting model, for the arithmetic here and the bounds of
//! [`culling`](crate::culling).

use glam::DVec3;

use crate::reference;
use crate::reference::{AmbientTerm, Reflectance, SpecularGate};
use crate::scene;

/// The switches of a model of ambient, diffuse and Phong specular terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Model {
    /// Whether a light with a range ends there, by the factor `(1 - (d / range)^4)^2`.
    pub windowed: bool,
    pub specular: SpecularGate,
    pub ambient: AmbientTerm,
    /// Whether the scene's ambient light is reflected by the material's own ambient colour, not
    /// like diffuse light.
    pub own_ambient: bool,
    pub terms: Terms,
    pub cone: ConeTerm,
    pub reflectance: Reflectance,
    /// The exponent of highlights, if not the material's.
    pub shininess: Option<u16>,
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

impl Model {
    /// Returns the switches of a reference model.
    ///
    /// # Errors
    /// The reason there is neither a bound nor a compiled form of it.
    pub fn new(model: &reference::Model) -> Result<Model, &'static str> {
        // Each refusal is a term whose upper bound is not known, or which the kernels cannot
        // compute.
        use reference::{ArraySpecular, ConeEdge, Family, Highlight, Normal, Power, Window};
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
            specular: model.specular_gate,
            ambient: model.ambient,
            own_ambient: model.family == Family::ViewSpace && model.ambient == AmbientTerm::Once,
            terms,
            cone: match model.cone_edge {
                ConeEdge::Hard => ConeTerm::Hard,
                ConeEdge::Soft if to_axis => ConeTerm::ToAxis,
                ConeEdge::Soft => ConeTerm::Ramp,
            },
            reflectance: model.reflectance,
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
            AmbientTerm::Once | AmbientTerm::None => DVec3::ZERO,
        };
        [ambient, diffuse, specular]
    }

    /// Whether the scene's ambient light counts.
    pub fn counts_ambient(&self) -> bool {
        self.ambient == AmbientTerm::Once
    }
}
