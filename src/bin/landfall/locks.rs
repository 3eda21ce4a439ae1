//! Finds the locks in a directory.

use std::path::{Path, PathBuf};

use landfall_layout::lock;
use landfall_layout::source::kind_of_path;

use crate::read;

/// Whether a file with the name of a lock contains one, possibly truncated.
pub fn holds_lock(path: &Path) -> bool {
    read::file(path).is_some_and(|bytes| lock::is_lock(&String::from_utf8_lossy(&bytes)))
}

/// Files of a directory with the names of locks, sorted.
pub fn locks_below(dir: &Path) -> Vec<PathBuf> {
    if !dir.is_dir() {
        return Vec::new();
    }
    let walk = ignore::WalkBuilder::new(dir)
        .standard_filters(false)
        .sort_by_file_name(|a, b| a.cmp(b))
        .build();
    let files = walk.filter_map(Result::ok);
    let files = files.filter(|entry| entry.file_type().is_some_and(|kind| kind.is_file()));
    let is_lock = |path: &PathBuf| {
        path.extension().is_some_and(|e| e == "json")
            && kind_of_path(&path.with_extension("")).is_some()
    };
    files.map(ignore::DirEntry::into_path).filter(is_lock).collect()
}
