//! Run time against error: what a variant of a shader costs, and how wrong it gets.
//!
//! [`bench`] measures variants on readers against the reference and ranks them; [`plot`] draws
//! what was found.

pub mod bench;
pub mod plot;
