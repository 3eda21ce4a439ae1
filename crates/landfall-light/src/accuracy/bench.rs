//! Variants of lighting, or of a function, on readers: time against error, measured so that a
//! busy machine is no excuse.
//!
//! A [`Workload`] is a variant on a reader; [`measure`] runs them in turns by a [`clock`] and
//! gives [`Spread`]s; [`Errors`] hold what it gives against the truth, [`Permitted`] says what any
//! device may give, [`Work`] what it does; [`rank`] says who is better. All of it is a [`Bench`],
//! printed by the report of `landfall bench` and drawn by [`plot`](super::plot).

pub mod called;
pub mod clock;
pub mod compiled;
pub mod counted;
pub mod driven;
mod errors;
pub mod function;
mod kernel;
pub mod machine;
pub mod rank;
mod report;
mod rounds;
pub mod scene;
pub mod shader;
mod spread;
pub mod uploaded;

pub use errors::{Errors, Results};
pub use machine::Machine;
pub use report::{Bench, BenchRow, Failed, Permitted, Runner, Size, Unit, Work, drawing};
pub use rounds::{Part, Rounds, Samples, Workload, measure};
pub use spread::Spread;
