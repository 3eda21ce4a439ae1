//! The engine of `landfall check`, as the command, pages and editors call it: it takes and returns data, prints
//! nothing, and keeps no state between calls.
//!
//! [`config`] and the options of a caller → [`basis`] → a [`pass`] over all shaders, which [`inputs`] finds
//! by [`walk`], each by [`check_shader`] or from the [`cache`] → [`tree`] over all shaders → [`baseline`] →
//! [`fix`].

// The names of a part of the command; what the facade re-exports has documentation of its own.
#![allow(missing_docs)]

pub mod add_allow;
pub mod against;
pub mod asserted;
pub mod baseline;
pub mod basis;
pub mod cache;
pub mod caught;
pub mod check_shader;
pub mod compiled;
pub mod config;
mod digests;
pub mod files;
pub mod fix;
pub mod given_names;
pub mod hash;
pub mod inputs;
mod lock_file;
pub mod locks;
pub mod missing_includes;
pub mod pass;
pub mod policies;
#[cfg(feature = "exec")]
pub mod proved;
pub mod rust;
mod stamp;
pub mod stop;
pub mod templates;
pub mod texts;
pub mod tree;
pub mod verified;
pub mod walk;
