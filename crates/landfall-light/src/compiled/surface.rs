//! A fragment with what its material says there: read by both forms.

use glam::Vec3;

use super::{AmbientTerm, Model, Terms};
use crate::sample::{Texels, texels};
use crate::scene::Material;
use crate::{Fragment, Frame, Upload};

/// What is lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Where it is.
    pub position: Vec3,
    /// Its normal, of any length.
    pub normal: Vec3,
    /// What it reflects of the scene's one ambient light.
    pub ambient: Vec3,
    /// What it reflects of each light's ambient and diffuse terms.
    pub diffuse: Vec3,
    /// What it reflects in highlights.
    pub specular: Vec3,
    /// The power of the highlight, as uploaded.
    pub shininess: f32,
    /// How the robust form raises it.
    pub power: Power,
    /// Where the base of the power gives less than a gate lets pass; 0 without gate.
    pub gate: f32,
}

/// How a power is raised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Power {
    /// By that many squarings: a power of two up to 256.
    Squarings(u32),
    /// By squarings and products: another whole number up to 256.
    Whole(u32),
    /// From the chord of the angle, `exp(n log1p(-m))`, which keeps what a cosine near 1 loses.
    Chord,
}

impl Power {
    /// How that exponent is raised.
    pub fn of(shininess: f32) -> Power {
        if !(1.0..=256.0).contains(&shininess) || shininess.fract() != 0.0 {
            return Power::Chord;
        }
        let whole = shininess as u32;
        if whole.is_power_of_two() {
            Power::Squarings(whole.trailing_zeros())
        } else {
            Power::Whole(whole)
        }
    }
}

/// The fragments of a frame with their materials, for a gate that lets pass powers of at least
/// `least`; 0 for no gate.
pub fn surfaces(frame: &Frame, upload: &Upload, model: &Model, least: f64) -> Vec<Surface> {
    let shininess = |m: &Material| model.shininess.map_or(m.shininess, f64::from);
    let gates: Vec<f32> = upload.materials.iter().map(|m| gate(shininess(m), least)).collect();
    let at = |fragment: &Fragment| {
        let gate = gates.get(fragment.material as usize).copied().unwrap_or(0.0);
        Surface { gate, ..surface(fragment, upload, model) }
    };
    frame.fragments.iter().map(at).collect()
}

/// One fragment with its material, without gate; black where there is no such material.
pub fn surface(fragment: &Fragment, upload: &Upload, model: &Model) -> Surface {
    let black = Surface {
        position: Vec3::from(fragment.position),
        normal: Vec3::from(fragment.normal),
        ambient: Vec3::ZERO,
        diffuse: Vec3::ZERO,
        specular: Vec3::ZERO,
        shininess: 1.0,
        power: Power::Squarings(0),
        gate: 0.0,
    };
    let Some(material) = upload.materials.get(fragment.material as usize) else { return black };
    let Texels { ambient, diffuse, specular } = texels(material, fragment.uv);
    let shininess = model.shininess.map_or(material.shininess as f32, f32::from);
    let specular = match model.terms {
        Terms::Three | Terms::Single => specular,
        Terms::PlainSpecular => specular.x * diffuse,
    };
    let own = model.ambient == AmbientTerm::OnceOfItsOwn;
    Surface {
        ambient: if own { ambient } else { diffuse }.as_vec3(),
        diffuse: diffuse.as_vec3(),
        specular: (specular * model.reflected(material.reflectance)).as_vec3(),
        shininess,
        power: Power::of(shininess),
        ..black
    }
}

/// The base below which `base^n` is less than `least`.
fn gate(shininess: f64, least: f64) -> f32 {
    if least > 0.0 && shininess > 0.0 { least.powf(1.0 / shininess) as f32 } else { 0.0 }
}
