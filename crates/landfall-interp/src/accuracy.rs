//! The error of each backend's built-in functions; measured, checked and written by
//! `tests/exec/builtins.rs`.
//!
#![doc = include_str!("accuracy.md")]
