//! Lights a frame: with all lights, or by a plan.

use std::borrow::Cow;

use glam::Vec3;

use super::fused::{Fused, PlainLights};
use super::wide::{Batch, common_power};
use super::{Emission, Gates, Lights, Model, Power, Surface, Tally, robust, seed, surface};
use crate::plan::{Grid, Interpolation, LightSet, Plan};
use crate::{Fragment, Upload};

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
    /// The counts.
    pub tally: T,
}

/// Lights every fragment with every light.
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
/// Fragments in no draw stay black. Without counts the robust form lights several fragments at once, and
/// by a plan with grids, whose result is not exact anyway, plain point lights with fused operations.
pub fn execute<T: Tally + Default>(
    plan: &Plan,
    upload: &Upload,
    surfaces: &[Surface],
    model: &Model,
    form: Form,
) -> Shaded<T> {
    if let (Form::Robust(gates), false) = (form, T::COUNTS) {
        let colors = several(plan, upload, surfaces, model, gates);
        return Shaded { colors, tally: T::default() };
    }
    let (all, eye) = (Lights::new(upload, model), upload.camera.as_vec3());
    let (mut tally, mut some) = (T::default(), Lights::default());
    let colors = each(plan, upload, (surfaces, model), |surfaces, _, numbers, set, colors| {
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
    let all_finite = lights.emissions().all(Emission::is_finite);
    let plain = (!plan.grids.is_empty()).then(|| PlainLights::new(lights));
    each(plan, upload, (surfaces, model), |surfaces, power, numbers, set, colors| {
        let finite = all_finite || lights.are_finite(set);
        let batch = Batch { surfaces, power, numbers, eye, lights, set, finite, model, gates };
        match plain.as_ref().and_then(|plain| Fused::of(&batch, plain)) {
            Some(fused) => {
                let numbers = &*fused.shade(colors);
                Batch { numbers, ..batch }.shade(colors);
            }
            None => batch.shade(colors),
        }
    })
}

/// Lights the nodes of all grids of a plan and the fragments of its draws by `light`, which gets
/// surfaces, the evaluation of their power if it is that of all, the indices of those to be lit, and
/// the lights; returns the colours of the fragments.
fn each(
    plan: &Plan,
    upload: &Upload,
    (surfaces, model): (&[Surface], &Model),
    mut light: impl FnMut(&[Surface], Option<Power>, &[u32], &LightSet, &mut [Vec3]),
) -> Vec<Vec3> {
    let mut at_nodes = |grid: &Grid| {
        let Some(first) = grid.nodes.first() else { return Vec::new() };
        // Nodes differ in their places alone.
        let first = surface(first, upload, model);
        let node = |node: &Fragment| Surface { position: Vec3::from(node.position), ..first };
        let nodes: Vec<Surface> = grid.nodes.iter().map(node).collect();
        let numbers: Vec<u32> = (0..nodes.len() as u32).collect();
        let mut colors = vec![Vec3::ZERO; nodes.len()];
        light(&nodes, Some(first.power), &numbers, &grid.lights, &mut colors);
        colors
    };
    let nodes: Vec<Vec<Vec3>> = plan.grids.iter().map(&mut at_nodes).collect();
    let far = Interpolation::new(plan, &nodes);
    let position = |number: u32| surfaces.get(number as usize).map(|surface| surface.position);
    let mut colors = vec![Vec3::ZERO; surfaces.len()];
    let power = common_power(surfaces);
    for draw in &plan.draws {
        let is_known = |number: &u32| (*number as usize) < surfaces.len();
        let numbers = match draw.fragments.iter().all(is_known) {
            true => Cow::Borrowed(&draw.fragments[..]),
            false => draw.fragments.iter().copied().filter(is_known).collect(),
        };
        light(surfaces, power, &numbers, &draw.lights, &mut colors);
        far.add(draw, &position, &mut colors);
    }
    colors
}
