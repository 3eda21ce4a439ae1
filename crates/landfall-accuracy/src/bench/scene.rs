//! A scene as the subject of a bench: its fragments and their reference colours.
//!
//! Feeds the workloads of [`native`](super::native) and [`shader`](super::shader).

use super::errors::Errors;
use landfall_ir::analysis::hazard::threshold::EDGE;
use landfall_ir::threads;
use landfall_light::frame::AT_A_TIME;
use landfall_light::reference::{Model, shade};
use landfall_light::{Fragment, Frame, Upload, sample};

/// A scene with its fragments and reference.
#[derive(Clone, Debug)]
pub struct BenchScene {
    pub upload: Upload,
    /// The fragments, sorted by material.
    pub frame: Frame,
    pub model: Model,
    /// The reference colour of each fragment; `None` where it is undefined or depends on rounding.
    truth: Vec<Option<[f64; 3]>>,
}

impl BenchScene {
    /// Lights a scene with the reference.
    ///
    /// If fragments times lights exceed `most`, an evenly spaced subset of the fragments is taken.
    pub fn new(model: Model, upload: Upload, mut frame: Frame, most: u64) -> BenchScene {
        let lights = upload.lights.counts().iter().sum::<usize>() as u64;
        // The cost of the reference and of the interpreter is fragments times lights.
        let all = frame.fragments.len() as u64 * lights.max(1);
        let stride = all.div_ceil(most.max(1)).max(1) as usize;
        frame.fragments = frame.fragments.into_iter().step_by(stride).collect();
        // A stable sort keeps the order within each draw.
        frame.fragments.sort_by_key(|fragment| fragment.material);
        let truth = truth(&model, &upload, &frame);
        BenchScene { upload, frame, model, truth }
    }

    /// Returns the number of lights of all kinds.
    pub fn lights(&self) -> u32 {
        self.upload.lights.counts().iter().sum::<usize>() as u32
    }

    /// Returns the errors of colours of the fragments, in their order.
    pub fn errors(&self, colors: &[[f32; 3]]) -> Errors {
        Errors::new(colors, &self.truth)
    }

    /// Returns the reference colour of a fragment; `None` where it is undefined.
    pub(super) fn truth(&self, fragment: usize) -> Option<[f64; 3]> {
        self.truth.get(fragment).copied().flatten()
    }
}

fn truth(model: &Model, upload: &Upload, frame: &Frame) -> Vec<Option<[f64; 3]>> {
    let one = |fragment: &Fragment| {
        let texels = sample::texels(&upload.materials[fragment.material as usize], fragment.uv);
        let shaded = shade(model, upload, fragment, &texels).ok()?;
        // At a hard edge rounding decides between lit and dark: neither is an error.
        let at_edge = shaded.edge.is_some_and(|edge| edge.abs() < EDGE.value);
        (!at_edge).then(|| shaded.total.to_array())
    };
    threads::map(&frame.fragments, AT_A_TIME, one).collect()
}
