//! Files read within bounds, and written whole or not at all.
//!
//! For the command and the build script; nothing else touches the file system but
//! [`source`](crate::source).

use std::io::Read;
use std::path::Path;
use std::{fs, io};

use crate::error::Error;

mod write;

pub use write::{FileWriter, Written, write_whole};

/// The reason of a failure in the words of the operating system, without its number.
pub fn reason(cause: &io::Error) -> String {
    let text = cause.to_string();
    text.split(" (os error").next().unwrap_or(&text).to_lowercase()
}

/// Bytes of the largest file that is read unless the caller says otherwise: 64 MiB.
pub const MOST_BYTES: u64 = 64 << 20;

/// Reads a whole file of at most `most` bytes.
///
/// # Errors
/// The file is a directory, a device, a pipe or a socket, is larger, or cannot be read. A pipe
/// that the caller was given open, `/dev/stdin` or `/dev/fd/N`, is read.
pub fn read_whole(path: &Path, most: u64) -> Result<Vec<u8>, Error> {
    let shown = path.display().to_string();
    let failed = |cause: io::Error| {
        Error::new(&shown, format!("cannot be read: {}", reason(&cause))).unreadable()
    };
    let found = fs::metadata(path).map_err(failed)?;
    if found.is_dir() {
        return Err(Error::new(&shown, "is a directory, not a file").unreadable());
    }
    let given = ["/dev/stdin", "/dev/fd/", "/proc/self/fd/"];
    if !found.is_file() && !given.iter().any(|given| path.starts_with(given)) {
        let message = "is a device, pipe or socket, not a file";
        return Err(Error::new(&shown, message).unreadable());
    }
    let mut bytes = Vec::new();
    // A file may grow while it is read, and those of the system have no size.
    let read = fs::File::open(path)
        .and_then(|file| match found.len() <= most {
            true => file.take(most.saturating_add(1)).read_to_end(&mut bytes),
            false => Ok(0),
        })
        .map_err(failed)?;
    if found.len() > most || read as u64 > most {
        return Err(too_large(&shown, most));
    }
    Ok(bytes)
}

/// Reads a stream of at most `most` bytes to its end.
///
/// # Errors
/// The stream is longer, or cannot be read.
pub fn read_stream(name: &str, stream: impl Read, most: u64) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    let failed = |cause: io::Error| {
        Error::new(name, format!("cannot be read: {}", reason(&cause))).unreadable()
    };
    stream.take(most.saturating_add(1)).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > most { Err(too_large(name, most)) } else { Ok(bytes) }
}

fn too_large(shown: &str, most: u64) -> Error {
    Error::new(shown, format!("is larger than {most} bytes, the most that is read"))
        .with_help("if it is what was meant, raise the limit with `--max-bytes N`")
        .unreadable()
}
