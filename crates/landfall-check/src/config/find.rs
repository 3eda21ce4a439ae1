//! Finds the configuration file, or the locks of a project without one: in the directory of the
//! checked paths or the nearest above.

use std::path::{Path, PathBuf};

use landfall_layout::Error;

use super::LOCKS;
use super::root::{absolute, current, relative_path, repository};
use crate::files::is_stdin;
use crate::locks::{holds_lock, locks_below};

/// The names of a configuration file.
pub const NAMES: [&str; 2] = ["landfall.toml", ".landfall.toml"];

/// The file or directory that determines the root directory of a project.
pub enum ProjectBase {
    /// A configuration file, from the current directory.
    File(PathBuf),
    /// The directory that contains `layouts`, or the current directory.
    Root(PathBuf),
}

/// Searches upwards from these paths, or from the current directory.
///
/// The search ends at the root of the repository; a configuration precedes locks.
///
/// # Errors
///
/// A directory contains both names of a configuration, or the file cannot be read.
pub fn find(paths: &[PathBuf]) -> Result<ProjectBase, Error> {
    let current = current()?;
    let mut folders =
        paths.iter().filter(|path| !is_stdin(path)).map(|path| folder(&current, path));
    let first = folders.next().unwrap_or_else(|| current.clone());
    // The directory that all of them have in common.
    let start = folders.fold(first, |common, other| {
        common
            .components()
            .zip(other.components())
            .take_while(|(a, b)| a == b)
            .map(|(a, _)| a)
            .collect()
    });
    // A repository inside the project, such as vendored code, does not end the search.
    let inside = if start.starts_with(&current) { &current } else { &start };
    let top = repository(inside);
    let folders: Vec<&Path> =
        start.ancestors().filter(|folder| top.is_none_or(|top| folder.starts_with(top))).collect();
    for folder in &folders {
        if let Some(file) = config(folder, &current)? {
            return Ok(ProjectBase::File(file));
        }
    }
    // The locks of the current directory precede those of a directory below it.
    let here = start.starts_with(&current).then_some(current.as_path());
    let locked = here.into_iter().chain(folders).find(|folder| holds_locks(&folder.join(LOCKS)));
    Ok(ProjectBase::Root(
        locked.map_or_else(PathBuf::new, |folder| relative_path(&current, folder)),
    ))
}

/// The configuration file of a directory, from the current one.
fn config(folder: &Path, current: &Path) -> Result<Option<PathBuf>, Error> {
    let held: Vec<&str> = NAMES.into_iter().filter(|name| holds(&folder.join(name))).collect();
    let shown = |name: &str| relative_path(current, folder).join(name);
    match held.as_slice() {
        [] => Ok(None),
        [name] => {
            let shown = shown(name);
            readable(&folder.join(name), &shown)?;
            Ok(Some(shown))
        }
        _ => {
            let message = format!("conflicts with `{}`: only one may exist", NAMES[1]);
            Err(Error::new(shown(NAMES[0]).display().to_string(), message)
                .with_help("remove one, or select one with `--config`"))
        }
    }
}

/// Whether a directory contains a lock.
fn holds_locks(folder: &Path) -> bool {
    locks_below(folder).iter().any(|path| holds_lock(path))
}

/// Whether anything of this name exists: a broken link or a directory is an error, not a missing file.
fn holds(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}

/// Fails if the configuration exists but cannot be read.
fn readable(path: &Path, shown: &Path) -> Result<(), Error> {
    let refuse = |what: &str| {
        Error::new(shown.display().to_string(), what)
            .with_help("remove it, or ignore it with `--no-config`")
            .unreadable()
    };
    match path.metadata() {
        Ok(found) if found.is_file() => Ok(()),
        Ok(_) => Err(refuse("is the configuration but not a file")),
        Err(_) if path.is_symlink() => Err(refuse("is the configuration but a broken link")),
        Err(_) => Err(refuse("is the configuration but cannot be read")),
    }
}

/// The directory of a file or glob.
fn folder(current: &Path, path: &Path) -> PathBuf {
    let real = absolute(current, path);
    if real.is_dir() {
        return real;
    }
    let is_glob = |part: &std::ffi::OsStr| part.to_string_lossy().contains(['*', '?', '[', '{']);
    let fixed: PathBuf = real.iter().take_while(|part| !is_glob(part)).collect();
    if fixed == real { real.parent().map(Path::to_path_buf).unwrap_or(real) } else { fixed }
}
