//! Tests of the interpreter on modules lowered from GLSL and WGSL.

mod support;

mod batches;
mod builtins;
mod control;
mod cpu;
mod elementary;
mod half;
mod integers;
mod lanes;
mod lighting;
mod mediump;
mod memory;
mod notes;
mod outward;
mod permitted;
mod random;
mod statements;
