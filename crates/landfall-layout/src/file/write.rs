//! The one writer of files: whole or not at all, and never over what the user cannot get back.
//!
//! A file is written beside its place under a name of its own and then renamed, so that whoever
//! looks finds the old text or the new one. What a process that was killed left behind is removed
//! by the next one that writes into the same folder.

use std::collections::HashSet;
use std::ffi::OsStr;
use std::fs::{self, Metadata, OpenOptions};
use std::hash::{BuildHasher, RandomState};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::time::Duration;

use super::reason;
use crate::error::Error;

/// Names of files that are being written: `.landfall-PID-TOKEN-N.partial`.
const PARTIAL_START: &str = ".landfall-";
const PARTIAL_END: &str = ".partial";

/// How often a file is written again whose partial file somebody else removed.
const ATTEMPTS: u32 = 3;

/// Where nobody can say whether a process lives, its partial files are left alone for this long.
const ABANDONED: Duration = Duration::from_secs(3600);

/// Links that are followed one after the other, as Linux does.
const MOST_LINKS: u32 = 40;

/// What became of a file that was to be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Written {
    /// It held those bytes already.
    Unchanged,
    /// It was made or replaced.
    Changed,
}

/// Writes files, none of them over an input, and none through a symbolic link out of its tree.
#[derive(Clone, Debug, Default)]
pub struct FileWriter {
    /// Inputs without links.
    paths: HashSet<PathBuf>,
    /// Their devices and numbers on those.
    nodes: HashSet<(u64, u64)>,
    tree: Option<PathBuf>,
}

/// What says that two paths are one file.
struct Identity {
    /// Without links.
    path: PathBuf,
    /// Device and number on the device: the same for all hard links.
    node: Option<(u64, u64)>,
}

impl Identity {
    /// The identity of a regular file.
    fn of(path: &Path) -> Option<Identity> {
        let found = fs::metadata(path).ok().filter(Metadata::is_file)?;
        Some(Identity { path: fs::canonicalize(path).ok()?, node: node(&found) })
    }
}

#[cfg(unix)]
fn node(found: &Metadata) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    Some((found.dev(), found.ino()))
}

#[cfg(not(unix))]
fn node(_: &Metadata) -> Option<(u64, u64)> {
    None
}

impl FileWriter {
    /// A writer that leaves these files alone.
    pub fn new(inputs: impl IntoIterator<Item = impl AsRef<Path>>) -> FileWriter {
        let mut writer = FileWriter::default();
        writer.protect(inputs);
        writer
    }

    /// Leaves these files alone, too.
    pub fn protect(&mut self, inputs: impl IntoIterator<Item = impl AsRef<Path>>) {
        for found in inputs.into_iter().filter_map(|path| Identity::of(path.as_ref())) {
            self.paths.insert(found.path);
            self.nodes.extend(found.node);
        }
    }

    /// The same writer for files below a folder: whatever links stand on the way, nothing is
    /// written or removed outside of it.
    pub fn inside(self, tree: &Path) -> FileWriter {
        FileWriter { tree: Some(real(tree)), ..self }
    }

    /// Writes a file whole or not at all, and not when it already holds those bytes.
    ///
    /// Behind a symbolic link the file it leads to is replaced; a pipe or device is written to.
    ///
    /// # Errors
    /// The file is an input, is read-only, or lies behind a symbolic link out of the tree; the
    /// directory cannot be made or the file cannot be written. What was there before still is.
    pub fn write(&self, path: &Path, bytes: impl AsRef<[u8]>) -> Result<Written, Error> {
        let bytes = bytes.as_ref();
        let failed = |cause: io::Error| {
            let message = format!("cannot be written: {}", reason(&cause));
            Error::new(path.display().to_string(), message)
        };
        let there = fs::metadata(path).ok();
        let is_device = there.as_ref().is_some_and(|found| !found.is_file() && !found.is_dir());
        if is_device && self.tree.is_some() {
            return Err(Error::new(path.display().to_string(), "is no file, and is left alone")
                .with_help("remove it, or keep the files of landfall elsewhere"));
        }
        if is_device || is_stream(path) {
            let mut file = OpenOptions::new().write(true).open(path).map_err(failed)?;
            return file.write_all(bytes).map(|()| Written::Changed).map_err(failed);
        }
        self.allows(path)?;
        let real = if path.is_symlink() { fs::canonicalize(path).ok() } else { None };
        let target = real.as_deref().unwrap_or(path);
        let folder = folder_of(target);
        sweep(folder);
        if fs::read(target).is_ok_and(|old| old == bytes) {
            return Ok(Written::Unchanged);
        }
        if there.as_ref().is_some_and(|found| found.is_file() && found.permissions().readonly()) {
            return Err(Error::new(
                path.display().to_string(),
                "cannot be written: it is read-only",
            )
            .with_help("make it writable, or name another file"));
        }
        fs::create_dir_all(folder).map_err(|cause| {
            let message = format!("cannot be made a directory: {}", reason(&cause));
            Error::new(folder.display().to_string(), message)
        })?;
        replace(target, folder, bytes, there).map(|()| Written::Changed).map_err(failed)
    }

    /// Removes a file, but neither an input nor one outside of the tree.
    ///
    /// # Errors
    /// It is one of those, or cannot be removed.
    pub fn remove(&self, path: &Path) -> Result<(), Error> {
        self.allows(path)?;
        fs::remove_file(path).map_err(|cause| {
            let message = format!("cannot be removed: {}", reason(&cause));
            Error::new(path.display().to_string(), message)
        })
    }

