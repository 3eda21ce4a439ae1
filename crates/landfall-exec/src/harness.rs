//! Shaders prepared for backends: probes, function calls, fragments, and verification.

mod access;
pub mod bindings;
pub mod call;
pub mod coverage;
pub mod fragments;
pub mod origins;
pub mod probe;
mod rewrite;
pub mod spirv;
pub mod verify;
