//! Lowering of GLSL and WGSL to naga IR with landfall's offsets, and analyses of it.

pub mod analysis;
mod glsl;
pub mod module;
pub mod reach;
mod wgsl;

pub use module::Module;
