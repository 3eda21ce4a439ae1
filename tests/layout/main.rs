//! Tests of layouts, locks, buffers and generated code.

#[path = "../support/mod.rs"]
mod support;

mod assertions;
mod attributes;
mod bindings_gl;
mod bodies;
mod buffer;
mod build_script;
mod c_header;
mod c_types;
mod codec;
mod condition_trees;
mod dialects;
mod diff_mutations;
mod fuzz;
mod glsl;
mod languages;
mod large_trees;
mod length_constants;
mod lock;
mod mirror_text;
mod mirrors;
mod modules;
mod oracles;
mod port;
mod port_compiles;
mod port_naga;
mod port_reading;
mod port_tint;
mod properties;
mod reading;
mod rules;
mod spirv;
mod variants;
mod wgsl;
mod wgsl_findings;
mod wgsl_naga;
mod words;
