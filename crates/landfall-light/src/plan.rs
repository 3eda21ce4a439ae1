//! Plans of lighting: the lights of each fragment, and the savings.
//!
//! Built by [`culling::plan`](crate::culling::plan()); executed by the [compiled
//! models](crate::shading_f32) and by [`render`](crate::render), which uploads the lights of each
//! draw; printed by the report of `render --skip`.

use std::ops::Range;

use glam::DVec3;

mod choice;
mod interpolation;
mod lists;
mod settings;

pub use choice::{Choice, Timed};
pub(crate) use interpolation::Interpolation;
pub use interpolation::interpolate;
pub(crate) use interpolation::places;
pub use settings::{Compiled, ConstantKind, Setting, Value};

use crate::Fragment;

/// A plan of lighting.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// The draws; each fragment of the frame is in exactly one.
    pub draws: Vec<Draw>,
    /// The grids where far lights are evaluated instead of at each fragment, parents first.
    pub grids: Vec<Grid>,
    /// The light lists as buffers, if the frame was divided into tiles.
    pub tiles: Option<TileLists>,
    /// The numbers of lights that a shader must hold.
    pub compiled: Compiled,
    /// The savings and errors.
    pub savings: Savings,
}

/// Fragments lit by the same lights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Draw {
    /// The indices of fragments in the frame, ascending.
    pub fragments: Vec<u32>,
    /// The lights evaluated at each fragment.
    pub lights: LightSet,
    /// The index of the grid whose interpolated light is added.
    pub grid: Option<u32>,
}

/// Indices of lights in the upload, in the order of the sum: ascending but in grids.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LightSet {
    /// Whether ambient light is added.
    pub ambient: bool,
    /// The directional lights.
    pub directional: Vec<u32>,
    /// The point lights.
    pub point: Vec<u32>,
    /// The spotlights.
    pub spot: Vec<u32>,
}

impl LightSet {
    /// Returns the number of lights, the ambient one not counted.
    pub fn len(&self) -> usize {
        self.directional.len() + self.point.len() + self.spot.len()
    }

    /// Whether there are no lights, the ambient one not counted.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Points on a plane where lights are evaluated, for the fragments between them.
///
/// The nodes are the Chebyshev points of a rectangle. A fragment gets the polynomial through them, to
/// which that of the parent is added, so that a fragment evaluates only one. See [`interpolate`].
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// The nodes, row by row, `side * side`.
    pub nodes: Vec<Fragment>,
    /// The nodes in a row.
    pub side: u32,
    /// The lights evaluated at the nodes, never the ambient one.
    pub lights: LightSet,
    /// The index of the grid around it, on the same axes or rectangle; less than its own.
    pub parent: Option<u32>,
    /// The centre of the rectangle.
    pub center: DVec3,
    /// The unit vectors along its sides.
    pub axes: [DVec3; 2],
    /// Half its length along each side.
    pub half: [f64; 2],
}

/// The lights of each tile of a frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TileLists {
    /// The side of a tile in pixels.
    pub size: u32,
    /// The tiles in a row: tile `row * columns + column` holds the pixels from `(column * size, row
    /// * size)`, rows counted from the top.
    pub columns: u32,
    /// The rows of tiles.
    pub rows: u32,
    /// The start of each tile's list of point lights in `indices`, and its length.
    pub tiles: Vec<[u32; 2]>,
    /// The start of each tile's list of spotlights in `indices`, and its length.
    pub spots: Vec<[u32; 2]>,
    /// Bit `n` of a tile's number: whether it needs directional light `n`. Those from the 33rd on
    /// have no bit, and every tile needs them.
    pub directional: Vec<u32>,
    /// The indices of point lights and of spotlights in the upload, ascending in each list. Never
    /// empty, since no shader language has empty buffers.
    pub indices: Vec<u32>,
}

/// The savings of a plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Savings {
    /// The fragments of the frame.
    pub fragments: u64,
    /// The light evaluations of a loop over every slot of the shader.
    pub before: u64,
    /// The light evaluations of the plan, those at nodes included.
    pub after: u64,
    /// The effect of each option, in the order applied.
    pub steps: Vec<OptionEffect>,
    /// What was measured to pick the options, if they were picked.
    pub choice: Option<Choice>,
    /// The measured difference from the picture with all lights, on the same backend.
    pub checked: Option<Measured>,
    /// The constants the shader was compiled with, as `NAME=VALUE`.
    pub compiled: Vec<String>,
    /// Warnings: lights without a bound, lights without a slot.
    pub notes: Vec<String>,
}

/// The effect of one option.
#[derive(Clone, Debug, PartialEq)]
pub struct OptionEffect {
    /// The option in the notation of `--skip`.
    pub option: String,
    /// A description of the effect, with numbers.
    pub did: String,
    /// The light evaluations before and after, where it changes them.
    pub evaluations: Option<[u64; 2]>,
    /// The error in the picture.
    pub error: Claim,
    /// The tests of a light against a region.
    pub tests: u64,
}

