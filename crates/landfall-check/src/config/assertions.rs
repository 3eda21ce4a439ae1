//! `[[assert]]`: files of assertions about structures of the program.

use std::path::PathBuf;

use landfall_codegen::languages::{self, LANGUAGES};
use landfall_codegen::{CodeOptions, OutputLanguage};
use landfall_layout::Diagnostic;
use landfall_layout::diagnostic::Code;
use landfall_layout::finding::Place;

use super::root::Root;
use super::strings;
use super::toml::{Keys, Text};
use crate::walk::slashes;

/// A row of the configuration: a file of assertions, and what is in it.
#[derive(Clone, Debug)]
pub struct AssertionFile {
    /// The file, as messages show it.
    pub out: PathBuf,
    pub language: OutputLanguage,
    /// Paths and globs of the shaders, as messages show them.
    pub shaders: Vec<String>,
    pub options: CodeOptions,
    pub place: Place,
}

pub fn read(keys: &Keys<'_>, root: &Root) -> Option<AssertionFile> {
    let (out, name) = (keys.needed("out"), keys.needed("lang"));
    let language = name.and_then(|name| language(keys, &name));
    let shaders = keys.texts("shaders").unwrap_or_default();
    let structures =
        strings(keys, "structures", "{ \"engine::PointLight\" = \"PointLight\" }", "structure");
    for (key, is_empty, example) in [
        ("shaders", shaders.is_empty(), "[\"shaders/*.frag\"]"),
        ("structures", structures.is_empty(), "{ \"engine::PointLight\" = \"PointLight\" }"),
    ] {
        // A value of a wrong type is empty, too, and has an error already.
        if is_empty && keys.row(key).is_none_or(|row| row.len() == Some(0)) {
            let message = format!("`[[assert]]` has no `{key}`");
            let found = Diagnostic::error(Code::MissingKey, keys.span(), message);
            keys.add(found.with_help(format!("add `{key} = {example}`")));
        }
    }
    let mut options = CodeOptions::default();
    options.assertions.structures = structures;
    options.assertions.fields =
        strings(keys, "fields", "{ \"PointLight.pos\" = \"position\" }", "name");
    options.assertions.field_prefix =
        keys.text("field-prefix").map_or(String::new(), |text| text.value);
    let headers = keys.texts("include-header").unwrap_or_default();
    options.c.includes = headers.into_iter().map(|text| text.value).collect();
    let out = root.path(&out?.value);
    options.file = out.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Some(AssertionFile {
        out,
        language: language?,
        shaders: shaders.iter().map(|text| slashes(&root.path(&text.value))).collect(),
        options,
        place: keys.place(),
    })
}

fn language(keys: &Keys<'_>, name: &Text) -> Option<OutputLanguage> {
    let found = languages::from_name(&name.value);
    if found.is_none() {
        let known: Vec<&'static str> = LANGUAGES.iter().map(|language| language.name).collect();
        keys.unknown(Code::WrongValue, "language", name, &known);
    }
    found
}
