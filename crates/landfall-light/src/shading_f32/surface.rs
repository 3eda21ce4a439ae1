//! A fragment with its material, for both forms.

use glam::Vec3;

use super::{Model, Terms};
use crate::sample::{Texels, texels};
use crate::scene::Material;
use crate::{Fragment, Frame, Upload};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    pub position: Vec3,
    /// The normal, of any length.
    pub normal: Vec3,
    /// The reflectance of the scene's ambient light.
    pub ambient: Vec3,
    /// The reflectance of each light's ambient and diffuse terms.
    pub diffuse: Vec3,
    /// The reflectance in highlights.
    pub specular: Vec3,
    /// The exponent of the highlight, as uploaded.
    pub shininess: f32,
    /// The evaluation of the power in the robust form.
    pub power: Power,
    /// The base below which the power is less than the gate; 0 without a gate.
    pub gate: f32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Power {
    /// By that many squarings: a power of two up to 256.
    Squarings(u32),
    /// By squarings and products: another integer up to 256.
    Whole(u32),
    /// From the chord of the angle, `exp(n log1p(-m))`, which is accurate for cosines near 1.
    Chord,
}

impl Power {
    /// Returns the evaluation for an exponent.
    pub fn new(shininess: f32) -> Power {
        // Fractions have no product form. Past 256 the error of `base` (2^-24) times the exponent
        // is past 2^-16.
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

/// Returns the surfaces of a frame for a gate that passes powers of at least `least`; 0 for no
/// gate.
pub fn surfaces(frame: &Frame, upload: &Upload, model: &Model, least: f64) -> Vec<Surface> {
    let shininess = |m: &Material| model.shininess.map_or(m.shininess, f64::from);
    let gates: Vec<f32> = upload.materials.iter().map(|m| gate(shininess(m), least)).collect();
    let at = |fragment: &Fragment| {
        let gate = gates.get(fragment.material as usize).copied().unwrap_or(0.0);
        Surface { gate, ..surface(fragment, upload, model) }
    };
    frame.fragments.iter().map(at).collect()
}

/// Returns the surface of one fragment, without a gate; black if there is no such material.
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
    Surface {
        ambient: if model.own_ambient { ambient } else { diffuse }.as_vec3(),
        diffuse: diffuse.as_vec3(),
        specular: (specular * model.reflectance.factor(material.reflectance)).as_vec3(),
        shininess,
        power: Power::new(shininess),
        ..black
    }
}

/// Returns the base below which `base^n` is less than `least`.
fn gate(shininess: f64, least: f64) -> f32 {
    // base^n < least where base < least^(1/n).
    if least > 0.0 && shininess > 0.0 { least.powf(1.0 / shininess) as f32 } else { 0.0 }
}
