//! Findings: diagnostics that stand alone.
//!
//! Their places are paths, lines and columns, so that findings can be cached, and rendered without the
//! shader at hand.

use std::borrow::Cow;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::diagnostic::{self, Diagnostic, Label, Severity};
use crate::source::{Files, Span};
use crate::text::named::named;

named! {
    /// The level of a lint: whether its findings are reported, and whether they fail the run.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
    #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
    #[serde(rename_all = "lowercase")]
    pub enum Level {
        /// Not looked for.
        Allow = "allow",
        /// Reported; the run still succeeds.
        Warn = "warn",
        /// Reported, and the run fails with exit code 1.
        Deny = "deny",
    }

    const ALL;
    fn from_name;
}

impl Level {
    /// The severity of findings at this level; `None` for `allow`, which reports none.
    pub fn severity(self) -> Option<Severity> {
        match self {
            Level::Allow => None,
            Level::Warn => Some(Severity::Warning),
            Level::Deny => Some(Severity::Error),
        }
    }
}

/// A diagnostic that stands alone: its places are paths, lines and columns, its code is text.
///
/// It has at least one label, the main place; a file as a whole has line 0.
pub type Finding = Diagnostic<Place, String>;

/// A replacement of bytes in a file, by path, line and column.
pub type Edit = diagnostic::Edit<Place>;

/// A range of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

impl Place {
    /// A file as a whole.
    pub fn file(path: impl Into<String>) -> Place {
        Place { path: path.into(), ..Place::default() }
    }

    /// The place of a span.
    pub fn new(files: &Files, span: Span) -> Place {
        let span = files.resolve(span);
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
    /// A finding of a lint at a place of a shader; [`Level`]s are applied later.
    pub fn at(
        code: &str,
        about: impl Into<String>,
        place: Place,
        message: impl Into<String>,
    ) -> Finding {
        let new = Diagnostic::new(code.to_string(), Severity::Warning, place, message);
        Diagnostic { about: about.into(), ..new }
    }

    /// The main place.
    pub fn place(&self) -> &Place {
        &self.labels[0].at
    }

    /// The remark at the main place; may be empty.
    pub fn text(&self) -> &str {
        &self.labels[0].text
    }

    /// The further places.
    pub fn related(&self) -> &[Label<Place>] {
        &self.labels[1..]
    }

    /// The level of this severity.
    pub fn level(&self) -> Level {
        match self.severity {
            Severity::Warning => Level::Warn,
            Severity::Error => Level::Deny,
        }
    }
}

impl Diagnostic {
    /// The same with places that stand alone. Labels in files that `files` does not hold are
    /// left out; without any, the place is the file as a whole.
    pub fn located(&self, files: &Files) -> Finding {
        let mut labels: Vec<Label<Place>> = self
            .labels
            .iter()
            .filter(|label| files.get(label.at.file).is_some())
            .map(|label| Label { at: Place::new(files, label.at), text: label.text.clone() })
            .collect();
        if labels.is_empty() {
            let path = self.path.clone().or_else(|| files.get(0).map(|file| file.path.clone()));
            let at = Place::file(path.unwrap_or_default());
            labels.push(Label { at, text: String::new() });
        }
        Diagnostic {
            code: self.code.name().to_string(),
            severity: self.severity,
            message: self.message.clone(),
            path: None,
            // The same whichever shader includes the file.
            about: labels[0].at.path.clone(),
            labels,
            notes: self.notes.clone(),
            listing: self.listing.clone(),
            help: self.help.clone(),
            fix: Vec::new(),
        }
    }
}

/// A finding as JSON reports and caches hold it.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[doc(hidden)]
pub struct FindingObject<'a> {
    /// Kebab-case name of the lint.
    #[cfg_attr(feature = "schema", schemars(regex(pattern = r"^[a-z0-9]+(-[a-z0-9]+)*$")))]
    code: Cow<'a, str>,
    /// `deny` makes the run fail.
    #[cfg_attr(feature = "schema", schemars(extend("enum" = [Level::Warn, Level::Deny])))]
    level: Level,
    message: Cow<'a, str>,
    /// The subject of the finding, independent of line numbers: `PointLightBlock`, `Light.color`.
    about: Cow<'a, str>,
    place: Cow<'a, Place>,
    /// The label at the main place; may be empty.
    text: Cow<'a, str>,
    /// Further places.
    related: Cow<'a, [Label<Place>]>,
    notes: Cow<'a, [String]>,
    /// The block's layout, including padding.
    listing: Option<Cow<'a, str>>,
    /// The smallest edit that resolves the finding.
    help: Option<Cow<'a, str>>,
    /// The edits that `--fix` applies; empty if none is mechanical.
    fix: Cow<'a, [Edit]>,
}

impl Serialize for Finding {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        FindingObject {
            code: Cow::Borrowed(&self.code),
            level: self.level(),
            message: Cow::Borrowed(&self.message),
            about: Cow::Borrowed(&self.about),
            place: Cow::Borrowed(self.place()),
            text: Cow::Borrowed(self.text()),
            related: Cow::Borrowed(self.related()),
            notes: Cow::Borrowed(&self.notes),
            listing: self.listing.as_deref().map(Cow::Borrowed),
            help: self.help.as_deref().map(Cow::Borrowed),
            fix: Cow::Borrowed(&self.fix),
        }
        .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Finding {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Finding, D::Error> {
        let read = FindingObject::deserialize(deserializer)?;
        let main = Label { at: read.place.into_owned(), text: read.text.into_owned() };
        Ok(Diagnostic {
            code: read.code.into_owned(),
            severity: read.level.severity().unwrap_or(Severity::Warning),
            message: read.message.into_owned(),
            path: None,
            about: read.about.into_owned(),
            labels: std::iter::once(main).chain(read.related.into_owned()).collect(),
            notes: read.notes.into_owned(),
            listing: read.listing.map(Cow::into_owned),
            help: read.help.map(Cow::into_owned),
            fix: read.fix.into_owned(),
        })
    }
}
