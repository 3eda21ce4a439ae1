//! Light culling: skips the lights that a scene does not need, and reports the savings and the
//! error.
//!
//! Reads an [`Upload`] and the [`Frame`] it lights; returns a [`Plan`], plain data that the
//! [compiled models](super::shading_f32) and the backends execute. All culling rests on the upper
//! [`bound`] of a light over a [`region`]: it drops lights with a bound of zero (exact), as many as
//! stay within a budget together (proven), or those beyond the usual cut-offs, whose sum has no
//! bound and whose error is measured.

pub mod bound;
mod cost;
mod cull;
mod lamps;
mod lists;
mod measure;
mod near;
mod options;
mod patch;
mod placed;
mod plane;
pub mod radius;
pub mod region;
mod select;
mod smooth;
mod upload;
mod used;

pub use cost::Costs;
pub use measure::{brute, compare};
pub use options::{Choose, Cull, Division, Interpolate, Options, PARTS, parse, parse_given};
pub use upload::{UploadChoice, choose};

use rustc_hash::FxHashMap;

pub use crate::plan::{
    Choice, Claim, Compiled, ConstantKind, Draw, Grid, LightSet, Measured, OptionEffect, Plan,
    Savings, Setting, TileLists, Timed, Value, interpolate,
};

use super::shading_f32::{Model, SpecularTerm};
use super::{Frame, Upload};
use bound::Bounded;
use cull::Lists;
use patch::Patched;
use region::Points;

/// One step of 8 bits.
pub const STEP: f64 = 1.0 / 255.0;

/// The steepest slope of the sRGB transfer function, near black: a budget in steps of an sRGB
/// target is smaller in linear light by that factor.
pub const SRGB_SLOPE: f64 = 12.92;

/// Returns the plan for lighting `frame` with `upload`, and measures errors without a bound.
pub fn plan(upload: &Upload, frame: &Frame, model: &Model, options: &Options) -> Plan {
    let (mut plan, whole) = unmeasured(upload, frame, model, options);
    for at in 0..plan.savings.steps.len() {
        if plan.savings.steps[at].error == Claim::Unmeasured {
            let measured = measure::measure(&plan, &whole, upload, frame, model);
            plan.savings.steps[at].error = Claim::Measured(measured);
        }
    }
    if let Some(steps) = options.gates {
        let step = measure::gates(&plan, upload, frame, model, steps);
        plan.savings.steps.push(step);
    }
    plan
}

/// Returns the plan without measurements, as a renderer needs it every frame.
pub fn plan_only(upload: &Upload, frame: &Frame, model: &Model, options: &Options) -> Plan {
    unmeasured(upload, frame, model, options).0
}

/// Returns a plan, and the one that evaluates all used lights everywhere.
fn unmeasured(upload: &Upload, frame: &Frame, model: &Model, options: &Options) -> (Plan, Plan) {
    let all = bound::bounded(upload, model);
    let (lights, mut savings) = used::used(upload, frame, model, &all, options);
    let order: Vec<u32> = (0..lights.len() as u32).collect();
    let ambient = used::ambient(upload, model, options);
    let sets = Sets::new(&lights);
    let whole = Plan::all_lights(frame.fragments.len(), sets.set(order, ambient));
    let job = Job { upload, frame, model, options, lights: &lights, sets: &sets, ambient };
    let mut plan = match (options.interpolate, options.division) {
        (Some(interpolate), _) => job.interpolated(interpolate, &whole, &mut savings),
        (None, Division::Whole) => None,
        (None, division) => job.divided(division, &whole, &mut savings),
    }
    .unwrap_or_else(|| whole.clone());
    plan.compiled = used::compiled(&plan, ambient);
    savings.after = plan.evaluations();
    plan.savings = savings;
    (plan, whole)
}

/// The input of all parts of planning.
struct Job<'a> {
    upload: &'a Upload,
    frame: &'a Frame,
    model: &'a Model,
    options: &'a Options,
    lights: &'a [Bounded],
    sets: &'a Sets,
    ambient: bool,
}

