//! Extracts files of a git revision to a temporary directory.
//!
//! Runs the `git` on the path, which resolves revisions.

use std::collections::HashSet;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::ops::Deref;
use std::path::{Component, Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

use landfall_check::against::ExtractedTree;
use landfall_layout::Error;
use landfall_layout::file::{is_running, reason};
use landfall_layout::source::{Language, kind_of_path};

use crate::child::{self, Child};
use crate::watch;

/// A path at a revision, as spelt in the argument.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Revision {
    /// `HEAD~1`.
    pub rev: String,
    /// The path in the revision: from the root of the repository, or from the current directory if
    /// it starts with `./` or `../`.
    pub path: String,
}

impl Revision {
    /// Parses `REV:path`, unless a file of that name exists.
    pub fn parse(text: &str) -> Option<Revision> {
        if Path::new(text).exists() {
            return None;
        }
        let (rev, path) = text.split_once(':')?;
        // `C:\shader.frag` is a path on a drive.
        if rev.is_empty() || path.starts_with('\\') {
            return None;
        }
        Some(Revision { rev: rev.to_string(), path: path.to_string() })
    }

    fn shown(&self) -> String {
        format!("{}:{}", self.rev, self.path)
    }
}

/// Extracted files of a revision, removed on drop.
pub struct Tree(ExtractedTree);

impl Deref for Tree {
    type Target = ExtractedTree;

    fn deref(&self) -> &ExtractedTree {
        &self.0
    }
}

impl Drop for Tree {
    fn drop(&mut self) {
        watch::forget(&self.root);
        let _ = fs::remove_dir_all(&self.root);
    }
}

/// Extracts a file, or the shaders and locks of a directory, with every file of the revision that
/// they may include.
pub fn extract(revision: &Revision) -> Result<Tree, Error> {
    extract_any(revision)?.map_err(|is_there| {
        let message = match is_there {
            true => "contains no shader or lock at that revision",
            false => "does not exist at that revision",
        };
        let help = format!("`git ls-tree -r --name-only {}` lists its files", revision.rev);
        Error::new(revision.shown(), message).with_help(help)
    })
}

/// Extracts the same. Without any shader or lock, returns whether the path exists at the revision.
pub fn extract_any(revision: &Revision) -> Result<Result<Tree, bool>, Error> {
    let shown = revision.shown();
    let refuse = |message: &str| Error::new(&shown, message);
    // `git ls-tree` would take it for an option.
    if revision.rev.starts_with('-') {
        return Err(refuse("is not a revision: it begins with `-`"));
    }
    let top = PathBuf::from(parsed("--show-toplevel", &shown)?);
    // The directory of the command within the repository, for paths that start with `./`.
    let prefix = parsed("--show-prefix", &shown)?;
    let path =
        normal(&revision.path, &prefix).ok_or_else(|| refuse("is outside the repository"))?;
    // Separated by zero bytes, as paths may contain anything else.
    let list = git(&["ls-tree", "-r", "-z", "--full-tree", &revision.rev], &shown)?;
    let files = entries(&list);
    let below = format!("{path}/");
    let is_chosen = |file: &&TreeEntry| {
        file.path == path
            || (path.is_empty() || file.path.starts_with(&below)) && is_ours(Path::new(&file.path))
    };
    let mut chosen: Vec<&TreeEntry> = files.iter().filter(is_chosen).collect();
    if chosen.is_empty() {
        let is_there = files.iter().any(|file| path.is_empty() || file.path.starts_with(&below));
        return Ok(Err(is_there));
    }
    let root =
        scratch().map_err(|cause| refuse(&format!("cannot be extracted: {}", reason(&cause))))?;
    // Removed on drop, also if reading fails below.
    let tree = Tree(ExtractedTree { path: root.join(&path), root, rev: revision.rev.clone(), top });
    let mut taken: HashSet<&str> = chosen.iter().map(|file| file.path.as_str()).collect();
    let mut batch = CatFile::open(&shown)?;
    // A work list: each file may include others, by any path that ends in the name. More than
    // needed is extracted rather than less, since include directories are resolved later.
    while let Some(file) = chosen.pop() {
        let bytes = batch.read(&file.object, &shown)?;
        let target = tree.root.join(&file.path);
        let folder = target.parent().unwrap_or(&tree.root);
        fs::create_dir_all(folder)
            .and_then(|()| fs::write(&target, &bytes))
            .map_err(|cause| refuse(&format!("cannot be extracted: {}", reason(&cause))))?;
        for name in names_included(&bytes) {
            let named = files.iter().filter(|file| file.path.rsplit('/').next() == Some(&name));
            chosen.extend(named.filter(|file| taken.insert(file.path.as_str())));
        }
        // Which modules it needs is known only when it is read.
        let is_wgsl = |path: &str| {
            kind_of_path(Path::new(path)).is_some_and(|(language, _)| language == Language::Wgsl)
        };
        // WGSL modules are imported by names that no file name tells.
        if is_wgsl(&file.path) && String::from_utf8_lossy(&bytes).contains("import") {
            let modules = files.iter().filter(|file| is_wgsl(&file.path));
            chosen.extend(modules.filter(|file| taken.insert(file.path.as_str())));
        }
    }
    Ok(Ok(tree))
}

