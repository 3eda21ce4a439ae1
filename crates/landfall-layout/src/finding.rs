//! One finding of a lint: what, where, how bad, and the edit that mends it.
//!
//! Self-contained: places are paths, lines and columns, so that findings can be
//! cached, merged from several runs, and rendered without the shader at hand.

use serde::{Deserialize, Serialize};

use crate::source::{Files, Span};

/// How much a lint's findings matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Not looked for.
    Allow,
    /// Reported; the run still succeeds.
    Warn,
    /// Reported, and the run fails with exit code 1.
    Deny,
}

impl Level {
    /// `allow`, `warn` or `deny`.
    pub fn name(self) -> &'static str {
        match self {
            Level::Allow => "allow",
            Level::Warn => "warn",
            Level::Deny => "deny",
        }
    }
}

/// One finding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// The lint's code.
    pub code: String,
    /// The level it has here; never `allow`.
    pub level: Level,
    /// One sentence, lower case, names in backticks.
    pub message: String,
    /// What it is about, the same wherever the lines move: `PointLightBlock`, `Light.color`.
    pub about: String,
    /// The main place; a file as a whole has line 0.
    pub place: Place,
    /// A word at the main place; may be empty.
    pub text: String,
    /// Further places with a word on their part.
    pub related: Vec<Related>,
    /// Facts that explain the message.
    pub notes: Vec<String>,
    /// The block's listing, holes spelled out, where it helps to see it.
    pub listing: Option<String>,
    /// The smallest edit that mends it, in words.
    pub help: Option<String>,
    /// The same edit for `--fix`, where it is mechanical.
    pub fix: Vec<Edit>,
}

/// A range of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Place {
    /// The path as messages print it, `/` between its parts.
    pub path: String,
    /// First line, from 1; 0 for the file as a whole.
    pub line: u32,
    /// First column in characters, from 1.
    pub column: u32,
    /// Last line.
    pub end_line: u32,
    /// One past the last column.
    pub end_column: u32,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

/// A further place of a finding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Related {
    /// Where.
    pub place: Place,
    /// Its part in the finding.
    pub text: String,
}

/// A replacement of bytes in a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Edit {
    /// The bytes that go.
    pub place: Place,
    /// What stands there instead.
    pub new: String,
}

impl Place {
    /// A file as a whole.
    pub fn file(path: impl Into<String>) -> Place {
        Place { path: path.into(), ..Place::default() }
    }

    /// The place of a span.
    pub fn of(files: &Files, span: Span) -> Place {
        let from = files.locate(span);
        let to = files.locate(Span { start: span.end, ..span });
        Place {
            path: from.path,
            line: from.line,
            column: from.column,
            end_line: to.line,
            end_column: to.column,
            start: span.start,
            end: span.end,
        }
    }
}

impl Finding {
    /// A finding of that lint at a place of a shader; its level is set by who asked the lint.
    pub fn new(
        code: &str,
        about: impl Into<String>,
        place: Place,
        message: impl Into<String>,
    ) -> Finding {
        Finding {
            code: code.to_string(),
            level: Level::Warn,
            message: message.into(),
            about: about.into(),
            place,
            text: String::new(),
            related: Vec::new(),
            notes: Vec::new(),
            listing: None,
            help: None,
            fix: Vec::new(),
        }
    }

    /// The same with a word at the main place.
    pub fn with_text(mut self, text: impl Into<String>) -> Finding {
        self.text = text.into();
        self
    }

    /// The same with a further place.
    pub fn with_related(mut self, place: Place, text: impl Into<String>) -> Finding {
        self.related.push(Related { place, text: text.into() });
        self
    }

    /// The same with a fact that explains it.
    pub fn with_note(mut self, note: impl Into<String>) -> Finding {
        self.notes.push(note.into());
        self
    }

    /// The same with a block's listing.
    pub fn with_listing(mut self, listing: impl Into<String>) -> Finding {
        self.listing = Some(listing.into());
        self
    }

    /// The same with advice.
    pub fn with_help(mut self, help: impl Into<String>) -> Finding {
        self.help = Some(help.into());
        self
    }

    /// The same with an edit that mends it.
    pub fn with_edit(mut self, place: Place, new: impl Into<String>) -> Finding {
        self.fix.push(Edit { place, new: new.into() });
        self
    }
}
