//! What there is to say about a shader: a finding with its place in the user's text.
//!
//! Made by every stage of the way through, rendered by [`crate::format`].

mod code;

pub use code::Code;

use crate::error::Error;
use crate::source::Span;

/// How serious a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing; the layout stands.
    Warning,
    /// No layout can be given for what the finding is about.
    Error,
}

impl Severity {
    /// `error` or `warning`.
    pub fn name(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
        }
    }
}

/// One finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// The kind of finding.
    pub code: Code,
    /// How serious it is.
    pub severity: Severity,
    /// One sentence, lower case, names in backticks.
    pub message: String,
    /// The file it is about when no label says so.
    pub path: Option<String>,
    /// Places in the text, the main one first.
    pub labels: Vec<Label>,
    /// Facts that explain the message.
    pub notes: Vec<String>,
    /// The smallest edit that mends it.
    pub help: Option<String>,
}

/// A place in the text with a word on its part in the finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// Where.
    pub span: Span,
    /// What about it; may be empty.
    pub text: String,
}

impl Diagnostic {
    /// An error: no layout can be given for what it is about.
    pub fn error(code: Code, span: Span, message: impl Into<String>) -> Diagnostic {
        Diagnostic {
            code,
            severity: Severity::Error,
            message: message.into(),
            path: None,
            labels: vec![Label { span, text: String::new() }],
            notes: Vec::new(),
            help: None,
        }
    }

    /// A warning: the layout stands, but the reader should know.
    pub fn warning(code: Code, span: Span, message: impl Into<String>) -> Diagnostic {
        Diagnostic { severity: Severity::Warning, ..Diagnostic::error(code, span, message) }
    }

    /// An error about a file, an option or nothing that has a place in the text.
    pub fn about(
        code: Code,
        message: impl Into<String>,
        help: Option<String>,
        about: impl Into<String>,
    ) -> Diagnostic {
        Diagnostic {
            code,
            severity: Severity::Error,
            message: message.into(),
            path: Some(about.into()),
            labels: Vec::new(),
            notes: Vec::new(),
            help,
        }
    }

    /// The same finding with words at its main place.
    pub fn with_text(mut self, text: impl Into<String>) -> Diagnostic {
        if let Some(label) = self.labels.first_mut() {
            label.text = text.into();
        }
        self
    }

    /// The same finding with a further place.
    pub fn with_label(mut self, span: Span, text: impl Into<String>) -> Diagnostic {
        self.labels.push(Label { span, text: text.into() });
        self
    }

    /// The same finding with a fact that explains it.
    pub fn with_note(mut self, note: impl Into<String>) -> Diagnostic {
        self.notes.push(note.into());
        self
    }

    /// The same finding with advice.
    pub fn with_help(mut self, help: impl Into<String>) -> Diagnostic {
        self.help = Some(help.into());
        self
    }
}

impl From<Error> for Diagnostic {
    fn from(error: Error) -> Diagnostic {
        Diagnostic {
            code: Code::UnreadableFile,
            severity: Severity::Error,
            message: format!("`{}` {}", error.path, error.message),
            path: Some(error.path),
            labels: Vec::new(),
            notes: Vec::new(),
            help: error.help,
        }
    }
}
