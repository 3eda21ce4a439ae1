//! The files of `[[assert]]`: structures of the program, held to the shaders by its own compiler.

use std::collections::BTreeSet;
use std::path::PathBuf;

use landfall_layout::finding::{Finding, Level};
use landfall_layout::source::Files;
use landfall_layout::text::glob;
use landfall_layout::{Diagnostic, Error, Language, Severity, ShaderLayout};
use landfall_lint::{levels, stale_assertions};

use crate::basis::Basis;
use crate::config::AssertionFile;
use crate::files;
use crate::inputs::Inputs;
use crate::pass::{CheckRun, Pass};
use crate::stop::StopFlag;

/// What a file of assertions has to hold.
pub struct AssertionText {
    pub text: String,
    /// The shaders and their includes.
    pub files: BTreeSet<PathBuf>,
}

impl AssertionFile {
    /// Whether a shader is one of those that it is about.
    pub fn takes(&self, shader: &str) -> bool {
        // A directory stands for all shaders below it.
        let is_below = |folder: &String| {
            let rest = shader.strip_prefix(folder.as_str());
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        };
        self.shaders.iter().any(|named| glob::matches(named, shader) || is_below(named))
    }

    /// The text of the file, and what was read for it.
    ///
    /// # Errors
    ///
    /// A shader that cannot be read or laid out, and a structure or member that is not there.
    pub fn text(&self, basis: &Basis, stop: &StopFlag) -> Result<AssertionText, Vec<Finding>> {
        let mut layouts: Vec<ShaderLayout> = Vec::new();
        let paths = self.shaders.iter().map(PathBuf::from).collect();
        for input in Inputs::new(paths, stop.clone()) {
            let read = input.and_then(|input| basis.read(&input.path, None));
            let source =
                read.map_err(|error| vec![Diagnostic::from(error).located(&Files::default())])?;
            let shader = basis.settings.layout(&source, &basis.options);
            let errors = shader.diagnostics.iter().filter(|d| d.severity == Severity::Error);
            let errors: Vec<Finding> = errors.map(|found| found.located(&shader.files)).collect();
            if !errors.is_empty() {
                return Err(errors);
            }
            // Variants that lay blocks out in other ways are asserted, too.
            layouts.extend(basis.settings.distinct_variants(&source, &shader));
        }
        let layouts: Vec<&ShaderLayout> = layouts.iter().collect();
        let output = self.language.assertions(&layouts, &self.options);
        let empty = ShaderLayout::empty(String::new(), Language::Glsl, None);
        let files_of = |found: &Diagnostic| {
            let shader = layouts.iter().find(|shader| found.path.as_ref() == Some(&shader.path));
            shader.map_or(&empty, |shader| *shader).files.clone()
        };
        let errors = output.diagnostics.iter().filter(|d| d.severity == Severity::Error);
        let at_its_place = |found: &Diagnostic| {
            let mut finding = found.located(&files_of(found));
            // What is about no shader is about the row.
            let places = finding.labels.iter_mut().map(|label| &mut label.at);
            places.filter(|at| at.path.is_empty()).for_each(|at| *at = self.place.clone());
            finding
        };
        let errors: Vec<Finding> = errors.map(at_its_place).collect();
        let files = layouts.iter().flat_map(|shader| shader.all_files());
        let files = files.map(|file| PathBuf::from(&file.path)).collect();
        if errors.is_empty() { Ok(AssertionText { text: output.text, files }) } else { Err(errors) }
    }

    /// Why the file is not the one of the shaders; `None` if it is.
    pub fn difference(&self, text: &str) -> Result<Option<&'static str>, Error> {
        Ok(match files::file(&self.out) {
            Some(there) if there == text.as_bytes() => None,
            Some(_) => Some("is out of date"),
            None if self.out.exists() => {
                return Err(Error::new(self.out.display().to_string(), "is not a file"));
            }
            None => Some("does not exist"),
        })
    }
}

/// The findings about the files of which a shader was checked.
pub fn findings(pass: &Pass, check: &CheckRun<'_>) -> Vec<Finding> {
    if levels::level(stale_assertions::LINT.code, &check.basis.settings) == Level::Allow {
        return Vec::new();
    }
    // A check of some shaders looks at the rows that take one of them.
    let is_touched = |file: &&AssertionFile| {
        check.basis.scope.whole || pass.checked.iter().any(|checked| file.takes(&checked.path))
    };
    let mut found = Vec::new();
    for file in check.config.assertions.iter().filter(is_touched) {
        let shown = file.out.display().to_string();
        let about = |what: &str| stale_assertions::finding(&shown, &file.place, what);
        match file.text(check.basis, &check.stop) {
            Ok(AssertionText { text, .. }) => match file.difference(&text) {
                Ok(difference) => found.extend(difference.map(about)),
                Err(error) => found.push(about(&error.message)),
            },
            // What is wrong with a shader is a finding already.
            Err(errors) => {
                let first = errors.into_iter().next();
                let (cause, help) = first.map_or_else(Default::default, |e| (e.message, e.help));
                let finding = about(&format!("cannot be written: {cause}"));
                found.push(Finding { help, ..finding });
            }
        }
    }
    found
}
