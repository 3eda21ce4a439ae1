//! Lights a frame: with all lights, or by a plan.

use std::borrow::Cow;

use glam::Vec3;

use super::wide::{WideBatch, common_power};
use super::{Gates, Lights, Model, Surface, Tally, TermColors, robust, seed};
use crate::Upload;
use crate::plan::{LightSet, Plan};

/// The arithmetic of light evaluations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// The form of the published shaders.
    Seed,
    /// The more accurate and faster form.
    Robust(Gates),
}

/// The colours of fragments, in their order, and the counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shaded<T> {
    /// The linear red, green and blue of each fragment.
    pub colors: Vec<Vec3>,
    pub tally: T,
}

pub fn shade_all<T: Tally + Default>(
    surfaces: &[Surface],
    eye: Vec3,
    lights: &Lights,
    model: &Model,
    form: Form,
) -> Shaded<T> {
    let mut tally = T::default();
    let colors = match form {
        Form::Seed => {
            surfaces.iter().map(|s| seed::shade(s, eye, lights, model, &mut tally)).collect()
        }
        Form::Robust(gates) => surfaces
            .iter()
            .map(|s| robust::shade(s, eye, lights, model, gates, &mut tally))
            .collect(),
    };
    Shaded { colors, tally }
}

/// Lights the fragments by a plan; `surfaces` are those of the frame it was made for.
///
/// Fragments in no draw stay black. Without counts the robust form lights several fragments at
/// once.
pub fn execute<T: Tally + Default>(
    plan: &Plan,
    upload: &Upload,
    surfaces: &[Surface],
    model: &Model,
    form: Form,
) -> Shaded<T> {
    // Counting needs a branch for each light and fragment; without it lanes are lit together.
    if let (Form::Robust(gates), false) = (form, T::COUNTS) {
        let colors = several(plan, upload, surfaces, model, gates);
        return Shaded { colors, tally: T::default() };
    }
    let (all, eye) = (Lights::new(upload, model), upload.camera.as_vec3());
    // The vectors of `some` are filled again for each draw, without an allocation.
    let (mut tally, mut some) = (T::default(), Lights::default());
    let colors = each(plan, surfaces, |numbers, set, colors| {
        all.select(set, &mut some);
        for &number in numbers {
            let surface = &surfaces[number as usize];
            colors[number as usize] = match form {
                Form::Seed => seed::shade(surface, eye, &some, model, &mut tally),
                Form::Robust(gates) => robust::shade(surface, eye, &some, model, gates, &mut tally),
            };
        }
    });
    Shaded { colors, tally }
}

/// Lights the fragments by a plan, several at once.
fn several(
    plan: &Plan,
    upload: &Upload,
    surfaces: &[Surface],
    model: &Model,
    gates: Gates,
) -> Vec<Vec3> {
    let (lights, eye) = (&Lights::new(upload, model), upload.camera.as_vec3());
    let all_finite = lights.emissions().all(TermColors::is_finite);
    let power = common_power(surfaces);
    // The wide form multiplies by 0 where `robust` skips; an infinite colour would make that NaN.
    each(plan, surfaces, |numbers, set, colors| {
        let finite = all_finite || lights.are_finite(set);
        WideBatch { surfaces, power, numbers, eye, lights, set, finite, model, gates }
            .shade(colors);
    })
}

/// Lights the fragments of the draws of a plan by `light`, which gets their indices and the lights;
/// returns the colours of all fragments.
fn each(
    plan: &Plan,
    surfaces: &[Surface],
    mut light: impl FnMut(&[u32], &LightSet, &mut [Vec3]),
) -> Vec<Vec3> {
    let mut colors = vec![Vec3::ZERO; surfaces.len()];
    for draw in &plan.draws {
        // A plan of another frame may number fragments that these surfaces lack: they are left
        // out.
        let is_known = |number: &u32| (*number as usize) < surfaces.len();
        let numbers = match draw.fragments.iter().all(is_known) {
            true => Cow::Borrowed(&draw.fragments[..]),
            false => draw.fragments.iter().copied().filter(is_known).collect(),
        };
        light(&numbers, &draw.lights, &mut colors);
    }
    colors
}
