//! Parsing: from shader text or SPIR-V to [`Shape`]. Function bodies are skipped.

pub mod constant;
pub mod glsl;
#[cfg(feature = "spirv")]
mod spirv;
pub(crate) mod wgsl;

use std::borrow::Cow;
use std::hash::Hash;
use std::ops::Range;
use std::path::{Path, PathBuf};

use rustc_hash::FxHashSet;

use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::interface::Interface;
use crate::shape::Shape;
use crate::source::{Files, Language, ReadOptions, Source, Span, Stage, Target};
use crate::text::edit_distance::suggestion;

/// The result of parsing a shader.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Parsed {
    /// The blocks and the types in them.
    pub shape: Shape,
    /// The stage of a SPIR-V module.
    pub stage: Option<Stage>,
    /// The shader's file, then its includes.
    pub files: Files,
    /// Errors and warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// Function bodies in the shader's own file: from after `{` to before `}`.
    pub bodies: Vec<Span>,
    /// The API assumed for a GLSL shader that tests for `VULKAN`, where neither options nor text
    /// name one.
    pub assumed: Option<Target>,
    /// Whether OpenGL is assumed because of uniforms outside blocks, which Vulkan's GLSL lacks.
    pub assumed_of_loose: bool,
    /// Whether it is GLSL ES that is read for OpenGL.
    pub opengl_es: bool,
    /// Whether a WGSL shader requires `uniform_buffer_standard_layout`.
    pub standard_uniforms: bool,
}

/// Parses the declarations of a shader. With `gather`, loose uniforms become one std140 block.
pub fn parse(source: &Source, options: &ReadOptions, gather: bool) -> Parsed {
    let mut parsed = match source.language {
        Language::Glsl => glsl::read(source, options, gather),
        Language::Wgsl => wgsl::read(source, options),
        #[cfg(feature = "spirv")]
        Language::SpirV => spirv::read(source, options),
        #[cfg(not(feature = "spirv"))]
        Language::SpirV => no_modules(source),
    };
    if source.byte_order_mark {
        let message = "the file begins with a byte-order mark";
        let warning = Diagnostic::warning(Code::ByteOrderMark, Span::default(), message);
        let note = "compilers refuse that character, unless the program that reads the file \
                    removes it";
        parsed.diagnostics.push(warning.with_note(note).with_help("save the file without one"));
    }
    parsed
}

/// The answer to a module in a build that reads texts alone.
#[cfg(not(feature = "spirv"))]
fn no_modules(source: &Source) -> Parsed {
    let mut parsed = Parsed::default();
    parsed.files.add(source.path.as_str(), std::sync::Arc::from(""));
    let message = "this build does not read SPIR-V";
    let error = Diagnostic::error(Code::OtherLanguage, Span::default(), message);
    parsed
        .diagnostics
        .push(error.with_help("build it with the feature `spirv` of `landfall-layout`"));
    parsed
}

/// The limit on errors about the names in one text's bodies. Each takes time to find the name that
/// is meant.
const MAX_NAME_ERRORS: usize = 100;

/// Returns the errors up to the limit; the last one notes that there are more.
fn first_name_errors(mut errors: impl Iterator<Item = Diagnostic>) -> Vec<Diagnostic> {
    let mut first: Vec<Diagnostic> = errors.by_ref().take(MAX_NAME_ERRORS).collect();
    if let (Some(last), true) = (first.last_mut(), errors.next().is_some()) {
        last.notes.push("more names of the file are unknown; they are not shown".to_string());
    }
    first
}

/// Returns a text of the same length with blanks in some ranges, whose ends of lines stay.
// Blanks instead of removal, byte for byte: spans and line numbers are those of the file.
fn blanked(text: &str, ranges: impl IntoIterator<Item = Range<usize>>) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for range in ranges {
        let part = bytes[range].iter_mut().filter(|byte| !matches!(byte, b'\n' | b'\r'));
        part.for_each(|byte| *byte = b' ');
    }
    String::from_utf8(bytes).expect("the ranges hold whole characters")
}

/// The nodes of a graph that are reached from some, these included.
fn reached<T: Copy + Eq + Hash, N: Iterator<Item = T>>(
    from: impl IntoIterator<Item = T>,
    next: impl Fn(T) -> N,
) -> FxHashSet<T> {
    let mut reached: FxHashSet<T> = from.into_iter().collect();
    let mut open: Vec<T> = reached.iter().copied().collect();
    while let Some(one) = open.pop() {
        open.extend(next(one).filter(|other| reached.insert(*other)));
    }
    reached
}

/// Returns a name without a part that may stand at one of its ends, and whether it stands there.
fn stripped<'t>(name: &'t str, rest: Option<&'t str>) -> (&'t str, bool) {
    (rest.unwrap_or(name), rest.is_some())
}

