//! Light culling: skips the lights that a scene does not need, and reports the savings and the
//! error.
//!
//! Reads an [`Upload`] and the [`Frame`] it lights; returns a [`Plan`], plain data that the
//! [compiled models](super::shading_f32) and the backends execute. A light is left out of a tile
//! where the shader's code was [shown](ShownLights) to give zero for it, or else where its upper
//! [`bound`] over the tile's [`region`] is zero (exact, by the model) or within a budget.

pub mod bound;
mod cull;
mod lists;
mod measure;
mod options;
pub mod region;
mod upload;
mod used;

pub use measure::{brute, compare};
pub use options::{Options, PARTS, ShownLight, ShownLights, parse};
pub use upload::{CALL, UploadChoice, choose};

use rustc_hash::FxHashMap;

pub use crate::plan::{
    Claim, Compiled, ConstantKind, Draw, Evaluations, LightSet, Measured, OptionEffect, Plan,
    Savings, Setting, TileLists, Times, Value, Whole,
};

use super::reference::SpecularGate;
use super::shading_f32::Model;
use super::{Frame, Upload};
use crate::scene::Kind;
use bound::Bounded;
use cull::Lists;
use region::Points;

pub const STEP: f64 = 1.0 / 255.0;

/// The steepest slope of the sRGB transfer function, near black: a budget in steps of an sRGB
/// target is smaller in linear light by that factor.
pub const SRGB_SLOPE: f64 = 12.92;

/// Returns the plan for lighting `frame` with `upload`, and counts what gates would skip.
pub fn plan(upload: &Upload, frame: &Frame, model: &Model, options: &Options) -> Plan {
    let mut plan = plan_only(upload, frame, model, options);
    if let Some(steps) = options.gates {
        let step = measure::gates(&plan, upload, frame, model, steps);
        plan.savings.steps.push(step);
    }
    plan
}

/// Returns the plan without what gates would skip, as a renderer needs it every frame.
pub fn plan_only(upload: &Upload, frame: &Frame, model: &Model, options: &Options) -> Plan {
    // The stages: bounds of all lights, those with a slot and an effect, then a list for each
    // tile. Ambient light has no place and so is kept or dropped as a whole.
    let all = bound::bounded(upload, model);
    let (lights, mut savings) = used::used(upload, frame, model, &all, options);
    let ambient = used::ambient(upload, model, options);
    let job = PlanningInput { upload, frame, model, options, lights: &lights, ambient };
    let mut plan = match options.tiles {
        Some(size) => job.tiled(size, &mut savings),
        None => {
            let order = (0..lights.len() as u32).collect();
            Plan::all_lights(frame.fragments.len(), LightSets::new(&lights).set(order, ambient))
        }
    };
    plan.compiled = used::compiled(&plan, ambient);
    savings.after = plan.evaluations();
    plan.savings = savings;
    plan
}

struct PlanningInput<'a> {
    upload: &'a Upload,
    frame: &'a Frame,
    model: &'a Model,
    options: &'a Options,
    lights: &'a [Bounded],
    ambient: bool,
}

