//! Code generation from layouts: Rust mirrors and C headers.

pub mod c;
mod runtime_tail;
pub mod rust;
