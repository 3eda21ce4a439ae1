//! Lints of hazards of lighting code, one file per lint.

pub(super) mod ambient_per_light;
pub(super) mod attenuation_division;
pub(super) mod cone_division;
pub(super) mod cosine_cone;
pub(super) mod degrees_for_cosine;
pub(super) mod kahan_without_precise;
pub(super) mod loop_past_count;
pub(super) mod mediump_position;
pub(super) mod pow_of_negative;
pub(super) mod pow_of_zero;
pub(super) mod unclamped_count;
pub(super) mod ungated_specular;
pub(super) mod unguarded_normalize;
pub(super) mod unguarded_operation;
pub(super) mod uninitialised_accumulator;
pub(super) mod unnormalised_normal;
pub(super) mod vec4_normalise;

use super::definition::{Check, Lint};
use landfall_layout::finding::Level;
