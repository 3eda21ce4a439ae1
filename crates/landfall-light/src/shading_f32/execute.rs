//! Lights a frame: with all lights, or by a plan.

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
    let all = Lights::new(upload, model);
    let finite = all.emissions().all(Emission::is_finite);
    let plain = (!plan.grids.is_empty()).then(|| PlainLights::new(&all));
    let mut run = Run {
        plain,
        eye: upload.camera.as_vec3(),
        all,
        finite,
        some: Lights::default(),
        model,
        form,
        tally: T::default(),
    };
    let nodes: Vec<Vec<Vec3>> = plan.grids.iter().map(|grid| run.grid(grid, upload)).collect();
    let far = Interpolation::new(plan, &nodes);
    let position = |number: u32| surfaces.get(number as usize).map(|surface| surface.position);
    let mut colors = vec![Vec3::ZERO; surfaces.len()];
    let power = common_power(surfaces);
    for draw in &plan.draws {
        run.draw((surfaces, power), &draw.fragments, &draw.lights, &mut colors);
        far.add(draw, &position, &mut colors);
    }
    Shaded { colors, tally: run.tally }
}

struct Run<'a, T> {
    /// The plain lights, if the plan is not exact anyway.
    plain: Option<PlainLights>,
    eye: Vec3,
    all: Lights,
    /// Whether no colour is infinite or NaN.
    finite: bool,
    some: Lights,
    model: &'a Model,
    form: Form,
    tally: T,
}

impl<T: Tally> Run<'_, T> {
    fn draw(
        &mut self,
        (surfaces, power): (&[Surface], Option<Power>),
        numbers: &[u32],
        set: &LightSet,
        colors: &mut [Vec3],
    ) {
        let within = numbers.iter().all(|number| (*number as usize) < surfaces.len());
        if let (Form::Robust(gates), false, true) = (self.form, T::COUNTS, within) {
            let Run { plain, eye, finite, all: lights, model, .. } = self;
            let (eye, finite) = (*eye, *finite || lights.are_finite(set));
            let batch = Batch { surfaces, power, numbers, eye, lights, set, finite, model, gates };
            match plain.as_ref().and_then(|plain| Fused::of(&batch, plain)) {
                Some(fused) => {
                    let numbers = &*fused.shade(colors);
                    Batch { numbers, ..batch }.shade(colors);
                }
                None => batch.shade(colors),
            }
            return;
        }
        self.all.select(set, &mut self.some);
        for &number in numbers {
            if let Some(surface) = surfaces.get(number as usize) {
                colors[number as usize] = self.shade(surface);
            }
        }
    }

    fn grid(&mut self, grid: &Grid, upload: &Upload) -> Vec<Vec3> {
        let Some(first) = grid.nodes.first() else { return Vec::new() };
        // Nodes differ in their places alone.
        let first = surface(first, upload, self.model);
        let node = |node: &Fragment| Surface { position: Vec3::from(node.position), ..first };
        let nodes: Vec<Surface> = grid.nodes.iter().map(node).collect();
        let numbers: Vec<u32> = (0..nodes.len() as u32).collect();
        let mut colors = vec![Vec3::ZERO; nodes.len()];
        self.draw((&nodes, Some(first.power)), &numbers, &grid.lights, &mut colors);
        colors
    }

    fn shade(&mut self, surface: &Surface) -> Vec3 {
        let Run { eye, some, model, form, tally, .. } = self;
        match form {
            Form::Seed => seed::shade(surface, *eye, some, model, tally),
            Form::Robust(gates) => robust::shade(surface, *eye, some, model, *gates, tally),
        }
    }
}
