//! Which switches of the lighting model are on: what both the arithmetic and the bounds of
//! [`skip`](crate::skip) depend on.

use glam::DVec3;

use crate::reference;
use crate::scene;

/// The switches of a model of ambient, diffuse and Phong specular terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Model {
    /// Whether a light with a range ends there, weighed by `(1 - (d / range)^4)^2`.
    pub windowed: bool,
    /// Where the specular term is counted.
    pub specular: SpecularTerm,
    /// Where ambient light comes from.
    pub ambient: AmbientTerm,
    /// Which colours of a light its terms take.
    pub terms: Terms,
    /// What a cone's edge is like.
    pub cone: ConeTerm,
    /// What a highlight is multiplied with for the material's reflectance.
    pub reflectance: ReflectanceTerm,
    /// The power of highlights, if not the material's.
    pub shininess: Option<u16>,
}

/// Where the specular term is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum SpecularTerm {
    /// Everywhere, lights behind the surface too, as the published shaders do.
    #[default]
    Everywhere,
    /// Where the surface faces the light, `n . l > 0`.
    Facing,
}

/// Where ambient light comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum AmbientTerm {
    /// From each light, weakened as its other terms are, by its cone too.
    #[default]
    PerLight,
    /// From the scene's one ambient light, reflected as diffuse light is.
    Once,
    /// From the same, reflected by the material's own ambient colour.
    OnceOfItsOwn,
    /// From nowhere.
    Absent,
}

/// Which colours of a light its terms take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Terms {
    /// One for each term.
    #[default]
    Three,
    /// The one colour times its intensity, for diffuse and specular.
    Single,
    /// As `Single`, but the specular term takes the colour without the intensity, the specular
    /// texel's red and the diffuse texel.
    PlainSpecular,
}

/// What a cone's edge is like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ConeTerm {
    /// Linear in the cosine from the outer angle to the inner.
    #[default]
    Ramp,
    /// Linear from the outer angle to the axis.
    ToAxis,
    /// Whole inside the inner angle, nothing outside.
    Hard,
}

/// What a highlight is multiplied with for the material's reflectance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ReflectanceTerm {
    /// Nothing.
    #[default]
    Ignored,
    /// Zero where it is not above zero.
    Gate,
    /// Itself.
    Factor,
}

impl Model {
    /// The switches of a reference model.
    ///
    /// # Errors
    /// Why there is neither a bound for it nor a compiled form of it.
    pub fn of(model: &reference::Model) -> Result<Model, &'static str> {
        use reference::{
            AmbientTerm as Ambient, ArraySpecular, ConeEdge, Family, Highlight, Normal, Power,
            Reflectance, SpecularGate, Window,
        };
        if model.normal == Normal::AsInterpolated {
            return Err("a highlight mirrored at a normal as interpolated has no upper bound");
        }
        if model.highlight == Highlight::Blinn {
            return Err("highlights of half vectors are not compiled");
        }
        let single = match model.array_specular {
            ArraySpecular::Fixed => Terms::Single,
            ArraySpecular::AsPublished => Terms::PlainSpecular,
        };
        let (terms, to_axis) = match model.family {
            Family::Multi => (Terms::Three, false),
            Family::Array => (single, false),
            Family::ViewSpace => (Terms::Single, true),
            Family::Casters => return Err("a single caster has nothing to skip"),
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

    /// The colours of the ambient, diffuse and specular terms of a light.
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

    /// Whether the scene's one ambient light is counted.
    pub fn counts_ambient(&self) -> bool {
        match self.ambient {
            AmbientTerm::Once | AmbientTerm::OnceOfItsOwn => true,
            AmbientTerm::PerLight | AmbientTerm::Absent => false,
        }
    }

    /// What a highlight is multiplied with where a material has that reflectance.
    pub fn reflected(&self, reflectance: f64) -> f64 {
        match self.reflectance {
            ReflectanceTerm::Ignored => 1.0,
            ReflectanceTerm::Gate if reflectance > 0.0 => 1.0,
            ReflectanceTerm::Gate => 0.0,
            ReflectanceTerm::Factor => reflectance,
        }
    }
}
