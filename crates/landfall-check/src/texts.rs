//! Texts of files by the paths in findings.

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

use landfall_layout::source::Files;

/// Texts that are given, and those that are read from disk when they are asked for.
pub struct Texts {
    pub given: HashMap<String, String>,
    /// Each as the only one of its [`Files`], which know where its lines are.
    read: RefCell<HashMap<String, Files>>,
}

impl Texts {
    /// Reads files from disk, except for the given texts.
    pub fn new(given: HashMap<String, String>) -> Texts {
        Texts { given, read: RefCell::default() }
    }

    pub fn of(&self, path: &str) -> Option<Arc<str>> {
        self.read(path);
        self.read.borrow()[path].get(0).map(|file| Arc::clone(&file.text))
    }

    /// Returns a line of a file, from 1.
    pub fn line(&self, path: &str, number: u32) -> Option<String> {
        self.read(path);
        self.read.borrow()[path].get(0)?.line(number).map(str::to_string)
    }

    fn read(&self, path: &str) {
        let mut read = self.read.borrow_mut();
        if read.contains_key(path) {
            return;
        }
        let text = match self.given.get(path) {
            Some(text) => Some(Arc::from(text.as_str())),
            None => std::fs::read_to_string(path).ok().map(|text| {
                // Spans do not count a byte-order mark.
                Arc::from(text.strip_prefix('\u{feff}').unwrap_or(&text))
            }),
        };
        let mut files = Files::default();
        if let Some(text) = text {
            files.add(path, text);
        }
        read.insert(path.to_string(), files);
    }
}
