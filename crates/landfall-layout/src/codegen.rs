//! Code generation from layouts: Rust mirrors and C headers.

pub mod c;
pub mod rust;
