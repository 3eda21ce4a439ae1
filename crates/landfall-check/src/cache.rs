//! The cache of findings: a file per set of settings, in a directory of its own.
//!
//! A truncated or damaged file, or one of other settings or of another version, is ignored. Of concurrent
//! runs, the last one to finish replaces the file. Who can write the file can write any findings into it.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use landfall_layout::Error;
use landfall_layout::file::FileWriter;
use serde::{Deserialize, Serialize};

use crate::basis::Basis;
use crate::check_shader::{Checked, Known, sort_by_path};
use crate::digests::{CachedDigests, Digests};
use crate::hash::{Hash, checksum};
use crate::pass::Pass;
use crate::tree::Remembered;

/// Maximum number of files in the directory.
const MAX_FILES: usize = 16;

/// The start of a cache file, followed by the hash of its settings, a blank, the checksum of the rest, a
/// newline, the JSON of the results, a newline, the JSON of their digests, and a newline.
const MARK: &str = "landfall-check-cache ";

#[derive(Default)]
pub struct Cache {
    file: PathBuf,
    /// The hash of everything besides its files that findings of a shader depend on.
    basis: Hash,
    writer: FileWriter,
    pub known: Known,
    pub tree: Option<Remembered>,
    /// What the findings over all shaders in the file depend on.
    written_tree: Option<String>,
}

#[derive(Serialize)]
struct WrittenCache<'a> {
    checked: Vec<Checked>,
    tree: &'a Option<Remembered>,
}

#[derive(Deserialize)]
struct ReadCache {
    checked: Vec<Checked>,
    tree: Option<Remembered>,
}

impl Cache {
    /// Opens the cache of a directory for these settings.
    pub fn open(folder: &Path, basis: &Basis, writer: FileWriter) -> Cache {
        // Another build may find other things.
        let basis =
            Hash::from_bytes(format!("{} {}", program(), basis.fingerprint().as_str()).as_bytes());
        let file = folder.join(format!("check-{}.json", basis.short()));
        let cache = Cache { file, basis, writer, ..Cache::default() };
        let bytes = is_ours(&cache.file).then(|| fs::read(&cache.file).ok()).flatten();
        let text = bytes.and_then(|bytes| String::from_utf8(bytes).ok());
        let read = text.and_then(|text| cache.read(text));
        match read {
            Some(read) => {
                let known =
                    read.checked.into_iter().map(|c| (c.path.clone(), Box::new(c))).collect();
                let written_tree = read.tree.as_ref().map(|tree| tree.depends_on.clone());
                Cache { known, tree: read.tree, written_tree, ..cache }
            }
            None => cache,
        }
    }

    /// The content of a file of these settings whose checksum is right.
    fn read(&self, text: String) -> Option<ReadCache> {
        let (head, json) = text.strip_prefix(MARK)?.split_once('\n')?;
        let json = json.strip_suffix('\n')?;
        if head != self.head(json) {
            return None;
        }
        let (results, digests) = json.split_once('\n')?;
        let mut read: ReadCache = serde_json::from_str(results).ok()?;
        let end = text.len() - 1;
        let digests = end - digests.len()..end;
        let digests = CachedDigests::new(text, digests);
        for (index, checked) in read.checked.iter_mut().enumerate() {
            checked.blocks = Digests::Cached(Arc::clone(&digests), index);
        }
        Some(read)
    }

    /// What follows the mark in front of this data.
    fn head(&self, json: &str) -> String {
        format!("{} {}", self.basis.as_str(), checksum(json))
    }

    /// Whether there is a file that lacks results of this check, of which this is the last pass; an edit of
    /// shaders took passes before it.
    pub fn is_stale(&self, pass: &Pass, is_edited: bool) -> bool {
        let tree = self.tree.as_ref().map(|tree| &tree.depends_on);
        !self.file.as_os_str().is_empty()
            && (is_edited || pass.fresh + pass.restamped > 0 || tree != self.written_tree.as_ref())
    }

    /// Writes the results of this check, and the cached ones of other shaders.
    pub fn write(&self, pass: &Pass) -> Result<(), Error> {
        let mut all: Vec<&Checked> = pass.checked.iter().filter(|c| !c.failed).collect();
        all.extend(
            pass.left.values().map(Box::as_ref).filter(|other| Path::new(&other.path).is_file()),
        );
        // The first record of a shader, from this check, wins.
        sort_by_path(&mut all);
        all.dedup_by(|a, b| a.path == b.path);
        let digests: Vec<&Digests> = all.iter().map(|checked| &checked.blocks).collect();
        let digests = serde_json::to_string(&digests).expect("a list");
        let bare =
            |checked: &&Checked| Checked { blocks: Digests::default(), ..(*checked).clone() };
        let written = WrittenCache { checked: all.iter().map(bare).collect(), tree: &self.tree };
        let results = serde_json::to_string(&written).expect("keys are strings");
        let json = format!("{results}\n{digests}");
        let folder = self.file.parent().unwrap_or(Path::new("."));
        // A directory made by the user gets no `.gitignore`.
        if !folder.exists() {
            self.writer.write(
                &folder.join(".gitignore"),
                "# Made by landfall; may be removed at any time.\n*\n",
            )?;
        }
        // The name, a hash of the settings, is unique to this cache.
        let is_empty = fs::metadata(&self.file).is_ok_and(|f| f.is_file() && f.len() == 0);
        if self.file.symlink_metadata().is_ok() && !is_empty && !is_ours(&self.file) {
            let error = Error::new(self.file.display().to_string(), "is not a cache of landfall");
            return Err(error.with_help("move it, or choose another directory with `--cache-dir`"));
        }
        self.writer.write(&self.file, format!("{MARK}{}\n{json}\n", self.head(&json)))?;
        self.forget_oldest(folder);
        Ok(())
    }

    fn forget_oldest(&self, folder: &Path) {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        let ours = entries.filter(|entry| {
            let name = entry.file_name();
            let name = name.to_string_lossy();
            name.starts_with("check-") && name.ends_with(".json")
        });
        let mut files: Vec<_> = ours
            .filter(|entry| is_ours(&entry.path()))
            .filter_map(|entry| Some((entry.metadata().ok()?.modified().ok()?, entry.path())))
            .collect();
        files.sort();
        let more = files.len().saturating_sub(MAX_FILES);
        for (_, path) in files.into_iter().take(more) {
            let _ = self.writer.remove(&path);
        }
    }
}

/// Whether a file is a cache, of any settings.
fn is_ours(path: &Path) -> bool {
    use std::io::Read as _;
    // Pipes and devices may have no end.
    if !path.is_file() {
        return false;
    }
    let mut start = Vec::new();
    let file = fs::File::open(path).map(|file| file.take(MARK.len() as u64));
    file.and_then(|mut file| file.read_to_end(&mut start)).is_ok_and(|_| start == MARK.as_bytes())
}

/// The version and the size of the program, to tell rebuilt programs apart.
fn program() -> String {
    let size = std::env::current_exe().and_then(fs::metadata).map_or(0, |found| found.len());
    format!("{} {size}", env!("CARGO_PKG_VERSION"))
}
