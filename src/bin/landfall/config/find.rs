//! Where the configuration is: in the folder of what is checked, or the nearest one above.

use std::path::{Path, PathBuf};

use landfall_layout::Error;

use super::root::{absolute, current, way};
use crate::read::is_stdin;

const NAMES: [&str; 2] = ["landfall.toml", ".landfall.toml"];

/// The configuration for a run about these paths.
///
/// # Errors
/// A folder holds both names.
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
                let message = format!("stands beside `{}`, and only one can hold", NAMES[1]);
                return Err(Error::new(shown(NAMES[0]).display().to_string(), message)
                    .with_help("remove one, or say which with `--config`"));
            }
        }
    }
    Ok(None)
}

/// Whether there is something of that name: a link that leads nowhere is meant to be a
/// configuration, too.
fn holds(path: &Path) -> bool {
    path.symlink_metadata().is_ok_and(|found| !found.is_dir())
}

/// A configuration that cannot be read is not the same as none.
fn readable(path: &Path, shown: &Path) -> Result<(), Error> {
    let refuse = |what: &str| {
        Error::new(shown.display().to_string(), what)
            .with_help("remove it, or run without a configuration with `--no-config`")
    };
    match path.metadata() {
        Ok(found) if found.is_file() => Ok(()),
        Ok(_) => Err(refuse("is the configuration, and is no file")),
        Err(_) if path.is_symlink() => {
            Err(refuse("is the configuration, and a link that leads nowhere"))
        }
        Err(_) => Err(refuse("is the configuration, and cannot be read")),
    }
}

/// The folder that a file or glob is in.
fn folder(current: &Path, path: &Path) -> PathBuf {
    let real = absolute(current, path);
    if real.is_dir() {
        return real;
    }
    let is_glob = |part: &std::ffi::OsStr| part.to_string_lossy().contains(['*', '?', '[', '{']);
    let fixed: PathBuf = real.iter().take_while(|part| !is_glob(part)).collect();
    if fixed == real { real.parent().map(Path::to_path_buf).unwrap_or(real) } else { fixed }
}
