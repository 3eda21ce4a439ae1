//! Code generated from layouts: mirrors of blocks in the languages of one [table](languages), and
//! the API for build scripts.
//!
//! Public signatures name no type of another crate than `landfall-layout`.

mod assertions;
pub mod build_script;
pub mod c;
mod language;
pub mod languages;
mod model;
mod refusal;
mod runtime_tail;
pub mod rust;
mod scalar_names;
mod user_types;

pub use build_script::{Build, BuildError};
pub use language::{AssertOptions, CodeOptions, CodeOutput, OutputLanguage};
