//! Finds the locks in a directory.

use std::path::{Path, PathBuf};

use landfall_layout::lock;
use landfall_layout::source::kind_of_path;
use walkdir::DirEntry;

use crate::{files, walk};

/// Whether a file with the name of a lock contains one, possibly truncated.
pub fn holds_lock(path: &Path) -> bool {
    files::file(path).is_some_and(|bytes| lock::is_lock(&String::from_utf8_lossy(&bytes)))
}

/// The files of a directory and those below it, sorted; none if it is no directory.
pub fn files_below(dir: &Path) -> impl Iterator<Item = DirEntry> {
    let entries = dir.is_dir().then(|| walk::sorted(dir)).into_iter().flatten();
    entries.filter_map(Result::ok).filter(|entry| !entry.file_type().is_dir())
}

/// Files of a directory with the names of locks, sorted.
pub fn locks_below(dir: &Path) -> Vec<PathBuf> {
    // Links are left out, and pipes, which would block.
    let files = files_below(dir).filter(|entry| entry.file_type().is_file());
    let is_lock = |path: &PathBuf| {
        path.extension().is_some_and(|e| e == "json")
            && kind_of_path(&path.with_extension("")).is_some()
    };
    files.map(DirEntry::into_path).filter(is_lock).collect()
}
