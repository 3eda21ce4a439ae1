//! Runs shaders on an interpreter, OpenGL or wgpu, and verifies the offsets they read.

pub mod backend;
pub mod harness;
pub mod interp;
pub mod processor;
