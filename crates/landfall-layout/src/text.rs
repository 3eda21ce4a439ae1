//! Text utilities: counts, globs, JSON with spans, filters before lists of words, suggestions for misspelt names,
//! and escaping of untrusted text.

pub mod counts;
pub mod edit_distance;
pub mod escape;
pub mod glob;
pub mod json;
pub mod locate;
pub(crate) mod named;
pub(crate) mod word_filter;
pub mod word_list;
