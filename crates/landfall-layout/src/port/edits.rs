//! Edits of a text, applied at the end: everything outside the edits stays byte for byte.

use std::ops::Range;

/// Changes to one text.
#[derive(Clone, Debug, Default)]
pub(super) struct Edits {
    edits: Vec<Edit>,
}

#[derive(Clone, Debug)]
struct Edit {
    range: Range<usize>,
    text: String,
    /// Whether these are whole lines, which come before other insertions at the same byte.
    lines: bool,
}

impl Edits {
    /// Replaces a range; an edit inside another edit's range is dropped.
    pub fn replace(&mut self, range: Range<usize>, text: impl Into<String>) {
        self.edits.push(Edit { range, text: text.into(), lines: false });
    }

    pub fn delete(&mut self, range: Range<usize>) {
        self.replace(range, "");
    }

    /// Inserts `text` before the byte `at`, after earlier insertions there.
    pub fn insert(&mut self, at: usize, text: impl Into<String>) {
        self.replace(at..at, text);
    }

    /// Inserts whole lines before the line that starts at `at`.
    pub fn insert_lines(&mut self, at: usize, text: impl Into<String>) {
        self.edits.push(Edit { range: at..at, text: text.into(), lines: true });
    }

    /// A part of the text with its edits applied.
    pub fn render(&self, text: &str, part: Range<usize>) -> String {
        let mut inside: Vec<&Edit> = self
            .edits
            .iter()
            .filter(|edit| edit.range.start >= part.start && edit.range.end <= part.end)
            // An insertion at the end of the part belongs to the text after it.
            .filter(|edit| edit.range.start < part.end || part.end == text.len())
            .collect();
        // Insertions come before edits that start at the same byte, wide edits before those inside.
        inside.sort_by_key(|edit| {
            (edit.range.start, !edit.range.is_empty(), !edit.lines, usize::MAX - edit.range.end)
        });
        let mut result = String::with_capacity(part.len());
        let mut at = part.start;
        for edit in inside {
            if edit.range.start < at {
                continue;
            }
            result.push_str(&text[at..edit.range.start]);
            result.push_str(&edit.text);
            at = edit.range.end;
        }
        result.push_str(&text[at..part.end]);
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_change_swallows_those_inside_it() {
        let mut edits = Edits::default();
        edits.replace(4..5, "X");
        edits.delete(2..6);
        edits.insert(2, "<");
        edits.insert(6, ">");
        edits.insert(3, "lost");
        assert_eq!(edits.render("abcdefgh", 0..8), "ab<>gh");
        assert_eq!(edits.render("abcdefgh", 3..6), "lostdXf");
    }
}
