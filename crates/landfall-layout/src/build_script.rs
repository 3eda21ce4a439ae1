//! For `build.rs`: mirrors and headers that cannot drift from the shaders.
//!
//! Lays shaders out, writes what is asked for, tells Cargo which files to watch. Together with
//! the binary the only place that looks at the environment and prints.

use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};

use crate::codegen::c::{COptions, c};
use crate::codegen::rust::{RustOptions, Tables, Vectors, Visibility, rust};
use crate::diagnostic::{Diagnostic, Severity};
use crate::error::Error;
use crate::file::FileWriter;
use crate::format::{Paint, diagnostics};
use crate::source::{Files, Source, Target};
use crate::{Options, ShaderLayout, layout};

/// What a build script makes of its shaders.
///
/// ```no_run
/// # extern crate landfall_layout as landfall;
/// fn main() -> Result<(), landfall::BuildError> {
///     landfall::Build::new()
///         .shader("shaders/lights.frag")
///         .include("shaders/include")
///         .define("MAX_LIGHTS", "128")
///         .mirrors("lights.rs")
///         .run()
/// }
/// ```
///
/// and in the crate: `include!(concat!(env!("OUT_DIR"), "/lights.rs"));`
#[derive(Clone, Debug, Default)]
pub struct Build {
    shaders: Vec<PathBuf>,
    options: Options,
    rust: RustOptions,
    outputs: Vec<Output>,
}

/// A file to be written.
#[derive(Clone, Debug)]
struct Output {
    content: Content,
    place: Place,
    file: PathBuf,
}

#[derive(Clone, Copy, Debug)]
enum Content {
    RustMirrors,
    CHeader,
}

/// From where a path counts.
#[derive(Clone, Copy, Debug)]
enum Place {
    /// Cargo's `OUT_DIR`.
    OutDir,
    /// The package: the file is to be checked in.
    Package,
}

/// Why a build script has to stop, as text that is meant to be read.
///
/// A build script's `main` that returns it shows the findings as they are, source excerpts
/// included, because its `Debug` is its `Display`.
#[derive(Clone, PartialEq, Eq)]
pub struct BuildError {
    text: String,
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl fmt::Debug for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // After Cargo's own `Error: `.
        write!(f, "landfall cannot go on\n\n{}", self.text)
    }
}

impl std::error::Error for BuildError {}

impl From<Error> for BuildError {
    fn from(error: Error) -> BuildError {
        BuildError { text: error.to_string() }
    }
}

impl Build {
    /// Nothing yet: shaders and outputs are named with the methods below.
    pub fn new() -> Build {
        Build::default()
    }

    /// A shader whose blocks are mirrored; the path counts from the package.
    pub fn shader(mut self, path: impl AsRef<Path>) -> Build {
        self.shaders.push(path.as_ref().to_path_buf());
        self
    }

    /// A directory searched for `#include`.
    pub fn include(mut self, dir: impl AsRef<Path>) -> Build {
        self.options.read.include_dirs.push(dir.as_ref().to_path_buf());
        self
    }

    /// A macro of the shaders.
    pub fn define(mut self, name: &str, text: &str) -> Build {
        self.options.read.defines.push((name.to_string(), text.to_string()));
        self
    }

    /// The value of a specialisation constant or override, by name or number.
    pub fn specialise(mut self, name: &str, value: &str) -> Build {
        self.options.read.overrides.push((name.to_string(), value.to_string()));
        self
    }

    /// The API that GLSL texts are meant for, where they do not say.
    pub fn target(mut self, target: Target) -> Build {
        self.options.read.target = Some(target);
        self
    }

    /// Gathers loose uniforms into one std140 block, `DefaultBlock`.
    pub fn gather_loose_uniforms(mut self) -> Build {
        self.options.gather = true;
        self
    }

    /// Vectors as plain arrays instead of glam's types: the crate then needs no glam.
    pub fn plain_arrays(mut self) -> Build {
        self.rust.vectors = Vectors::Array;
        self
    }

    /// Items for the crate alone: `pub(crate)`.
    pub fn crate_visible(mut self) -> Build {
        self.rust.visibility = Visibility::Crate;
        self
    }

    /// Mirrors only, without the tables from names to offsets.
    pub fn without_tables(mut self) -> Build {
        self.rust.tables = Tables::Without;
        self
    }

    /// Writes Rust mirrors of all blocks to this file in `OUT_DIR`.
    pub fn mirrors(self, file: impl AsRef<Path>) -> Build {
        self.output(Content::RustMirrors, Place::OutDir, file.as_ref())
    }

    /// Writes Rust mirrors of all blocks to this file in the package, to be checked in.
    pub fn mirrors_in_package(self, file: impl AsRef<Path>) -> Build {
        self.output(Content::RustMirrors, Place::Package, file.as_ref())
    }

    /// Writes a C11 and C++17 header of all blocks to this file in `OUT_DIR`.
    pub fn c_header(self, file: impl AsRef<Path>) -> Build {
        self.output(Content::CHeader, Place::OutDir, file.as_ref())
    }

    /// Writes a C11 and C++17 header of all blocks to this file in the package, to be checked in.
    pub fn c_header_in_package(self, file: impl AsRef<Path>) -> Build {
        self.output(Content::CHeader, Place::Package, file.as_ref())
    }

    fn output(mut self, content: Content, place: Place, file: &Path) -> Build {
        self.outputs.push(Output { content, place, file: file.to_path_buf() });
        self
    }

