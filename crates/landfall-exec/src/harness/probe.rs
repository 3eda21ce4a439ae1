//! Probes: shaders that read every leaf of a block and report the bytes they saw.
//!
//! [`plan`] chooses the reads and computes the byte each must see, `glsl` and `wgsl` append them to
//! the user's own text, [`sentinel`] fills a buffer in which every word is different, and
//! [`results`] infers the bytes that were read from the returned words. [`cause`] names the layout
//! error of a backend that read other bytes.

pub mod cause;
pub(crate) mod glsl;
pub(crate) mod pixels;
pub mod plan;
pub mod results;
pub mod sentinel;
pub(crate) mod wgsl;

pub use plan::{AccessMode, Plan, Read, plans};
pub use results::{ProbeResult, ProbedLocation};
