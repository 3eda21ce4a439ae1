//! A scene as the subject of a bench: its fragments, and what the reference says of them.
//!
//! Feeds the workloads of [`compiled`](super::compiled) and [`shader`](super::shader).

use std::thread;

use super::errors::Errors;
use crate::reference::{Model, shade};
use crate::{Fragment, Frame, Upload, sample};
use landfall_ir::analysis::hazard::threshold::EDGE;

/// A scene made ready to be lit by many.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The lights and materials.
    pub upload: Upload,
    /// The fragments, those of one material together.
    pub frame: Frame,
    /// What lighting is.
    pub model: Model,
    /// The colour of each fragment; none where it is undefined, or a matter of rounding.
    truth: Vec<Option<[f64; 3]>>,
}

impl Stage {
    /// Lights a scene by the reference.
    ///
    /// Of a frame whose fragments times lights are more than `most`, every so many fragments are
    /// taken.
    pub fn new(model: Model, upload: Upload, mut frame: Frame, most: u64) -> Stage {
        let lights = &upload.lights;
        let lights = (lights.directional.len() + lights.point.len() + lights.spot.len()) as u64;
        let all = frame.fragments.len() as u64 * lights.max(1);
        let stride = all.div_ceil(most.max(1)).max(1) as usize;
        frame.fragments = frame.fragments.into_iter().step_by(stride).collect();
        // Stable: what a draw of one material holds is as it was.
        frame.fragments.sort_by_key(|fragment| fragment.material);
        let truth = truth(&model, &upload, &frame);
        Stage { upload, frame, model, truth }
    }

    /// Lights of all kinds.
    pub fn lights(&self) -> u32 {
        let lights = &self.upload.lights;
        (lights.directional.len() + lights.point.len() + lights.spot.len()) as u32
    }

    /// How far colours of the fragments, in their order, are from the reference.
    pub fn errors(&self, colors: &[[f32; 3]]) -> Errors {
        Errors::of(colors, &self.truth)
    }

    /// What the reference says of a fragment; none where that is undefined.
    pub(super) fn truth(&self, fragment: usize) -> Option<[f64; 3]> {
        self.truth.get(fragment).copied().flatten()
    }
}

fn truth(model: &Model, upload: &Upload, frame: &Frame) -> Vec<Option<[f64; 3]>> {
    let one = |fragment: &Fragment| {
        let texels = sample::texels(&upload.materials[fragment.material as usize], fragment.uv);
        let shaded = shade(model, upload, fragment, &texels).ok()?;
        let at_edge = shaded.edge.is_some_and(|edge| edge.abs() < EDGE.value);
        (!at_edge).then(|| shaded.total.to_array())
    };
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let share = frame.fragments.len().div_ceil(threads).max(1);
    thread::scope(|scope| {
        let one = &one;
        let parts = frame.fragments.chunks(share);
        let running: Vec<_> = parts
            .map(|part| scope.spawn(move || part.iter().map(one).collect::<Vec<_>>()))
            .collect();
        let done = running.into_iter().map(thread::ScopedJoinHandle::join);
        done.flat_map(|part| part.expect("the reference does not panic")).collect()
    })
}
