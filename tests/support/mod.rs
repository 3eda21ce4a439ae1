//! What every number is held against: oracles that share no code with the
//! crate, and the blocks they are asked about.
//!
//! `generate` and `pairs` make blocks, `blocks` prints them as GLSL, `glslang` and
//! `driver` each answer with the neutral table of `leaf`, and `known` lists
//! where those two answer differently and which one the specification backs.
//! `wgsl` does the same for WGSL, with encase as the oracle and `naga_wgsl`
//! for a second opinion on it.
//!
//! A missing oracle fails the test that needs it and names the Debian package.

#![allow(dead_code, reason = "each test binary uses its own part of the harness")]

#[cfg(feature = "full")]
pub mod backends;
pub mod blocks;
pub mod c;
pub mod c_names;
#[cfg(feature = "full")]
pub mod command;
pub mod driver;
pub mod files;
pub mod fold;
pub mod generate;
pub mod gl_types;
pub mod glslang;
pub mod glslang_server;
pub mod image;
pub mod jobs;
pub mod known;
pub mod landfall;
pub mod leaf;
pub mod naga_wgsl;
pub mod pairs;
pub mod picture;
pub mod run;
pub mod rustc;
pub mod sample;
#[cfg(feature = "full")]
pub mod schema;
pub mod spirv;
pub mod tint;
pub mod wgsl;
