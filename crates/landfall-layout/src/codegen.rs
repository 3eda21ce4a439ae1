//! Code generation from layouts: mirrors of blocks in the languages of one [table](languages).

pub mod c;
mod language;
pub mod languages;
mod model;
mod runtime_tail;
pub mod rust;

pub use language::{CodeOptions, CodeOutput, OutputLanguage};
