//! The picture by the reference, and its pixels that are undefined or depend on rounding.

use std::collections::BTreeMap;

use glam::DVec3;

use super::background;
use crate::bind::{BindingMap, Kind, LightPart, MaterialPart, Quantity};
use crate::frame::AT_A_TIME;
use crate::picture::Picture;
use crate::reference::{
    AmbientTerm, ArraySpecular, CasterAttenuation, ConeEdge, Family, Model, Normal, Reflectance,
    SpecularGate, UndefinedReason, Window, shade,
};
use crate::{Fragment, Frame, Upload, sample};
use landfall_ir::analysis::hazard::threshold::EDGE;
use landfall_ir::threads;

/// A picture by the reference.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// The picture; black where a pixel is undefined.
    pub picture: Picture,
    /// A mark for each pixel that comparisons leave out.
    pub leave_out: Vec<bool>,
    pub undefined: BTreeMap<UndefinedReason, u64>,
    /// The fragments so close to a hard edge that rounding decides on which side they are.
    pub at_edges: u64,
}

pub fn truth(model: &Model, upload: &Upload, frame: &Frame, behind: DVec3) -> Truth {
    let Frame { width, height, fragments } = frame;
    let picture = Picture::filled(*width, *height, background(behind));
    let leave_out = bytemuck::zeroed_vec(picture.pixels.len());
    let mut truth = Truth { picture, leave_out, ..Truth::default() };
    let parts: Vec<&[Fragment]> = fragments.chunks(AT_A_TIME).collect();
    let lit = threads::map(&parts, 1, |part| LitFragments::new(model, upload, part));
    for (fragments, part) in parts.iter().zip(lit) {
        for (fragment, (color, leave_out)) in fragments.iter().zip(part.pixels) {
            let pixel = fragment.pixel as usize;
            truth.picture.pixels[pixel] = color;
            truth.leave_out[pixel] = leave_out;
        }
        truth.at_edges += part.at_edges;
        for (reason, count) in part.undefined {
            *truth.undefined.entry(reason).or_default() += count;
        }
    }
    truth
}

#[derive(Default)]
struct LitFragments {
    /// The colour of each, and whether comparisons leave it out.
    pixels: Vec<([f32; 4], bool)>,
    undefined: BTreeMap<UndefinedReason, u64>,
    at_edges: u64,
}

impl LitFragments {
    fn new(model: &Model, upload: &Upload, fragments: &[Fragment]) -> LitFragments {
        let mut part =
            LitFragments { pixels: Vec::with_capacity(fragments.len()), ..LitFragments::default() };
        for fragment in fragments {
            let (color, at_edge) = pixel(model, upload, fragment);
            part.at_edges += u64::from(at_edge);
            if let Err(reason) = color {
                *part.undefined.entry(reason).or_default() += 1;
            }
            let leave_out = at_edge || color.is_err();
            part.pixels.push((background(color.unwrap_or(DVec3::ZERO)), leave_out));
        }
        part
    }
}

/// A fragment's light, and whether it is at a hard edge.
type Pixel = (Result<DVec3, UndefinedReason>, bool);

fn pixel(model: &Model, upload: &Upload, fragment: &Fragment) -> Pixel {
    let texels = sample::texels(&upload.materials[fragment.material as usize], fragment.uv);
    match shade(model, upload, fragment, &texels) {
        Ok(shaded) => (Ok(shaded.total), shaded.edge.is_some_and(|edge| edge.abs() < EDGE.value)),
        Err(undef) => (Err(undef), false),
    }
}

/// The fragments needed to distinguish models.
const ENOUGH: usize = 4096;

/// Returns the indices of the fragments by which [`nearest`] distinguishes models.
pub fn sampled(frame: &Frame) -> Vec<u32> {
    let step = frame.fragments.len().div_ceil(ENOUGH).max(1);
    (0..frame.fragments.len() as u32).step_by(step).collect()
}

/// Returns the model of the same family that is nearest to a picture: names do not tell the
/// variants of a family apart.
pub fn nearest(model: &Model, upload: &Upload, frame: &Frame, picture: &Picture) -> Model {
    let sampled = sampled(frame);
    let distance = |model: &Model| -> f64 {
        let each = sampled.iter().map(|at| &frame.fragments[*at as usize]).map(|fragment| {
            let Some(seen) = picture.pixels.get(fragment.pixel as usize) else { return 0.0 };
            let [r, g, b, _] = seen.map(f64::from);
            match pixel(model, upload, fragment) {
                // Pixels at hard edges and undefined ones say nothing about the model.
                (Ok(color), false) if (r + g + b).is_finite() => {
                    (color - DVec3::new(r, g, b)).abs().element_sum()
                }
                _ => 0.0,
            }
        });
        each.sum()
    };
    let mut all: Vec<(f64, Model)> =
        model_variants(model).into_iter().map(|m| (distance(&m), m)).collect();
    // A stable sort: of equally near models, the first.
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.first().map_or(*model, |(_, model)| *model)
}

/// Returns a model and the variants of its family among published shaders.
fn model_variants(model: &Model) -> Vec<Model> {
    let mut all = vec![*model];
    let mut also = |change: &dyn Fn(&mut Model)| {
        // Each change doubles the variants: all combinations are tried.
        let changed = all.iter().map(|known| {
            let mut changed = *known;
            change(&mut changed);
            changed
        });
        let changed: Vec<Model> = changed.collect();
        all.extend(changed);
    };
    also(&|m| m.specular_gate = SpecularGate::Facing);
    // A range member does not imply that the light ends there.
    if model.window == Window::Quartic {
        also(&|m| m.window = Window::None);
    }
    match model.family {
        Family::Multi => {}
        Family::Array => also(&|m| {
            m.array_specular = ArraySpecular::AsPublished;
            m.normal = Normal::AsInterpolated;
        }),
        Family::ViewSpace => also(&|m| m.reflectance = Reflectance::Factor),
        Family::Casters => {
            also(&|m| m.caster_attenuation = CasterAttenuation::None);
            also(&|m| m.cone_edge = ConeEdge::Hard);
        }
    }
    all
}

/// Returns the most likely family of a shader with these members. Members alone tell neither how a
/// range ends the light nor the condition of a highlight: [`nearest`] compares pictures.
pub fn likely_model(map: &BindingMap) -> Model {
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
    let mut model = Model::new(family);
    use LightPart::{InverseRange, InverseRangeSquared, Range, RangeSquared};
    if [Range, RangeSquared, InverseRange, InverseRangeSquared].into_iter().any(part) {
        model.window = Window::Quartic;
    }
    if family == Family::Array && !has(&|q| matches!(q, Quantity::Ambient(_))) {
        model.ambient = AmbientTerm::None;
    }
    model
}
