//! Tests of lints and their reports.

#[path = "../support/mod.rs"]
mod support;

mod asked;
mod corpus;
mod digest;
mod figures;
mod find_hazards;
mod findings;
mod fix;
mod lengths_and_ranges;
mod lints_a;
mod lints_b;
mod precision;
mod stated;
