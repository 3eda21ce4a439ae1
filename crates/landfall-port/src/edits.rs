//! Edits of a text, applied at the end: everything outside the edits stays byte for byte.

use std::collections::BTreeMap;
use std::ops::Range;

/// Changes to one text.
#[derive(Clone, Debug, Default)]
pub(super) struct Edits {
    /// By their first byte.
    edits: BTreeMap<usize, Vec<TextEdit>>,
}

#[derive(Clone, Debug)]
struct TextEdit {
    range: Range<usize>,
    text: String,
    /// Whether these are whole lines, which come before other insertions at the same byte.
    lines: bool,
}

impl Edits {
    /// Replaces a range; an edit inside another edit's range is dropped.
    pub fn replace(&mut self, range: Range<usize>, text: impl Into<String>) {
        self.push(TextEdit { range, text: text.into(), lines: false });
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
        self.push(TextEdit { range: at..at, text: text.into(), lines: true });
    }

    fn push(&mut self, edit: TextEdit) {
        self.edits.entry(edit.range.start).or_default().push(edit);
    }

    /// A part of the text with its edits applied.
    pub fn render(&self, text: &str, part: Range<usize>) -> String {
        let mut result = String::with_capacity(part.len());
        let mut at = part.start;
        for edit in self.applied(text, &part) {
            result.push_str(&text[at..edit.range.start]);
            result.push_str(&edit.text);
            at = edit.range.end;
        }
        result.push_str(&text[at..part.end]);
        result
    }

    /// The line of the text, counted from 1, that each line of its rendering comes from.
    pub fn lines(&self, text: &str) -> Vec<u32> {
        let newlines = |from: usize, to: usize| text[from..to].matches('\n').count() as u32;
        // The line at `from` in the text, and the line of the text for each line that was rendered
        // so far.
        let (mut from, mut line, mut lines) = (0, 1, vec![1]);
        for edit in self.applied(text, &(0..text.len())) {
            for _ in 0..newlines(from, edit.range.start) {
                line += 1;
                lines.push(line);
            }
            // Lines that an edit adds come from the line it starts in; those that it takes are
            // skipped.
            lines.extend(edit.text.matches('\n').map(|_| line));
            line += newlines(edit.range.start, edit.range.end);
            from = edit.range.end;
            let is_start = text[..from].ends_with('\n');
            if is_start && (edit.text.is_empty() || edit.text.ends_with('\n')) {
                // Whole lines went; this one begins after them.
                lines.pop();
                lines.push(line);
            }
        }
        let rest = newlines(from, text.len());
        lines.extend((1..=rest).map(|more| line + more));
        lines
    }

    /// The byte of the text that byte `at` of its rendering comes from, or the place of the
    /// insertion that contains it.
    #[cfg(feature = "naga")]
    pub fn origin(&self, text: &str, at: usize) -> usize {
        let (mut from, mut rendered) = (0, 0);
        for edit in self.applied(text, &(0..text.len())) {
            let start = rendered + (edit.range.start - from);
            if at < start {
                break;
            }
            if at < start + edit.text.len() {
                return edit.range.start;
            }
            (from, rendered) = (edit.range.end, start + edit.text.len());
        }
        (from + (at - rendered)).min(text.len())
    }

    /// Whether byte `at` of the rendering of the text was inserted where nothing was.
    #[cfg(feature = "naga")]
    pub fn is_inserted(&self, text: &str, at: usize) -> bool {
        let (mut from, mut rendered) = (0, 0);
        for edit in self.applied(text, &(0..text.len())) {
            let start = rendered + (edit.range.start - from);
            if at < start + edit.text.len() {
                return at >= start && edit.range.is_empty();
            }
            (from, rendered) = (edit.range.end, start + edit.text.len());
        }
        false
    }

    /// The edits of a part of the text that are not inside others, in their order.
    fn applied(&self, text: &str, part: &Range<usize>) -> Vec<&TextEdit> {
        let mut inside: Vec<&TextEdit> = self
            .edits
            .range(part.start..=part.end)
            .flat_map(|(_, edits)| edits)
            .filter(|edit| edit.range.end <= part.end)
            // An insertion at the end of the part belongs to the text after it.
            .filter(|edit| edit.range.start < part.end || part.end == text.len())
            .collect();
        // Insertions come before edits that start at the same byte, wide edits before those inside.
        inside.sort_by_key(|edit| {
            (edit.range.start, !edit.range.is_empty(), !edit.lines, usize::MAX - edit.range.end)
        });
        let mut at = part.start;
        inside.retain(|edit| {
            let kept = edit.range.start >= at;
            if kept {
                at = edit.range.end;
            }
            kept
        });
        inside
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

    #[test]
    fn each_line_of_the_result_has_its_line() {
        let mut edits = Edits::default();
        edits.insert_lines(2, "new\n");
        edits.delete(4..8);
        edits.replace(9..10, "x\ny");
        let text = "a\nb\nc\nd\ne\nf";
        let rendered = edits.render(text, 0..text.len());
        assert_eq!(rendered, "a\nnew\nb\nex\nyf");
        assert_eq!(edits.lines(text), [1, 2, 2, 5, 5]);
    }

    #[cfg(feature = "naga")]
    #[test]
    fn each_byte_of_the_result_has_its_origin() {
        let mut edits = Edits::default();
        edits.insert_lines(0, "new\n");
        edits.replace(2..4, "longer");
        edits.delete(5..6);
        let text = "abcdefgh";
        let rendered = edits.render(text, 0..text.len());
        assert_eq!(rendered, "new\nablongeregh");
        for (at, byte) in rendered.bytes().enumerate() {
            let origin = edits.origin(text, at);
            let inserted = at < 4 || (6..12).contains(&at);
            assert!(inserted || text.as_bytes()[origin] == byte, "{at}");
            assert!(!(6..12).contains(&at) || origin == 2);
        }
        assert_eq!(edits.origin(text, rendered.len()), text.len());
    }
}
