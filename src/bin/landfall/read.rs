//! Reads shaders and other input files, and converts arguments to layout options.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use landfall_layout::file::{MOST_BYTES, read_stream, read_whole};
use landfall_layout::other_language;
use landfall_layout::other_language::content;
use landfall_layout::{Error, Language, Options, ReadOptions, Rules, Source, source};

use crate::args::{Api, ReadArgs};

/// The layout options from the command line.
pub fn options(args: &ReadArgs) -> Options {
    let mut read = ReadOptions::default();
    read.defines = args.defines.iter().chain(&args.text.features).cloned().collect();
    read.preludes = args.text.preludes.clone();
    read.include_dirs = args.text.include_dirs.clone();
    read.overrides = args.text.overrides.clone();
    read.target = Api::reading(&args.text.targets);
    read.max_bytes = args.text.max_bytes;
    Options::default()
        .with_read(read)
        .with_rules(args.text.rules.as_deref().and_then(Rules::from_name))
        .with_gather(args.text.gather)
}

/// Whether a path on the command line means stdin.
pub fn is_stdin(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// The path that stands for stdin.
pub fn stdin_path(args: &ReadArgs) -> PathBuf {
    args.text.stdin_filename.clone().unwrap_or_else(|| PathBuf::from("<stdin>"))
}

/// The path of a shader in messages; for stdin its substitute.
pub fn message_path(path: &Path, args: &ReadArgs) -> PathBuf {
    if is_stdin(path) { stdin_path(args) } else { path.to_path_buf() }
}

/// Reads one shader.
pub fn source(path: &Path, args: &ReadArgs) -> Result<Source, Error> {
    if args.text.language.is_none() {
        other_language::refuse(&message_path(path, args))?;
    }
    let mut source = if is_stdin(path) {
        let name = stdin_path(args).display().to_string();
        let most = args.text.max_bytes.unwrap_or(MOST_BYTES);
        let bytes = read_stream("<stdin>", std::io::stdin().lock(), most)?;
        Source::from_bytes(name, bytes)?
    } else {
        let bytes = source::read_bytes(path, args.text.max_bytes)?;
        Source::from_bytes(path.display().to_string(), bytes)?
    };
    if let Some(language) = args.text.language {
        let language = language.language();
        if source.words.is_some() {
            let message = format!("is SPIR-V, but `--language {}` is given", language.name());
            return Err(Error::new(source.path, message).with_help("leave `--language` out"));
        }
        source.language = language;
    }
    source.stage = match source.language {
        Language::Glsl => args.text.stage.or(source.stage),
        Language::Wgsl | Language::SpirV => None,
    };
    Ok(source)
}

/// Reads one shader, of which the text is needed.
pub fn shader_text(path: &Path, args: &ReadArgs) -> Result<Source, Error> {
    let source = source(path, args)?;
    source.without_text().map_or(Ok(source), Err)
}

/// The name of a file in messages.
pub fn display_path(path: &Path) -> String {
    if is_stdin(path) { "<stdin>".to_string() } else { path.display().to_string() }
}

/// The maximum size of a file of values, locks or tables: 1 GiB.
const MOST_OTHER: u64 = 1 << 30;

/// Reads a file other than a shader.
pub fn bytes(path: &Path) -> Result<Vec<u8>, Error> {
    if is_stdin(path) {
        return read_stream("<stdin>", std::io::stdin().lock(), MOST_OTHER);
    }
    read_whole(path, MOST_OTHER)
}

/// The bytes of a regular file; `None` for anything else, such as a pipe, which would block.
pub fn file(path: &Path) -> Option<Vec<u8>> {
    let is_file = std::fs::metadata(path).is_ok_and(|found| found.is_file());
    if is_file { std::fs::read(path).ok() } else { None }
}

/// Whether a search takes a file with the ending of a shader: one whose ending other programs use as
/// well is looked into.
pub fn holds_shader(path: &Path) -> bool {
    if !content::has_shared_ending(path) {
        return true;
    }
    // What cannot be read is reported where it is read as a shader.
    head(path).is_none_or(|head| content::may_hold_shader(path, &head))
}

/// The first bytes of a regular file.
fn head(path: &Path) -> Option<Vec<u8>> {
    let is_file = std::fs::metadata(path).is_ok_and(|found| found.is_file());
    let file = if is_file { std::fs::File::open(path).ok() } else { None };
    let mut head = Vec::new();
    file?.take(content::HEAD_BYTES as u64).read_to_end(&mut head).ok()?;
    Some(head)
}

/// Reads a text file other than a shader, without its byte-order mark.
pub fn text(path: &Path) -> Result<String, Error> {
    let text = source::decode(&display_path(path), bytes(path)?)?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_string).unwrap_or(text))
}

/// Fails if both inputs are stdin.
pub fn only_one_stdin(shader: &Path, other: &Path) -> Result<(), Error> {
    if is_stdin(shader) && is_stdin(other) {
        return Err(Error::new("<stdin>", "cannot be both the shader and the other input")
            .with_help("name a file for one of them"));
    }
    Ok(())
}

/// Splits an error's text into the message and the help.
pub fn message_and_help(text: &str) -> (String, Option<String>) {
    match text.split_once("\nhelp: ") {
        Some((message, help)) => (message.to_string(), Some(help.to_string())),
        None => (text.to_string(), None),
    }
}
