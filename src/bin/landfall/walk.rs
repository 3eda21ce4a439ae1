//! Walks a directory without the files that `.gitignore` and `.ignore` name.
//!
//! An ignore file that is a pipe or a device ends the walk, as reading it may never end.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use ignore::{DirEntry, Walk, WalkBuilder};
use landfall_layout::{Error, other_language, source};

/// The ignore files that a walk reads in each directory.
const IGNORE_FILES: [&str; 3] = [".ignore", ".gitignore", ".git/info/exclude"];

/// The entries of a directory, sorted by name.
pub struct FilteredWalk {
    root: PathBuf,
    walk: Option<Walk>,
    /// An ignore file ahead that may have no end.
    endless: Option<PathBuf>,
}

impl FilteredWalk {
    pub fn new(root: &Path) -> FilteredWalk {
        let absolute = fs::canonicalize(root).unwrap_or_else(|_| root.to_path_buf());
        let endless = absolute.ancestors().find_map(endless);
        let mut walk = WalkBuilder::new(root);
        // Of paths in one directory, only the names differ; bytes are compared fastest.
        walk.sort_by_file_path(|a, b| a.as_os_str().cmp(b.as_os_str()));
        FilteredWalk { root: root.to_path_buf(), walk: Some(walk.build()), endless }
    }
}

impl Iterator for FilteredWalk {
    type Item = Result<DirEntry, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        let walk = self.walk.as_mut()?;
        if let Some(file) = self.endless.take() {
            self.walk = None;
            let error = Error::new(file.display().to_string(), "is not a regular file");
            return Some(Err(error.with_help("write the ignore file as text, or remove it")));
        }
        let entry = walk.next()?;
        // The walk reads the ignore files of a subdirectory before it returns the subdirectory.
        let is_folder = |entry: &&DirEntry| entry.file_type().is_some_and(|kind| kind.is_dir());
        if let Some(folder) = entry.as_ref().ok().filter(is_folder) {
            self.endless = below(folder.path());
        }
        Some(entry.map_err(|cause| {
            let root = self.root.display().to_string();
            Error::new(root, format!("cannot be searched: {cause}"))
        }))
    }
}

/// The shaders that a walk has found, so that a later search of one of its directories need not read
/// the directories again.
#[derive(Default)]
pub struct Listing {
    /// The index of the first file in each directory or below it.
    folders: HashMap<PathBuf, usize>,
    files: Vec<PathBuf>,
}

impl Listing {
    /// Adds an entry of a walk.
    pub fn add(&mut self, entry: &DirEntry) {
        let path = without_dot(entry.path());
        if entry.file_type().is_some_and(|kind| kind.is_dir()) {
            self.folders.insert(path.to_path_buf(), self.files.len());
        } else if source::kind_of_path(path).is_some() || other_language::of_path(path).is_some() {
            self.files.push(path.to_path_buf());
        }
    }

    /// The files below a directory in the order of its own walk, if a walk has passed through it.
    pub fn below(&self, folder: &Path) -> Option<Vec<PathBuf>> {
        let folder = without_dot(folder);
        let first = *self.folders.get(folder)?;
        let is_below = |file: &&PathBuf| folder == Path::new(".") || file.starts_with(folder);
        Some(self.files[first..].iter().take_while(is_below).cloned().collect())
    }
}

/// A path without `./` at its start.
pub fn without_dot(path: &Path) -> &Path {
    match path.strip_prefix(".") {
        Ok(rest) if !rest.as_os_str().is_empty() => rest,
        Ok(_) | Err(_) => path,
    }
}

/// An ignore file that may have no end, in a subdirectory.
fn below(folder: &Path) -> Option<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut folders = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    folders.find_map(|entry| endless(&entry.path()))
}

/// An ignore file of a directory that may have no end.
fn endless(folder: &Path) -> Option<PathBuf> {
    let is_endless =
        |file: &PathBuf| fs::metadata(file).is_ok_and(|found| !found.is_file() && !found.is_dir());
    IGNORE_FILES.iter().map(|name| folder.join(name)).find(is_endless)
}
