//! Plans of lighting: the lights of each fragment, and the savings.
//!
//! Built by [`culling::plan`](crate::culling::plan()); executed by the [compiled
//! models](crate::shading_f32) and by [`render`](crate::render), which uploads the lights of each
//! draw; printed by the report of `render --skip`.

mod lists;
mod settings;
mod times;

pub use settings::{Compiled, ConstantKind, Setting, Value};
pub use times::{Times, Whole};

use serde::Serialize;

use crate::scene::{Kind, Lights};

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// The draws; each fragment of the frame is in exactly one.
    pub draws: Vec<Draw>,
    /// The light lists as buffers, if the frame was divided into tiles.
    pub tiles: Option<TileLists>,
    /// The numbers of lights that a shader must hold.
    pub compiled: Compiled,
    pub savings: Savings,
}

/// Fragments lit by the same lights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Draw {
    /// The indices of fragments in the frame, ascending.
    pub fragments: Vec<u32>,
    pub lights: LightSet,
}

/// Indices of lights in the upload, in the order of the sum: ascending.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LightSet {
    /// Whether ambient light is added.
    pub ambient: bool,
    /// Those of each kind.
    pub numbers: [Vec<u32>; 3],
}

impl LightSet {
    pub fn all(lights: &Lights) -> LightSet {
        LightSet::first(lights.counts())
    }

    /// The ambient light, and the first lights of each kind.
    pub fn first(counts: [usize; 3]) -> LightSet {
        LightSet { ambient: true, numbers: counts.map(|count| (0..count as u32).collect()) }
    }

    /// Returns the lights of a kind.
    pub fn of(&self, kind: Kind) -> &[u32] {
        &self.numbers[kind as usize]
    }

    /// Returns the number of lights of each kind.
    pub fn counts(&self) -> [usize; 3] {
        Kind::ALL.map(|kind| self.of(kind).len())
    }

    /// Returns the number of lights, the ambient one not counted.
    pub fn count(&self) -> usize {
        self.counts().iter().sum()
    }
}

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TileLists {
    /// The side of a tile in pixels.
    pub size: u32,
    /// The tiles in a row: tile `row * columns + column` holds the pixels from `(column * size, row
    /// * size)`, rows counted from the top.
    pub columns: u32,
    /// The height of the picture in pixels.
    pub height: u32,
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

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Savings {
    pub fragments: u64,
    /// The light evaluations of a loop over every slot of the shader.
    pub before: u64,
    /// The light evaluations of the plan.
    pub after: u64,
    /// The effect of each option, in the order applied.
    pub steps: Vec<OptionEffect>,
    /// The time of planning and lighting, once the picture is lit.
    pub times: Option<Times>,
    /// The difference from the picture with all lights at every fragment, on the same backend, if
    /// it was measured.
    pub checked: Option<Measured>,
    /// The constants the shader was compiled with, as `NAME=VALUE`.
    pub compiled: Vec<String>,
    /// Warnings: lights without a bound, lights without a slot.
    pub notes: Vec<String>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "PlanStepObject"))]
pub struct OptionEffect {
    // In the notation of `--skip`.
    pub option: String,
    // A description of the effect, with numbers.
    pub did: String,
    // Where it changes them.
    pub evaluations: Option<Evaluations>,
    pub error: Claim,
    /// The tests of a light against a region.
    pub tests: u64,
}

// The light evaluations of all fragments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Evaluations {
    pub before: u64,
    pub after: u64,
}

// The error of an option in the picture; steps are 1/255.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "PlanErrorObject"))]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Claim {
    // No error: the lights dropped contribute exactly zero.
    Exact {
        why: String,
    },
    /// The most steps by which a channel of any fragment is too dark, by the bounds of the lighting
    /// model.
    Proven {
        #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
        steps: f64,
        by: String,
    },
    // The error on this frame; on others it may be larger.
    Measured {
        #[serde(flatten)]
        measured: Measured,
    },
    // None, since the option was not applied.
    Unused,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "MeasuredObject"))]
