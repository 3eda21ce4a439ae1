//! Texts with the positions of the protocol: line and character, from 0, in the units that the client
//! counts in.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use gen_lsp_types::{Position, PositionEncodingKind, Range as LspRange};

/// The units of a position's `character`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PositionEncoding {
    /// Bytes.
    Utf8,
    /// Code units of UTF-16, which every client knows.
    #[default]
    Utf16,
    /// Characters.
    Utf32,
}

impl PositionEncoding {
    /// The encoding that costs least of those a client offers.
    pub fn chosen(offered: &[PositionEncodingKind]) -> PositionEncoding {
        let offers = |kind: &PositionEncodingKind| offered.contains(kind);
        match () {
            () if offers(&PositionEncodingKind::UTF8) => PositionEncoding::Utf8,
            () if offers(&PositionEncodingKind::UTF32) => PositionEncoding::Utf32,
            () => PositionEncoding::Utf16,
        }
    }

    pub fn kind(self) -> PositionEncodingKind {
        match self {
            PositionEncoding::Utf8 => PositionEncodingKind::UTF8,
            PositionEncoding::Utf16 => PositionEncodingKind::UTF16,
            PositionEncoding::Utf32 => PositionEncodingKind::UTF32,
        }
    }

    fn units(self, c: char) -> usize {
        match self {
            PositionEncoding::Utf8 => c.len_utf8(),
            PositionEncoding::Utf16 => c.len_utf16(),
            PositionEncoding::Utf32 => 1,
        }
    }
}

/// A text whose lines are found once, and edited in place.
#[derive(Clone, Debug)]
pub struct LineText {
    text: String,
    /// The same for those who keep it.
    shared: OnceLock<Arc<str>>,
    encoding: PositionEncoding,
    starts: OnceLock<Vec<usize>>,
}

const BYTE_ORDER_MARK: char = '\u{feff}';

impl LineText {
    pub fn new(text: impl Into<String>, encoding: PositionEncoding) -> LineText {
        let (shared, starts) = (OnceLock::new(), OnceLock::new());
        LineText { text: text.into(), shared, encoding, starts }
    }

    pub fn text(&self) -> &str {
        &self.text
    }

    /// The text without a byte-order mark, as spans of the layout count it.
    pub fn plain(&self) -> &str {
        &self.text[self.mark()..]
    }

    pub fn shared(&self) -> Arc<str> {
        Arc::clone(self.shared.get_or_init(|| self.text.as_str().into()))
    }

    /// Bytes before those that spans of the layout count: of a byte-order mark.
    fn mark(&self) -> usize {
        if self.text.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len_utf8() } else { 0 }
    }

    /// The starts of the lines, which end with `\n`, `\r\n` or `\r`.
    fn starts(&self) -> &[usize] {
        self.starts.get_or_init(|| {
            std::iter::once(0).chain(starts_behind(&self.text, 0..self.text.len())).collect()
        })
    }

    /// The byte of a position in the whole text. One past the end of a line or of the text is that end.
    pub fn byte(&self, position: Position) -> usize {
        let starts = self.starts();
        let line = position.line as usize;
        let Some(&start) = starts.get(line) else { return self.text.len() };
        let end = starts.get(line + 1).copied().unwrap_or(self.text.len());
        let content = self.text[start..end].trim_end_matches(['\n', '\r']);
        let mut units = position.character as usize;
        for (at, c) in content.char_indices() {
            let own = self.encoding.units(c);
            if units < own {
                return start + at;
            }
            units -= own;
        }
        start + content.len()
    }

    /// The byte of a position as spans of the layout count it.
    pub fn offset(&self, position: Position) -> u32 {
        self.byte(position).saturating_sub(self.mark()) as u32
    }

    /// The position of a byte as spans of the layout count it.
    pub fn position(&self, offset: u32) -> Position {
        let mut byte = (offset as usize + self.mark()).min(self.text.len());
        while !self.text.is_char_boundary(byte) {
            byte -= 1;
        }
        let starts = self.starts();
        let line = starts.partition_point(|&start| start <= byte) - 1;
        let before = self.text[starts[line]..byte].chars();
        let character: usize = before.map(|c| self.encoding.units(c)).sum();
        Position { line: line as u32, character: character as u32 }
    }

    /// The end of the text.
    pub fn end(&self) -> Position {
        self.position(self.plain().len() as u32)
    }

    pub fn range(&self, span: Range<u32>) -> LspRange {
        LspRange { start: self.position(span.start), end: self.position(span.end) }
    }

    /// Replaces a range; the lines before and behind it are not looked for again.
    pub fn replace(&mut self, range: LspRange, new: &str) {
        let start = self.byte(range.start);
        let end = self.byte(range.end).max(start);
        self.text.replace_range(start..end, new);
        self.shared = OnceLock::new();
        let Some(starts) = self.starts.get_mut() else { return };
        // Whether a `\r` before the range ends a line is told by what is behind it.
        let changed = start.saturating_sub(1)..start + new.len();
        let first = starts.partition_point(|&at| at <= changed.start);
        let behind = starts.partition_point(|&at| at <= end);
        starts[behind..].iter_mut().for_each(|at| *at = *at - end + start + new.len());
        starts.splice(first..behind, starts_behind(&self.text, changed));
    }

    /// The word of letters, digits and `_` that a byte of a span is in or directly behind.
    pub fn word(&self, offset: u32) -> Option<Range<u32>> {
        let mark = self.mark();
        let at = (offset as usize + mark).min(self.text.len());
        let is_part = |c: char| c == '_' || c.is_alphanumeric();
        let before = self.text.get(..at)?;
        let start = before
            .rfind(|c| !is_part(c))
            .map_or(0, |last| last + before[last..].chars().next().map_or(0, char::len_utf8));
        let after = &self.text[at..];
        let end = at + after.find(|c| !is_part(c)).unwrap_or(after.len());
        (start < end).then(|| (start - mark.min(start)) as u32..(end - mark) as u32)
    }

    /// The part of the text that a span of the layout covers.
    pub fn slice(&self, span: Range<u32>) -> &str {
        let mark = self.mark();
        self.text.get(span.start as usize + mark..span.end as usize + mark).unwrap_or_default()
    }
}

