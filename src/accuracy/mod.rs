//! How wrong a shader's arithmetic gets, measured.
//!
//! [`stress`] looks for the inputs at which a function breaks; [`plot`] draws what was found.
//! Everything here runs on [`run`](crate::run) and is printed by [`emit`](crate::emit).

pub mod plot;
pub mod stress;
