//! Shader sources: path, language, stage and text, and the map from a byte offset to file, line and
//! column.
//!
//! Feeds [`parse`](mod@crate::syntax); nothing here parses the text.

pub(crate) mod file_cache;
pub(crate) mod joined;
mod open_files;
mod spirv_words;
mod stage;

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use crate::error::Error;
use crate::file::{MAX_BYTES, read_whole};
use crate::other_language::refuse_text;
#[doc(hidden)]
pub use open_files::OpenFiles;
#[doc(hidden)]
pub use stage::ExecutableStage;
pub use stage::Stage;
use stage::stage_of_extension;

/// The language of a shader.
///
/// Exhaustive: a new language has to be handled everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Language {
    /// GLSL: desktop 1.10 to 4.60, ES 1.00 to 3.20, and the Vulkan flavour.
    Glsl,
    /// WGSL.
    Wgsl,
    /// SPIR-V binaries, 1.0 to 1.6, of either byte order.
    SpirV,
}

impl Language {
    /// Every language.
    pub const ALL: [Language; 3] = [Language::Glsl, Language::Wgsl, Language::SpirV];

    /// Returns the name used in messages and JSON: `glsl`, `wgsl` or `spirv`.
    pub fn name(self) -> &'static str {
        match self {
            Language::Glsl => "glsl",
            Language::Wgsl => "wgsl",
            Language::SpirV => "spirv",
        }
    }
}

/// Extensions of shader files that do not imply a stage.
const STAGELESS: &[&str] = &["glsl", "glslinc", "glslh", "shader", "slang"];

/// A shader source: its path, language, stage and text.
#[derive(Clone, Debug)]
pub struct Source {
    /// The path as messages print it; need not exist.
    pub path: String,
    /// The text, without a byte-order mark and with LF for a lone CR.
    pub text: Arc<str>,
    /// The language; taken from the extension unless set.
    pub language: Language,
    /// The words of a SPIR-V module, whose text is empty.
    pub words: Option<Arc<[u32]>>,
    /// The stage; taken from the extension unless set. WGSL has none, and SPIR-V says it itself.
    pub stage: Option<Stage>,
    /// Bytes of the file that are not UTF-8, read as Latin-1.
    pub foreign: Option<Foreign>,
    /// Whether the file begins with a byte-order mark.
    pub byte_order_mark: bool,
    /// The files that the text was put together from, if it imports others.
    #[doc(hidden)]
    pub linked: Option<Arc<joined::Linked>>,
}

/// Bytes of a file that are not UTF-8, which GLSL allows in comments (4.60 §3.1). Each is read as
/// the Latin-1 character of the same value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Foreign {
    /// Offset of the first in the text.
    pub first: u32,
    /// Number of such bytes.
    pub count: u32,
}

impl Source {
    /// Creates a source from text in memory; language and stage come from the path's extension.
    pub fn new(path: impl Into<String>, text: impl Into<Arc<str>>) -> Source {
        let path = path.into();
        let (language, stage) = kind_of_path(Path::new(&path)).unwrap_or((Language::Glsl, None));
        let text: Arc<str> = text.into();
        let byte_order_mark = text.starts_with('\u{feff}');
        let text = normalized(text);
        Source {
            path,
            text,
            language,
            words: None,
            stage,
            foreign: None,
            byte_order_mark,
            linked: None,
        }
    }

    /// Creates a source from the bytes of a file. Those that begin with SPIR-V's magic number are a
    /// module, whatever the path.
    ///
    /// # Errors
    /// The bytes are UTF-16, contain a zero byte, or are Slang or a template; or the path ends in `.spv`
    /// and they are no module.
    pub fn from_bytes(path: impl Into<String>, bytes: Vec<u8>) -> Result<Source, Error> {
        let path = path.into();
        // The extension as well: a file `a.spv` that is no module gets the error of one.
        if spirv_words::has_extension(Path::new(&path)) || spirv_words::begins(&bytes) {
            let words = Some(spirv_words::of_bytes(&path, &bytes)?);
            let language = Language::SpirV;
            return Ok(Source { language, words, stage: None, ..Source::new(path, "") });
        }
        let (text, foreign) = decode_shader(&path, bytes)?;
        refuse_text(Path::new(&path), &text)?;
        Ok(Source { foreign, ..Source::new(path, text) })
    }

