//! Lowering of GLSL and WGSL to naga IR with landfall's offsets, and analyses of it.

pub mod analysis;
mod glsl;
mod lower;
pub mod module;
pub mod reach;
mod stack;
mod wgsl;

pub use module::Module;
