//! The list of all lints.

use super::definition::Lint;
use super::hazards;

/// Every lint, by code. A lint is registered by its row here and its `mod` in `lib.rs`.
pub const LINTS: &[&Lint] = &[
    &hazards::ambient_per_light::LINT,
    &super::array_stride_waste::LINT,
    &hazards::attenuation_division::LINT,
    &super::block_mismatch::LINT,
    &super::bool_in_block::LINT,
    &super::buffer_too_small::LINT,
    &super::compiled_differs::LINT,
    &hazards::cone_division::LINT,
    &hazards::cosine_cone::LINT,
    &super::define_changes_layout::LINT,
    &hazards::degrees_for_cosine::LINT,
    &super::driver_disagrees::LINT,
    &super::implicit_padding::LINT,
    &super::invalid_shader::LINT,
    &hazards::kahan_without_precise::LINT,
    &super::layout_drift::LINT,
    &super::length_from_use::LINT,
    &super::lock_missing::LINT,
    &super::lock_orphan::LINT,
    &hazards::loop_past_count::LINT,
    &super::mat3_padding::LINT,
    &hazards::mediump_position::LINT,
    &super::naga_disagrees::LINT,
    &super::layout_warnings::NOT_ANALYSED,
    &super::not_proved::LINT,
    &super::over_limit::LINT,
    &hazards::pow_of_negative::LINT,
    &hazards::pow_of_zero::LINT,
    &super::push_constant_limit::LINT,
    &super::reorder_saves::LINT,
    &super::row_major_matrix::LINT,
    &super::rules_undeclared::LINT,
    &super::mirror_lints::MIRROR,
    &super::mirror_lints::UNKNOWN,
    &super::scalar_after_vec3::LINT,
    &super::specialised_length::LINT,
    &super::stale_assertions::LINT,
    &super::stale_comment::LINT,
    &super::target_changes_layout::LINT,
    &hazards::unclamped_count::LINT,
    &super::layout_warnings::UNDEFINED_MACRO,
    &hazards::ungated_specular::LINT,
    &hazards::unguarded_normalize::LINT,
    &hazards::unguarded_operation::LINT,
    &super::layout_warnings::UNIFORM_CONSTRAINTS,
    &hazards::uninitialised_accumulator::LINT,
    &super::layout_warnings::UNKNOWN_BLOCK,
    &hazards::unnormalised_normal::LINT,
    &super::unreached_block::LINT,
    &super::unused_allow::LINT,
    &super::unused_block::LINT,
    &super::unused_member::LINT,
    &super::vec3_array::LINT,
    &hazards::vec4_normalise::LINT,
    &super::webgl2_size::LINT,
];

/// Returns the lint of that code.
pub fn lint(code: &str) -> Option<&'static Lint> {
    LINTS.iter().find(|lint| lint.code == code).copied()
}
