//! What was found the last time, in one file a set of settings below a folder of its own.
//!
//! A file that is cut off, changed by hand, sealed with another key or from another version is as
//! good as none. Runs at the same time each write theirs whole, and the last one stays.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use landfall_layout::Error;
use landfall_layout::file::FileWriter;
use serde::{Deserialize, Serialize};

use super::basis::Basis;
use super::hash::{Hash, seal};
use super::one::Checked;
use super::pass::Pass;
use super::tree::Remembered;

/// Files kept in the folder: one for each set of flags that checks are run with.
const MOST_FILES: usize = 16;

/// What a file of ours begins with; then come the seal, a line's end, JSON and a line's end.
const MARK: &str = "landfall-check-cache ";

/// What is remembered.
#[derive(Default)]
pub struct Cache {
    file: PathBuf,
    key: Vec<u8>,
    /// All that findings of one shader depend on besides its files.
    basis: Hash,
    writer: FileWriter,
    pub known: HashMap<String, Checked>,
    pub tree: Option<Remembered>,
}

#[derive(Serialize)]
struct Written<'a> {
    checked: &'a [&'a Checked],
    tree: &'a Option<Remembered>,
}

#[derive(Deserialize)]
struct Read {
    checked: Vec<Checked>,
    tree: Option<Remembered>,
}

impl Cache {
    /// What a folder remembers of checks like this one.
    pub fn open(folder: &Path, basis: &Basis, key: Vec<u8>, writer: FileWriter) -> Cache {
        let basis = Hash::of(format!("{} {}", program(), basis.fingerprint().as_str()).as_bytes());
        let file = folder.join(format!("check-{}.json", basis.short()));
        let cache = Cache { file, key, basis, writer, ..Cache::default() };
        let read = fs::read_to_string(&cache.file).ok().and_then(|text| cache.read(&text));
        match read {
            Some(read) => {
                let known = read.checked.into_iter().map(|c| (c.path.clone(), c)).collect();
                Cache { known, tree: read.tree, ..cache }
            }
            None => cache,
        }
    }

    /// The content of a file that is as it was written, by whoever has the key.
    fn read(&self, text: &str) -> Option<Read> {
        let (sum, json) = text.strip_prefix(MARK)?.split_once('\n')?;
        let json = json.strip_suffix('\n')?;
        if sum != self.seal(json) {
            return None;
        }
        serde_json::from_str(json).ok()
    }

    /// Binds what is remembered to what it holds for.
    fn seal(&self, json: &str) -> String {
        seal(&self.key, format!("{}\n{json}", self.basis.as_str()).as_bytes())
    }

    /// Remembers what this check found, and what is known of shaders it did not look at.
    pub fn write(&self, pass: &Pass) -> Result<(), Error> {
        let mut all: Vec<&Checked> = pass.checked.iter().filter(|c| !c.failed).collect();
        all.extend(pass.left.values().filter(|other| Path::new(&other.path).is_file()));
        // Of two records of one shader the first, which is this check's, stays.
        all.sort_by(|a, b| a.path.cmp(&b.path));
        all.dedup_by(|a, b| a.path == b.path);
        let written = Written { checked: &all, tree: &self.tree };
        let json = serde_json::to_string(&written).expect("keys are strings");
        let folder = self.file.parent().unwrap_or(Path::new("."));
        // A folder that somebody has made is theirs to ignore.
        if !folder.exists() {
            self.writer.write(
                &folder.join(".gitignore"),
                "# Made by landfall; may be removed at any time.\n*\n",
            )?;
        }
        // Nobody else makes a file whose name is a hash of these settings.
        self.writer.write(&self.file, format!("{MARK}{}\n{json}\n", self.seal(&json)))?;
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
        let more = files.len().saturating_sub(MOST_FILES);
        for (_, path) in files.into_iter().take(more) {
            let _ = self.writer.remove(&path);
        }
    }
}

/// Whether a file is a cache, whoever sealed it.
fn is_ours(path: &Path) -> bool {
    use std::io::Read as _;
    let mut start = Vec::new();
    let file = fs::File::open(path).map(|file| file.take(MARK.len() as u64));
    file.and_then(|mut file| file.read_to_end(&mut start)).is_ok_and(|_| start == MARK.as_bytes())
}

/// The version, and the size of the program: one built anew from changed sources is another.
fn program() -> String {
    let size = std::env::current_exe().and_then(fs::metadata).map_or(0, |found| found.len());
    format!("{} {size}", env!("CARGO_PKG_VERSION"))
}
