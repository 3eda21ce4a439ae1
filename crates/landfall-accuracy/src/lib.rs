//! Measures the accuracy and the run time of shader functions and lighting.
//!
//! [`inputs`] samples the arguments of a function; [`stress`] searches for those at which it
//! breaks. [`prove`](mod@prove) shows that there are none, and [`demand`] reports whether what a
//! user demands of a function is shown. [`bench`](mod@bench) measures variants on backends against
//! the reference and ranks them; [`plot`] draws the results. All of it runs on [`landfall_exec`]
//! and is printed by the reports of the command.
//!
//! Public signatures name `serde::Serialize`, `serde_json::Value` and `serde_json::Map` for what is
//! read and written as JSON.

// The parts of a program; what others call is named above.
#![allow(missing_docs)]

pub mod bench;
pub mod demand;
pub mod inputs;
mod measure;
mod permitted;
pub mod plot;
pub mod prove;
pub mod stress;
