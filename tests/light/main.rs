//! Tests of scenes, pictures, stress and bench.

#[path = "../support/mod.rs"]
mod support;

mod bind;
mod bind_signs;
mod hazards;
mod light_bound;
mod light_claims;
mod light_forms;
mod light_listed;
mod light_plan;
mod light_planned;
mod light_scenes;
mod made;
mod picture;
mod plot;
mod prove;
mod reference;
mod render;
mod scene;
mod stress;
mod stress_backends;
