//! The error of a build script.

use std::fmt;

use landfall_layout::error::Error;

/// The error of a build script, as human-readable text.
///
/// `Debug` is the same as `Display`, so that a `main` that returns it prints the findings with
/// their source excerpts.
#[derive(Clone, PartialEq, Eq)]
pub struct BuildError {
    pub(super) text: String,
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl fmt::Debug for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Follows the `Error: ` that `main` prints.
        write!(f, "landfall failed\n\n{}", self.text)
    }
}

impl std::error::Error for BuildError {}

impl From<Error> for BuildError {
    fn from(error: Error) -> BuildError {
        BuildError { text: error.to_string() }
    }
}
