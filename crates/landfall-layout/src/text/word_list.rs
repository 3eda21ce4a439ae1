//! Lists of words in tables.

/// Words with one space between each two.
#[derive(Clone, Copy, Debug)]
pub struct WordList(pub &'static str);

impl WordList {
    pub fn iter(self) -> impl Iterator<Item = &'static str> {
        self.0.split(' ')
    }

    pub fn contains(self, word: &str) -> bool {
        self.0.as_bytes().split(|byte| *byte == b' ').any(|known| known == word.as_bytes())
    }
}
