//! What the parts of a plan cost, to tell whether dividing a frame saves more than it costs.

use crate::plan::Plan;

/// Nanoseconds each thing takes where the plan is made and executed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Costs {
    /// A light evaluated for a fragment.
    pub evaluation: f64,
    /// A light held against a region.
    pub test: f64,
    /// A fragment put into a region.
    pub sort: f64,
    /// A draw: its lights put next to each other and uploaded.
    pub draw: f64,
    /// A light put next to the others of a draw.
    pub light: f64,
    /// A fragment's interpolated light.
    pub interpolation: f64,
    /// What a call that uploads bytes costs, in bytes that could be moved instead.
    pub call: usize,
}

impl Costs {
    /// The compiled robust form on one core, as `cargo bench --bench light` measured it.
    pub const CPU: Costs = Costs {
        evaluation: 10.0,
        test: 15.0,
        sort: 30.0,
        draw: 100.0,
        light: 8.0,
        interpolation: 25.0,
        call: 1024,
    };

    /// The evaluator of this crate, which interprets the shader on all cores.
    pub const EVALUATOR: Costs =
        Costs { evaluation: 50.0, draw: 100_000.0, light: 1_000.0, ..Costs::CPU };

    /// A driver, to which every draw is a job of its own that is waited for.
    pub const DRIVER: Costs =
        Costs { evaluation: 8.0, draw: 1_000_000.0, light: 1_000.0, ..Costs::CPU };

    /// The same where the shader finds its lights in lists: a region is an entry of a buffer, and
    /// all of them are one draw.
    pub fn by_lists(self) -> Costs {
        Costs { draw: Costs::CPU.draw, light: Costs::CPU.light, ..self }
    }

    /// Modelled nanoseconds of lighting a frame by a plan, with what making it took.
    pub fn of(&self, plan: &Plan, tests: u64, sorted: u64) -> f64 {
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
