//! Finds the shaders of a directory or a glob, as the command does but for ignore files.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use landfall_layout::Error;
use landfall_layout::file::reason;
use landfall_layout::other_language::content;
use landfall_layout::source::is_searched;
use landfall_layout::text::glob::Glob;

/// What a path stands for.
pub enum FoundShaders {
    /// A file, which may not be there.
    File,
    /// The shaders below a directory, sorted, hidden files left out.
    Below {
        /// The directory that was searched.
        directory: PathBuf,
        shaders: BTreeSet<PathBuf>,
    },
}

/// Searches for the shaders that a path stands for.
///
/// # Errors
/// A directory cannot be read or has no shader, a glob is none or matches none.
pub fn search(named: &Path) -> Result<FoundShaders, Error> {
    let shown = || named.display().to_string();
    if named.is_dir() {
        let mut shaders = files(named)?;
        shaders.retain(|path| is_searched(path) && content::holds_shader(path));
        if shaders.is_empty() {
            return Err(Error::new(shown(), "contains no shader file"));
        }
        return Ok(FoundShaders::Below { directory: named.to_path_buf(), shaders });
    }
    let is_glob = |part: &Path| part.to_string_lossy().contains(['*', '?', '[', '{']);
    // The name of a file may contain the signs of a glob.
    if !is_glob(named) || named.exists() {
        return Ok(FoundShaders::File);
    }
    let pattern = slashes(named);
    let refused = |cause| Error::new(shown(), format!("is not a glob: {cause}"));
    let glob = Glob::new(&pattern).map_err(refused)?;
    // The search begins at the directory before the first part with a wildcard.
    let fixed = named.components().take_while(|part| !is_glob(part.as_ref()));
    let directory: PathBuf = fixed.collect();
    let directory = if directory.as_os_str().is_empty() { PathBuf::from(".") } else { directory };
    let mut shaders = files(&directory)?;
    shaders.retain(|path| glob.matches(&slashes(path.strip_prefix("./").unwrap_or(path))));
    if shaders.is_empty() {
        return Err(Error::new(shown(), "matches no shader file"));
    }
    Ok(FoundShaders::Below { directory, shaders })
}

/// The files below a directory. Links to directories are not followed: they may lead back.
fn files(directory: &Path) -> Result<BTreeSet<PathBuf>, Error> {
    let failed = |cause: std::io::Error| {
        let message = format!("cannot be searched: {}", reason(&cause));
        Error::new(directory.display().to_string(), message)
    };
    let mut found = BTreeSet::new();
    for entry in fs::read_dir(directory).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        if entry.file_name().as_encoded_bytes().starts_with(b".") {
            continue;
        }
        let path = entry.path();
        match entry.file_type().map_err(failed)?.is_dir() {
            true => found.extend(files(&path)?),
            false if path.is_file() => drop(found.insert(path)),
            false => {}
        }
    }
    Ok(found)
}

/// A path with `/` between its parts.
fn slashes(path: &Path) -> String {
    path.display().to_string().replace(std::path::MAIN_SEPARATOR, "/")
}
