//! Atomic file writes that never overwrite an input.
//!
//! A file is written under a temporary name in the same directory and then renamed, so that others
//! see either the old text or the new one. If it replaces a file, its bytes are flushed to the disk
//! first, so that this also holds after a system crash. Temporary files of a killed process are
//! removed by the next process that writes to the directory.

use std::collections::{BTreeSet, HashSet};
use std::ffi::OsStr;
use std::fs::{self, Metadata, OpenOptions};
use std::hash::{BuildHasher, RandomState};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::reason;
use crate::error::Error;

mod special;
mod unchanged;

use special::{is_character_device, is_pipe, is_stream, reader_of};
use unchanged::holds;

/// The start of temporary file names: `.landfall-PID-TOKEN-N.partial`.
const PARTIAL_START: &str = ".landfall-";
const PARTIAL_END: &str = ".partial";

/// Files that decide what commands read.
const CONTROL_FILES: [&str; 4] = [".gitignore", ".ignore", "landfall.toml", ".landfall.toml"];

/// The number of retries when another process removes the partial file.
const ATTEMPTS: u32 = 3;

/// The age after which partial files are removed if their process cannot be checked.
const ABANDONED: Duration = Duration::from_secs(3600);

/// The most symbolic links followed in a row, as on Linux.
const MAX_LINKS: u32 = 40;

/// The result of writing a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Written {
    /// The file already held these bytes.
    Unchanged,
    /// The file was created or replaced.
    Changed,
}

/// Writes files, but never over an input, and never through a symbolic link out of its tree.
#[derive(Clone, Debug, Default)]
pub struct FileWriter {
    /// The paths of inputs that are links, or without a number; links resolved.
    paths: HashSet<PathBuf>,
    /// The other inputs, as they were named.
    named: Vec<PathBuf>,
    /// The device and inode numbers of all inputs.
    nodes: HashSet<(u64, u64)>,
    tree: Option<PathBuf>,
}

/// The identity of a file behind its paths.
struct Identity {
    /// The path, links resolved.
    path: PathBuf,
    /// The device and inode number, the same for all hard links.
    node: Option<(u64, u64)>,
}

