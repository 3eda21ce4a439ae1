//! Finds the locks in a directory.

use std::path::{Path, PathBuf};

use landfall_layout::lock;
use landfall_layout::source::kind_of_path;

use crate::{files, walk};

/// Whether a file with the name of a lock contains one, possibly truncated.
pub fn holds_lock(path: &Path) -> bool {
    files::file(path).is_some_and(|bytes| lock::is_lock(&String::from_utf8_lossy(&bytes)))
}

/// Files of a directory with the names of locks, sorted.
pub fn locks_below(dir: &Path) -> Vec<PathBuf> {
    if !dir.is_dir() {
        return Vec::new();
    }
    let files = walk::sorted(dir).into_iter().filter_map(Result::ok);
    let files = files.filter(|entry| entry.file_type().is_file());
    let is_lock = |path: &PathBuf| {
        path.extension().is_some_and(|e| e == "json")
            && kind_of_path(&path.with_extension("")).is_some()
    };
    files.map(walkdir::DirEntry::into_path).filter(is_lock).collect()
}
