//! A fragment with what its material says there: read by both forms.

use glam::{DVec3, Vec3};

use crate::light::scene::{self, Material};
use crate::light::{Fragment, Frame, Upload};

/// What is lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Where it is.
    pub position: Vec3,
    /// Its normal, of any length.
    pub normal: Vec3,
    /// What it reflects of ambient and diffuse light.
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
pub fn surfaces(frame: &Frame, upload: &Upload, least: f64) -> Vec<Surface> {
    let gates: Vec<f32> =
        upload.materials.iter().map(|material| gate(material.shininess, least)).collect();
    let at = |fragment: &Fragment| {
        let gate = gates.get(fragment.material as usize).copied().unwrap_or(0.0);
        Surface { gate, ..surface(fragment, upload, 0.0) }
    };
    frame.fragments.iter().map(at).collect()
}

/// One fragment with its material; black where there is no such material.
pub fn surface(fragment: &Fragment, upload: &Upload, least: f64) -> Surface {
    let material = upload.materials.get(fragment.material as usize);
    let color = |of: fn(&Material) -> &scene::Surface| {
        material.map_or(DVec3::ZERO, |m| sample(of(m), fragment.uv)).as_vec3()
    };
    let shininess = material.map_or(1.0, |m| m.shininess);
    Surface {
        position: Vec3::from(fragment.position),
        normal: Vec3::from(fragment.normal),
        diffuse: color(|m| &m.diffuse),
        specular: color(|m| &m.specular),
        shininess: shininess as f32,
        power: Power::of(shininess as f32),
        gate: gate(shininess, least),
    }
}

/// The colour of a surface there: the nearest texel, repeating.
pub fn sample(surface: &scene::Surface, uv: [f32; 2]) -> DVec3 {
    match surface {
        scene::Surface::Constant(color) => *color,
        scene::Surface::Texture(texture) => {
            let place = |at: f32, size: u32| {
                let cell = (f64::from(at).rem_euclid(1.0) * f64::from(size)).floor();
                (cell as usize).min((size as usize).saturating_sub(1))
            };
            let [x, y] = [place(uv[0], texture.width), place(uv[1], texture.height)];
            let texel = texture.texels.get(y * texture.width as usize + x);
            let [r, g, b] = texel.copied().unwrap_or_default().map(|byte| {
                let code = f64::from(byte) / 255.0;
                if texture.srgb { linear(code) } else { code }
            });
            DVec3::new(r, g, b)
        }
    }
}

/// The base below which `base^n` is less than `least`.
fn gate(shininess: f64, least: f64) -> f32 {
    if least > 0.0 && shininess > 0.0 { least.powf(1.0 / shininess) as f32 } else { 0.0 }
}

/// IEC 61966-2-1.
fn linear(code: f64) -> f64 {
    if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}
