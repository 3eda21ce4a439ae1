//! Lints: what is wrong, risky or wasteful in a layout that can be computed.
//!
//! One file a lint, listed in [`LINTS`]. They read [`ShaderLayout`]s and the
//! texts behind them; the command asks them and renders their [`Finding`]s.

pub mod allow;
pub mod digest;
pub mod fix;

pub mod render;
pub mod run;
pub mod settings;

mod array_stride_waste;
mod block_mismatch;
mod bool_in_block;
mod buffer_too_small;
mod define_changes_layout;
pub mod drift;
pub mod driver_disagrees;
mod glob;
pub mod hazards;
mod layout_drift;
mod lock_missing;
mod lock_orphan;
mod mat3_padding;
pub mod naga_disagrees;
mod over_limit;
mod push_constant_limit;
mod reorder_saves;
mod rules_undeclared;
pub mod rust_mirror;
mod scalar_after_vec3;
mod show;
mod stale_comment;
mod unused_allow;
mod unused_block;
mod unused_member;
mod vec3_array;
mod walk;
mod webgl2_size;

use landfall_ir::analysis::hazard::Hazard;
use landfall_layout::source::Source;
use landfall_layout::{Options, ShaderLayout};

pub use reorder_saves::smaller_order;

pub use landfall_layout::finding::{Edit, Finding, Level, Place, Related};
pub use settings::Settings;

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
    /// The level it has under those settings while nobody sets one by name.
    pub fn level_under(&self, settings: &Settings) -> Level {
        // What wgpu reads wrong is certain to be wrong for who runs on it.
        if self.code == naga_disagrees::CODE && settings.targets.contains(&settings::Target::WebGpu)
        {
            return Level::Deny;
        }
        self.level
    }
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
    /// How it was laid out; naga was asked too where [`naga_disagrees::wanted`] says so.
    pub options: &'a Options,
    /// Its layout; it has no errors.
    pub shader: &'a ShaderLayout,
}

/// Every lint, by code.
pub const LINTS: &[&Lint] = &[
    &hazards::ambient_per_light::LINT,
    &array_stride_waste::LINT,
    &hazards::attenuation_division::LINT,
    &block_mismatch::LINT,
    &bool_in_block::LINT,
    &buffer_too_small::LINT,
    &hazards::cone_division::LINT,
    &hazards::cosine_cone::LINT,
    &define_changes_layout::LINT,
    &hazards::degrees_for_cosine::LINT,
    &driver_disagrees::LINT,
    &hazards::kahan_without_precise::LINT,
    &layout_drift::LINT,
    &lock_missing::LINT,
    &lock_orphan::LINT,
    &hazards::loop_past_count::LINT,
    &mat3_padding::LINT,
    &hazards::mediump_position::LINT,
    &naga_disagrees::LINT,
    &over_limit::LINT,
    &hazards::pow_of_negative::LINT,
    &hazards::pow_of_zero::LINT,
    &push_constant_limit::LINT,
    &reorder_saves::LINT,
    &rules_undeclared::LINT,
    &rust_mirror::LINT,
    &rust_mirror::UNKNOWN,
    &scalar_after_vec3::LINT,
    &stale_comment::LINT,
    &hazards::unclamped_count::LINT,
    &hazards::ungated_specular::LINT,
    &hazards::unguarded_normalize::LINT,
    &hazards::uninitialised_accumulator::LINT,
    &hazards::unnormalised_normal::LINT,
    &unused_allow::LINT,
    &unused_block::LINT,
    &unused_member::LINT,
    &vec3_array::LINT,
    &hazards::vec4_normalise::LINT,
    &webgl2_size::LINT,
];

/// The lint of that code.
pub fn lint(code: &str) -> Option<&'static Lint> {
    LINTS.iter().find(|lint| lint.code == code).copied()
}

/// Returns the code of the lint that a hazard's earlier spelling means: `pow-of-zero` for
/// `power-of-zero`. `None` for codes of lints and for all others.
pub fn renamed(code: &str) -> Option<&'static str> {
    let hazard = Hazard::named(code).filter(|hazard| hazard.info().aliases.contains(&code))?;
    lint(hazard.code()).map(|lint| lint.code).filter(|now| *now != code)
}

/// The known name nearest to one that is not: two edits away at most.
pub fn nearest<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    landfall_layout::text::edit_distance::nearest(name, known)
}
