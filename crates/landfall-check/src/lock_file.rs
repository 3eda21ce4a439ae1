//! The lock of one shader: read, and compared with its layout.

use std::fs;
use std::path::{Path, PathBuf};

use landfall_layout::finding::Finding;
use landfall_layout::lock::{self, Lock};
use landfall_layout::{Error, ShaderLayout, source};

use crate::hash::Hash;

/// The lock of a shader: its path, and its bytes if it exists.
pub struct LockFile {
    pub path: PathBuf,
    pub bytes: Result<Option<Vec<u8>>, Error>,
    /// The layout at the revision that is compared with instead of a lock.
    pub old: Option<ShaderLayout>,
}

impl LockFile {
    pub fn read(path: PathBuf) -> LockFile {
        // Reading a pipe would block.
        let is_other = |found: fs::Metadata| !found.is_file() && !found.is_dir();
        if fs::metadata(&path).is_ok_and(is_other) {
            let bytes = Err(Error::new(path.display().to_string(), "is not a file"));
            return LockFile { path, bytes, old: None };
        }
        let bytes = match fs::read(&path) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(cause) if cause.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(cause) => {
                let message = format!("cannot be read: {}", landfall_layout::file::reason(&cause));
                Err(Error::new(path.display().to_string(), message))
            }
        };
        LockFile { path, bytes, old: None }
    }
}

/// The comparison of a shader with its lock: the hash of the lock, the lock, and the changes.
pub struct LockComparison {
    pub hash: Option<Hash>,
    pub lock: Option<Lock>,
    pub found: Vec<Finding>,
}

/// Compares a shader with its lock. A lock that cannot be read, such as one of a newer landfall,
/// is an error, so that it is not overwritten.
pub fn drift(
    shader: &ShaderLayout,
    path: &Path,
    bytes: Option<Vec<u8>>,
) -> Result<LockComparison, Error> {
    let shown = crate::walk::slashes(path);
    let Some(bytes) = bytes else {
        let found = landfall_lint::drift::drift(shader, &shown, None);
        return Ok(LockComparison { hash: None, lock: None, found });
    };
    let hash = Hash::from_bytes(&bytes);
    let text = source::decode(&shown, bytes)?;
    // So are most: then there is nothing to read and to compare.
    if text == lock::write(shader) {
        return Ok(LockComparison { hash: Some(hash), lock: None, found: Vec::new() });
    }
    let lock = lock::read(&shown, &text)?;
    let found = landfall_lint::drift::drift(shader, &shown, Some(&lock));
    Ok(LockComparison { hash: Some(hash), lock: Some(lock), found })
}
