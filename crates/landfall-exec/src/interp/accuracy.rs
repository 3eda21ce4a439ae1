//! How far each reader's results are from the true ones; measured and held by
//! `tests/builtins.rs`, written by it, and read here only.
//!
#![doc = include_str!("accuracy.md")]
