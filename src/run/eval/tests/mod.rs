//! Claims about the evaluator, on modules as users have them.

mod support;

mod builtins;
mod control;
mod integers;
mod lighting;
mod memory;
mod notes;
mod random;
mod readers;
