//! A scene prepared for a shader: the bindings of its fragments with all lights, without lights, or
//! by a plan.
//!
//! Prepared once for each variant; used by the workloads of [`shader`](super::shader) on every
//! backend, and by [`counted`](super::counted).

use std::time::Duration;

use super::scene::BenchScene;
use landfall_light::bind::OverflowPolicy;
use landfall_light::culling::{LightSet, Options};
use landfall_light::render;
use landfall_light::render::planned::FragmentGroup;
use landfall_light::render::{Draw, Prepared, Renderer};
use landfall_light::shading_f32::Model;

/// The bindings of a shader for a scene.
pub struct Uploaded<'a> {
    pub(super) stage: &'a BenchScene,
    pub(super) renderer: &'a Renderer,
    pub(super) limit: Duration,
    /// Fragments lit together; each is in one group.
    pub(super) whole: Vec<FragmentGroup>,
    /// The same without lights; `None` for a shader without light counts, which evaluates lights of
    /// zeros, and for a plan, which would differ without lights.
    pub(super) unlit: Option<Vec<Prepared>>,
}

impl<'a> Uploaded<'a> {
    /// Prepares a scene for a shader; `limit` is a backend's time for a job.
    ///
    /// # Errors
    /// A scene that does not fit the shader.
    pub fn new(
        stage: &'a BenchScene,
        renderer: &'a Renderer,
        limit: Duration,
    ) -> Result<Uploaded<'a>, String> {
        let wrong = |error: render::RenderError| error.to_string();
        let all = renderer.lights(&stage.upload, OverflowPolicy::Refuse);
        let all = all.map_err(|error| error.to_string())?;
        let none = LightSet::first([0; 3]);
        let work = work(stage, limit);
        let numbers = stage.frame.numbers();
        let lots = |lights: &LightSet| {
            let draw = Draw { fragments: &numbers, lights, tiles: None };
            renderer.fragment_groups(&work, &draw).map_err(wrong)
        };
        let whole = lots(&all)?;
        // A shader that evaluates slots of zeros does as much work without lights.
        let unlit = match renderer.evaluated(&none) {
            0 => Some(lots(&none)?.into_iter().map(|lot| lot.prepared).collect()),
            _ => None,
        };
        Ok(Uploaded { stage, renderer, limit, whole, unlit })
    }

    /// Prepares a scene with the lights that a plan leaves at each fragment.
    ///
    /// # Errors
    /// The same, and a scene whose model has no plan.
    pub fn by_plan(
        stage: &'a BenchScene,
        renderer: &'a Renderer,
        limit: Duration,
        options: &Options,
    ) -> Result<Uploaded<'a>, String> {
        let model = Model::new(&stage.model).map_err(str::to_string)?;
        let work = work(stage, limit);
        let plan = renderer.plan(&work, &model, options);
        let whole =
            renderer.plan_fragment_groups(&work, &plan).map_err(|error| error.to_string())?;
        Ok(Uploaded { stage, renderer, limit, whole, unlit: None })
    }

    /// Returns about that many fragments, evenly spaced.
    pub(super) fn sampled_groups(&self, about: usize) -> Vec<FragmentGroup> {
        let stride = self.stage.frame.fragments.len().div_ceil(about.max(1)).max(1);
        // Every `stride`-th fragment of the frame, counted across the groups.
        let mut before = 0;
        let each = self.whole.iter().map(|lot| {
            let first = (stride - before % stride) % stride;
            before += lot.fragments.len();
            lot.step_by(first, stride)
        });
        each.filter(|lot| !lot.fragments.is_empty()).collect()
    }
}

fn work(stage: &BenchScene, limit: Duration) -> render::Work<'_> {
    render::Work {
        upload: &stage.upload,
        frame: &stage.frame,
        background: Default::default(),
        limit,
    }
}
