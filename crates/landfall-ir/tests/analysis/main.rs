//! Tests of the analyses. As unit tests they would compile the crate a second time.

mod falloff;
mod hazard;
mod identifier;
mod roles;
mod stack;
