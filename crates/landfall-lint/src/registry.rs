//! The list of all lints.

use super::definition::Lint;
use super::settings::Settings;
use super::{
    array_stride_waste, block_mismatch, bool_in_block, buffer_too_small, define_changes_layout,
    driver_disagrees, hazards, layout_drift, lock_missing, lock_orphan, mat3_padding,
    naga_disagrees, not_proved, over_limit, push_constant_limit, reorder_saves, rules_undeclared,
    rust_mirror, scalar_after_vec3, stale_comment, target_changes_layout, unused_allow,
    unused_block, unused_member, vec3_array, webgl2_size,
};
use landfall_ir::analysis::hazard::Hazard;

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
    &not_proved::LINT,
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
    &target_changes_layout::LINT,
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

/// Returns the lint of that code.
pub fn lint(code: &str) -> Option<&'static Lint> {
    LINTS.iter().find(|lint| lint.code == code).copied()
}

/// Returns the current code for a hazard's earlier spelling: `pow-of-zero` for `power-of-zero`.
/// `None` for codes of lints and for all others.
pub fn renamed(code: &str) -> Option<&'static str> {
    let hazard = Hazard::named(code).filter(|hazard| hazard.info().aliases.contains(&code))?;
    lint(hazard.code()).map(|lint| lint.code).filter(|now| *now != code)
}

/// Replaces earlier spellings of codes in the settings, and returns each replaced spelling once
/// with its current code.
pub fn resolve_renamed(settings: &mut Settings) -> Vec<(String, &'static str)> {
    let mut found = Vec::new();
    let rows = settings.path_levels.iter_mut().flat_map(|row| &mut row.levels);
    for (code, _) in settings.levels.iter_mut().chain(rows).chain(&mut settings.flag_levels) {
        let Some(now) = renamed(code) else { continue };
        let was = std::mem::replace(code, now.to_string());
        if !found.iter().any(|(known, _)| *known == was) {
            found.push((was, now));
        }
    }
    found
}
