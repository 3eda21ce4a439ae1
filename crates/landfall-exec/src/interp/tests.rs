//! Claims about the interpreter, on modules as users have them.

mod support;

mod builtins;
mod control;
mod cpu;
mod half;
mod integers;
mod lighting;
mod mediump;
mod memory;
mod notes;
mod permitted;
mod random;
