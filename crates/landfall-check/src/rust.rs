//! Reads Rust files with mirrors, named by the configuration or found by their comments, for lints
//! over all shaders.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use landfall_layout::Error;
use landfall_layout::file::{MAX_BYTES, read_whole};
use landfall_layout::source::OpenFiles;
use landfall_lint::rust_mirror::readable;
use landfall_lint::settings::{RustFile, Settings};

use crate::basis::Basis;
use crate::config::Config;
use crate::files;
use crate::walk::{FilteredWalk, Listing};

/// The start of a comment that marks a mirror.
const MARK: &[u8] = b"landfall: mirror";

/// What a search for Rust files has found.
#[derive(Default)]
pub struct Search {
    pub files: Vec<RustFile>,
    /// The shaders in the same directories.
    pub listing: Listing,
}

/// The Rust files with mirrors, if a lint of mirrors is enabled, and the shaders beside them.
/// Comments are searched in the named directories and Rust files, or in the configuration's
/// directory if no path is named. Texts of an editor replace files.
///
/// # Errors
///
/// A configured file cannot be read or is not Rust.
pub fn files(
    config: &Config,
    settings: &Settings,
    named: &[PathBuf],
    open: Option<&OpenFiles>,
) -> Result<Search, Error> {
    let mut listing = Some(Listing::default());
    if !Basis::wants_rust(settings) {
        return Ok(Search::default());
    }
    let mut found: BTreeMap<String, RustFile> = BTreeMap::new();
    let mut take = |path: &Path, shown: String| {
        let text = match open.and_then(|open| open.text(path)) {
            Some(text) => text.to_string(),
            None => files::text(path)?,
        };
        let file = RustFile { path: shown.clone(), text: text.into() };
        readable(&file)?;
        found.insert(shown, file);
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
        for entry in FilteredWalk::new(folder) {
            let Ok(entry) = entry else {
                // What cannot be searched is reported with the shaders, which need walks of their own.
                listing = None;
                continue;
            };
            if let Some(listing) = &mut listing {
                listing.add(&entry);
            }
            let path = entry.path();
            // Most files are not Rust; the name costs least.
            let is_rust = path.extension().is_some_and(|e| e == "rs") && path.is_file();
            if !is_rust || config.excludes(path) {
                continue;
            }
            // Unreadable files are skipped, as they may contain no mirror.
            let bytes = match open.and_then(|open| open.text(path)) {
                Some(text) => text.as_bytes().to_vec(),
                None => read_whole(path, MAX_BYTES).unwrap_or_default(),
            };
            if memchr::memmem::find(&bytes, MARK).is_some() {
                take(path, config.root.show(path))?;
            }
        }
    }
    Ok(Search { files: found.into_values().collect(), listing: listing.unwrap_or_default() })
}
