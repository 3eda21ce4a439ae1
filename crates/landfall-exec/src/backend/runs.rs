//! The executable stages: whether a stage is one, and the grid on which it runs once.

use landfall_layout::source::{ExecutableStage, Stage};

use super::{Failure, Grid, Texel};

/// The executable stage, if supported.
///
/// # Errors
/// Stages that no backend executes.
pub fn executable(stage: Stage) -> Result<ExecutableStage, Failure> {
    let refused = || Failure::refused(format!("a {} shader cannot run", stage.name()), "");
    ExecutableStage::of(stage).ok_or_else(refused)
}

/// The grid on which a stage runs once.
pub fn single_run(stage: ExecutableStage) -> Grid {
    match stage {
        ExecutableStage::Vertex => Grid::Points { count: 1, texel: Texel::Uint },
        ExecutableStage::Fragment => Grid::Image { width: 1, height: 1, texel: Texel::Uint },
        ExecutableStage::Compute => Grid::Groups([1, 1, 1]),
    }
}
