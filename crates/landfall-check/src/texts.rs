//! Texts of files by the paths in findings.

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

/// Texts that are given, and those that are read from disk when they are asked for.
pub struct Texts {
    pub given: HashMap<String, String>,
    read: RefCell<HashMap<String, Option<Arc<str>>>>,
}

impl Texts {
    /// Reads files from disk, except for the given texts.
    pub fn new(given: HashMap<String, String>) -> Texts {
        Texts { given, read: RefCell::default() }
    }

    pub fn of(&self, path: &str) -> Option<Arc<str>> {
        let mut read = self.read.borrow_mut();
        if let Some(text) = read.get(path) {
            return text.clone();
        }
        let text = match self.given.get(path) {
            Some(text) => Some(Arc::from(text.as_str())),
            None => std::fs::read_to_string(path).ok().map(|text| {
                // Spans do not count a byte-order mark.
                Arc::from(text.strip_prefix('\u{feff}').unwrap_or(&text))
            }),
        };
        read.insert(path.to_string(), text.clone());
        text
    }
}
