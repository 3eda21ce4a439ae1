//! What is run: probes, functions, fragments, and whole shaders for verification.

mod access;
pub mod bindings;
pub mod call;
pub mod coverage;
pub mod fragments;
pub mod probe;
mod rewrite;
pub mod spirv;
pub mod verify;
