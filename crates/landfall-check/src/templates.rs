//! Templates that a search finds: they are passed over, and named once a directory.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use landfall_layout::diagnostic::Code;
use landfall_layout::error::ErrorKind;
use landfall_layout::format::phrases::counted;
use landfall_layout::{Diagnostic, Error, Severity};

use crate::inputs::Input;

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

    /// A warning for each directory; an error if `is_all` that the search found are templates.
    pub fn findings(&self, is_all: bool) -> Vec<Diagnostic> {
        let found = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let severity = if is_all { Severity::Error } else { Severity::Warning };
        let one = |(directory, files): (&PathBuf, &BTreeMap<PathBuf, Error>)| {
            let first = files.values().next()?;
            // A single file is named itself, several are named by their directory.
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
