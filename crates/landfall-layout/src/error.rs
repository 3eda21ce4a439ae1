//! The tool could not do its work: a file that cannot be read or written.
//!
//! What is wrong *inside* a shader is a [`Diagnostic`](crate::Diagnostic) instead.

use std::fmt;

/// Why something could not be done, and to which file.
#[derive(Clone, PartialEq, Eq)]
pub struct Error {
    /// The file it happened to.
    pub path: String,
    /// What happened, to be read after the path: `is a directory, not a shader file`.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
    /// What kind of thing it is.
    pub kind: ErrorKind,
}

/// The kinds of [`Error`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ErrorKind {
    /// A file that cannot be read, or holds no text.
    Unreadable,
    /// Anything else.
    #[default]
    Other,
}

impl Error {
    /// An error about a file.
    pub fn new(path: impl Into<String>, message: impl Into<String>) -> Error {
        Error { path: path.into(), message: message.into(), help: None, kind: ErrorKind::Other }
    }

    /// The same error as one of a file that cannot be read.
    pub fn unreadable(self) -> Error {
        Error { kind: ErrorKind::Unreadable, ..self }
    }

    /// The same error with advice.
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

/// `main` of a build script prints errors through `Debug`, so it reads like `Display`.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for Error {}
