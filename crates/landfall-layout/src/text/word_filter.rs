//! A filter before lists of words: most words of a text are in none of them.

/// The hashes of a list's words, as bits: a word whose bit is not set is not in the list.
#[derive(Clone, Copy)]
pub(crate) struct WordFilter(u128);

impl WordFilter {
    /// Returns the filter of an empty list.
    pub(crate) const NONE: WordFilter = WordFilter(0);

    /// Returns the filter of this one's list and further words.
    pub(crate) const fn with(self, words: &[&str]) -> WordFilter {
        let WordFilter(mut bits) = self;
        let mut at = 0;
        while at < words.len() {
            bits |= bit(words[at]);
            at += 1;
        }
        WordFilter(bits)
    }

    /// Whether the list may contain the word; if not, it does not.
    #[inline]
    pub(crate) const fn may_contain(self, word: &str) -> bool {
        self.0 & bit(word) != 0
    }
}

/// The bit of a word, by its length, first and last byte.
#[inline]
const fn bit(word: &str) -> u128 {
    let bytes = word.as_bytes();
    let (first, last) = match bytes {
        [] => (0, 0),
        [first, .., last] => (*first as u32, *last as u32),
        [only] => (*only as u32, *only as u32),
    };
    // Three properties that are found without reading the word, with factors that spread keywords
    // over the 128 bits.
    1 << ((bytes.len() as u32 * 29 + first * 5 + last * 11) % 128)
}

#[cfg(test)]
mod tests {
    use super::WordFilter;

    #[test]
    fn every_word_of_the_list_passes_and_few_others_do() {
        let list = ["", "a", "in", "out", "uniform", "struct"];
        let filter = WordFilter::NONE.with(&list[..3]).with(&list[3..]);
        assert!(list.iter().all(|word| filter.may_contain(word)));
        let others = ["position", "color", "light", "x", "normal", "u_time", "gl_Position"];
        assert!(others.iter().any(|word| !filter.may_contain(word)));
    }
}