    /// The error of what works on the text of a shader, if the source is a SPIR-V module.
    pub fn without_text(&self) -> Option<Error> {
        let is_module = self.language == Language::SpirV;
        is_module.then(|| {
            let message = "is SPIR-V, but what is asked for needs the text of a shader";
            let help = "name the text that it was compiled from; `layout`, `explain`, `lock`, \
                        `check`, `diff`, `emit`, `encode`, `decode` and `report` read SPIR-V";
            Error::new(self.path.as_str(), message).with_help(help)
        })
    }

    /// Reads a shader from a file.
    ///
    /// # Errors
    /// The file cannot be read, is a directory, or is not text.
    pub fn read(path: impl AsRef<Path>) -> Result<Source, Error> {
        let path = path.as_ref();
        Source::from_bytes(path.display().to_string(), read_bytes(path, None)?)
    }
}

/// Removes the byte-order mark and replaces every lone CR by LF, so that line ends are found by one
/// character; other bytes keep their offsets.
pub(crate) fn normalized(text: Arc<str>) -> Arc<str> {
    let lone = |text: &str, at: usize| text.as_bytes().get(at + 1) != Some(&b'\n');
    let rest = text.strip_prefix('\u{feff}').unwrap_or(&text);
    // Not by memchr, which first asks the processor what it can: that takes 30 µs where it is virtual,
    // and a WGSL file needs it nowhere else.
    if rest.match_indices('\r').any(|(at, _)| lone(rest, at)) {
        let ends = rest.char_indices();
        let ends = ends.map(|(at, c)| if c == '\r' && lone(rest, at) { '\n' } else { c });
        return ends.collect::<String>().into();
    }
    if rest.len() < text.len() { Arc::from(rest) } else { text }
}

/// Returns the language and stage implied by a path's extension; `None` if it is not a shader's.
pub fn kind_of_path(path: &Path) -> Option<(Language, Option<Stage>)> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    if matches!(extension.as_str(), "wgsl" | "wesl") {
        return Some((Language::Wgsl, None));
    }
    if spirv_words::has_extension(path) {
        return Some((Language::SpirV, None));
    }
    if let Some(stage) = stage_of_extension(&extension) {
        return Some((Language::Glsl, Some(stage)));
    }
    if STAGELESS.contains(&extension.as_str()) {
        // `light.frag.glsl`: the inner extension gives the stage; `shaders/fs.glsl`: the stem may.
        let stem = Path::new(path.file_stem()?);
        let inner = stem.extension().or(Some(stem.as_os_str()))?.to_str()?;
        return Some((Language::Glsl, stage_of_extension(&inner.to_ascii_lowercase())));
    }
    None
}

/// Whether a path's extension implies a language.
pub(crate) fn has_language(path: &Path, language: Language) -> bool {
    kind_of_path(path).is_some_and(|(of_path, _)| of_path == language)
}

/// Whether a search of a directory takes a file with that extension. SPIR-V, which a build writes
/// beside its sources, has to be named.
pub fn is_searched(path: &Path) -> bool {
    kind_of_path(path).is_some_and(|(language, _)| language != Language::SpirV)
}

/// Reads the bytes of a shader, at most `most` ([`MAX_BYTES`] if `None`).
///
/// # Errors
/// Those of [`read_whole`].
pub fn read_bytes(path: &Path, most: Option<u64>) -> Result<Vec<u8>, Error> {
    // Asked only when reading has failed, so that most files are looked at once.
    read_whole(path, most.unwrap_or(MAX_BYTES)).map_err(|error| match path.is_dir() {
        true => {
            let shown = path.display().to_string();
            Error::new(shown, "is a directory, not a shader file").unreadable()
        }
        false => error,
    })
}

/// Decodes a shader's bytes as UTF-8; bytes that are not UTF-8 are read as Latin-1.
///
/// # Errors
/// The bytes are UTF-16 or contain a zero byte.
pub(crate) fn decode_shader(
    path: &str,
    bytes: Vec<u8>,
) -> Result<(String, Option<Foreign>), Error> {
    let bytes = match std::str::from_utf8(&bytes) {
        Err(_) if !starts_as_utf16(&bytes) && !bytes.contains(&0) => bytes,
        // Whether it is UTF-8 or no text at all: all texts go this way, which has the errors.
        _ => return Ok((decode(path, bytes)?, None)),
    };
    // A byte that is not UTF-8 becomes a character of two bytes.
    let mut text = String::with_capacity(bytes.len() + 64);
    let mut foreign: Option<Foreign> = None;
    for chunk in bytes.utf8_chunks() {
        text.push_str(chunk.valid());
        for &byte in chunk.invalid() {
            let found = foreign.get_or_insert(Foreign { first: text.len() as u32, count: 0 });
            found.count += 1;
            text.push(char::from(byte));
        }
    }
    // Offsets do not count the byte-order mark.
    if let (Some(found), true) = (&mut foreign, text.starts_with('\u{feff}')) {
        found.first -= '\u{feff}'.len_utf8() as u32;
    }
    Ok((text, foreign))
}

