//! Reads shaders as the command line names them, and converts arguments to layout options.

use std::path::{Path, PathBuf};

use landfall_check::config::Config;
use landfall_check::files::is_stdin;
use landfall_layout::file::{MAX_BYTES, read_stdin};
use landfall_layout::other_language;
use landfall_layout::{Error, Language, Options, Source, source};

use crate::args::ReadArgs;

pub fn options(args: &ReadArgs) -> Options {
    Config::default().options(&args.flags())
}

/// The path that stands for stdin.
pub fn stdin_path(args: &ReadArgs) -> PathBuf {
    args.text.stdin_filename.clone().unwrap_or_else(|| PathBuf::from("<stdin>"))
}

/// The path of a shader in messages; for stdin its substitute.
pub fn message_path(path: &Path, args: &ReadArgs) -> PathBuf {
    if is_stdin(path) { stdin_path(args) } else { path.to_path_buf() }
}

pub fn source(path: &Path, args: &ReadArgs) -> Result<Source, Error> {
    // A file of another shading language is refused before it is parsed as GLSL, unless
    // `--language` says what it is.
    if args.text.language.is_none() {
        other_language::refuse(&message_path(path, args))?;
    }
    let mut source = if is_stdin(path) {
        let name = stdin_path(args).display().to_string();
        let bytes = read_stdin(MAX_BYTES)?;
        Source::from_bytes(name, bytes)?
    } else {
        let bytes = source::read_bytes(path, None)?;
        Source::from_bytes(path.display().to_string(), bytes)?
    };
    if let Some(language) = args.text.language {
        let language = language.language();
        // The bytes say what SPIR-V is; no option can make it text.
        if source.words.is_some() {
            let message = format!("is SPIR-V, but `--language {}` is given", language.name());
            return Err(Error::new(source.path, message).with_help("leave `--language` out"));
        }
        source.language = language;
    }
    // The stage follows from the name of the file; in WGSL and SPIR-V it is in the text.
    source.stage = match source.language {
        Language::Glsl => args.text.stage.or(source.stage),
        Language::Wgsl | Language::SpirV => None,
    };
    Ok(source)
}

/// Reads one shader, of which the text is needed.
#[cfg(any(feature = "exec", feature = "port"))]
pub fn shader_text(path: &Path, args: &ReadArgs) -> Result<Source, Error> {
    let source = source(path, args)?;
    source.without_text().map_or(Ok(source), Err)
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
