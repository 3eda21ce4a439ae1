//! Templates that a search finds: they are passed over, and named once a directory.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use landfall_layout::diagnostic::Code;
use landfall_layout::error::ErrorKind;
use landfall_layout::format::phrases::counted;
use landfall_layout::{Diagnostic, Error, Severity};

use crate::inputs::Input;

/// The templates of a run, by directory: their number, and why the first is one.
#[derive(Default)]
pub struct Templates(Mutex<BTreeMap<PathBuf, (usize, Error)>>);

impl Templates {
    /// Passes over an input that a search found, if it cannot be read because it is a template.
    pub fn passes_over(&self, input: &Input, error: &Error) -> bool {
        if !input.is_searched || error.kind != ErrorKind::Template {
            return false;
        }
        let directory = input.path.parent().unwrap_or(Path::new("")).to_path_buf();
        let mut found = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (count, first) = found.entry(directory).or_insert_with(|| (0, error.clone()));
        *count += 1;
        if error.path < first.path {
            *first = error.clone();
        }
        true
    }

    /// A warning for each directory; an error if `is_all` that the search found are templates.
    pub fn findings(&self, is_all: bool) -> Vec<Diagnostic> {
        let found = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let one = |(directory, (count, first)): (&PathBuf, &(usize, Error))| {
            if *count == 1 {
                let severity = if is_all { Severity::Error } else { Severity::Warning };
                return Diagnostic { severity, ..first.clone().into() };
            }
            let directory = match directory.as_os_str().is_empty() {
                true => ".".to_string(),
                false => directory.display().to_string(),
            };
            let message = format!(
                "{} of `{directory}` are templates, which landfall does not read",
                counted(*count, "file")
            );
            let found =
                Diagnostic::about(Code::OtherLanguage, message, first.help.clone(), directory);
            let severity = if is_all { Severity::Error } else { Severity::Warning };
            let note = format!("`{}` {}", first.path, first.message);
            Diagnostic { severity, ..found }.with_note(note)
        };
        found.iter().map(one).collect()
    }
}
