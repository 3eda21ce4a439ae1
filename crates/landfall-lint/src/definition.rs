//! A lint: its code, its level, its explanation, and the function that checks a shader for it.

use landfall_ir::analysis::hazard::Hazard;
use landfall_ir::analysis::occurrence::Kind;
use landfall_layout::finding::{Finding, Level};
use landfall_layout::source::Source;
use landfall_layout::{Options, ShaderLayout};

use super::hazard_text::HazardText;
use super::settings::Settings;

/// A kind of finding.
#[derive(Debug)]
pub struct Lint {
    /// Kebab-case name: `stale-comment`.
    pub code: &'static str,
    /// The default level.
    pub level: Level,
    /// The construct that it reports, as a noun phrase without a full stop.
    pub what: &'static str,
    /// The consequences of leaving it.
    pub why: &'static str,
    /// A small shader with a finding.
    pub example: &'static str,
    /// The edit that resolves a finding.
    pub fix: &'static str,
    pub check: Check,
}

impl Lint {
    /// Returns the hazards that the reported code may cause.
    pub fn hazards(&self) -> &'static [Hazard] {
        match self.check {
            Check::Hazard(kind, _) => kind.hazards(),
            Check::Shader(_)
            | Check::Functions
            | Check::Naga(_)
            | Check::Tree(_)
            | Check::Elsewhere => &[],
        }
    }

    /// Whether this build includes it; some lints need the feature `analysis`.
    pub fn is_built(&self) -> bool {
        match self.check {
            Check::Hazard(..) | Check::Naga(_) => cfg!(feature = "analysis"),
            Check::Shader(_) | Check::Functions | Check::Tree(_) | Check::Elsewhere => true,
        }
    }
}

/// The input from which a lint computes its findings.
#[derive(Clone, Copy, Debug)]
pub enum Check {
    /// One shader.
    Shader(fn(&Subject<'_>, &Settings) -> Vec<Finding>),
    /// The functions of one shader, which are read once for this one and the lints of hazards.
    Functions,
    /// One shader that naga parses, in builds with the feature `analysis`.
    Naga(fn(&Subject<'_>, &Settings) -> Vec<Finding>),
    /// All shaders of a run.
    Tree(fn(&[Subject<'_>], &Settings) -> Vec<Finding>),
    /// One shader with lights, in builds with the feature `analysis`; all lints of this variant share
    /// one analysis, and each writes its findings.
    Hazard(Kind, HazardText),
    /// A lock, a report of `verify`, or another source outside this crate's lint functions.
    Elsewhere,
}

/// A shader that lints check.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    pub source: &'a Source,
    /// The options of its layout; they include the comparison with naga if
    /// [`naga_disagrees::applies_to`](crate::naga_disagrees::applies_to).
    pub options: &'a Options,
    /// The layout, which has no errors.
    pub shader: &'a ShaderLayout,
}
