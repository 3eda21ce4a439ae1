//! Rust files with mirrors: those the configuration names, and those whose comments name blocks.
//!
//! Read once a check, for lints over all shaders.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use ignore::WalkBuilder;
use landfall_layout::Error;
use landfall_layout::file::{MOST_BYTES, read_whole};
use landfall_lint::rust_mirror::readable;
use landfall_lint::settings::{RustFile, Settings};

use crate::config::Config;
use crate::read;

/// What a comment that names a mirror begins with.
const MARK: &[u8] = b"landfall: mirror";

/// The files; when nothing was named all below the configuration's folder are searched for
/// comments, otherwise the folders and Rust files that were named.
///
/// # Errors
/// A file that is to be guarded cannot be read, or is no Rust.
pub fn files(
    config: &Config,
    settings: &Settings,
    named: &[PathBuf],
) -> Result<Vec<RustFile>, Error> {
    let mut files: BTreeMap<String, RustFile> = BTreeMap::new();
    let mut take = |path: &Path, shown: String| {
        let text = read::text(path)?;
        let file = RustFile { path: shown.clone(), text: text.into() };
        readable(&file)?;
        files.insert(shown, file);
        Ok::<(), Error>(())
    };
    for mirror in &settings.rust_mirrors {
        let path = Path::new(&mirror.file);
        take(path, config.root.show(path)).map_err(|error| {
            let place = &mirror.place;
            let help = format!("`[[rust-mirror]]` names it, {}:{}", place.path, place.line);
            if error.help.is_none() { error.with_help(help) } else { error }
        })?;
    }
    let everything = [config.root.path("")];
    let folders = if named.is_empty() { &everything[..] } else { named };
    for folder in folders.iter().filter(|path| path.is_dir()) {
        for entry in WalkBuilder::new(folder).build().filter_map(Result::ok) {
            let path = entry.path();
            let is_rust = path.extension().is_some_and(|e| e == "rs") && path.is_file();
            let below = config.root.below(path);
            if !is_rust || below.is_some_and(|below| config.exclude.takes(&below)) {
                continue;
            }
            // What cannot be read names no mirror that anybody could know of.
            let bytes = read_whole(path, MOST_BYTES).unwrap_or_default();
            if memchr::memmem::find(&bytes, MARK).is_some() {
                take(path, config.root.show(path))?;
            }
        }
    }
    Ok(files.into_values().collect())
}
