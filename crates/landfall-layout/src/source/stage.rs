//! Pipeline stages, and the file extensions that imply them.

/// The pipeline stage of a GLSL shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
#[non_exhaustive]
pub enum Stage {
    Vertex,
    TessellationControl,
    TessellationEvaluation,
    Geometry,
    Fragment,
    Compute,
    Task,
    Mesh,
    RayGeneration,
    Intersection,
    AnyHit,
    ClosestHit,
    Miss,
    Callable,
}

/// Every stage, its name in messages and JSON, and the file extensions that imply it.
const STAGES: &[(Stage, &str, &[&str])] = &[
    // glslang's extensions come first, behind them those of engines and editors.
    (Stage::Vertex, "vertex", &["vert", "vs", "vsh", "vertex", "vshader"]),
    (Stage::TessellationControl, "tess_control", &["tesc", "tcs", "cont"]),
    (Stage::TessellationEvaluation, "tess_evaluation", &["tese", "tes", "eval"]),
    (Stage::Geometry, "geometry", &["geom", "gs", "gsh"]),
    (Stage::Fragment, "fragment", &["frag", "fs", "fsh", "ps", "fragment", "fshader"]),
    (Stage::Compute, "compute", &["comp", "cs", "compute"]),
    (Stage::Task, "task", &["task"]),
    (Stage::Mesh, "mesh", &["mesh"]),
    (Stage::RayGeneration, "ray_generation", &["rgen"]),
    (Stage::Intersection, "intersection", &["rint"]),
    (Stage::AnyHit, "any_hit", &["rahit"]),
    (Stage::ClosestHit, "closest_hit", &["rchit"]),
    (Stage::Miss, "miss", &["rmiss"]),
    (Stage::Callable, "callable", &["rcall"]),
];

impl Stage {
    /// Returns the name used in messages and JSON, such as `fragment`.
    pub fn name(self) -> &'static str {
        STAGES
            .iter()
            .find(|row| row.0 == self)
            .map(|row| row.1)
            .expect("every stage has a row in STAGES")
    }

    /// Returns the stage with that name or extension: `fragment` and `frag` are the same stage.
    pub fn from_name(name: &str) -> Option<Stage> {
        let name = name.to_ascii_lowercase();
        STAGES.iter().find(|row| row.1 == name || row.2.contains(&name.as_str())).map(|row| row.0)
    }

    /// Returns the name of every stage, as [`Stage::name`] does.
    pub fn names() -> impl Iterator<Item = &'static str> {
        STAGES.iter().map(|row| row.1)
    }
}

/// A stage that landfall can execute.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ExecutableStage {
    /// Vertex stage.
    Vertex,
    /// Fragment stage.
    Fragment,
    /// Compute stage.
    Compute,
}

impl ExecutableStage {
    /// The executable stage, if supported.
    pub fn from_stage(stage: Stage) -> Option<ExecutableStage> {
        match stage {
            Stage::Vertex => Some(ExecutableStage::Vertex),
            Stage::Fragment => Some(ExecutableStage::Fragment),
            Stage::Compute => Some(ExecutableStage::Compute),
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
}

impl From<ExecutableStage> for Stage {
    fn from(runs: ExecutableStage) -> Stage {
        match runs {
            ExecutableStage::Vertex => Stage::Vertex,
            ExecutableStage::Fragment => Stage::Fragment,
            ExecutableStage::Compute => Stage::Compute,
        }
    }
}

/// The stage that an extension in lower case implies.
pub(super) fn stage_of_extension(extension: &str) -> Option<Stage> {
    STAGES.iter().find(|row| row.2.contains(&extension)).map(|row| row.0)
}
