//! The executable stages, and the grid of a single run.

use landfall_layout::source::{ExecutableStage, Stage};

use super::{Failure, Grid, Texel};

/// Returns the stage as an executable stage.
///
/// # Errors
/// Fails for stages that no backend executes.
pub fn executable(stage: Stage) -> Result<ExecutableStage, Failure> {
    let refused = || {
        Failure::refused(
            format!(
                "a {} shader cannot run: only vertex, fragment and compute shaders can",
                stage.name()
            ),
            "",
        )
    };
    ExecutableStage::from_stage(stage).ok_or_else(refused)
}

/// Returns the grid that runs a stage once.
pub fn single_run(stage: ExecutableStage) -> Grid {
    match stage {
        ExecutableStage::Vertex => Grid::Points { count: 1, texel: Texel::Uint },
        ExecutableStage::Fragment => Grid::Image { width: 1, height: 1, texel: Texel::Uint },
        ExecutableStage::Compute => Grid::Groups([1, 1, 1]),
    }
}