/// The starts of lines whose ends are in a range of bytes.
fn starts_behind(text: &str, range: Range<usize>) -> impl Iterator<Item = usize> {
    let bytes = text.as_bytes();
    let is_end = |at: &usize| match bytes[*at] {
        b'\n' => true,
        b'\r' => bytes.get(at + 1) != Some(&b'\n'),
        _ => false,
    };
    range.filter(is_end).map(|at| at + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(line: u32, character: u32) -> Position {
        Position { line, character }
    }

    #[test]
    fn columns_behind_an_emoji_count_the_units_of_the_encoding() {
        let text = "a\r\n\u{1f4a1}b\rc";
        for (encoding, b) in [
            (PositionEncoding::Utf8, 4),
            (PositionEncoding::Utf16, 2),
            (PositionEncoding::Utf32, 1),
        ] {
            let text = LineText::new(text, encoding);
            assert_eq!(text.offset(at(1, b)), 7, "{encoding:?}");
            assert_eq!(text.position(7), at(1, b), "{encoding:?}");
            assert_eq!(text.position(9), at(2, 0), "a lone carriage return ends a line");
        }
    }

    #[test]
    fn a_position_past_an_end_is_that_end() {
        let text = LineText::new("ab\ncd", PositionEncoding::Utf16);
        assert_eq!(text.byte(at(0, 99)), 2);
        assert_eq!(text.byte(at(9, 0)), 5);
        assert_eq!(text.position(99), at(1, 2));
        let cut = LineText::new("\u{1f4a1}", PositionEncoding::Utf16);
        assert_eq!(cut.byte(at(0, 1)), 0, "inside a surrogate pair");
    }

    #[test]
    fn spans_do_not_count_a_byte_order_mark() {
        let text = LineText::new("\u{feff}ab c", PositionEncoding::Utf16);
        assert_eq!(text.position(0), at(0, 1));
        assert_eq!(text.offset(at(0, 1)), 0);
        assert_eq!(text.word(1), Some(0..2));
        assert_eq!(text.slice(0..2), "ab");
    }

    #[test]
    fn the_lines_after_an_edit_are_those_of_the_new_text() {
        let before = "a\r\nb\rc\n\r\nd";
        let pieces = ["", "\n", "\r", "\r\n", "x", "\nx\r"];
        for start in 0..=before.len() {
            for end in start..=before.len() {
                for new in pieces {
                    let mut text = LineText::new(before, PositionEncoding::Utf8);
                    let (from, to) = (text.position(start as u32), text.position(end as u32));
                    let (start, end) = (text.byte(from), text.byte(to));
                    text.replace(LspRange { start: from, end: to }, new);
                    let expected = [&before[..start], new, &before[end.max(start)..]].concat();
                    assert_eq!(text.text(), expected);
                    let fresh = LineText::new(expected, PositionEncoding::Utf8);
                    assert_eq!(text.starts(), fresh.starts(), "{:?}", text.text());
                }
            }
        }
    }
}
