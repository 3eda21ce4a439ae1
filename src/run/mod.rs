//! A shader run: the proof that an upload lands where the shader reads it.
//!
//! [`module`] makes a shader runnable: naga IR whose offsets, strides and sizes
//! are ours. [`reader`] says what it is to run one: a job in, words out. The
//! readers are [`eval`], our own evaluator, and the drivers `gl` and `gpu`.

pub mod eval;
#[cfg(feature = "gl")]
pub mod gl;
mod glsl;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod module;
pub mod reader;
mod wgsl;

pub use module::Module;
