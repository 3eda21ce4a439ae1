//! Helpers on text: JSON with spans, and the nearest known name to a misspelt one.

pub mod edit_distance;
pub mod json;
pub mod locate;
pub mod xml;
