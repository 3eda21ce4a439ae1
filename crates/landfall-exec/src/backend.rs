//! The backends besides the interpreter: drivers (`gl`, `gpu`) and browsers (`web`), each in a process
//! of its own.
//!
//! The interface, a [`Job`] in, a [`JobOutput`] or a [`Failure`] out, is that of `landfall-interp`.

#[cfg(any(feature = "gl", feature = "gpu", feature = "web"))]
mod child;
pub mod devices;
#[cfg(feature = "gl")]
pub mod gl;
#[cfg(any(feature = "gl", feature = "gpu"))]
mod limits;
mod runs;
#[cfg(any(feature = "gl", feature = "gpu"))]
pub mod subprocess;
#[cfg(feature = "web")]
pub mod web;
#[cfg(feature = "gpu")]
pub mod wgpu;

pub use runs::{executable, single_run};

pub use landfall_interp::backend::{
    Backend, BackendKind, Device, Failure, FailureKind, Grid, Job, JobOutput, LooseUniform,
    Resource, ResourceKind, StageCode, Texel, texel_index,
};
pub use landfall_interp::reflection;
