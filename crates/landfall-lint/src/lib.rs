//! Lints: errors, risks and waste in layouts of blocks, and hazards of lighting code.
//!
//! Each lint has a file of its own and a row in [`LINTS`]. Lints read
//! [`ShaderLayout`](landfall_layout::ShaderLayout)s and the texts of the shaders; the command runs
//! them and renders their [`Finding`]s.
//!
//! Settings and reports are read and written as JSON: public signatures name `serde::Serialize`,
//! `serde::Deserialize` and `serde_json::Value`.

// What other crates of the workspace call; users see the facade.
#![allow(missing_docs)]

pub mod add_allow;
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
pub mod compiled_differs;
mod define_changes_layout;
mod definition;
pub mod drift;
pub mod driver_disagrees;
pub mod hazard_findings;
mod hazard_text;
mod hazards;
mod implicit_padding;
mod invalid_shader;
mod layout_drift;
mod layout_warnings;
mod length_from_use;
pub mod levels;
mod lock_missing;
mod lock_orphan;
mod mat3_padding;
mod mirror_lints;
pub mod naga_disagrees;
pub mod not_proved;
mod over_limit;
mod push_constant_limit;
mod registry;
mod reorder_saves;
mod row_major_matrix;
mod rules_undeclared;
#[cfg(feature = "rust-mirrors")]
pub mod rust_mirror;
mod scalar_after_vec3;
mod show;
mod specialised_length;
pub mod stale_assertions;
mod stale_comment;
mod target_changes_layout;
pub mod unreached_block;
mod unused_allow;
mod unused_block;
mod unused_member;
mod vec3_array;
mod walk;
mod webgl2_size;

pub use definition::{Check, Lint, Subject};
pub use invalid_shader::function_errors;
pub use registry::{LINTS, lint};
pub use reorder_saves::smaller_order;

pub use landfall_layout::finding::{Edit, Finding, Level, Place};
pub use settings::Settings;