    /// Lays the shaders out and writes what was asked for, each file whole or not at all, and only
    /// when it changes. Tells Cargo to run the script again when a shader or an include changes,
    /// also when this fails, and hands warnings on as Cargo's.
    ///
    /// # Errors
    /// A shader cannot be read or laid out, or a file cannot be written.
    pub fn run(&self) -> Result<(), BuildError> {
        let mut said = Said::default();
        let layouts = self.lay_out(&mut said);
        let texts: Vec<String> = match said.errors.is_empty() {
            true => self.outputs.iter().map(|out| self.text(&layouts, out, &mut said)).collect(),
            false => Vec::new(),
        };
        for path in &said.watched {
            println!("cargo::rerun-if-changed={}", path.display());
        }
        for warning in &said.warnings {
            println!("cargo::warning={warning}");
        }
        let writer = FileWriter::new(&said.watched);
        said.into_result()?;
        for (output, text) in self.outputs.iter().zip(texts) {
            writer.write(&output.path()?, text)?;
        }
        Ok(())
    }

    /// The Rust mirrors as text, for those who want to write them themselves; nothing is printed.
    ///
    /// # Errors
    /// A shader cannot be read or laid out.
    pub fn generate_string(&self) -> Result<String, BuildError> {
        let mut said = Said::default();
        let layouts = self.lay_out(&mut said);
        let text = self.mirrors_of(&layouts, &mut said);
        said.into_result()?;
        Ok(text)
    }

    fn lay_out(&self, said: &mut Said) -> Vec<ShaderLayout> {
        let mut layouts = Vec::new();
        for path in &self.shaders {
            said.watched.insert(path.clone());
            let source = match Source::read(path) {
                Ok(source) => source,
                Err(error) => {
                    said.tell(&[error.into()], &Files::default());
                    continue;
                }
            };
            let shader = layout(&source, &self.options);
            let files = shader.files.iter().map(|file| PathBuf::from(&file.path));
            said.watched.extend(files.filter(|file| file.is_file()));
            said.tell(&shader.diagnostics, &shader.files);
            layouts.push(shader);
        }
        layouts
    }

    fn text(&self, layouts: &[ShaderLayout], output: &Output, said: &mut Said) -> String {
        match output.content {
            Content::RustMirrors => self.mirrors_of(layouts, said),
            Content::CHeader => {
                let name = output.file.file_name().unwrap_or_default().to_string_lossy();
                let options = COptions { file: name.into_owned(), prefix: String::new() };
                let output = c(&layouts.iter().collect::<Vec<_>>(), &options);
                said.left_out(&output.diagnostics, layouts);
                output.text
            }
        }
    }

    fn mirrors_of(&self, layouts: &[ShaderLayout], said: &mut Said) -> String {
        let inputs = self.shaders.iter().map(|path| path.display().to_string()).collect();
        let options = RustOptions { inputs, ..self.rust.clone() };
        let output = rust(&layouts.iter().collect::<Vec<_>>(), &options);
        said.left_out(&output.diagnostics, layouts);
        output.text
    }
}

/// What a run has to say, and the files it looked at.
#[derive(Default)]
struct Said {
    watched: BTreeSet<PathBuf>,
    warnings: BTreeSet<String>,
    errors: String,
}

impl Said {
    /// Errors are kept with their excerpts; a warning of Cargo's is a line.
    fn tell(&mut self, found: &[Diagnostic], files: &Files) {
        let (errors, warnings): (Vec<Diagnostic>, Vec<Diagnostic>) =
            found.iter().cloned().partition(|d| d.severity == Severity::Error);
        self.errors.push_str(&diagnostics::human(&errors, files, Paint::Plain));
        self.warnings.extend(warnings.iter().map(|warning| one_line(warning, files)));
    }

    /// A block without a mirror is named; the others have theirs.
    fn left_out(&mut self, found: &[Diagnostic], layouts: &[ShaderLayout]) {
        for found in found {
            let shader = layouts.iter().find(|shader| found.path.as_ref() == Some(&shader.path));
            let files = shader.map_or_else(Files::default, |shader| shader.files.clone());
            self.warnings.insert(one_line(found, &files));
        }
    }

    fn into_result(self) -> Result<(), BuildError> {
        match self.errors.is_empty() {
            true => Ok(()),
            false => Err(BuildError { text: self.errors.trim_end().to_string() }),
        }
    }
}

fn one_line(found: &Diagnostic, files: &Files) -> String {
    let place = match found.labels.first() {
        Some(label) => {
            let at = files.locate(label.span);
            format!("{}:{}:{}: ", at.path, at.line, at.column)
        }
        None => String::new(),
    };
    let help = found.help.as_ref().map(|help| format!(" ({help})")).unwrap_or_default();
    format!("{place}{}{help}", found.message).replace('\n', " ")
}

impl Output {
    fn path(&self) -> Result<PathBuf, BuildError> {
        let variable = match self.place {
            Place::OutDir => "OUT_DIR",
            Place::Package => "CARGO_MANIFEST_DIR",
        };
        match std::env::var_os(variable) {
            Some(dir) => Ok(PathBuf::from(dir).join(&self.file)),
            None => {
                let message = format!("has no place: `{variable}` is not set");
                let error = Error::new(self.file.display().to_string(), message);
                Err(error
                    .with_help("call `run` from a build script, or use `generate_string`")
                    .into())
            }
        }
    }
}
