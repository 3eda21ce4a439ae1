//! Lighting compiled into this program, as workloads: the forms of
//! [`light::compiled`](crate::compiled) on one thread.

use glam::Vec3;
use std::hint::black_box;

use super::clock::Took;
use super::errors::Errors;
use super::report::Work;
use super::rounds::{Part, Workload};
use super::scene::Stage;
use crate::compiled;
use crate::compiled::{Form, Lights, Model, Shaded, Surface, execute, shade_all, surfaces};
use crate::skip;
use crate::skip::Plan;

/// A form of the lighting, over a stage.
pub struct Compiled<'a> {
    stage: &'a Stage,
    model: Model,
    form: Form,
    surfaces: Vec<Surface>,
    lights: Lights,
    /// Which lights each fragment is lit by, if not all.
    plan: Option<Plan>,
}

impl<'a> Compiled<'a> {
    /// A form; powers of less than `least` are left out, none for 0.
    ///
    /// # Errors
    /// Why the stage's model has no compiled form.
    pub fn new(stage: &'a Stage, form: Form, least: f64) -> Result<Compiled<'a>, String> {
        let model = Model::of(&stage.model).map_err(str::to_string)?;
        let surfaces = surfaces(&stage.frame, &stage.upload, &model, least);
        let lights = Lights::new(&stage.upload, &model);
        Ok(Compiled { stage, model, form, surfaces, lights, plan: None })
    }

    /// The same by a plan that skips lights.
    pub fn by_plan(self, options: &skip::Options) -> Compiled<'a> {
        let plan = skip::plan(&self.stage.upload, &self.stage.frame, &self.model, options);
        Compiled { plan: Some(plan), ..self }
    }

    /// What it gives, how far that is from the reference, and what it does for that.
    pub fn judged(&self) -> (Errors, Work) {
        let Shaded { colors, tally } = self.shade::<compiled::Work>(&self.lights);
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

    fn shade<T: compiled::Tally + Default>(&self, lights: &Lights) -> Shaded<T> {
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
            // A plan without lights is another plan.
            Part::Unlit => self.plan.is_none(),
        }
    }

    fn run(&mut self, part: Part) -> Result<Option<Took>, String> {
        match part {
            Part::Whole => drop(black_box(self.shade::<()>(black_box(&self.lights)))),
            Part::Unlit => {
                let ambient = Lights { ambient: self.lights.ambient, ..Lights::default() };
                drop(black_box(self.shade::<()>(black_box(&ambient))));
            }
            Part::Trivial => {
                let copied: Vec<Vec3> =
                    black_box(&self.surfaces).iter().map(|surface| surface.position).collect();
                drop(black_box(copied));
            }
        }
        Ok(None)
    }
}
