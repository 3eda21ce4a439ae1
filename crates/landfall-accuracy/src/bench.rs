//! Benches of lighting or of a function: variants on backends, time against error, in interleaved
//! rounds that cancel out other load on the machine.
//!
//! A [`Workload`] is a variant on a backend; [`measure`] runs workloads in interleaved rounds by a
//! [`clock`], for a [`Spread`] each; [`Errors`] compares its results with the truth, [`Permitted`]
//! bounds those of any conformant device, [`Work`] counts operations; [`rank`] compares variants.
//! The result is a [`Bench`], printed by the report of `landfall bench` and drawn by
//! [`plot`](super::plot).

pub mod called;
pub mod clock;
pub mod counted;
pub mod driver_calls;
mod errors;
pub mod function;
mod kernel;
pub mod machine;
pub mod native;
pub mod rank;
mod report;
mod rounds;
pub mod scene;
pub mod shader;
mod spread;
mod truth;
pub mod uploaded;

pub use super::inputs::DistributedInput;
pub use errors::{Errors, Results};
pub use machine::Machine;
pub use report::{
    Bench, BenchRow, ErrorMeasure, Failed, Permitted, Runner, SampleSet, SampledInputs, Size, Unit,
    Work, WorstCall, drawing,
};
pub use rounds::{Part, Rounds, Samples, Workload, measure};
pub use spread::Spread;