/// The error of an option in the picture; steps are 1/255.
#[derive(Clone, Debug, PartialEq)]
pub enum Claim {
    /// No error: the lights dropped contribute exactly zero.
    Exact(String),
    /// A proven bound whose preconditions were checked.
    Proven {
        /// The largest darkening of a channel.
        steps: f64,
        /// The proof.
        by: String,
    },
    /// The error on this frame; on others it may be larger.
    Measured(Measured),
    /// Neither bounded nor measured.
    Unmeasured,
    /// None, since the option was not applied.
    Unused,
}

/// A measured difference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// The maximum of any channel, in steps of linear light.
    pub steps: f64,
    /// The 8-bit codes that differ.
    pub codes: u64,
    /// The codes compared.
    pub of: u64,
    /// The fragments measured.
    pub fragments: u64,
    /// The interval between measured fragments of the frame.
    pub every: u64,
}

impl Plan {
    /// The plan of lighting all fragments with all of the lights.
    pub fn all_lights(fragments: usize, lights: LightSet) -> Plan {
        let draw = Draw { fragments: numbers(0..fragments), lights, grid: None };
        Plan { draws: vec![draw], ..Plan::default() }
    }

    /// Whether the difference from the picture with all lights, measured on a backend, is within
    /// the plan's errors; if not, the shader computes another model than the plan assumes.
    ///
    /// Interpolation may differ by twice its measured error, on other samples or in another form.
    pub fn is_confirmed_by(&self, checked: &Measured) -> bool {
        let most = self.savings.steps.iter().map(|step| match &step.error {
            Claim::Exact(_) | Claim::Unused => 0.0,
            Claim::Proven { steps, .. } => *steps,
            Claim::Measured(measured) => 2.0 * measured.steps,
            Claim::Unmeasured => f64::INFINITY,
        });
        checked.steps <= most.sum::<f64>() + ROUNDING
    }

    /// Returns the largest error in steps that its claims permit; `None` if one of its options is
    /// measured only, which permits any.
    pub fn permitted(&self) -> Option<f64> {
        let each = self.savings.steps.iter().map(|step| match &step.error {
            Claim::Exact(_) | Claim::Unused => Some(0.0),
            Claim::Proven { steps, .. } => Some(*steps),
            // Gates and the like leave the plan as it is.
            Claim::Measured(_) if step.evaluations.is_none() => Some(0.0),
            Claim::Measured(_) | Claim::Unmeasured => None,
        });
        each.sum()
    }

    /// Settles its claims by the difference from the picture with all lights, measured with the
    /// shader itself: a claim about the model becomes what was measured, unless `shown` says that
    /// the shader was shown to compute the model. Returns false, and becomes the plan of `all`
    /// lights, if the difference is more than the claims permit.
    pub fn settle(&mut self, checked: Measured, shown: bool, all: LightSet) -> bool {
        // Options that were picked must keep the error asked for, those named their own.
        let asked = self.savings.choice.as_ref().map(|choice| choice.permitted);
        let permitted = asked.or_else(|| self.permitted());
        let rounding = if asked.is_some() { 0.0 } else { ROUNDING };
        let holds = permitted.is_none_or(|most| checked.steps <= most + rounding);
        for step in &mut self.savings.steps {
            let applied = step.evaluations.is_some();
            match &step.error {
                _ if !applied => {}
                _ if !holds => {
                    step.did = format!(
                        "not applied: without these lights the shader's result changes by {} \
                         steps, more than the permitted {}",
                        figure(checked.steps),
                        figure(permitted.unwrap_or_default()),
                    );
                    (step.evaluations, step.error) = (None, Claim::Unused);
                }
                Claim::Exact(_) | Claim::Proven { .. } if !shown => {
                    step.error = Claim::Measured(checked);
                }
                Claim::Measured(modelled) => {
                    // The model's measurement has more fragments, the shader's is of the shader.
                    let worse = if checked.steps > modelled.steps { checked } else { *modelled };
                    step.error = Claim::Measured(worse);
                }
                Claim::Exact(_) | Claim::Proven { .. } | Claim::Unmeasured | Claim::Unused => {}
            }
        }
        self.savings.checked = Some(checked);
        if !holds {
            self.savings.choice.iter_mut().for_each(|choice| choice.picked = 0);
            let fragments = self.draws.iter().map(|draw| draw.fragments.len()).sum();
            let savings = Savings {
                after: self.savings.before,
                compiled: Vec::new(),
                ..std::mem::take(&mut self.savings)
            };
            *self = Plan { savings, ..Plan::all_lights(fragments, all) };
        }
        holds
    }

    /// Returns the number of light evaluations.
    pub fn evaluations(&self) -> u64 {
        let product = |a: usize, b: &LightSet| a as u64 * b.len() as u64;
        let draws = self.draws.iter().map(|draw| product(draw.fragments.len(), &draw.lights));
        let grids = self.grids.iter().map(|grid| product(grid.nodes.len(), &grid.lights));
        draws.sum::<u64>() + grids.sum::<u64>()
    }
}

/// The rounding error of adding lights in another order, in steps.
const ROUNDING: f64 = 1e-2;

fn figure(steps: f64) -> String {
    match steps {
        s if s >= 10.0 => format!("{s:.0}"),
        s => format!("{s:.2}"),
    }
}

fn numbers(range: Range<usize>) -> Vec<u32> {
    range.map(|n| n as u32).collect()
}
