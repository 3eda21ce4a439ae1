//! Helpers on text: JSON with spans, the nearest known name to a misspelt one, and text of others
//! made safe for what reads it.

pub mod edit_distance;
pub mod escape;
pub mod json;
pub mod locate;
