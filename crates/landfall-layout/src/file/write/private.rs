//! Files that only their user can read.

use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

use super::{folder_of, partial_name, partials, sweep};

/// Creates a file that only the user can read, with its directory. Of two processes that create it,
/// the first wins; it is never there in part.
///
/// # Errors
/// [`io::ErrorKind::AlreadyExists`] if there is such a file; or it cannot be written.
pub fn create_private(path: &Path, bytes: &[u8]) -> Result<(), io::Error> {
    let folder = folder_of(path);
    fs::create_dir_all(folder)?;
    sweep(folder);
    let partial = folder.join(partial_name());
    partials().insert(partial.clone());
    let created = private(&partial).and_then(|mut file| file.write_all(bytes));
    let linked = created.and_then(|()| match fs::hard_link(&partial, path) {
        // Some file systems have no hard links.
        Err(cause) if cause.kind() != io::ErrorKind::AlreadyExists => fs::rename(&partial, path),
        linked => linked,
    });
    let _ = fs::remove_file(&partial);
    partials().remove(&partial);
    linked
}

#[cfg(unix)]
fn private(path: &Path) -> Result<fs::File, io::Error> {
    use std::os::unix::fs::OpenOptionsExt;
    OpenOptions::new().write(true).create_new(true).mode(0o600).open(path)
}

/// Windows closes the files of `LOCALAPPDATA` to other users.
#[cfg(not(unix))]
fn private(path: &Path) -> Result<fs::File, io::Error> {
    OpenOptions::new().write(true).create_new(true).open(path)
}