impl PlanningInput<'_> {
    /// Returns a plan with a list per tile.
    fn tiled(&self, size: u32, savings: &mut Savings) -> Plan {
        let PlanningInput { upload, frame, model, options, lights, .. } = *self;
        let mut points = Points::new(frame, upload, model);
        // Where every light and material has a highlight in all channels and the model shows it
        // behind a surface as well, no normal makes a bound zero. Leaving normals out saves their
        // bounds. A budget needs them, since they decide how large a bound is.
        let shows_all = options.budget.is_none()
            && model.specular == SpecularGate::None
            && !points.has_dull()
            && !lights.iter().any(Bounded::is_dull);
        if shows_all || options.shown.is_some() {
            points = points.undirected();
        }
        let divided = region::divide(frame, &points, size);
        let Lists { of, tests, dropped } = cull::lists(&divided, lights, model, options);
        let tiles = lists::tile_lists(frame, &divided, lights, &of, size);
        let regions = of.len();
        let plan =
            Plan { draws: self.draws(divided.cells, &of), tiles: Some(tiles), ..Plan::default() };
        let before = frame.fragments.len() as u64 * lights.len() as u64;
        let evaluations = Evaluations { before, after: plan.evaluations() };
        let per = |n: u64| n as f64 / frame.fragments.len().max(1) as f64;
        let did = format!(
            "{regions} regions, {:.1} of {:.1} lights per fragment",
            per(evaluations.after),
            per(evaluations.before),
        );
        let evaluations = Some(evaluations);
        let (option, error) = claimed(options, size, dropped.max_element() / STEP);
        savings.steps.push(OptionEffect { option, did, evaluations, error, tests });
        plan
    }

    /// Returns the draws: regions with the same lights share one.
    fn draws(&self, cells: Vec<region::RegionCell>, lists: &[Vec<u32>]) -> Vec<Draw> {
        // A draw costs a call and an upload of its lights, so regions with equal lists become one.
        // Lists are ascending, hence equal sets are equal slices.
        let sets = LightSets::new(self.lights);
        let mut draws: Vec<Draw> = Vec::new();
        let mut known: FxHashMap<&[u32], usize> = FxHashMap::default();
        for (cell, list) in cells.into_iter().zip(lists) {
            let at = *known.entry(list).or_insert_with(|| {
                let lights = sets.set(list.clone(), self.ambient);
                draws.push(Draw { fragments: Vec::new(), lights });
                draws.len() - 1
            });
            // The first region gives its vector away instead of being copied.
            match &mut draws[at].fragments {
                none if none.is_empty() => *none = cell.fragments,
                some => some.extend(cell.fragments),
            }
        }
        // Fragments of several regions are mixed; executors and comparisons rely on the frame's
        // order.
        for draw in &mut draws {
            draw.fragments.sort_unstable();
        }
        draws
    }
}

/// Returns the notation of a division into tiles, and its claim.
fn claimed(options: &Options, size: u32, dropped: f64) -> (String, Claim) {
    let exact = match options.shown {
        Some(_) => {
            "the shader's code was shown to give exactly zero for a light at the fragments it is \
             left out of, all beyond its range"
        }
        None => {
            "a light left out of a region is out of range, has the region outside its cone or is \
             behind every surface there, and contributes exactly zero"
        }
    };
    match options.budget {
        None => (format!("tiles={size}"), Claim::Exact { why: exact.to_string() }),
        Some(steps) => {
            let by =
                "the upper bounds of the lights left out of a region, summed, at their largest";
            let error = Claim::Proven { steps: dropped, by: by.to_string() };
            (format!("tiles={size},budget={steps}"), error)
        }
    }
}

/// The kinds of lights and their numbers in the upload.
struct LightSets {
    of: Vec<(Kind, u32)>,
    /// Whether all are point lights.
    points: bool,
}

impl LightSets {
    fn new(lights: &[Bounded]) -> LightSets {
        let of: Vec<_> = lights.iter().map(|light| (light.kind, light.number)).collect();
        LightSets { points: of.iter().all(|(kind, _)| *kind == Kind::Point), of }
    }

    /// Returns the set of the lights at those indices.
    fn set(&self, mut places: Vec<u32>, ambient: bool) -> LightSet {
        // Places count all kinds in sequence, numbers count within a kind: with points alone the
        // places are rewritten without a look at each kind, which is the case of scenes with
        // thousands of lights.
        let mut set = LightSet { ambient, ..LightSet::default() };
        if self.points {
            places.iter_mut().for_each(|place| *place = self.of[*place as usize].1);
            set.numbers[Kind::Point as usize] = places;
            return set;
        }
        for place in places {
            let (kind, number) = self.of[place as usize];
            set.numbers[kind as usize].push(number);
        }
        set
    }
}
