//! Compares pictures, and measures the evaluations that gates skip by lighting the frame with the
//! compiled robust form.

use glam::Vec3;

use super::STEP;
use crate::plan::{Claim, Measured, OptionEffect, Plan};
use crate::shading_f32::{
    Form, Gates, Lights, Model, Shaded, Surface, Work, execute, shade_all, surfaces,
};
use crate::{Frame, Upload};

/// The most light evaluations of a measurement; larger frames are measured at evenly spaced
/// fragments.
const LIMIT: u64 = 50_000_000;

pub fn compare(pairs: impl Iterator<Item = (Vec3, Vec3)>) -> Measured {
    let mut measured = Measured { every: 1, ..Measured::default() };
    for (a, b) in pairs {
        measured.fragments += 1;
        measured.of += 3;
        for (a, b) in a.to_array().into_iter().zip(b.to_array()) {
            // A step is 1/255 of linear light, not of the encoded code.
            let apart = (f64::from(a) - f64::from(b)).abs() / STEP;
            // A value that is NaN or infinite in only one of them counts as the largest error.
            // `inf - inf` is NaN as well: equal infinities are no difference.
            let same = a.to_bits() == b.to_bits();
            let apart = match apart.is_nan() {
                true if same => 0.0,
                true => f64::INFINITY,
                false => apart,
            };
            measured.steps = measured.steps.max(apart);
            measured.codes += u64::from(code(a) != code(b));
        }
    }
    measured
}

fn code(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u8
}

fn thin(plan: &Plan, stride: usize) -> Plan {
    let mut plan = plan.clone();
    for draw in &mut plan.draws {
        draw.fragments.retain(|number| (*number as usize).is_multiple_of(stride));
    }
    plan
}

/// Measures the evaluations that gates skip in a plan; powers below `steps` of 1/255 are skipped
/// too.
pub(super) fn gates(
    plan: &Plan,
    upload: &Upload,
    frame: &Frame,
    model: &Model,
    steps: f64,
) -> OptionEffect {
    let stride = plan.evaluations().div_ceil(LIMIT).max(1) as usize;
    let plan = thin(plan, stride);
    let lit = |surfaces: &[Surface], gates: Gates| -> Shaded<Work> {
        // Three runs: without gates, for the counts; with exact gates; with gates that drop weak
        // highlights. The error is that of the third against the second, since the second is
        // exact.
        execute(&plan, upload, surfaces, model, Form::Robust(gates))
    };
    let open = lit(&surfaces(frame, upload, model, 0.0), Gates::NONE);
    let exact = surfaces(frame, upload, model, 0.0);
    let shut = lit(&surfaces(frame, upload, model, steps * STEP), Gates::ALL);
    let fragments = frame.fragments.len().div_ceil(stride).max(1) as f64;
    let per = |n: u64| n as f64 / fragments;
    let (a, b) = (open.tally, shut.tally);
    let did = format!(
        "per fragment: evaluations {:.2} instead of {:.2}, attenuations {:.2} instead of {:.2}, \
         powers {:.2} instead of {:.2}",
        per(b.evaluations),
        per(a.evaluations),
        per(b.attenuations),
        per(a.attenuations),
        per(b.powers),
        per(a.powers),
    );
    let error = if steps > 0.0 {
        let exact = lit(&exact, Gates::ALL);
        // Thinned plans light every `stride`-th fragment; the others stay black in both pictures.
        let pairs = shut.colors.into_iter().zip(exact.colors).step_by(stride);
        let measured = Measured { every: stride as u64, ..compare(pairs) };
        Claim::Measured { measured }
    } else {
        let why = "gates skip only terms that are multiplied by exactly zero".to_string();
        Claim::Exact { why }
    };
    let option = if steps > 0.0 { format!("gates={steps}") } else { "gates".to_string() };
    // Gates do not change the lists: the evaluations of the plan stay.
    OptionEffect { option, did, evaluations: None, error, tests: 0 }
}

/// Lights all fragments with all lights, for comparison.
pub fn brute(upload: &Upload, frame: &Frame, model: &Model, form: Form) -> Shaded<Work> {
    let surfaces = surfaces(frame, upload, model, 0.0);
    shade_all(&surfaces, upload.camera.as_vec3(), &Lights::new(upload, model), model, form)
}