/// The limit on folders above a file that are searched.
const MAX_FOLDERS: usize = 16;

/// A path and the folders above it, up to that of the repository.
pub(crate) fn above(path: &Path) -> impl Iterator<Item = PathBuf> {
    let mut paths: Vec<PathBuf> = path.ancestors().map(Path::to_path_buf).collect();
    if path.is_relative() {
        // Those above the working directory.
        let up = std::iter::successors(Some(PathBuf::from("..")), |up| Some(up.join("..")));
        paths.extend(up.take(MAX_FOLDERS));
    }
    let mut is_done = false;
    paths.into_iter().take(MAX_FOLDERS).take_while(move |folder| {
        let goes_on = !is_done;
        is_done = folder.join(".git").exists();
        goes_on
    })
}

/// The paths in a folder in their order; none if it cannot be read.
pub(crate) fn listed(folder: &Path) -> Vec<PathBuf> {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(here).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| folder.join(entry.file_name())).collect();
    paths.sort_unstable();
    paths
}

/// The error for a structure that a text does not declare.
fn no_structure<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Diagnostic {
    let message = format!("no structure named `{name}`");
    let error = Diagnostic::without_place(Code::UnknownBlock, Severity::Error, message);
    let known: Vec<&str> = known.collect();
    match suggestion(name, known.iter().copied()) {
        Some(help) => error.with_help(help),
        None if known.is_empty() => error.with_note("the text declares none"),
        None => {
            error.with_help(format!("available: `{}`", known[..known.len().min(8)].join("`, `")))
        }
    }
}

/// Returns a shader with what it imports in its text, its conditions applied; the shader itself where
/// there is nothing to import, or where that fails, which [`parse`] reports.
pub fn linked<'s>(source: &'s Source, options: &ReadOptions) -> Cow<'s, Source> {
    link(source, options).0
}

/// As [`linked`], with the warnings about its imports, which [`parse`] no longer reports of it.
pub(crate) fn link<'s>(
    source: &'s Source,
    options: &ReadOptions,
) -> (Cow<'s, Source>, Vec<Diagnostic>) {
    match source.language {
        Language::Glsl | Language::SpirV => (Cow::Borrowed(source), Vec::new()),
        Language::Wgsl => match wgsl::link::linked(source, options) {
            Ok(Some((linked, warnings))) => (Cow::Owned(linked), warnings),
            Ok(None) | Err(_) => (Cow::Borrowed(source), Vec::new()),
        },
    }
}

/// Returns what a program binds to a shader.
pub fn interface(source: &Source, options: &ReadOptions) -> Interface {
    match source.language {
        Language::Glsl => glsl::interface::read(source, options),
        Language::Wgsl => wgsl::interface::read(&linked(source, options), options),
        Language::SpirV => Interface::default(),
    }
}

/// Returns the first syntax error of a GLSL shader, function bodies included.
pub fn syntax_error(source: &Source, options: &ReadOptions) -> Option<Diagnostic> {
    match source.language {
        Language::Glsl => glsl::syntax_error(source, options),
        Language::Wgsl | Language::SpirV => None,
    }
}

/// What no compiler takes in the function bodies of a shader whose declarations have no errors.
pub struct BodyErrors {
    /// The first syntax error of GLSL, or every name that is reserved or not declared. A text without
    /// an entry point is a part of others, which may declare its names and macros: it has only
    /// reserved words.
    pub errors: Vec<Diagnostic>,
    /// Whether the text has an entry point.
    pub has_entry_point: bool,
}

/// Returns what no compiler takes in the function bodies of a shader.
pub fn body_errors(source: &Source, options: &ReadOptions) -> BodyErrors {
    match source.language {
        Language::Glsl => glsl::body_errors(source, options),
        Language::Wgsl => wgsl::body_errors(&linked(source, options)),
        Language::SpirV => BodyErrors { errors: Vec::new(), has_entry_point: true },
    }
}

/// Returns a text without its line continuations, which WGSL does not have.
pub fn joined_lines(text: &str, language: Language) -> Cow<'_, str> {
    match language {
        Language::Glsl => glsl::joined_lines(text),
        Language::Wgsl | Language::SpirV => Cow::Borrowed(text),
    }
}

/// Returns the tokens of a text without line continuations. Comments are left out, macros are not
/// expanded, and a `;` follows each directive, whose end only its line shows.
pub fn tokens(text: &str, language: Language) -> Vec<&str> {
    match language {
        Language::Glsl => glsl::tokens(text),
        Language::Wgsl => wgsl::tokens(text),
        Language::SpirV => Vec::new(),
    }
}
