//! Streams, pipes and devices, which are written to in place.

use std::ffi::OsStr;
use std::fs::{self, Metadata};
use std::path::Path;

use super::folder_of;
use crate::error::Error;

/// Whether a path names an open stream: `/dev/stdout`, which may refer to a file that is being
/// written, `/dev/fd/N`, or `/proc/PID/fd/N`.
pub(super) fn is_stream(path: &Path) -> bool {
    let is_standard = ["/dev/stdin", "/dev/stdout", "/dev/stderr"].map(Path::new).contains(&path);
    let folder = folder_of(path);
    let is_open = folder == Path::new("/dev/fd")
        || folder.starts_with("/proc") && folder.file_name() == Some(OsStr::new("fd"));
    cfg!(unix) && (is_standard || is_open)
}

#[cfg(unix)]
pub(super) fn is_pipe(found: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    found.file_type().is_fifo()
}

#[cfg(not(unix))]
pub(super) fn is_pipe(_: &Metadata) -> bool {
    false
}

#[cfg(unix)]
pub(super) fn is_character_device(found: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    found.file_type().is_char_device()
}

#[cfg(not(unix))]
pub(super) fn is_character_device(_: &Metadata) -> bool {
    false
}

/// Opens a named pipe; fails if no process reads it, for which others would wait.
#[cfg(any(target_os = "linux", target_os = "macos"))]
pub(super) fn reader_of(pipe: &Path) -> Result<Option<fs::File>, Error> {
    use std::os::unix::fs::OpenOptionsExt;
    /// `O_NONBLOCK`.
    const AT_ONCE: i32 = if cfg!(target_os = "linux") { 0o4000 } else { 0x4 };
    // Opening a pipe for writing without waiting fails if there is no reader.
    match fs::OpenOptions::new().write(true).custom_flags(AT_ONCE).open(pipe) {
        Ok(opened) => Ok(Some(opened)),
        Err(_) => Err(super::refused(pipe, "is a pipe that no process reads")
            .with_help("start its reader first, or name a file")),
    }
}

#[cfg(not(any(target_os = "linux", target_os = "macos")))]
pub(super) fn reader_of(_: &Path) -> Result<Option<fs::File>, Error> {
    Ok(None)
}