/// Whether a path may be a shader or a lock.
fn is_ours(path: &Path) -> bool {
    kind_of_path(path).is_some() || path.extension().is_some_and(|e| e == "json")
}

/// Normalizes a path to one from the root of the repository, with `/` separators.
fn normal(path: &str, prefix: &str) -> Option<String> {
    let here = path == "." || path == ".." || path.starts_with("./") || path.starts_with("../");
    let whole = if here { Path::new(prefix).join(path) } else { PathBuf::from(path) };
    let mut parts: Vec<&str> = Vec::new();
    for part in whole.components() {
        match part {
            Component::Normal(name) => parts.push(name.to_str()?),
            Component::CurDir => {}
            Component::ParentDir => {
                parts.pop()?;
            }
            // An absolute path is none of a revision.
            Component::RootDir | Component::Prefix(_) => return None,
        }
    }
    Some(parts.join("/"))
}

/// Converts a path of the work tree to one from the root of the repository at a revision.
pub fn in_repository(rev: &str, path: &Path) -> Result<Revision, Error> {
    let shown = format!("{rev}:{}", path.display());
    let top = PathBuf::from(parsed("--show-toplevel", &shown)?);
    let here = std::env::current_dir().unwrap_or_default().join(path);
    // A removed file has no canonical path, but its directory may.
    let real = fs::canonicalize(&here).unwrap_or_else(|_| {
        let parent = here.parent().and_then(|parent| fs::canonicalize(parent).ok());
        parent.zip(here.file_name()).map_or(here.clone(), |(parent, name)| parent.join(name))
    });
    let inside = real.strip_prefix(&top).map_err(|_| {
        Error::new(path.display().to_string(), "is not in the git repository of this directory")
    })?;
    let parts: Vec<String> =
        inside.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
    Ok(Revision { rev: rev.to_string(), path: parts.join("/") })
}

struct TreeEntry {
    object: String,
    path: String,
}

/// Parses `MODE blob OBJECT\tPATH` entries that end in a zero byte; skips links and submodules.
fn entries(list: &str) -> Vec<TreeEntry> {
    let entry = |line: &str| {
        let (facts, path) = line.split_once('\t')?;
        let mut facts = facts.split(' ');
        let (mode, kind, object) = (facts.next()?, facts.next()?, facts.next()?);
        // Modes 100644 and 100755 are files; 120000 is a link, 160000 a submodule.
        (kind == "blob" && mode.starts_with("100"))
            .then(|| TreeEntry { object: object.to_string(), path: path.to_string() })
    };
    list.split('\0').filter_map(entry).collect()
}

/// The file names in the `#include` lines of a text, without directories; not those from macros.
fn names_included(bytes: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(bytes);
    let names = text.lines().filter_map(included).filter_map(|name| name.rsplit('/').next());
    names.filter(|name| !name.is_empty()).map(str::to_string).collect()
}

/// The file that a line includes.
pub fn included(line: &str) -> Option<&str> {
    let rest = line.trim_start().strip_prefix('#')?.trim_start().strip_prefix("include")?;
    let rest = rest.trim_start().strip_prefix(['"', '<'])?;
    rest.split(['"', '>']).next().filter(|name| !name.is_empty())
}

