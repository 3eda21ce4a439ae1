//! A stage made ready for a shader: what is bound for its fragments, with all lights and with
//! none.
//!
//! Made once a variant; read by the workloads of [`shader`](super::shader) on every reader, and by
//! [`counted`](super::counted).

use std::time::Duration;

use super::scene::Stage;
use crate::light::bind::{Excess, Kind, Lit};
use crate::light::render::{self, Draw, Prepared, RenderError, Renderer};

/// What a shader is given for a stage.
pub struct Uploaded<'a> {
    pub(super) stage: &'a Stage,
    pub(super) renderer: &'a Renderer,
    pub(super) limit: Duration,
    /// Of each material.
    pub(super) whole: Vec<Prepared>,
    /// The same without lights; none of a shader without counts, which evaluates lights of zeros.
    pub(super) unlit: Option<Vec<Prepared>>,
    /// Slots of each kind that the shader's loops are given.
    pub(super) slots: [(Kind, u64); 3],
}

impl<'a> Uploaded<'a> {
    /// A stage for a shader, of which a reader has `limit` for a job.
    ///
    /// # Errors
    /// The scene does not go into the shader.
    pub fn new(
        stage: &'a Stage,
        renderer: &'a Renderer,
        limit: Duration,
    ) -> Result<Uploaded<'a>, RenderError> {
        let [directional, point, spot] = renderer.lights(&stage.upload, Excess::Refuse)?;
        let all = Lit { ambient: true, directional: &directional, point: &point, spot: &spot };
        let none = Lit { ambient: true, directional: &[], point: &[], spot: &[] };
        let work = render::Work {
            upload: &stage.upload,
            frame: &stage.frame,
            background: Default::default(),
            limit,
        };
        let prepare = |lights: Lit<'_>| -> Result<Vec<Prepared>, RenderError> {
            stage
                .by_material()
                .map(|fragments| {
                    let fragments: Vec<_> = fragments.iter().collect();
                    let draw = Draw { fragments: &[], lights, tiles: None };
                    renderer.prepare(&work, &fragments, &draw)
                })
                .collect()
        };
        let slots = Kind::ALL.map(|kind| (kind, renderer.walked(kind, &all)));
        let whole = prepare(all)?;
        let unlit = if renderer.evaluated(&none) == 0 { Some(prepare(none)?) } else { None };
        Ok(Uploaded { stage, renderer, limit, whole, unlit, slots })
    }

    /// Every so many fragments, about as many as that, and where they are in the stage's frame.
    pub(super) fn some(&self, about: usize) -> Vec<(Prepared, Vec<usize>)> {
        let stride = self.stage.frame.fragments.len().div_ceil(about.max(1)).max(1);
        let mut first = 0;
        let each = self.whole.iter().map(|prepared| {
            let inputs = prepared
                .inputs
                .iter()
                .map(|values| values.iter().copied().step_by(stride).collect())
                .collect();
            let places: Vec<usize> = (first..first + prepared.count).step_by(stride).collect();
            first += prepared.count;
            (Prepared { inputs, count: places.len(), ..prepared.clone() }, places)
        });
        each.collect()
    }
}
