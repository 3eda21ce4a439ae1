//! Static analyses of a module: numerical hazards, and the structures that are lights.

pub mod hazard;
#[cfg(feature = "lowering")]
pub mod hazards;
pub mod identifier;
pub mod occurrence;
pub mod roles;
pub mod undefined;
