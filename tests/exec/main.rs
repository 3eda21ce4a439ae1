//! Tests of the interpreter and the backends.

#[path = "../support/mod.rs"]
mod support;

mod accuracy;
mod builtins;
mod digits;
mod fragments;
mod kernel;
mod mirror_proof;
mod permitted;
mod run_gl;
mod run_gpu;
mod run_module;
mod run_remote;
mod runtime_tail;
mod verify;
mod verify_same_text;
mod verify_web;
mod verify_widths;
