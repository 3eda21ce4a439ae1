//! What the command prints itself, and gives the server for its answers.

use landfall_check::pass::{CheckRun, Pass};
use landfall_check::texts::Texts;
use landfall_layout::finding::Finding;
use landfall_layout::{Options, ShaderLayout, Source, Span};

/// The functions that print it.
#[derive(Clone, Copy)]
pub struct CommandTexts {
    /// The page of `report`, opened at a block.
    pub page: fn(&CheckRun<'_>, &Pass, &[Finding], &Texts, Option<&str>) -> String,
    /// What `lights` says of one function; `None` in a build that follows no functions.
    pub lights: Option<fn(&FunctionQuery<'_>) -> FunctionLights>,
}

/// A function of a shader.
pub struct FunctionQuery<'q> {
    pub source: &'q Source,
    pub options: &'q Options,
    pub shader: &'q ShaderLayout,
    /// Whether it has a place.
    pub holds: &'q dyn Fn(Span) -> bool,
    /// Whether it reads a path of a block; of none, whether it names a structure.
    pub reads: &'q dyn Fn(&str, &str) -> bool,
}

/// What is known of the lights of a function.
#[derive(Default)]
pub struct FunctionLights {
    /// The lights that it reads, as a table with the members of each; empty if it reads none.
    pub text: String,
    /// The hazards in it.
    pub hazards: Vec<Finding>,
    /// Why its hazards and the bounds of its loops are unknown.
    pub unfollowed: Option<String>,
}
