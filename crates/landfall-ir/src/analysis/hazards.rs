//! Finds the hazards of a shader's lighting by following values symbolically through its IR.
//!
//! `walk` interprets a [`Module`] symbolically from its entry points, with calls inlined: every
//! value is a node of a `graph`, `abstract_domain` holds the known facts about it, and `checks`
//! examines each operation under the conditions that hold there. The results are [`Occurrence`]s
//! with spans in the source text; `landfall_lint::hazard_findings` turns them into findings.

mod abstract_domain;
mod checks;
mod control;
mod expression;
pub mod falloff;
mod graph;
mod memory;
mod operation;
mod refine;
mod specular;
mod verdict;
mod walk;

use super::hazard::Hazard;
use super::occurrence::{Access, Certainty, HazardReport, IndexBound, Kind, Occurrence};
use super::roles::LightBinding;
use landfall_layout::Diagnostic;
use landfall_layout::source::{Language, Source, Stage};

use crate::module::Module;

/// Follows the values of a module with these lights, and returns hazards and accesses.
///
/// # Errors
/// The constructs that are not supported.
pub fn find(
    module: &Module,
    source: &Source,
    lights: &[LightBinding<'_>],
) -> Result<HazardReport, Vec<Diagnostic>> {
    let precise = source.language == Language::Glsl
        // The word anywhere in the text: `precise` is a qualifier that the IR does not keep (GLSL
        // 4.60 §4.9).
        && source.text.split(|c: char| !c.is_alphanumeric() && c != '_').any(|w| w == "precise");
    let setting = HazardSetting {
        language: source.language,
        // A text of unknown stage may be a fragment stage.
        fragment: source.stage.is_none_or(|stage| stage == Stage::Fragment),
        precise,
    };
    crate::stack::over_shader(|| Ok(walk::follow(module, lights, setting)))
}

/// Properties of the shader as a whole.
#[derive(Clone, Copy, Debug)]
struct HazardSetting {
    language: Language,
    /// Whether inputs may be interpolated.
    fragment: bool,
    /// Whether some of its sums are declared `precise`.
    precise: bool,
}
