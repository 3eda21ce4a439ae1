//! Lowering of GLSL and WGSL to naga IR with Landfall's offsets, and analyses of the IR.
//!
//! Public signatures name types of naga, whose IR a `Module` holds.

// The parts of a program; what others call is `Module` and the analyses.
#![allow(missing_docs)]

pub mod analysis;
#[cfg(feature = "lowering")]
pub mod call_graph;
#[cfg(feature = "es")]
pub mod es;
#[cfg(feature = "lowering")]
mod glsl;
#[cfg(feature = "lowering")]
mod lower;
#[cfg(feature = "lowering")]
pub mod module;
pub mod stack;
pub mod threads;
#[cfg(feature = "lowering")]
mod wgsl;

#[cfg(feature = "lowering")]
pub use module::Module;
