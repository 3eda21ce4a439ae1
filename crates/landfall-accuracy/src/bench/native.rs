//! Lighting compiled into this program, as workloads: the forms of
//! [`shading_f32`] on one thread.

use glam::Vec3;
use std::hint::black_box;

use super::clock::Elapsed;
use super::errors::Errors;
use super::report::Work;
use super::rounds::{Part, Workload};
use super::scene::BenchScene;
use landfall_light::culling;
use landfall_light::culling::Plan;
use landfall_light::shading_f32;
use landfall_light::shading_f32::{
    Form, Lights, Model, Shaded, Surface, execute, shade_all, surfaces,
};

/// A form of the lighting over a scene.
pub struct Compiled<'a> {
    stage: &'a BenchScene,
    model: Model,
    form: Form,
    surfaces: Vec<Surface>,
    lights: Lights,
    /// The plan of lights per fragment; `None` for all lights.
    plan: Option<Plan>,
}

impl<'a> Compiled<'a> {
    /// A form that skips powers below `least`; 0 skips none.
    ///
    /// # Errors
    /// A model of the scene that has no compiled form.
    pub fn new(stage: &'a BenchScene, form: Form, least: f64) -> Result<Compiled<'a>, String> {
        let model = Model::new(&stage.model).map_err(str::to_string)?;
        let surfaces = surfaces(&stage.frame, &stage.upload, &model, least);
        let lights = Lights::new(&stage.upload, &model);
        Ok(Compiled { stage, model, form, surfaces, lights, plan: None })
    }

    /// Returns the workload with a plan that skips lights.
    pub fn by_plan(self, options: &culling::Options) -> Compiled<'a> {
        let plan = culling::plan(&self.stage.upload, &self.stage.frame, &self.model, options);
        Compiled { plan: Some(plan), ..self }
    }

    /// Returns the errors of its colours against the reference, and its work.
    pub fn measure_errors(&self) -> (Errors, Work) {
        let Shaded { colors, tally } = self.shade::<shading_f32::Work>(&self.lights);
        let colors: Vec<[f32; 3]> = colors.iter().map(Vec3::to_array).collect();
        let fragments = colors.len().max(1) as f64;
        let work = Work {
            evaluations: Some(tally.evaluations as f64 / fragments),
            evaluations_error: Some(0.0),
            slots: None,
            powers: Some(tally.powers as f64 / fragments),
            operations: None,
            bytes: None,
        };
        (self.stage.errors(&colors), work)
    }

    fn shade<T: shading_f32::Tally + Default>(&self, lights: &Lights) -> Shaded<T> {
        let Compiled { stage, model, form, surfaces, plan, .. } = self;
        match plan {
            Some(plan) => execute(plan, &stage.upload, surfaces, model, *form),
            None => shade_all(surfaces, stage.upload.camera.as_vec3(), lights, model, *form),
        }
    }
}

impl Workload for Compiled<'_> {
    fn has(&self, part: Part) -> bool {
        match part {
            Part::Whole | Part::Trivial => true,
            // Without lights there would be a different plan.
            Part::Unlit => self.plan.is_none(),
        }
    }

    fn run(&mut self, part: Part) -> Result<Option<Elapsed>, String> {
        match part {
            Part::Whole => drop(black_box(self.shade::<()>(black_box(&self.lights)))),
            Part::Unlit => {
                let ambient = Lights { ambient: self.lights.ambient, ..Lights::default() };
                drop(black_box(self.shade::<()>(black_box(&ambient))));
            }
            Part::Trivial => {
                // As many reads and writes as there are fragments, without arithmetic.
                let copied: Vec<Vec3> =
                    black_box(&self.surfaces).iter().map(|surface| surface.position).collect();
                drop(black_box(copied));
            }
        }
        Ok(None)
    }
}
