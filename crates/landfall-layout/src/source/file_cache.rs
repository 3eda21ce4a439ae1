//! The files that readings of one shader under several sets of macros have in common: each is looked
//! for and read once.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use rustc_hash::FxHashMap;

use super::{Foreign, ReadOptions, decode_shader, normalized, read_bytes};
use crate::error::Error;

/// Where a file was looked for, and where it is.
pub(crate) type FoundFile = (Vec<PathBuf>, Option<PathBuf>);

/// The way in which a file was looked for, the file that names it, and the name.
type SearchKey = (&'static str, PathBuf, String);

/// What was found in the file system.
#[derive(Debug, Default)]
pub struct FileCache {
    found: Mutex<FxHashMap<SearchKey, FoundFile>>,
    texts: Mutex<FxHashMap<PathBuf, Arc<str>>>,
}

impl ReadOptions {
    /// Returns the file that another one names; `find` looks for it, if that was not done before.
    pub(crate) fn found(
        &self,
        way: &'static str,
        from: &Path,
        name: &str,
        find: impl FnOnce() -> FoundFile,
    ) -> FoundFile {
        // Several threads may look for one file at once, as it is not locked while it is read: all
        // find the same.
        let Some(cache) = &self.cache else { return find() };
        let key = (way, from.to_path_buf(), name.to_string());
        let known = cache.found.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
        known.unwrap_or_else(|| {
            let found = find();
            let mut all = cache.found.lock().unwrap_or_else(PoisonError::into_inner);
            all.insert(key, found.clone());
            found
        })
    }

    /// Whether a path is that of a file that may be read.
    pub(crate) fn is_file(&self, path: &Path) -> bool {
        match &self.files {
            Some(files) => files.iter().any(|(given, _)| Path::new(given) == path),
            None => {
                let is_open = self.open_files.as_ref().is_some_and(|o| o.text(path).is_some());
                let find = || (Vec::new(), path.is_file().then(|| path.to_path_buf()));
                is_open || self.found("file", path, "", find).1.is_some()
            }
        }
    }

    /// Reads and decodes a file.
    ///
    /// # Errors
    /// It cannot be read, or is no text.
    pub(crate) fn read_file(&self, path: &Path) -> Result<(Arc<str>, Option<Foreign>), Error> {
        let bytes = match &self.files {
            Some(files) => {
                let given = files.iter().find(|(given, _)| Path::new(given) == path);
                given.map(|(_, text)| text.clone().into_bytes()).unwrap_or_default()
            }
            None => read_bytes(path, self.max_bytes)?,
        };
        let (text, foreign) = decode_shader(&path.display().to_string(), bytes)?;
        Ok((normalized(text.into()), foreign))
    }

    /// Returns the text of a file that is open or was read before.
    pub(crate) fn known_text(&self, path: &Path) -> Option<Arc<str>> {
        // An open file comes before what a cache has read.
        if let Some(text) = self.open_files.as_ref().and_then(|open| open.text(path)) {
            return Some(Arc::clone(text));
        }
        let texts = self.cache.as_ref()?.texts.lock().unwrap_or_else(PoisonError::into_inner);
        texts.get(path).cloned()
    }

    /// Keeps the text of a file for other readings.
    pub(crate) fn keep_text(&self, path: &Path, text: &Arc<str>) {
        if let Some(cache) = &self.cache {
            let mut texts = cache.texts.lock().unwrap_or_else(PoisonError::into_inner);
            texts.insert(path.to_path_buf(), Arc::clone(text));
        }
    }
}
