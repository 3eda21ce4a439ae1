//! The stages that run.
//!
//! Made of a [`Stage`] where a text or a job comes in; the probes, calls and readers of this
//! folder match on these three.

use super::reader::{Failure, Grid, Texel};
use crate::source::Stage;

/// A stage that runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Runs {
    Vertex,
    Fragment,
    Compute,
}

impl Runs {
    /// It, if it runs.
    pub fn of(stage: Stage) -> Option<Runs> {
        match stage {
            Stage::Vertex => Some(Runs::Vertex),
            Stage::Fragment => Some(Runs::Fragment),
            Stage::Compute => Some(Runs::Compute),
            Stage::TessellationControl
            | Stage::TessellationEvaluation
            | Stage::Geometry
            | Stage::Task
            | Stage::Mesh
            | Stage::RayGeneration
            | Stage::Intersection
            | Stage::AnyHit
            | Stage::ClosestHit
            | Stage::Miss
            | Stage::Callable => None,
        }
    }

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

impl From<Runs> for Stage {
    fn from(runs: Runs) -> Stage {
        match runs {
            Runs::Vertex => Stage::Vertex,
            Runs::Fragment => Stage::Fragment,
            Runs::Compute => Stage::Compute,
        }
    }
}
