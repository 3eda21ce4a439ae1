//! The shaders of this repository.

use std::fs;
use std::path::{Path, PathBuf};

/// All of them, by name.
pub fn shaders() -> Vec<PathBuf> {
    fn walk(dir: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(dir).expect("the tests run in the repository") {
            let path = entry.expect("a readable directory").path();
            if path.is_dir() {
                walk(&path, found);
            } else if ::landfall::source::kind_of_path(&path).is_some() {
                found.push(path);
            }
        }
    }
    let mut found = Vec::new();
    walk(Path::new("shaders"), &mut found);
    found.sort();
    found
}
