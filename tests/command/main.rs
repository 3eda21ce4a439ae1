//! Tests of the command line, as a process.

#[path = "../support/mod.rs"]
mod support;

mod budget;
mod ci_examples;
mod cli;
mod cli_bench;
mod cli_bench_fn;
mod cli_bench_inputs;
mod cli_check;
mod cli_codec;
mod cli_diff;
mod cli_emit;
mod cli_emit_languages;
mod cli_init;
mod cli_lock;
mod cli_modules;
mod cli_policy;
mod cli_port;
mod cli_render;
mod cli_render_causes;
mod cli_render_claims;
mod cli_render_skip;
mod cli_rule;
mod cli_run;
mod cli_run_faults;
mod cli_stress;
mod cli_structures;
mod cli_variants;
mod cli_verify;
mod cli_verify_web;
mod completions;
mod help;
mod hostile_names;
mod hostile_trees;
mod ignore_files;
mod names_without_effect;
mod nothing_done;
mod readme;
mod reference;
mod schema;
mod slopes;
mod streams;
mod unified;
mod without_effect;
mod writers;
