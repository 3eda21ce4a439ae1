//! Fast and accurate, measured: how wrong a shader's arithmetic gets, and what it costs.
//!
//! [`inputs`] says what a function may be called with; [`stress`] looks for those at which it
//! breaks; [`bench`](mod@bench) measures variants on readers against the reference and ranks them;
//! [`plot`] draws what was found. Everything here runs on [`run`](landfall_exec) and is printed by
//! the reports of the command.

pub mod bench;
pub mod inputs;
mod measure;
mod permitted;
pub mod plot;
pub mod stress;
