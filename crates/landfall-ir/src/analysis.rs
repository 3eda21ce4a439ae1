//! What can be said of a module without running it: numerical hazards, and which structures are lights.

pub mod hazard;
pub mod hazards;
pub mod roles;
pub mod words;
