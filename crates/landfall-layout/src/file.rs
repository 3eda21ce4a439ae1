//! Files written whole or not at all.
//!
//! For the command and the build script; nothing else touches the file system but
//! [`source`](crate::source).

use std::io::Write;
use std::path::Path;
use std::{fs, io};

use crate::error::Error;

/// The reason of a failure in the words of the operating system, without its number.
pub fn reason(cause: &io::Error) -> String {
    let text = cause.to_string();
    text.split(" (os error").next().unwrap_or(&text).to_lowercase()
}

/// Writes a file whole or not at all, and not when it already holds those bytes.
///
/// Behind a symbolic link the file it leads to is replaced; a pipe or device is written to.
///
/// # Errors
/// The directory cannot be made or the file cannot be written; what was there before still is.
pub fn write_whole(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), Error> {
    let bytes = bytes.as_ref();
    let given = path;
    let failed = |cause: io::Error| {
        Error::new(given.display().to_string(), format!("cannot be written: {}", reason(&cause)))
    };
    let real = if path.is_symlink() { fs::canonicalize(path).ok() } else { None };
    let path = real.as_deref().unwrap_or(path);
    if fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        let mut file = fs::OpenOptions::new().write(true).open(path).map_err(failed)?;
        return file.write_all(bytes).map_err(failed);
    }
    if fs::read(path).is_ok_and(|old| old == bytes) {
        return Ok(());
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    fs::create_dir_all(folder).map_err(|cause| {
        let message = format!("cannot be made a directory: {}", reason(&cause));
        Error::new(folder.display().to_string(), message)
    })?;
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.partial", std::process::id()));
    let partial = folder.join(name);
    let written = fs::write(&partial, bytes).and_then(|()| {
        // Whoever might read or run the old file may still.
        if let Ok(old) = fs::metadata(path) {
            fs::set_permissions(&partial, old.permissions())?;
        }
        fs::rename(&partial, path)
    });
    written.map_err(|cause| {
        let _ = fs::remove_file(&partial);
        failed(cause)
    })
}
