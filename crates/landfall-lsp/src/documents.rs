//! The documents that the client has open, as it edits them.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gen_lsp_types::{TextDocumentContentChangeEvent, Uri};
use landfall_layout::source::OpenFiles;

use crate::positions::{LineText, PositionEncoding};
use crate::uris;

/// Bytes of a text beyond which it is not looked at while it is edited, but as it is saved.
const LARGEST: usize = 1 << 20;

/// An open document.
pub struct OpenDocument {
    /// As the client spells it.
    pub uri: Uri,
    pub version: i32,
    pub text: Arc<LineText>,
}

/// The open documents by their absolute paths.
#[derive(Default)]
pub struct Documents {
    pub encoding: PositionEncoding,
    open: HashMap<PathBuf, OpenDocument>,
    /// Increased by every change.
    pub generation: u64,
}

impl Documents {
    pub fn open(&mut self, uri: Uri, version: i32, text: String) -> Option<PathBuf> {
        let path = uris::path(&uri)?;
        let text = Arc::new(LineText::new(text, self.encoding));
        self.open.insert(path.clone(), OpenDocument { uri, version, text });
        self.generation += 1;
        Some(path)
    }

    pub fn close(&mut self, uri: &Uri) -> Option<PathBuf> {
        let path = uris::path(uri)?;
        self.open.remove(&path)?;
        self.generation += 1;
        Some(path)
    }

    pub fn change(
        &mut self,
        uri: &Uri,
        version: i32,
        changes: Vec<TextDocumentContentChangeEvent>,
    ) -> Option<PathBuf> {
        let path = uris::path(uri)?;
        let document = self.open.get_mut(&path)?;
        document.version = version;
        for change in changes {
            match change {
                TextDocumentContentChangeEvent::TextDocumentContentChangePartial(part) => {
                    Arc::make_mut(&mut document.text).replace(part.range, &part.text);
                }
                TextDocumentContentChangeEvent::TextDocumentContentChangeWholeDocument(whole) => {
                    document.text = Arc::new(LineText::new(whole.text, self.encoding));
                }
            }
        }
        self.generation += 1;
        Some(path)
    }

    pub fn get(&self, path: &Path) -> Option<&OpenDocument> {
        self.open.get(path)
    }

    pub fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        self.open.keys()
    }

    /// Whether a document is as its file is.
    pub fn is_saved(&self, path: &Path) -> bool {
        let text = self.get(path).map(|document| document.text.text().as_bytes());
        std::fs::read(path).is_ok_and(|bytes| text == Some(&bytes[..]))
    }

    /// Whether a text is small enough to be looked at while it is edited.
    pub fn is_live(&self, path: &Path) -> bool {
        self.get(path).is_some_and(|document| document.text.text().len() <= LARGEST)
    }

    /// The texts that stand for files.
    pub fn texts(&self, current: &Path) -> OpenFiles {
        let live = self.open.iter().filter(|(path, _)| self.is_live(path));
        let texts = live.map(|(path, one)| (path.clone(), one.text.shared()));
        OpenFiles::new(current.to_path_buf(), texts)
    }

    /// The URI of a file, as the client spells it if it is open.
    pub fn uri(&self, path: &Path) -> Uri {
        self.get(path).map_or_else(|| uris::uri(path), |document| document.uri.clone())
    }

    /// The text of a file, open or not.
    pub fn text(&self, path: &Path) -> Option<Arc<LineText>> {
        match self.get(path) {
            Some(document) => Some(Arc::clone(&document.text)),
            None => {
                let bytes = landfall_layout::source::read_bytes(path, None).ok()?;
                let text = String::from_utf8_lossy(&bytes);
                Some(Arc::new(LineText::new(text, self.encoding)))
            }
        }
    }
}
