//! Finds the configuration file: in the directory of the checked paths or the nearest above.

use std::path::{Path, PathBuf};

use landfall_layout::Error;

use super::root::{absolute, current, way};
use crate::read::is_stdin;

const NAMES: [&str; 2] = ["landfall.toml", ".landfall.toml"];

/// The configuration file for these paths, if any.
///
/// # Errors
///
/// A directory contains both names, or the file cannot be read.
pub fn find(paths: &[PathBuf]) -> Result<Option<PathBuf>, Error> {
    let current = current()?;
    let mut folders =
        paths.iter().filter(|path| !is_stdin(path)).map(|path| folder(&current, path));
    let first = folders.next().unwrap_or_else(|| current.clone());
    let start = folders.fold(first, |common, other| {
        common
            .components()
            .zip(other.components())
            .take_while(|(a, b)| a == b)
            .map(|(a, _)| a)
            .collect()
    });
    for folder in start.ancestors() {
        let held: Vec<&str> = NAMES.into_iter().filter(|name| holds(&folder.join(name))).collect();
        let shown = |name: &str| way(&current, folder).join(name);
        match held.as_slice() {
            [] => {}
            [name] => {
                let shown = shown(name);
                readable(&folder.join(name), &shown)?;
                return Ok(Some(shown));
            }
            _ => {
                let message = format!("conflicts with `{}`: only one may exist", NAMES[1]);
                return Err(Error::new(shown(NAMES[0]).display().to_string(), message)
                    .with_help("remove one, or select one with `--config`"));
            }
        }
    }
    Ok(None)
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
