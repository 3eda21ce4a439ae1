//! The cost model of a plan, which decides whether dividing a frame pays off.

use landfall_exec::backend::BackendKind;

use crate::plan::Plan;

/// The nanoseconds of each operation in planning and lighting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Costs {
    /// Evaluating a light for a fragment.
    pub evaluation: f64,
    /// Testing a light against a region.
    pub test: f64,
    /// Sorting a fragment into a region.
    pub sort: f64,
    /// A draw: collecting and uploading its lights.
    pub draw: f64,
    /// Adding a light to a draw.
    pub light: f64,
    /// Interpolating light for a fragment.
    pub interpolation: f64,
    /// The cost of an upload call, as the bytes that could be transferred instead.
    pub call: usize,
    /// The part of the cost without a plan that its estimate must stay below to be applied.
    pub worth: f64,
    /// Preparing a trial: writing and compiling another shader.
    pub trial: f64,
}

impl Costs {
    /// The compiled robust form on one core, measured by `cargo bench --bench light`.
    pub const CPU: Costs = Costs {
        evaluation: 2.0,
        test: 10.0,
        sort: 12.0,
        draw: 100.0,
        light: 8.0,
        interpolation: 25.0,
        call: 1024,
        worth: 1.0,
        trial: 0.0,
    };

    /// This crate's interpreter, which interprets the shader on all cores.
    pub const INTERPRETER: Costs =
        Costs { evaluation: 50.0, draw: 100_000.0, light: 1_000.0, trial: 5e6, ..Costs::CPU };

    /// A driver, where every draw is a job of its own. A light that is read by an index from a list
    /// costs 1.9 to 2.2 times one of a plain loop (llvmpipe, both APIs, 1,024 lights), so that a plan
    /// must save more.
    pub const DRIVER: Costs = Costs {
        evaluation: 8.0,
        draw: 1_000_000.0,
        light: 1_000.0,
        worth: 0.45,
        trial: 4e7,
        ..Costs::CPU
    };

    /// Returns the costs of a shader on a backend. With light lists a region is an entry of a
    /// buffer, and all regions share one draw.
    pub fn for_backend(backend: BackendKind, lists: bool) -> Costs {
        let costs = if backend.is_driver() { Costs::DRIVER } else { Costs::INTERPRETER };
        match lists {
            true => Costs { draw: Costs::CPU.draw, light: Costs::CPU.light, ..costs },
            false => costs,
        }
    }

    /// Returns the estimated nanoseconds of planning and of lighting a frame by the plan.
    pub fn total(&self, plan: &Plan, tests: u64, sorted: u64) -> f64 {
        let mut nanoseconds = self.evaluation * plan.evaluations() as f64
            + self.test * tests as f64
            + self.sort * sorted as f64;
        for draw in &plan.draws {
            nanoseconds += self.draw + self.light * draw.lights.len() as f64;
            if draw.grid.is_some() {
                nanoseconds += self.interpolation * draw.fragments.len() as f64;
            }
        }
        for grid in &plan.grids {
            nanoseconds += self.draw + self.light * grid.lights.len() as f64;
            nanoseconds += self.interpolation * grid.nodes.len() as f64;
        }
        nanoseconds
    }
}
