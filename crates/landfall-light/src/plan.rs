//! A plan: which fragments are lit by which lights, and what that saves. Plain data.
//!
//! Made by [`skip::plan`](crate::skip::plan()); executed by the [compiled models](crate::compiled)
//! and by [`render`](crate::render), which uploads each draw's lights next to each other; printed
//! by the report of `render --skip`.

use std::ops::Range;

use glam::DVec3;

mod interpolation;
mod settings;

pub use interpolation::interpolate;
pub(crate) use interpolation::places;
pub use settings::{Compiled, Place, Setting, Value};

use crate::Fragment;

/// Which fragments are lit by which lights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// Each fragment of the frame is in exactly one of them.
    pub draws: Vec<Draw>,
    /// Places where far lights are evaluated instead of at each fragment, parents first.
    pub grids: Vec<Grid>,
    /// The same lists as buffers, a tile each, where the frame was divided in tiles.
    pub tiles: Option<TileLists>,
    /// What a shader need not hold for these lights.
    pub compiled: Compiled,
    /// What it saves, at what error.
    pub savings: Savings,
}

/// Fragments lit by the same lights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Draw {
    /// Their numbers in the frame, ascending.
    pub fragments: Vec<u32>,
    /// The lights evaluated at each.
    pub lights: LightSet,
    /// Number of the grid whose interpolated light is added.
    pub grid: Option<u32>,
}

/// Lights by their numbers in the upload, ascending: the order they are added in.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LightSet {
    /// Whether the light from everywhere is added.
    pub ambient: bool,
    /// Suns.
    pub directional: Vec<u32>,
    /// Lamps.
    pub point: Vec<u32>,
    /// Lamps with a cone.
    pub spot: Vec<u32>,
}

impl LightSet {
    /// How many there are, the light from everywhere not counted.
    pub fn len(&self) -> usize {
        self.directional.len() + self.point.len() + self.spot.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Places on a plane where lights are evaluated, for the fragments between them.
///
/// Its nodes are the Chebyshev points of a rectangle. What a fragment gets is the polynomial
/// through them; a parent's polynomial, of the same degree, is added to its children's nodes, so
/// that a fragment evaluates one however many grids it lies in. See
/// [`interpolate`].
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Row by row, `side * side`.
    pub nodes: Vec<Fragment>,
    /// Nodes in a row.
    pub side: u32,
    /// The lights evaluated there, never the light from everywhere.
    pub lights: LightSet,
    /// Number of the grid around it; less than its own.
    pub parent: Option<u32>,
    /// The middle of the rectangle.
    pub center: DVec3,
    /// Unit vectors along its sides.
    pub axes: [DVec3; 2],
    /// Half its length along each.
    pub half: [f64; 2],
}

/// Which point lights each tile of a frame has.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TileLists {
    /// Pixels along a tile's side.
    pub size: u32,
    /// Tiles in a row: tile `row * columns + column` holds the pixels from
    /// `(column * size, row * size)`, rows counted from the top.
    pub columns: u32,
    /// Rows of tiles.
    pub rows: u32,
    /// Of each tile, the first of its entries in `indices`, and how many they are.
    pub tiles: Vec<[u32; 2]>,
    /// Numbers of point lights, ascending in each tile. Never empty: no shader language knows
    /// an empty buffer.
    pub indices: Vec<u32>,
}

/// What a plan saves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Savings {
    /// Fragments of the frame.
    pub fragments: u64,
    /// Light evaluations of the plain loop: over every slot the shader has.
    pub before: u64,
    /// Light evaluations of the plan, those at nodes included.
    pub after: u64,
    /// What each option did, in the order they were applied.
    pub steps: Vec<Step>,
    /// How far the picture is from that of all lights, by the reader that made it.
    pub checked: Option<Measured>,
    /// Constants the shader was compiled with for it, as `NAME=VALUE`.
    pub compiled: Vec<String>,
    /// What is worth a warning: lights without a bound, lights that no slot is left for.
    pub notes: Vec<String>,
}

/// What one option did.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The option as it is asked for.
    pub option: String,
    /// What it did, with numbers.
    pub did: String,
    /// Light evaluations before and after, where it changes them.
    pub evaluations: Option<[u64; 2]>,
    /// What it may change in the picture.
    pub error: Claim,
    /// Lights held against regions to make it.
    pub tests: u64,
}

/// What a skip may change in the picture; steps are 1/255.
#[derive(Clone, Debug, PartialEq)]
pub enum Claim {
    /// Nothing: what is left out gives exactly zero.
    Exact(String),
    /// At most that, by a proof whose preconditions were checked.
    Proven {
        /// The most that a channel can be too dark by.
        steps: f64,
        /// By what.
        by: String,
    },
    /// That much on this frame; on another it may be more.
    Measured(Measured),
    /// Nothing bounds it and it was not measured.
    Unmeasured,
    /// Nothing, since it was not applied.
    Unused,
}

/// A difference that was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// The largest of any channel, in steps of linear light.
    pub steps: f64,
    /// Codes of 8 bits that differ.
    pub codes: u64,
    /// Of how many.
    pub of: u64,
    /// Fragments it was measured at.
    pub fragments: u64,
    /// That many of the frame's fragments for each of them.
    pub every: u64,
}

impl Plan {
    /// Everything lit by everything.
    pub fn whole(fragments: usize, lights: LightSet) -> Plan {
        let draw = Draw { fragments: numbers(0..fragments), lights, grid: None };
        Plan { draws: vec![draw], ..Plan::default() }
    }

    /// Whether a difference from the light of all lights, measured on a reader, is what the
    /// plan's steps say; if not, the shader computes another model than it was made for.
    ///
    /// Interpolation is given twice what was measured of it: another sample, another form.
    pub fn keeps(&self, checked: &Measured) -> bool {
        let most = self.savings.steps.iter().map(|step| match &step.error {
            Claim::Exact(_) | Claim::Unused => 0.0,
            Claim::Proven { steps, .. } => *steps,
            Claim::Measured(measured) => 2.0 * measured.steps,
            Claim::Unmeasured => f64::INFINITY,
        });
        // What rounding may differ by where lights are added in another order.
        checked.steps <= most.sum::<f64>() + 1e-2
    }

    /// Light evaluations it takes.
    pub fn evaluations(&self) -> u64 {
        let product = |a: usize, b: &LightSet| a as u64 * b.len() as u64;
        let draws = self.draws.iter().map(|draw| product(draw.fragments.len(), &draw.lights));
        let grids = self.grids.iter().map(|grid| product(grid.nodes.len(), &grid.lights));
        draws.sum::<u64>() + grids.sum::<u64>()
    }
}

fn numbers(range: Range<usize>) -> Vec<u32> {
    range.map(|n| n as u32).collect()
}
