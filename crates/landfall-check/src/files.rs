//! Reads files other than shaders, and makes writers.

use std::path::Path;

use landfall_layout::file::{FileWriter, read_stdin, read_whole};
use landfall_layout::{Error, source};

/// Whether a path on the command line means stdin.
pub fn is_stdin(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// The name of a file in messages.
pub fn display_path(path: &Path) -> String {
    if is_stdin(path) { "<stdin>".to_string() } else { path.display().to_string() }
}

/// The maximum size of a file of values, locks or tables: 1 GiB.
const MAX_OTHER: u64 = 1 << 30;

/// Reads a file other than a shader.
pub fn bytes(path: &Path) -> Result<Vec<u8>, Error> {
    if is_stdin(path) {
        return read_stdin(MAX_OTHER);
    }
    read_whole(path, MAX_OTHER)
}

/// The bytes of a regular file; `None` for anything else, such as a pipe, which would block.
pub fn file(path: &Path) -> Option<Vec<u8>> {
    let is_file = std::fs::metadata(path).is_ok_and(|found| found.is_file());
    if is_file { std::fs::read(path).ok() } else { None }
}

/// Reads a text file other than a shader, without its byte-order mark.
pub fn text(path: &Path) -> Result<String, Error> {
    let text = source::decode(&display_path(path), bytes(path)?)?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_string).unwrap_or(text))
}

/// A writer that does not overwrite the file that standard input is redirected from.
pub fn writer() -> FileWriter {
    // A file redirected to stdin is an input too, and would be emptied.
    FileWriter::new(["/dev/stdin"])
}
