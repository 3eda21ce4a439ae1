//! What was found the last time, in one file a set of settings below a folder of its own.
//!
//! A file that is cut off, changed by hand or from another version is as good as none. Runs at
//! the same time each write theirs whole, and the last one stays.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use landfall_layout::Error;
use landfall_layout::file::write_whole;
use landfall_lint::digest::fnv;
use serde::{Deserialize, Serialize};

use super::basis::Basis;
use super::one::Checked;
use super::pass::Pass;
use super::tree::Remembered;

/// Files kept in the folder: one for each set of flags that checks are run with.
const MOST_FILES: usize = 16;

/// What is remembered.
#[derive(Default)]
pub struct Cache {
    file: PathBuf,
    pub known: HashMap<String, Checked>,
    pub tree: Option<Remembered>,
}

#[derive(Serialize)]
struct Written<'a> {
    program: u64,
    checked: &'a [&'a Checked],
    tree: &'a Option<Remembered>,
}

#[derive(Deserialize)]
struct Read {
    program: u64,
    checked: Vec<Checked>,
    tree: Option<Remembered>,
}

impl Cache {
    /// What a folder remembers of checks like this one.
    pub fn open(folder: &Path, basis: &Basis) -> Cache {
        let file = folder.join(format!("check-{:016x}.json", basis.fingerprint()));
        let read = fs::read_to_string(&file).ok().and_then(|text| read(&text));
        match read.filter(|read| read.program == program()) {
            Some(read) => {
                let known = read.checked.into_iter().map(|c| (c.path.clone(), c)).collect();
                Cache { file, known, tree: read.tree }
            }
            None => Cache { file, ..Cache::default() },
        }
    }

    /// Remembers what this check found, and what is known of shaders it did not look at.
    pub fn write(&self, pass: &Pass) -> Result<(), Error> {
        let mut all: Vec<&Checked> = pass.checked.iter().filter(|c| !c.failed).collect();
        all.extend(pass.left.values().filter(|other| Path::new(&other.path).is_file()));
        // Of two records of one shader the first, which is this check's, stays.
        all.sort_by(|a, b| a.path.cmp(&b.path));
        all.dedup_by(|a, b| a.path == b.path);
        let written = Written { program: program(), checked: &all, tree: &self.tree };
        let json = serde_json::to_string(&written).expect("keys are strings");
        let folder = self.file.parent().unwrap_or(Path::new("."));
        // A folder that somebody has made is theirs to ignore.
        if !folder.exists() {
            write_whole(
                &folder.join(".gitignore"),
                "# Made by landfall; may be removed at any time.\n*\n",
            )?;
        }
        write_whole(&self.file, format!("{:016x}\n{json}\n", fnv(json.as_bytes())))?;
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
            .filter_map(|entry| Some((entry.metadata().ok()?.modified().ok()?, entry.path())))
            .collect();
        files.sort();
        let more = files.len().saturating_sub(MOST_FILES);
        for (_, path) in files.into_iter().take(more) {
            let _ = fs::remove_file(path);
        }
    }
}

/// The content of a file that is as it was written.
fn read(text: &str) -> Option<Read> {
    let (sum, json) = text.split_once('\n')?;
    let json = json.strip_suffix('\n')?;
    if u64::from_str_radix(sum, 16).ok()? != fnv(json.as_bytes()) {
        return None;
    }
    serde_json::from_str(json).ok()
}

/// The version, and the size of the program: one built anew from changed sources is another.
fn program() -> u64 {
    let size = std::env::current_exe().and_then(fs::metadata).map_or(0, |found| found.len());
    fnv(format!("{} {size}", env!("CARGO_PKG_VERSION")).as_bytes())
}
