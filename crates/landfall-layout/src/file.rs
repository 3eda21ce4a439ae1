//! Bounded file reads and atomic file writes.
//!
//! For the command and the build script; apart from these only [`source`](crate::source) touches
//! the file system.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::{fs, io};

use crate::error::Error;
use crate::text::counts;
use crate::text::edit_distance::nearest;

mod write;

pub use write::{FileWriter, Written, is_running, remove_partial};

/// The operating system's message for an error, lower case, without its number.
pub fn reason(cause: &io::Error) -> String {
    let text = cause.to_string();
    text.split(" (os error").next().unwrap_or(&text).to_lowercase()
}

/// The default limit on the size of files that are read: 64 MiB.
pub const MAX_BYTES: u64 = 64 << 20;

/// Removes a directory to which processes that are ending may still write, if it can be.
pub fn remove_directory(path: &Path) {
    // A directory that is still written to is not empty when it should be removed: half a second of
    // tries.
    for _ in 0..50 {
        match fs::remove_dir_all(path) {
            Err(cause) if cause.kind() != io::ErrorKind::NotFound || path.exists() => {
                std::thread::sleep(std::time::Duration::from_millis(10));
            }
            Ok(()) | Err(_) => return,
        }
    }
}

/// Reads a file of at most `most` bytes.
///
/// # Errors
/// The file is a directory, a device, a pipe or a socket, is larger, or cannot be read. Pipes that
/// are already open, `/dev/stdin` and `/dev/fd/N`, are read.
pub fn read_whole(path: &Path, most: u64) -> Result<Vec<u8>, Error> {
    let shown = path.display().to_string();
    let failed = |cause: io::Error| {
        Error::new(&shown, format!("cannot be read: {}", reason(&cause))).unreadable()
    };
    let found = fs::metadata(path).map_err(|cause| {
        let is_missing = cause.kind() == io::ErrorKind::NotFound;
        let near = is_missing.then(|| nearest_path(path)).flatten();
        let help = near.map(|near| format!("did you mean `{}`?", near.display()));
        Error { help, ..failed(cause) }
    })?;
    if found.is_dir() {
        return Err(Error::new(&shown, "is a directory, not a file").unreadable());
    }
    let given = ["/dev/stdin", "/dev/fd/", "/proc/self/fd/"];
    if !found.is_file() && !given.iter().any(|given| path.starts_with(given)) {
        let message = "is a device, pipe or socket, not a file";
        return Err(Error::new(&shown, message).unreadable());
    }
    // With room for the end of the file to be seen by the same read.
    let room = found.len().min(most).min(1 << 20) as usize + 64;
    let mut bytes = Vec::with_capacity(room);
    // A file may grow while it is read, and files in `/proc` report size 0.
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

/// The path in the same folder whose name is nearest to that of a path that does not exist.
pub(crate) fn nearest_path(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let entries = fs::read_dir(folder.unwrap_or(Path::new("."))).ok()?.flatten();
    let mut names: Vec<String> =
        entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    // Of two that are equally near, the same in every run.
    names.sort_unstable();
    // `a.frag` and `b.frag` are alike in their endings alone.
    let has_near_stem = |other: &&str| {
        let stems = Path::new(name).file_stem().zip(Path::new(other).file_stem());
        let stems = stems.and_then(|(own, other)| own.to_str().zip(other.to_str()));
        stems.is_some_and(|(own, other)| nearest(own, [other].into_iter()).is_some())
    };
    let near = nearest(name, names.iter().map(String::as_str).filter(has_near_stem))?;
    Some(path.with_file_name(near))
}

/// Reads standard input of at most `most` bytes to its end.
///
/// # Errors
/// It is longer, or cannot be read.
pub fn read_stdin(most: u64) -> Result<Vec<u8>, Error> {
    let name = "<stdin>";
    let mut bytes = Vec::new();
    let failed = |cause: io::Error| {
        Error::new(name, format!("cannot be read: {}", reason(&cause))).unreadable()
    };
    io::stdin().lock().take(most.saturating_add(1)).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > most { Err(too_large(name, most)) } else { Ok(bytes) }
}

fn too_large(shown: &str, most: u64) -> Error {
    Error::new(shown, format!("is larger than the limit of {}", counts::bytes(most))).unreadable()
}
