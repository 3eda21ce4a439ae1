//! The shaders of this repository.

use std::fs;
use std::path::{Path, PathBuf};

/// All of them, by name.
pub fn shaders() -> Vec<PathBuf> {
    below(["shaders"], |path| ::landfall::source::kind_of_path(path).is_some())
}

/// The files below some folders that a test wants, by name.
pub fn below(
    folders: impl IntoIterator<Item = impl Into<PathBuf>>,
    is_wanted: impl Fn(&Path) -> bool,
) -> Vec<PathBuf> {
    let mut folders: Vec<PathBuf> = folders.into_iter().map(Into::into).collect();
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("the tests run in the repository") {
            let path = entry.expect("a readable directory").path();
            if path.is_dir() {
                folders.push(path);
            } else if is_wanted(&path) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}
