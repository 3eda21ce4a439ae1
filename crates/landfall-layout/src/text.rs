//! Text utilities: JSON with spans, suggestions for misspelt names, and escaping of untrusted text.

pub mod edit_distance;
pub mod escape;
pub mod json;
pub mod locate;
