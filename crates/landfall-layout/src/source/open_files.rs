//! Texts that stand for files: those that an editor has changed and not saved.

use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use rustc_hash::FxHashMap;

/// Texts by the absolute paths of their files, which need not exist.
#[derive(Debug, Default)]
pub struct OpenFiles {
    current: PathBuf,
    texts: FxHashMap<PathBuf, Arc<str>>,
}

impl OpenFiles {
    /// Texts by path; paths that are not absolute, here and in searches, begin in `current`.
    pub fn new(
        current: PathBuf,
        texts: impl IntoIterator<Item = (PathBuf, Arc<str>)>,
    ) -> OpenFiles {
        let mut open = OpenFiles { current, texts: FxHashMap::default() };
        for (path, text) in texts {
            // As a reader of the file would have it: without a byte-order mark.
            open.texts.insert(open.absolute(&path), super::normalized(text));
        }
        open
    }

    /// The text that stands for a file.
    pub fn text(&self, path: &Path) -> Option<&Arc<str>> {
        if self.texts.is_empty() { None } else { self.texts.get(&self.absolute(path)) }
    }

    fn absolute(&self, path: &Path) -> PathBuf {
        let mut plain = PathBuf::new();
        // Without asking the file system, as the file need not exist: `..` takes the part before
        // it.
        for part in self.current.join(path).components() {
            match part {
                Component::CurDir => {}
                Component::ParentDir => {
                    plain.pop();
                }
                Component::Prefix(_) | Component::RootDir | Component::Normal(_) => {
                    plain.push(part)
                }
            }
        }
        plain
    }
}