fn starts_as_utf16(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff])
}

/// Decodes a file's bytes as UTF-8, with or without a byte-order mark.
///
/// # Errors
/// UTF-16, a zero byte, or bytes that are not UTF-8, with line and column of the first.
pub fn decode(path: &str, bytes: Vec<u8>) -> Result<String, Error> {
    decoded(path, bytes).map_err(Error::unreadable)
}

fn decoded(path: &str, bytes: Vec<u8>) -> Result<String, Error> {
    if starts_as_utf16(&bytes) {
        return Err(
            Error::new(path, "is UTF-16, but read as UTF-8").with_help("save the file as UTF-8")
        );
    }
    let text = match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => {
            // Up to here everything is UTF-8, so that line and column can be counted.
            let at = error.utf8_error().valid_up_to();
            let bytes = error.as_bytes();
            let before = &bytes[..at];
            let line = before.iter().filter(|&&b| b == b'\n').count() + 1;
            let line_start = before.iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
            let column = String::from_utf8_lossy(&before[line_start..]).chars().count() + 1;
            let message =
                format!("is not UTF-8: byte 0x{:02x} at line {line}, column {column}", bytes[at]);
            return Err(Error::new(path, message).with_help("save the file as UTF-8"));
        }
    };
    if let Some(at) = text.find('\0') {
        let message = format!("is not text: a zero byte at offset {at}");
        return Err(Error::new(path, message));
    }
    Ok(text)
}

/// A byte range in one of a shader's files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Span {
    /// Index into [`Files`].
    pub file: u32,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl Span {
    /// Extends `self` to the end of `other`, if both are in one file.
    pub fn to(self, other: Span) -> Span {
        if self.file == other.file && other.end >= self.start {
            Span { end: other.end, ..self }
        } else {
            self
        }
    }
}

/// A file of a shader: its own file comes first, then its includes.
#[derive(Clone, Debug)]
pub struct File {
    /// The path as messages print it.
    pub path: String,
    /// The text.
    pub text: Arc<str>,
    /// Offsets of the line starts, computed on first use.
    lines: OnceLock<Vec<u32>>,
    /// The number of characters before each [`COUNTED`] bytes, computed on first use.
    characters: OnceLock<Vec<u32>>,
}

/// The bytes whose characters are counted again for each place: a line may be as long as the file.
const COUNTED: usize = 1024;

impl File {
    fn new(path: String, text: Arc<str>) -> File {
        File { path, text, lines: OnceLock::new(), characters: OnceLock::new() }
    }

    fn lines(&self) -> &[u32] {
        self.lines.get_or_init(|| {
            // A line ends with LF, CR LF or a lone CR.
            let bytes = self.text.as_bytes();
            let ends = memchr::memchr2_iter(b'\n', b'\r', bytes)
                .filter(|&at| bytes[at] == b'\n' || bytes.get(at + 1) != Some(&b'\n'));
            std::iter::once(0).chain(ends.map(|end| end as u32 + 1)).collect()
        })
    }

    /// Returns the text of a line, from 1, without its end; `None` beyond the last byte.
    pub fn line(&self, number: u32) -> Option<&str> {
        let lines = self.lines();
        let at = (number as usize).checked_sub(1)?;
        let start = *lines.get(at)? as usize;
        let end = lines.get(at + 1).map_or(self.text.len(), |&next| next as usize);
        (start < end).then(|| self.text[start..end].trim_end_matches(['\r', '\n']))
    }

    /// The number of characters that begin before a byte.
    fn characters_before(&self, at: usize) -> u32 {
        let bytes = self.text.as_bytes();
        // Continuation bytes of UTF-8 do not start a character.
        let count = |bytes: &[u8]| bytes.iter().filter(|&&b| b & 0xc0 != 0x80).count() as u32;
        let steps = self.characters.get_or_init(|| {
            let add = |sum: &mut u32, step| {
                *sum += count(step);
                Some(*sum)
            };
            std::iter::once(0).chain(bytes.chunks_exact(COUNTED).scan(0, add)).collect()
        });
        steps[at / COUNTED] + count(&bytes[at - at % COUNTED..at])
    }
}

