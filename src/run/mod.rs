//! A shader run: the proof that an upload lands where the shader reads it.
//!
//! [`module`] makes a shader runnable: naga IR whose offsets, strides and sizes
//! are ours. [`reader`] says what it is to run one: a job in, words out. The
//! readers are [`eval`], our own evaluator, and the drivers `gl` and `gpu`; `remote`
//! runs a driver in a process of its own. [`accuracy`] is what they were measured at. [`hazards`]
//! follows values through a module without running it.

pub mod accuracy;
pub mod bound;
pub mod call;
pub mod coverage;
pub mod devices;
pub mod eval;
pub mod fragments;
#[cfg(feature = "gl")]
pub mod gl;
mod glsl;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod hazards;
#[cfg(any(feature = "gl", feature = "gpu"))]
mod limits;
pub mod module;
pub mod probe;
pub mod processor;
mod reach;
pub mod reader;
pub mod reflection;
#[cfg(any(feature = "gl", feature = "gpu"))]
pub mod remote;
mod rewrite;
mod runs;
pub mod spirv;
pub mod verify;
mod wgsl;

pub use module::Module;