impl Identity {
    /// The identity of a regular file, if it exists.
    fn from_path(path: &Path) -> Option<Identity> {
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
    /// Creates a writer that protects `inputs`.
    pub fn new(inputs: impl IntoIterator<Item = impl AsRef<Path>>) -> FileWriter {
        let mut writer = FileWriter::default();
        writer.protect(inputs);
        writer
    }

    /// Protects more files.
    pub fn protect(&mut self, inputs: impl IntoIterator<Item = impl AsRef<Path>>) {
        for path in inputs {
            let path = path.as_ref();
            // Most inputs are files without links: device and inode tell them apart without
            // resolving paths.
            let found = fs::symlink_metadata(path).ok().filter(Metadata::is_file);
            if let Some(node) = found.as_ref().and_then(node) {
                self.protect_node(path, node);
            } else if let Some(found) = Identity::from_path(path) {
                self.paths.insert(found.path);
                self.nodes.extend(found.node);
            }
        }
    }

    /// Protects a regular file that is no link and has these device and inode numbers.
    pub fn protect_node(&mut self, path: impl Into<PathBuf>, node: (u64, u64)) {
        self.nodes.insert(node);
        self.named.push(path.into());
    }

    /// Whether an input that is no link has this path, links resolved. Only paths that end alike
    /// are resolved: an input may be one of thousands.
    fn is_named(&self, real: &Path) -> bool {
        let end = |path: &Path| path.file_name().map(OsStr::to_ascii_lowercase);
        let (name, mut alike) = (end(real), self.named.iter());
        alike.any(|path| end(path) == name && fs::canonicalize(path).is_ok_and(|path| path == real))
    }

    /// Restricts the writer to files below `tree`: nothing is written or removed outside it, even
    /// through links.
    pub fn inside(self, tree: &Path) -> FileWriter {
        FileWriter { tree: Some(real(tree)), ..self }
    }

    /// Writes a file atomically, unless it already holds these bytes.
    ///
    /// The target of a symbolic link is replaced; a pipe or device is written to.
    ///
    /// # Errors
    /// The file is an input, is read-only, or lies behind a symbolic link out of the tree; the
    /// directory cannot be created or the file cannot be written. The old file is kept.
    pub fn write(&self, path: &Path, bytes: impl AsRef<[u8]>) -> Result<Written, Error> {
        let bytes = bytes.as_ref();
        let failed = |cause| failed(path, "be written", &cause);
        // A run may write thousands of files that are new: nothing is asked twice about them.
        let named = fs::symlink_metadata(path).ok();
        let there = match &named {
            Some(link) if link.is_symlink() => fs::metadata(path).ok(),
            Some(_) | None => named.clone(),
        };
        let is_device = there.as_ref().is_some_and(|found| !found.is_file() && !found.is_dir());
        // Within a tree only files are written: a device in it may be anything.
        if is_device && self.tree.is_some() {
            return Err(refused(path, "is not a regular file")
                .with_help("remove it, or choose another directory"));
        }
        if is_device || is_stream(path) {
            self.refuse_input(path)?;
            // Kept open until the file is: a reader ends when its last writer does.
            let _reader = match there.as_ref().is_some_and(is_pipe) && !is_stream(path) {
                true => reader_of(path)?,
                false => None,
            };
            let mut file = OpenOptions::new().write(true).open(path).map_err(failed)?;
            return file.write_all(bytes).map(|()| Written::Changed).map_err(failed);
        }
        self.allows_named(path, named.as_ref())?;
        let is_link = named.as_ref().is_some_and(Metadata::is_symlink);
        let real = if is_link { fs::canonicalize(path).ok() } else { None };
        // The target of a link is replaced, not the link.
        let target = real.as_deref().unwrap_or(path);
        let folder = folder_of(target);
        sweep(folder);
        let is_as_long = there.as_ref().is_some_and(|found| found.len() == bytes.len() as u64);
        if is_as_long && holds(target, bytes).unwrap_or(false) {
            return Ok(Written::Unchanged);
        }
        if there.as_ref().is_some_and(|found| found.is_file() && found.permissions().readonly()) {
            return Err(refused(path, "cannot be written: it is read-only")
                .with_help("make it writable, or name another file"));
        }
        create_folder(folder)
            .map_err(|cause| self::failed(folder, "be created as a directory", &cause))?;
        replace(target, folder, bytes, there).map(|()| Written::Changed).map_err(failed)
    }

    /// Appends to a file, which is created if it does not exist. If the bytes cannot be written as a
    /// whole, the file keeps its old length.
    ///
    /// # Errors
    /// The file is an input, a pipe or a socket, lies behind a symbolic link out of the tree, or
    /// cannot be written.
    pub fn append(&self, path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), Error> {
        self.allows(path)?;
        if fs::metadata(path).is_ok_and(|found| !found.is_file() && !is_character_device(&found)) {
            return Err(refused(path, "is not a regular file"));
        }
        let add = |file: &mut fs::File| {
            let old = file.metadata()?.len();
            file.write_all(bytes.as_ref()).inspect_err(|_| {
                let _ = file.set_len(old);
            })
        };
        let file = OpenOptions::new().create(true).append(true).open(path);
        file.and_then(|mut file| add(&mut file)).map_err(|cause| failed(path, "be written", &cause))
    }

    /// Removes a file.
    ///
    /// # Errors
    /// The file is an input, lies outside the tree, or cannot be removed.
    pub fn remove(&self, path: &Path) -> Result<(), Error> {
        self.allows(path)?;
        fs::remove_file(path).map_err(|cause| failed(path, "be removed", &cause))
    }

    /// Checks whether a file may be written.
    ///
    /// # Errors
    /// The file is an input, or lies behind a symbolic link out of the tree.
    pub fn allows(&self, path: &Path) -> Result<(), Error> {
        self.allows_named(path, fs::symlink_metadata(path).ok().as_ref())
    }

    /// The same for a path whose own metadata is known, if it exists.
    fn allows_named(&self, path: &Path, named: Option<&Metadata>) -> Result<(), Error> {
        if named.is_some() {
            self.refuse_input(path)?;
        }
        let trees = match &self.tree {
            Some(tree) => vec![tree.clone()],
            // Links of directories are fine in a path that the user names.
            None if !named.is_some_and(Metadata::is_symlink) => return Ok(()),
            // A link may lead to another file of its directory or below the current one.
            None => vec![real(folder_of(path)), real(Path::new("."))],
        };
        let target = real(path);
        if trees.iter().any(|tree| target.starts_with(tree)) {
            return Ok(());
        }
        let tree = trees.first().map(|tree| tree.display().to_string()).unwrap_or_default();
        let message =
            format!("leads through a symbolic link to `{}`, out of `{tree}`", target.display());
        Err(refused(path, message).with_help("remove the link, or name its target"))
    }

    /// Fails if a file is an input.
    fn refuse_input(&self, path: &Path) -> Result<(), Error> {
        let is_input = |found: &Identity| {
            found.node.is_some_and(|node| self.nodes.contains(&node))
                || self.paths.contains(&found.path)
                || self.is_named(&found.path)
        };
        // An output that changes what the next run reads is no output.
        let controls = |path: &Path| CONTROL_FILES.iter().any(|name| path.ends_with(name));
        match Identity::from_path(path) {
            Some(found) if controls(path) || controls(&found.path) || is_input(&found) => {}
            Some(_) | None => return Ok(()),
        }
        let message = "is an input of this command, and would be overwritten";
        Err(refused(path, message).with_help("name another file for the output"))
    }
}

fn refused(path: &Path, message: impl Into<String>) -> Error {
    Error::unwritten(path.display().to_string(), message)
}

fn failed(path: &Path, what: &str, cause: &io::Error) -> Error {
    refused(path, format!("cannot {what}: {}", reason(cause)))
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Resolves the links of a path, as far as it exists.
fn real(path: &Path) -> PathBuf {
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        // What does not exist has no links: the rest of the path is resolved above it.
        if fs::symlink_metadata(&path).is_err() {
            break;
        }
        if let Ok(real) = fs::canonicalize(&path) {
            return real;
        }
        // A dangling link resolves to its target.
        let Ok(link) = fs::read_link(&path) else { break };
        path = folder_of(&path).join(link);
    }
    // The last part as it is, below its directory resolved.
    match (path.parent(), path.components().next_back()) {
        (Some(_), Some(last @ Component::Normal(_))) => real(folder_of(&path)).join(last),
        _ => path,
    }
}

/// Creates a directory with those above it. The target of `missing/../a` is not known to be an input
/// until `missing` exists, so such a path is refused, as by the system.
fn create_folder(folder: &Path) -> io::Result<()> {
    let parts: Vec<Component> = folder.components().collect();
    for (at, _) in parts.iter().enumerate().filter(|(_, part)| **part == Component::ParentDir) {
        let before: PathBuf = parts[..at].iter().collect();
        if at > 0 {
            fs::metadata(before)?;
        }
    }
    fs::create_dir_all(folder)
}

/// Writes a temporary file, then renames it to `target`.
fn replace(
    target: &Path,
    folder: &Path,
    bytes: &[u8],
    old: Option<Metadata>,
) -> Result<(), io::Error> {
    let mut attempt = 1;
    loop {
        let partial = folder.join(partial_name());
        // Known to `remove_partial` before it exists.
        partials().insert(partial.clone());
        let written = fill(&partial, bytes, old.is_some()).and_then(|()| {
            // Keep the old file's permissions.
            if let Some(old) = &old {
                fs::set_permissions(&partial, old.permissions())?;
            }
            fs::rename(&partial, target)
        });
        partials().remove(&partial);
        match written {
            Ok(()) => return Ok(()),
            // A process that cannot see this one removed the partial file.
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

/// The partial files that this process is writing.
fn partials() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    static PARTIALS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    PARTIALS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the partial files of this process, and lets it begin no others; to be called at its end.
pub fn remove_partial() {
    let partials = partials();
    for partial in partials.iter() {
        let _ = fs::remove_file(partial);
    }
    // The lock is never released: threads that are still running wait instead of beginning a new
    // file.
    std::mem::forget(partials);
}

/// Creates a new file, failing if anything, such as a link, is in its place.
fn fill(path: &Path, bytes: &[u8], replaces: bool) -> Result<(), io::Error> {
    let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
    file.write_all(bytes)?;
    // A file that did not exist before cannot be lost in a system crash.
    if replaces { file.sync_data() } else { Ok(()) }
}

/// A token that distinguishes this process from later ones with the same identifier.
static TOKEN: LazyLock<u32> =
    LazyLock::new(|| RandomState::new().hash_one(std::process::id()) as u32);

fn partial_name() -> String {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    format!("{PARTIAL_START}{}-{:08x}-{number}{PARTIAL_END}", std::process::id(), *TOKEN)
}

/// Removes the partial files of killed processes from a directory, once per directory and process.
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
    // An earlier process had the same identifier, and was killed.
    if process == std::process::id() {
        return token != *TOKEN;
    }
    !is_running(process).unwrap_or_else(|| {
        // Without a list of processes only age tells that nobody will finish the file.
        let modified = entry.metadata().and_then(|found| found.modified());
        !modified.is_ok_and(|when| when.elapsed().is_ok_and(|age| age > ABANDONED))
    })
}

/// Whether a process of this identifier runs; `None` if the system does not list processes.
pub fn is_running(process: u32) -> Option<bool> {
    let list = Path::new("/proc");
    list.join("self").exists().then(|| list.join(process.to_string()).exists())
}

/// The identifier and token of the process that writes a partial file.
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

    #[test]
    fn an_input_that_was_replaced_since_is_known_by_its_path() {
        let folder = std::env::temp_dir().join(format!("landfall-replaced-{}", partial_name()));
        fs::create_dir_all(folder.join("sub")).expect("temporary files can be written");
        let [input, other, link] = ["Input.frag", "other", "link"].map(|name| folder.join(name));
        for path in [&input, &other] {
            fs::write(path, path.as_os_str().as_encoded_bytes()).expect("a file of this test");
        }
        let writer = FileWriter::new([&input]);
        assert!(writer.write(&link, "new").is_ok() && writer.write(&other, "new").is_ok());
        // Another file, with another number, as editors write.
        fs::rename(&link, &input).expect("a file of this test");
        for path in [input.clone(), folder.join("sub/../Input.frag")] {
            let refused = writer.write(&path, "output").expect_err("it is an input");
            assert!(refused.message.contains("is an input"), "{}", refused.message);
        }
        assert_eq!(fs::read(&input).ok(), Some(b"new".to_vec()));
        fs::remove_dir_all(&folder).expect("the folder of this test");
    }
}
