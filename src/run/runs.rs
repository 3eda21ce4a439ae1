//! What it takes to run a stage: the grid on which it runs once, or why it does not run.
//!
//! The probes, calls and readers of this folder match on these three stages.

use super::reader::{Failure, Grid, Texel};
use crate::source::{Runs, Stage};

impl Runs {
    /// It, or that it does not run.
    pub fn or_refused(stage: Stage) -> Result<Runs, Failure> {
        let refused = || Failure::refused(format!("a {} shader cannot run", stage.name()), "");
        Runs::of(stage).ok_or_else(refused)
    }

    /// The grid on which it runs once.
    pub fn once(self) -> Grid {
        match self {
            Runs::Vertex => Grid::Points { count: 1, texel: Texel::Uint },
            Runs::Fragment => Grid::Image { width: 1, height: 1, texel: Texel::Uint },
            Runs::Compute => Grid::Groups([1, 1, 1]),
        }
    }
}
