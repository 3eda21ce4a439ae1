//! The picture by the reference, and which of its pixels are no number or a matter of rounding.

use std::collections::BTreeMap;
use std::thread;

use glam::DVec3;

use super::background;
use crate::light::bind::{BindingMap, Kind, LightPart, MaterialPart, Quantity};
use crate::light::reference::{AmbientTerm, Family, Model, Undef, Window, shade};
use crate::light::{Fragment, Frame, Upload, sample};
use crate::picture::Picture;

/// A picture by the reference.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// The picture; black where a pixel is undefined.
    pub picture: Picture,
    /// Pixels that are not to be compared.
    pub leave_out: Vec<bool>,
    /// Fragments without a value, by the hazard that leaves them so.
    pub undefined: BTreeMap<Undef, u64>,
    /// Fragments so near to an edge without a ramp that rounding decides their side.
    pub at_edges: u64,
}

/// How near to an edge, in cosines, `f32` may find a fragment on the other side: the cosine is of
/// two vectors, each off by two units in the last place.
const EDGE: f64 = 1e-6;

/// Lights every fragment by the reference.
pub fn truth(model: &Model, upload: &Upload, frame: &Frame, behind: DVec3) -> Truth {
    let Frame { width, height, fragments } = frame;
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let share = fragments.len().div_ceil(threads).max(1);
    type Pixel = (Result<DVec3, Undef>, bool);
    let one = |fragment: &Fragment| -> Pixel {
        let texels = sample::texels(&upload.materials[fragment.material as usize], fragment.uv);
        match shade(model, upload, fragment, &texels) {
            Ok(shaded) => (Ok(shaded.total), shaded.edge.is_some_and(|edge| edge.abs() < EDGE)),
            Err(undef) => (Err(undef), false),
        }
    };
    let lit: Vec<Vec<Pixel>> = thread::scope(|scope| {
        let one = &one;
        let parts = fragments.chunks(share);
        let running: Vec<_> = parts
            .map(|part| scope.spawn(move || part.iter().map(one).collect::<Vec<_>>()))
            .collect();
        let done = running.into_iter().map(thread::ScopedJoinHandle::join);
        done.map(|part| part.expect("the reference does not panic")).collect()
    });
    let picture = Picture::filled(*width, *height, background(behind));
    let leave_out = vec![false; picture.pixels.len()];
    let mut truth = Truth { picture, leave_out, ..Truth::default() };
    for (fragment, (color, at_edge)) in fragments.iter().zip(lit.into_iter().flatten()) {
        let pixel = fragment.pixel as usize;
        let color = color.unwrap_or_else(|undef| {
            *truth.undefined.entry(undef).or_default() += 1;
            truth.leave_out[pixel] = true;
            DVec3::ZERO
        });
        if at_edge {
            truth.at_edges += 1;
            truth.leave_out[pixel] = true;
        }
        truth.picture.pixels[pixel] = background(color);
    }
    truth
}

/// The family of models that a shader with these members is likely to compute.
pub fn likely(map: &BindingMap) -> Model {
    let has = |wanted: &dyn Fn(Quantity) -> bool| {
        map.members.iter().any(|member| member.source.quantity().is_some_and(wanted))
    };
    let part =
        |wanted: LightPart| has(&|q| matches!(q, Quantity::Light { part, .. } if part == wanted));
    let kinds = Kind::ALL.into_iter().filter(|kind| map.has(*kind)).count();
    let each = has(&|q| matches!(q, Quantity::Light { .. }) && q.is_each());
    let family = if has(&|q| q == Quantity::Material(MaterialPart::Reflectance)) {
        Family::ViewSpace
    } else if !part(LightPart::Diffuse) {
        Family::Array
    } else if kinds == 1 && !each {
        Family::Casters
    } else {
        Family::Multi
    };
    let mut model = Model::of(family);
    if part(LightPart::Range) {
        model.window = Window::Quartic;
    }
    if family == Family::Array && !has(&|q| matches!(q, Quantity::Ambient(_))) {
        model.ambient = AmbientTerm::None;
    }
    model
}
