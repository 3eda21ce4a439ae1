//! Static analyses of a module: numerical hazards, and the structures that are lights.

pub mod hazard;
pub mod hazards;
pub mod identifier;
pub mod roles;
