//! A stage made ready for a shader: what is bound for its fragments, with all lights, with none,
//! or as a plan says.
//!
//! Made once a variant; read by the workloads of [`shader`](super::shader) on every reader, and by
//! [`counted`](super::counted).

use std::time::Duration;

use super::scene::Stage;
use crate::bind::{Excess, Lit};
use crate::compiled::Model;
use crate::render;
use crate::render::planned::Lot;
use crate::render::{Draw, Prepared, Renderer};
use crate::skip::Options;

/// What a shader is given for a stage.
pub struct Uploaded<'a> {
    pub(super) stage: &'a Stage,
    pub(super) renderer: &'a Renderer,
    pub(super) limit: Duration,
    /// Fragments that are lit together; each is in one lot.
    pub(super) whole: Vec<Lot>,
    /// The same without lights; none of a shader without counts, which evaluates lights of zeros,
    /// and none of a plan, since a plan without lights is another plan.
    pub(super) unlit: Option<Vec<Prepared>>,
}

impl<'a> Uploaded<'a> {
    /// A stage for a shader, of which a reader has `limit` for a job.
    ///
    /// # Errors
    /// Why the scene does not go into the shader.
    pub fn new(
        stage: &'a Stage,
        renderer: &'a Renderer,
        limit: Duration,
    ) -> Result<Uploaded<'a>, String> {
        let wrong = |error: render::RenderError| error.to_string();
        let lights = renderer.lights(&stage.upload, Excess::Refuse);
        let [directional, point, spot] = lights.map_err(|error| error.to_string())?;
        let all = Lit { ambient: true, directional: &directional, point: &point, spot: &spot };
        let none = Lit { ambient: true, directional: &[], point: &[], spot: &[] };
        let work = work(stage, limit);
        let numbers: Vec<u32> = (0..stage.frame.fragments.len() as u32).collect();
        let lots = |lights: Lit<'_>| {
            let draw = Draw { fragments: &numbers, lights, tiles: None };
            renderer.lots(&work, &draw).map_err(wrong)
        };
        let whole = lots(all)?;
        let unlit = match renderer.evaluated(&none) {
            0 => Some(lots(none)?.into_iter().map(|lot| lot.prepared).collect()),
            _ => None,
        };
        Ok(Uploaded { stage, renderer, limit, whole, unlit })
    }

    /// The same with the lights that a plan leaves at each fragment.
    ///
    /// # Errors
    /// The same, and why the stage's model has no plan, or a plan that is more than draws.
    pub fn by_plan(
        stage: &'a Stage,
        renderer: &'a Renderer,
        limit: Duration,
        options: &Options,
    ) -> Result<Uploaded<'a>, String> {
        let model = Model::of(&stage.model).map_err(str::to_string)?;
        let work = work(stage, limit);
        let plan = renderer.plan(&work, &model, options);
        if !plan.grids.is_empty() {
            return Err("`interpolate` adds light that no shader of a bench computes".to_string());
        }
        let whole = renderer.lots_of_plan(&work, &plan).map_err(|error| error.to_string())?;
        Ok(Uploaded { stage, renderer, limit, whole, unlit: None })
    }

    /// Every so many fragments, about as many as that.
    pub(super) fn some(&self, about: usize) -> Vec<Lot> {
        let stride = self.stage.frame.fragments.len().div_ceil(about.max(1)).max(1);
        let mut before = 0;
        let each = self.whole.iter().map(|lot| {
            let first = (stride - before % stride) % stride;
            before += lot.fragments.len();
            lot.every(first, stride)
        });
        each.filter(|lot| !lot.fragments.is_empty()).collect()
    }
}

fn work(stage: &Stage, limit: Duration) -> render::Work<'_> {
    render::Work {
        upload: &stage.upload,
        frame: &stage.frame,
        background: Default::default(),
        limit,
    }
}