/// What `git rev-parse` answers to an option.
fn parsed(option: &str, about: &str) -> Result<String, Error> {
    let said = git(&["rev-parse", option], about)?;
    Ok(said.trim_end_matches(['\n', '\r']).to_string())
}

fn git(arguments: &[&str], about: &str) -> Result<String, Error> {
    let out = child::output(Command::new("git").args(arguments));
    let out = out.map_err(|cause| no_git(&cause, about))?;
    if out.status.success() {
        return Ok(String::from_utf8_lossy(&out.stdout).into_owned());
    }
    let message = String::from_utf8_lossy(&out.stderr);
    let message = message.lines().next().unwrap_or("no reason given");
    // Git's first line says it; `fatal:` is its own. Names keep their capitals.
    let message = message.trim_start_matches("fatal: ");
    let (first, rest) = message.split_at(message.chars().next().map_or(0, char::len_utf8));
    let message = format!("cannot be read by git: {}{rest}", first.to_lowercase());
    Err(Error::new(about, message))
}

fn no_git(cause: &std::io::Error, about: &str) -> Error {
    Error::new(about, format!("needs `git`, which cannot be run: {}", reason(cause)))
}

/// A `git cat-file --batch` process for all files.
/// One process for all objects: starting one takes milliseconds.
struct CatFile {
    child: Child,
    answers: BufReader<std::process::ChildStdout>,
}

impl CatFile {
    fn open(about: &str) -> Result<CatFile, Error> {
        let mut command = Command::new("git");
        command.args(["cat-file", "--batch"]);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = Child::start(&mut command).map_err(|cause| no_git(&cause, about))?;
        let answers = BufReader::new(child.process().stdout.take().expect("stdout is piped above"));
        Ok(CatFile { child, answers })
    }

    fn read(&mut self, object: &str, about: &str) -> Result<Vec<u8>, Error> {
        let failed = || Error::new(about, format!("cannot be read by git: object {object}"));
        let stdin = self.child.process().stdin.as_mut().ok_or_else(failed)?;
        writeln!(stdin, "{object}").and_then(|()| stdin.flush()).map_err(|_| failed())?;
        // `OBJECT blob SIZE`, then the bytes, then a newline.
        let mut head = String::new();
        self.answers.read_line(&mut head).map_err(|_| failed())?;
        let size: usize =
            head.trim().rsplit(' ').next().and_then(|n| n.parse().ok()).ok_or_else(failed)?;
        let mut bytes = vec![0; size + 1];
        self.answers.read_exact(&mut bytes).map_err(|_| failed())?;
        bytes.truncate(size);
        Ok(bytes)
    }
}

/// The start of the names of temporary directories: `landfall-diff-PID-N`.
const SCRATCH: &str = "landfall-diff-";

/// Creates a temporary directory of this process, and removes those of killed processes.
fn scratch() -> std::io::Result<PathBuf> {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let base = fs::canonicalize(std::env::temp_dir())?;
    sweep(&base);
    loop {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        // The name has the process, so that a later run knows whether it may be removed.
        let dir = base.join(format!("{SCRATCH}{}-{number}", std::process::id()));
        match fs::create_dir(&dir) {
            Ok(()) => {
                // Removed on Ctrl-C as well, which runs no destructors.
                watch::remember(&dir);
                return Ok(dir);
            }
            Err(cause) if cause.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(cause) => return Err(cause),
        }
    }
}

/// Removes the temporary directories of processes that no longer run.
fn sweep(base: &Path) {
    for entry in fs::read_dir(base).into_iter().flatten().flatten() {
        let owner = owner(&entry.file_name().to_string_lossy());
        let is_dir = entry.file_type().is_ok_and(|kind| kind.is_dir());
        if is_dir && owner.is_some_and(|process| is_running(process) == Some(false)) {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

/// The process of a temporary directory's name.
fn owner(name: &str) -> Option<u32> {
    let (process, number) = name.strip_prefix(SCRATCH)?.split_once('-')?;
    number.parse::<u32>().ok()?;
    process.parse().ok()
}
