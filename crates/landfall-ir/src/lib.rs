//! Lowering of GLSL and WGSL to naga IR with Landfall's offsets, and analyses of the IR.

pub mod analysis;
pub mod call_graph;
mod glsl;
mod lower;
pub mod module;
mod stack;
mod wgsl;

pub use module::Module;