    /// Whether a file may be written.
    ///
    /// # Errors
    /// It is an input, or lies behind a symbolic link out of the tree.
    pub fn allows(&self, path: &Path) -> Result<(), Error> {
        let shown = || path.display().to_string();
        let is_input = |found: Identity| {
            self.paths.contains(&found.path) || found.node.is_some_and(|n| self.nodes.contains(&n))
        };
        if Identity::of(path).is_some_and(is_input) {
            return Err(Error::new(shown(), "is an input of this command, which would be lost")
                .with_help("name another file for the output"));
        }
        let target = real(path);
        let trees = match &self.tree {
            Some(tree) => vec![tree.clone()],
            // Who names a file may well name one behind links of folders.
            None if !path.is_symlink() => return Ok(()),
            None => vec![real(folder_of(path)), real(Path::new("."))],
        };
        if trees.iter().any(|tree| target.starts_with(tree)) {
            return Ok(());
        }
        let tree = trees.first().map(|tree| tree.display().to_string()).unwrap_or_default();
        let message =
            format!("leads through a symbolic link to `{}`, out of `{tree}`", target.display());
        Err(Error::new(shown(), message).with_help("remove the link, or name where it leads to"))
    }
}

/// Writes a file whole or not at all, and not when it already holds those bytes.
///
/// # Errors
/// Those of [`FileWriter::write`] without inputs.
pub fn write_whole(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), Error> {
    FileWriter::default().write(path, bytes).map(|_| ())
}

/// A name for a stream that is open already: `/dev/stdout` may lead to a file that is being
/// written.
fn is_stream(path: &Path) -> bool {
    cfg!(unix) && (path.starts_with("/dev") || path.starts_with("/proc"))
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// A path without links, as far as it exists: what would be made below has none.
fn real(path: &Path) -> PathBuf {
    let mut path = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        if let Ok(real) = fs::canonicalize(&path) {
            return real;
        }
        // A link that leads nowhere is where it leads to.
        let Ok(link) = fs::read_link(&path) else { break };
        path = folder_of(&path).join(link);
    }
    match (path.parent(), path.components().next_back()) {
        (Some(_), Some(last @ Component::Normal(_))) => real(folder_of(&path)).join(last),
        _ => path,
    }
}

/// Writes beside the target, then renames.
fn replace(
    target: &Path,
    folder: &Path,
    bytes: &[u8],
    old: Option<Metadata>,
) -> Result<(), io::Error> {
    let mut attempt = 1;
    loop {
        let partial = folder.join(partial_name());
        let written = fill(&partial, bytes).and_then(|()| {
            // Whoever might read or run the old file may still.
            if let Some(old) = &old {
                fs::set_permissions(&partial, old.permissions())?;
            }
            fs::rename(&partial, target)
        });
        match written {
            Ok(()) => return Ok(()),
            // Somebody who does not see this process took it for one that is gone.
            Err(cause) if cause.kind() == io::ErrorKind::NotFound && attempt < ATTEMPTS => {
                attempt += 1;
            }
            Err(cause) => {
                let _ = fs::remove_file(&partial);
                return Err(cause);
            }
        }
    }
}

/// Makes a file that is not there yet, so that no link stands in its place.
fn fill(path: &Path, bytes: &[u8]) -> Result<(), io::Error> {
    OpenOptions::new().write(true).create_new(true).open(path)?.write_all(bytes)
}

/// A number of this process that a later one with its identifier does not have.
static TOKEN: LazyLock<u32> =
    LazyLock::new(|| RandomState::new().hash_one(std::process::id()) as u32);

fn partial_name() -> String {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    format!("{PARTIAL_START}{}-{:08x}-{number}{PARTIAL_END}", std::process::id(), *TOKEN)
}

/// Removes what processes that were killed left in a folder; once a folder and process.
fn sweep(folder: &Path) {
    static SWEPT: Mutex<Option<HashSet<PathBuf>>> = Mutex::new(None);
    let mut swept = SWEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if !swept.get_or_insert_default().insert(folder.to_path_buf()) {
        return;
    }
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if is_abandoned(&entry) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn is_abandoned(entry: &fs::DirEntry) -> bool {
    let Some((process, token)) = owner(&entry.file_name()) else { return false };
    if process == std::process::id() {
        return token != *TOKEN;
    }
    if Path::new("/proc/self").exists() {
        return !Path::new("/proc").join(process.to_string()).exists();
    }
    let modified = entry.metadata().and_then(|found| found.modified());
    modified.is_ok_and(|when| when.elapsed().is_ok_and(|age| age > ABANDONED))
}

/// The process that writes a partial file, and its token.
fn owner(name: &OsStr) -> Option<(u32, u32)> {
    let parts = name.to_str()?.strip_prefix(PARTIAL_START)?.strip_suffix(PARTIAL_END)?;
    let mut parts = parts.split('-');
    let process = parts.next()?.parse().ok()?;
    let token = u32::from_str_radix(parts.next()?, 16).ok()?;
    parts.next()?.parse::<u32>().ok()?;
    parts.next().is_none().then_some((process, token))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn partial_files_name_their_process() {
        let token = *TOKEN;
        assert_eq!(owner(OsStr::new(&partial_name())), Some((std::process::id(), token)));
        for other in [".landfall-1-x-0.partial", "landfall-1-00-0.partial", ".landfall-.partial"] {
            assert_eq!(owner(OsStr::new(other)), None, "{other}");
        }
    }

    #[test]
    fn a_path_that_is_not_there_is_real_as_far_as_it_is() {
        let here = fs::canonicalize(".").expect("a current folder");
        assert_eq!(real(Path::new("no/such/file")), here.join("no/such/file"));
        assert_eq!(real(Path::new("src/../no.txt")), here.join("no.txt"));
    }
}
