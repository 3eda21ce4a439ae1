//! Executes shaders on the interpreter, OpenGL or wgpu, and checks where they read what.

pub mod backend;
pub mod harness;
pub mod interp;
pub mod processor;