/// The files of one shader; maps a [`Span`] to line and column.
#[derive(Clone, Debug, Default)]
pub struct Files {
    files: Vec<File>,
    /// Where the parts of the first file's text stand in the others, if it was put together.
    joined: Option<Arc<joined::Joined>>,
}

/// A line and column, both from 1; the column counts characters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// The path as messages print it.
    pub path: String,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
}

impl Files {
    /// Adds a file and returns its index for [`Span::file`].
    pub fn add(&mut self, path: impl Into<String>, text: Arc<str>) -> u32 {
        self.files.push(File::new(path.into(), text));
        self.files.len() as u32 - 1
    }

    /// Returns the file with that index.
    pub fn get(&self, file: u32) -> Option<&File> {
        self.files.get(file as usize)
    }

    /// Returns all files, the shader's own first.
    pub fn iter(&self) -> impl Iterator<Item = &File> {
        self.files.iter()
    }

    /// Returns the text of a span.
    pub fn text(&self, span: Span) -> &str {
        self.get(span.file)
            .and_then(|file| file.text.get(span.start as usize..span.end as usize))
            .unwrap_or("")
    }

    /// Returns the line and column of a span's first byte.
    pub fn locate(&self, span: Span) -> Location {
        let span = self.resolve(span);
        let Some(file) = self.get(span.file) else {
            return Location { path: String::new(), line: 0, column: 0 };
        };
        let start = (span.start as usize).min(file.text.len());
        let lines = file.lines();
        // The last line that starts at or before the byte; there is always the first.
        let line = lines.partition_point(|&line| line as usize <= start);
        let line_start = lines[line - 1] as usize;
        let column = file.characters_before(start) - file.characters_before(line_start) + 1;
        Location { path: file.path.clone(), line: line as u32, column }
    }
}

/// The API that a GLSL shader targets; in JSON `opengl` or `vulkan`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Target {
    /// OpenGL and OpenGL ES: `VULKAN` is not defined, block rules default to `shared`.
    OpenGl,
    /// Vulkan: `VULKAN` is 100, block rules default to std140 and std430.
    Vulkan,
}

/// Options of reading a shader.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ReadOptions {
    /// Macros defined before the first line, as name and text: `-D NAME=TEXT`.
    pub defines: Vec<(String, String)>,
    /// Directories searched for `#include`, in order: `-I DIR`.
    pub include_dirs: Vec<PathBuf>,
    /// Values of specialisation constants and overrides by name or number: `-O NAME=VALUE`.
    pub overrides: Vec<(String, String)>,
    /// The API a GLSL shader targets; `None` infers it from the text.
    pub target: Option<Target>,
    /// The size limit of a file in bytes; [`MAX_BYTES`] unless set.
    pub max_bytes: Option<u64>,
    /// Files whose text comes before that of each shader of their language, in order: `--prelude
    /// FILE`. Those whose name does not tell the language come before WGSL.
    pub preludes: Vec<PathBuf>,
    /// The name or path of a structure that is laid out instead of the blocks: `--struct NAME`.
    pub structure: Option<String>,
    /// Which stage is read of a GLSL file that an engine splits into several, from 0; `None` reads that
    /// of the source, or the first.
    #[doc(hidden)]
    pub stage_index: Option<usize>,
    /// The files that readings by these options have in common.
    #[doc(hidden)]
    pub cache: Option<Arc<file_cache::FileCache>>,
    /// Texts that stand for files of the system.
    #[doc(hidden)]
    pub open_files: Option<Arc<OpenFiles>>,
    /// The files that `#include` may read, by path and text, instead of those of the system.
    pub files: Option<Vec<(String, String)>>,
}

impl ReadOptions {
    /// Returns the options with values of specialisation constants and overrides.
    #[must_use]
    pub fn with_overrides(self, overrides: Vec<(String, String)>) -> ReadOptions {
        ReadOptions { overrides, ..self }
    }

    /// Returns the options with the API that GLSL shaders target.
    #[must_use]
    pub fn with_target(self, target: Target) -> ReadOptions {
        ReadOptions { target: Some(target), ..self }
    }
}