pub struct Measured {
    // The maximum of any channel, in steps of linear light. Infinity, which a pixel that is finite
    // in only one picture gives, is null in JSON.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>", range(min = 0.0)))]
    pub steps: f64,
    pub codes: u64,
    pub of: u64,
    pub fragments: u64,
    // The interval between measured fragments of the frame.
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    pub every: u64,
}

impl Plan {
    pub fn all_lights(fragments: usize, lights: LightSet) -> Plan {
        let draw = Draw { fragments: (0..fragments as u32).collect(), lights };
        Plan { draws: vec![draw], ..Plan::default() }
    }

    /// Returns the largest error in steps that its claims permit.
    pub fn permitted(&self) -> f64 {
        // Errors of parts add up: each is an upper bound of what it removes from the sum of light.
        let each = self.savings.steps.iter().map(|step| match &step.error {
            Claim::Proven { steps, .. } => *steps,
            // What gates would skip is counted only.
            Claim::Exact { .. } | Claim::Measured { .. } | Claim::Unused => 0.0,
        });
        each.sum()
    }

    /// Whether a difference from the picture with all lights is within its claims.
    pub fn permits(&self, checked: &Measured) -> bool {
        checked.steps <= self.permitted() + ROUNDING
    }

    /// Returns why it is not to be applied, by its error if it was measured and by its time, which
    /// `always` disregards; `None` if it is to be.
    pub fn drawback(
        &self,
        checked: Option<&Measured>,
        times: &Times,
        always: bool,
    ) -> Option<String> {
        // First the error, which `--skip always` cannot excuse; then the time, which it can.
        if let Some(checked) = checked.filter(|checked| !self.permits(checked)) {
            return Some(format!(
                "without these lights the shader's result changes by {} steps, more than the \
                 permitted {}",
                figure(checked.steps),
                figure(self.permitted()),
            ));
        }
        // A shader compiled for fewer lights may take less time for the same.
        if !always && self.savings.compiled.is_empty() && !self.leaves_out_enough() {
            return Some("it leaves out too little".to_string());
        }
        let costs_more = times.ratio().is_some_and(|ratio| ratio > WORTH);
        (costs_more && !always).then(|| "it costs more than it saves".to_string())
    }

    /// Whether it leaves out so many evaluations that it may pay.
    pub fn leaves_out_enough(&self) -> bool {
        // 0 of 0 evaluations leaves out enough: no loss.
        let Savings { before, after, .. } = self.savings;
        after as f64 <= before as f64 * WORTH
    }

    /// Replaces what its claims say of the model by what was measured with the shader.
    pub fn confirm(&mut self, checked: Measured) {
        for step in self.savings.steps.iter_mut().filter(|step| step.evaluations.is_some()) {
            step.error = Claim::Measured { measured: checked };
        }
        self.savings.checked = Some(checked);
    }

    /// Returns the plan of lighting `all`, which says why this one is not applied.
    pub fn refused(self, why: &str, all: LightSet) -> Plan {
        let fragments = self.savings.fragments as usize;
        let mut savings =
            Savings { after: self.savings.before, compiled: Vec::new(), ..self.savings };
        for step in &mut savings.steps {
            if step.evaluations.take().is_some() {
                step.did = format!("not applied: {why}");
                step.error = Claim::Unused;
            }
        }
        Plan { savings, ..Plan::all_lights(fragments, all) }
    }

    pub fn evaluations(&self) -> u64 {
        let product = |a: usize, b: &LightSet| a as u64 * b.count() as u64;
        self.draws.iter().map(|draw| product(draw.fragments.len(), &draw.lights)).sum()
    }
}

/// The rounding error of other operations for the same formula, in steps.
const ROUNDING: f64 = 1e-2;

/// The part of the time without skipping that skipping may take to be applied: a measured time is
/// off by some percent.
const WORTH: f64 = 0.95;

fn figure(steps: f64) -> String {
    match steps {
        s if s >= 10.0 => format!("{s:.0}"),
        s => format!("{s:.2}"),
    }
}
