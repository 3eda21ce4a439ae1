//! A lint: its code, its level, what it is for, and the function that checks a shader for it.

use landfall_ir::analysis::hazard::Hazard;
use landfall_layout::finding::{Finding, Level};
use landfall_layout::source::Source;
use landfall_layout::{Options, ShaderLayout};

use super::settings::Settings;

/// A kind of finding.
#[derive(Debug)]
pub struct Lint {
    /// Kebab-case name: `stale-comment`.
    pub code: &'static str,
    /// The level it has unless somebody says otherwise.
    pub level: Level,
    /// What it reports, in one sentence.
    pub what: &'static str,
    /// What goes wrong if it is left.
    pub why: &'static str,
    /// A small shader it reports.
    pub example: &'static str,
    /// How it is mended.
    pub fix: &'static str,
    /// How it is found.
    pub check: Check,
}

impl Lint {
    /// Returns the hazards that the code it reports may meet.
    pub fn hazards(&self) -> &'static [Hazard] {
        match self.check {
            Check::Hazard(kind) => kind.hazards(),
            Check::Shader(_) | Check::Tree(_) | Check::Elsewhere => &[],
        }
    }
}

/// How the findings of a lint are found.
#[derive(Clone, Copy, Debug)]
pub enum Check {
    /// In one shader.
    Shader(fn(&Subject<'_>, &Settings) -> Vec<Finding>),
    /// By looking at all shaders of a run.
    Tree(fn(&[Subject<'_>], &Settings) -> Vec<Finding>),
    /// In one shader that has lights, with all others of this kind at once.
    Hazard(landfall_ir::analysis::hazards::Kind),
    /// By comparing with a lock, or with what `verify` found.
    Elsewhere,
}

/// A shader that lints look at.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// Its text.
    pub source: &'a Source,
    /// How it was laid out; naga was asked too where [`naga_disagrees::wanted`](crate::naga_disagrees::wanted) says so.
    pub options: &'a Options,
    /// Its layout; it has no errors.
    pub shader: &'a ShaderLayout,
}
