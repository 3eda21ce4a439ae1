//! Walks a directory without the files that `.gitignore` and `.ignore` name.
//!
//! An ignore file that is a pipe or a device ends the walk, as reading it may never end.

mod ignore_files;

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};

use landfall_layout::file::reason;
use landfall_layout::{Error, other_language, source};
use walkdir::{DirEntry, WalkDir};

use self::ignore_files::IgnoreFiles;

/// The entries of a directory, sorted by name, without hidden and ignored ones.
pub struct FilteredWalk {
    root: PathBuf,
    walk: Option<walkdir::IntoIter>,
    ignore_files: Result<IgnoreFiles, PathBuf>,
}

impl FilteredWalk {
    pub fn new(root: &Path) -> FilteredWalk {
        FilteredWalk {
            root: root.to_path_buf(),
            walk: Some(sorted(root).into_iter()),
            ignore_files: IgnoreFiles::above(root),
        }
    }
}

impl Iterator for FilteredWalk {
    type Item = Result<DirEntry, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let walk = self.walk.as_mut()?;
            let files = match &mut self.ignore_files {
                Ok(files) => files,
                Err(endless) => {
                    self.walk = None;
                    let path = endless.display().to_string();
                    let error = Error::new(path, "is not a regular file");
                    return Some(Err(
                        error.with_help("write the ignore file as text, or remove it")
                    ));
                }
            };
            let entry = match walk.next()? {
                Ok(entry) => entry,
                Err(cause) => return Some(Err(unsearchable(&self.root, &cause))),
            };
            // A walk is depth first, so that the depth of an entry tells which directories were
            // left.
            files.leave(entry.depth());
            let is_root = entry.depth() == 0;
            let is_folder = is_root || entry.file_type().is_dir();
            let has_rules = files.has_rules();
            let relative =
                if is_folder || has_rules { below(&self.root, &entry) } else { String::new() };
            let ignored = if has_rules { files.ignored(&relative, is_folder) } else { None };
            // No rule brings the repository's own files back.
            let is_git = || entry.file_name() == ".git";
            if !is_root && (ignored.unwrap_or_else(|| is_hidden(&entry)) || is_git()) {
                if is_folder {
                    walk.skip_current_dir();
                }
                continue;
            }
            if is_folder {
                if let Err(endless) = files.enter(entry.path(), &relative) {
                    self.ignore_files = Err(endless);
                }
            }
            return Some(Ok(entry));
        }
    }
}

/// The entries of a directory, sorted by name.
pub fn sorted(root: &Path) -> WalkDir {
    WalkDir::new(root).sort_by_file_name()
}

/// The path of an entry from the root of a walk, with `/` between its parts.
fn below(root: &Path, entry: &DirEntry) -> String {
    slashes(entry.path().strip_prefix(root).unwrap_or(Path::new("")))
}

/// Whether an entry below the root has a hidden name.
pub fn is_hidden(entry: &DirEntry) -> bool {
    entry.depth() > 0 && entry.file_name().as_encoded_bytes().starts_with(b".")
}

/// The error of a directory that cannot be read.
pub fn unsearchable(root: &Path, cause: &walkdir::Error) -> Error {
    let path = cause.path().unwrap_or(root).display().to_string();
    let why = cause.io_error().map_or_else(|| cause.to_string(), reason);
    Error::new(path, format!("cannot be searched: {why}"))
}

/// A path from a directory, without `.` and without the folders that its `..` leave again.
pub fn joined(from: &Path, path: &Path) -> PathBuf {
    let mut joined = from.to_path_buf();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir
                if matches!(joined.components().next_back(), Some(Component::Normal(_))) =>
            {
                joined.pop();
            }
            part => joined.push(part),
        }
    }
    joined
}

/// A path with `/` between its parts.
pub fn slashes(path: &Path) -> String {
    // Paths are UTF-8 almost always.
    let text = path.to_str().map_or_else(|| path.display().to_string(), str::to_string);
    if std::path::MAIN_SEPARATOR == '/' {
        text
    } else {
        text.replace(std::path::MAIN_SEPARATOR, "/")
    }
}

/// Whether a path is below a directory, both from one root, whose own path is empty.
pub fn is_below(path: &str, folder: &str) -> bool {
    folder.is_empty() || path.strip_prefix(folder).is_some_and(|rest| rest.starts_with('/'))
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
        if entry.file_type().is_dir() {
            self.folders.insert(path.to_path_buf(), self.files.len());
        } else if source::is_searched(path) || other_language::of_path(path).is_some() {
            self.files.push(path.to_path_buf());
        }
    }

    /// The files below a directory in the order of its own walk, if a walk has passed through it.
    pub fn below(&self, folder: &Path) -> Option<Vec<PathBuf>> {
        let folder = without_dot(folder);
        let first = *self.folders.get(folder)?;
        let is_below = |file: &&PathBuf| folder == Path::new(".") || file.starts_with(folder);
        // A walk is depth first, so that the files below a directory are in a row.
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

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_tree_without_rules_is_walked_in_order() {
        let root = std::env::temp_dir().join(format!("landfall-walk-{}", std::process::id()));
        for file in ["b/c/d.frag", "b/.git.frag", ".hidden/e.frag", "b/c.frag", "a.frag"] {
            fs::create_dir_all(root.join(file).parent().expect("below the root")).expect("created");
            fs::write(root.join(file), "").expect("written");
        }
        let entries = FilteredWalk::new(&root).map(|entry| below(&root, &entry.expect("readable")));
        assert_eq!(
            entries.collect::<Vec<_>>(),
            ["", "a.frag", "b", "b/c", "b/c/d.frag", "b/c.frag"]
        );
        fs::remove_dir_all(root).expect("removed");
    }
}
