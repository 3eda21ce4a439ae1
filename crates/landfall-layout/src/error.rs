//! Errors of the tool itself: files that cannot be read or written.
//!
//! Faults *inside* a shader are [`Diagnostic`](crate::Diagnostic)s instead.

use std::fmt;

/// An operation that failed, and the file it failed on.
#[derive(Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Error {
    /// The path of the file.
    pub path: String,
    /// The failure, read after the path: `is a directory, not a shader file`.
    pub message: String,
    /// A suggested remedy.
    pub help: Option<String>,
    /// The kind of failure.
    pub kind: ErrorKind,
}

/// The kind of an [`Error`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A file that cannot be read or is not text.
    Unreadable,
    /// A file or a stream that cannot be written.
    Unwritten,
    /// A text with placeholders, which a program fills in.
    Template,
    /// Anything else.
    #[default]
    Other,
}

impl Error {
    /// Creates an error about a file, of kind [`ErrorKind::Other`].
    pub fn new(path: impl Into<String>, message: impl Into<String>) -> Error {
        Error { path: path.into(), message: message.into(), help: None, kind: ErrorKind::Other }
    }

    /// Creates an error about an output, of kind [`ErrorKind::Unwritten`].
    pub fn unwritten(path: impl Into<String>, message: impl Into<String>) -> Error {
        Error { kind: ErrorKind::Unwritten, ..Error::new(path, message) }
    }

    /// Returns the error with kind [`ErrorKind::Unreadable`].
    pub fn unreadable(self) -> Error {
        Error { kind: ErrorKind::Unreadable, ..self }
    }

    /// Returns the error with a help text.
    pub fn with_help(self, help: impl Into<String>) -> Error {
        Error { help: Some(help.into()), ..self }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` {}", self.path, self.message)?;
        match &self.help {
            Some(help) => write!(f, "\nhelp: {help}"),
            None => Ok(()),
        }
    }
}

/// Prints like `Display`, since `main` of a build script prints errors through `Debug`.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for Error {}
