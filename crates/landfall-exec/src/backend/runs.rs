//! The executable stages: whether a stage is one, and the grid on which it runs once.

use landfall_layout::source::{Runs, Stage};

use super::{Failure, Grid, Texel};

/// The executable stage, if supported.
///
/// # Errors
/// Stages that no backend executes.
pub fn executable(stage: Stage) -> Result<Runs, Failure> {
    let refused = || Failure::refused(format!("a {} shader cannot run", stage.name()), "");
    Runs::of(stage).ok_or_else(refused)
}

/// The grid on which a stage runs once.
pub fn single_run(stage: Runs) -> Grid {
    match stage {
        Runs::Vertex => Grid::Points { count: 1, texel: Texel::Uint },
        Runs::Fragment => Grid::Image { width: 1, height: 1, texel: Texel::Uint },
        Runs::Compute => Grid::Groups([1, 1, 1]),
    }
}
