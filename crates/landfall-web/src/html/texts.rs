//! The texts of a page that many members share.

use std::collections::HashMap;

/// Texts that many members share, by their index in the page.
#[derive(Debug, Default)]
pub(super) struct Texts {
    pub all: Vec<String>,
    known: HashMap<String, usize>,
}

impl Texts {
    pub fn index(&mut self, text: String) -> usize {
        let next = self.all.len();
        *self.known.entry(text).or_insert_with_key(|text| {
            self.all.push(text.clone());
            next
        })
    }
}
