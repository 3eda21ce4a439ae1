//! Templates that a search finds: they are passed over, and named once a directory.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use landfall_layout::diagnostic::Code;
use landfall_layout::error::ErrorKind;
use landfall_layout::format::phrases::counted;
use landfall_layout::source::Files;
use landfall_layout::{Diagnostic, Error, Severity, Source};

use crate::args::ReadArgs;
use crate::inputs::Input;
use crate::output::{FindingStyle, Streams};
use crate::read;

/// The templates of a run, by directory and path, and why each is one.
#[derive(Default)]
pub struct Templates(Mutex<BTreeMap<PathBuf, BTreeMap<PathBuf, Error>>>);

impl Templates {
    /// Passes over an input that a search found, if it cannot be read because it is a template.
    pub fn passes_over(&self, input: &Input, error: &Error) -> bool {
        if !input.is_searched || error.kind != ErrorKind::Template {
            return false;
        }
        let directory = input.path.parent().unwrap_or(Path::new("")).to_path_buf();
        let mut found = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        found.entry(directory).or_default().insert(input.path.clone(), error.clone());
        true
    }

    /// Reads an input; `None` for a template that is passed over.
    pub fn source(&self, input: &Input, args: &ReadArgs) -> Result<Option<Source>, Error> {
        match read::source(&input.path, args) {
            Err(error) if self.passes_over(input, &error) => Ok(None),
            read => read.map(Some),
        }
    }

    /// As [`Templates::source`], of which the text is needed.
    pub fn shader_text(&self, input: &Input, args: &ReadArgs) -> Result<Option<Source>, Error> {
        let source = self.source(input, args)?;
        source.map(|source| source.without_text().map_or(Ok(source), Err)).transpose()
    }

    /// Prints the findings, and returns whether they are errors.
    pub fn report(&self, is_all: bool, style: FindingStyle, streams: &Streams) -> bool {
        let found = self.findings(is_all);
        streams.report(&style.text(&found, &Files::default()));
        found.iter().any(|found| found.severity == Severity::Error)
    }

    /// A warning for each directory; an error if `is_all` that the search found are templates.
    pub fn findings(&self, is_all: bool) -> Vec<Diagnostic> {
        let found = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let severity = if is_all { Severity::Error } else { Severity::Warning };
        let one = |(directory, files): (&PathBuf, &BTreeMap<PathBuf, Error>)| {
            let first = files.values().next()?;
            if files.len() == 1 {
                return Some(Diagnostic { severity, ..first.clone().into() });
            }
            let directory = match directory.as_os_str().is_empty() {
                true => ".".to_string(),
                false => directory.display().to_string(),
            };
            let message = format!(
                "{} of `{directory}` are templates, which landfall does not read",
                counted(files.len(), "file")
            );
            let found =
                Diagnostic::about(Code::OtherLanguage, message, first.help.clone(), directory);
            let note = format!("`{}` {}", first.path, first.message);
            Some(Diagnostic { severity, ..found }.with_note(note))
        };
        found.iter().filter_map(one).collect()
    }
}
