//! Which switches of the lighting model are on: what both the arithmetic and the bounds of
//! [`skip`](crate::light::skip) depend on.

use glam::DVec3;

use crate::light::scene;

/// The switches of a model of ambient, diffuse and Phong specular terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Model {
    /// Whether a light with a range ends there, weighed by `(1 - (d / range)^4)^2`.
    pub windowed: bool,
    /// Where the specular term is counted.
    pub specular: SpecularTerm,
    /// What becomes of each light's own ambient term.
    pub ambient: AmbientTerm,
    /// Which colours of a light its terms take.
    pub terms: Terms,
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

/// What becomes of each light's own ambient term.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum AmbientTerm {
    /// Weakened as the light's other terms are, by its cone too.
    #[default]
    PerLight,
    /// Not counted: the scene has one ambient light.
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
    /// As `Single`, but the specular term takes the colour without the intensity.
    PlainSpecular,
}

impl Model {
    /// The colours of the ambient, diffuse and specular terms of a light.
    pub fn colors(&self, emission: &scene::Emission) -> [DVec3; 3] {
        let single = emission.color * emission.intensity;
        let [ambient, diffuse, specular] = match self.terms {
            Terms::Three => [emission.ambient, emission.diffuse, emission.specular],
            Terms::Single => [emission.ambient, single, single],
            Terms::PlainSpecular => [emission.ambient, single, emission.color],
        };
        match self.ambient {
            AmbientTerm::PerLight => [ambient, diffuse, specular],
            AmbientTerm::Absent => [DVec3::ZERO, diffuse, specular],
        }
    }
}
