//! Runs shaders on the interpreter (`landfall-interp`), OpenGL or wgpu, and verifies the offsets they
//! read.
//!
//! Reports, arguments and results are JSON: public signatures name `serde::Serialize`,
//! `serde::Deserialize`, `serde_json::Value` and `serde_json::Map`.

// What other crates of the workspace call; users see the facade.
#![allow(missing_docs)]

pub mod backend;
pub mod harness;
pub mod processor;
pub mod report;
