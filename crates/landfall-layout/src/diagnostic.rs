//! Diagnostics: errors, warnings and lint findings with their places in the user's texts.
//!
//! Every stage makes them; [`crate::format`] renders them.

mod code;

pub use code::Code;

use serde::{Deserialize, Serialize};

use crate::error::{Error, ErrorKind};
use crate::source::Span;

/// The severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
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

/// An error or warning about a shader, a file or an option.
///
/// `At` is how places are given: a [`Span`] while the texts are at hand, or the path, lines and
/// columns of a [`Finding`](crate::finding::Finding), which stands alone in caches and reports.
/// `C` is the code: [`Code`] for the diagnostics of this workspace, text for findings, whose
/// lints are an open set.
///
/// Its fields are complete: callers build diagnostics of their own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic<At = Span, C = Code> {
    /// The kind of diagnostic.
    pub code: C,
    /// The severity.
    pub severity: Severity,
    /// One sentence, lower case, names in backticks.
    pub message: String,
    /// The file it is about when no label says so.
    pub path: Option<String>,
    /// The name of what it is about, which no edit of other lines changes: `PointLightBlock`,
    /// `Light.color`. Empty where nothing keeps track of it.
    pub about: String,
    /// Places in the text, the main one first.
    pub labels: Vec<Label<At>>,
    /// Facts that explain the message.
    pub notes: Vec<String>,
    /// The block's listing, holes included, where it helps to see it.
    pub listing: Option<String>,
    /// The smallest edit that fixes it, as a sentence.
    pub help: Option<String>,
    /// The same edit for `--fix`, where it is mechanical.
    pub fix: Vec<Edit<At>>,
}

/// A place in the text with a remark.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Label<At = Span> {
    /// The place.
    #[serde(rename = "place")]
    pub at: At,
    /// The remark; may be empty.
    pub text: String,
}

/// A replacement of bytes in a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Edit<At = Span> {
    /// The bytes that are replaced.
    #[serde(rename = "place")]
    pub at: At,
    /// The replacement.
    pub new: String,
}

impl<At, C> Diagnostic<At, C> {
    /// A diagnostic whose main place is `at`.
    pub fn new(code: C, severity: Severity, at: At, message: impl Into<String>) -> Self {
        let labels = vec![Label { at, text: String::new() }];
        Diagnostic { labels, ..Diagnostic::without_place(code, severity, message) }
    }

    /// A diagnostic without a place: about an option, or the run as a whole.
    pub fn without_place(code: C, severity: Severity, message: impl Into<String>) -> Self {
        Diagnostic {
            code,
            severity,
            message: message.into(),
            path: None,
            about: String::new(),
            labels: Vec::new(),
            notes: Vec::new(),
            listing: None,
            help: None,
            fix: Vec::new(),
        }
    }

    /// Sets the remark at the main place.
    pub fn with_text(mut self, text: impl Into<String>) -> Self {
        if let Some(label) = self.labels.first_mut() {
            label.text = text.into();
        }
        self
    }

    /// Adds a place.
    pub fn with_label(mut self, at: At, text: impl Into<String>) -> Self {
        self.labels.push(Label { at, text: text.into() });
        self
    }

    /// Adds a fact that explains the message.
    pub fn with_note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// Sets a block's listing.
    pub fn with_listing(mut self, listing: impl Into<String>) -> Self {
        self.listing = Some(listing.into());
        self
    }

    /// Sets the advice.
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Returns the diagnostic about a file that has no text, without places and edits.
    pub fn of_binary(self, path: &str) -> Self {
        Diagnostic { path: Some(path.to_string()), labels: Vec::new(), fix: Vec::new(), ..self }
    }

    /// Adds an edit that fixes it.
    pub fn with_edit(mut self, at: At, new: impl Into<String>) -> Self {
        self.fix.push(Edit { at, new: new.into() });
        self
    }
}

impl Diagnostic {
    /// An error: no layout can be given for what it is about.
    pub fn error(code: Code, span: Span, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(code, Severity::Error, span, message)
    }

    /// A warning: the layout stands, but the user should know.
    pub fn warning(code: Code, span: Span, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(code, Severity::Warning, span, message)
    }

    /// An error about a file, an option or anything else without a place in a text.
    pub fn about(
        code: Code,
        message: impl Into<String>,
        help: Option<String>,
        about: impl Into<String>,
    ) -> Diagnostic {
        let bare = Diagnostic::without_place(code, Severity::Error, message);
        Diagnostic { path: Some(about.into()), help, ..bare }
    }
}

impl From<Error> for Diagnostic {
    fn from(error: Error) -> Diagnostic {
        let message = format!("`{}` {}", error.path, error.message);
        let code = match error.kind {
            ErrorKind::Template => Code::OtherLanguage,
            ErrorKind::Unwritten => Code::CannotWrite,
            ErrorKind::Unreadable | ErrorKind::Other => Code::UnreadableFile,
        };
        Diagnostic::about(code, message, error.help, error.path)
    }
}