impl Job<'_> {
    /// Returns a plan with a list per region; `None` if that costs more than it saves.
    fn divided(&self, division: Division, whole: &Plan, savings: &mut Savings) -> Option<Plan> {
        let Job { upload, frame, model, options, lights, ambient, .. } = *self;
        let before = whole.evaluations();
        let option = spelled(division, options.cull);
        let fragments = frame.fragments.len() as u64;
        let costs = &options.costs;
        let choose = options.choose == Choose::Cheaper;
        let plain = costs.total(whole, 0, 0);
        // No division saves more than the whole cost.
        if choose && costs.sort * fragments as f64 >= plain * costs.worth {
            savings.steps.push(unused(option, costs.sort * fragments as f64, plain, 0));
            return None;
        }
        let mut points = Points::new(frame, upload, model);
        // Surfaces that face away from a light show its highlight too, if there is one.
        let shows_all = options.cull == Cull::Exact
            && model.specular == SpecularTerm::Everywhere
            && !points.has_dull()
            && !lights.iter().any(Bounded::is_dull);
        if shows_all {
            points = points.undirected();
        }
        let draw = whole.draws.first()?;
        let divided = region::divide(frame, &points, upload.camera, &draw.fragments, division);
        let Lists { of, tests, dropped } = cull::lists(&divided, lights, model, options.cull);
        let tiles = lists::tile_lists(frame, &divided, lights, &of, division);
        let mut plan = Plan { draws: self.draws(divided.cells, &of), tiles, ..Plan::default() };
        let cost = costs.total(&plan, tests, fragments);
        if choose && cost >= plain * costs.worth {
            savings.steps.push(unused(option, cost, plain, tests));
            return None;
        }
        let regions = of.len();
        let after = plan.evaluations();
        let per = |n: u64| n as f64 / fragments.max(1) as f64;
        let did = format!(
            "{regions} regions, {:.1} of {:.1} lights per fragment; estimated {:.1} ms instead of {:.1}",
            per(after),
            per(before),
            cost * 1e-6,
            plain * 1e-6
        );
        let error = match options.cull {
            Cull::Exact => Claim::Exact(
                "a light left out of a region is out of range, has the region outside its cone or is behind every \
                 surface there, and contributes exactly zero"
                    .to_string(),
            ),
            Cull::Budget(_) => Claim::Proven {
                steps: dropped.max_element() / STEP,
                by: "the upper bounds of the lights left out of a region, summed, at their largest".to_string(),
            },
            Cull::Threshold(_) | Cull::Range(_) => Claim::Unmeasured,
        };
        savings.steps.push(OptionEffect {
            option,
            did,
            evaluations: Some([before, after]),
            error,
            tests,
        });
        plan.draws.retain(|draw| !draw.fragments.is_empty());
        debug_assert!(plan.draws.iter().all(|draw| draw.lights.ambient == ambient));
        Some(plan)
    }

    /// Returns the draws: regions with the same lights share one.
    fn draws(&self, cells: Vec<region::Cell>, lists: &[Vec<u32>]) -> Vec<Draw> {
        let mut draws: Vec<Draw> = Vec::new();
        let mut known: FxHashMap<&[u32], usize> = FxHashMap::default();
        for (cell, list) in cells.into_iter().zip(lists) {
            let at = *known.entry(list).or_insert_with(|| {
                let lights = self.sets.set(list.clone(), self.ambient);
                draws.push(Draw { fragments: Vec::new(), lights, grid: None });
                draws.len() - 1
            });
            match &mut draws[at].fragments {
                none if none.is_empty() => *none = cell.fragments,
                some => some.extend(cell.fragments),
            }
        }
        for draw in &mut draws {
            draw.fragments.sort_unstable();
        }
        draws
    }

    fn interpolated(
        &self,
        interpolate: Interpolate,
        whole: &Plan,
        savings: &mut Savings,
    ) -> Option<Plan> {
        let Job { frame, options, .. } = *self;
        let before = whole.evaluations();
        let Interpolate { diameters, nodes, within } = interpolate;
        let option = match within {
            Some(steps) => format!("far={steps}x{nodes}"),
            None => format!("interpolate={diameters}x{nodes}"),
        };
        let Patched { plan, tests, sorted, error } = patch::patches(self, interpolate);
        let plain = options.costs.total(whole, 0, 0);
        let cost = options.costs.total(&plan, tests, sorted);
        if options.choose == Choose::Cheaper && cost >= plain * options.costs.worth {
            savings.steps.push(unused(option, cost, plain, tests));
            return None;
        }
        let after = plan.evaluations();
        let per = |n: u64| n as f64 / frame.fragments.len().max(1) as f64;
        let most = if within.is_some() { "up to " } else { "" };
        let did = format!(
            "{} grids of {most}{nodes}x{nodes} nodes on planes, {} draws, {:.1} of {:.1} lights per \
             fragment; estimated {:.1} ms instead of {:.1}",
            plan.grids.len(),
            plan.draws.len(),
            per(after),
            per(before),
            cost * 1e-6,
            plain * 1e-6
        );
        let error = match within {
            Some(_) => Claim::Proven {
                steps: error / STEP,
                by: "the bounds of the error of interpolating each far light, summed, at their largest".to_string(),
            },
            None => Claim::Unmeasured,
        };
        savings.steps.push(OptionEffect {
            option,
            did,
            evaluations: Some([before, after]),
            error,
            tests,
        });
        Some(plan)
    }
}

/// The kinds of lights and their numbers in the upload.
struct Sets {
    of: Vec<(bound::Kind, u32)>,
    /// Whether all are point lights.
    points: bool,
}

impl Sets {
    fn new(lights: &[Bounded]) -> Sets {
        let of: Vec<_> = lights.iter().map(|light| (light.kind, light.number)).collect();
        Sets { points: of.iter().all(|(kind, _)| *kind == bound::Kind::Point), of }
    }

    /// Returns the set of the lights at those indices.
    fn set(&self, mut places: Vec<u32>, ambient: bool) -> LightSet {
        let mut set = LightSet { ambient, ..LightSet::default() };
        if self.points {
            places.iter_mut().for_each(|place| *place = self.of[*place as usize].1);
            set.point = places;
            return set;
        }
        for place in places {
            let (kind, number) = self.of[place as usize];
            match kind {
                bound::Kind::Directional => set.directional.push(number),
                bound::Kind::Point => set.point.push(number),
                bound::Kind::Spot => set.spot.push(number),
            }
        }
        set
    }
}

fn unused(option: String, cost: f64, plain: f64, tests: u64) -> OptionEffect {
    let did = format!(
        "not applied: estimated {:.2} ms with it, {:.2} ms without",
        cost * 1e-6,
        plain * 1e-6
    );
    OptionEffect { option, did, evaluations: None, error: Claim::Unused, tests }
}

fn spelled(division: Division, cull: Cull) -> String {
    let division = match division {
        Division::Whole => "whole".to_string(),
        Division::Tiles { size } => format!("tiles={size}"),
        Division::Clusters { columns, rows, slices } => {
            format!("clusters={columns}x{rows}x{slices}")
        }
    };
    match cull {
        Cull::Exact => division,
        Cull::Budget(steps) => format!("{division},budget={steps}"),
        Cull::Threshold(value) => format!("{division},below={value}"),
        Cull::Range(value) => format!("{division},cut={value}"),
    }
}
