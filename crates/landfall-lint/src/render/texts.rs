//! The texts of the files in findings, and the bytes of lines and columns in them.
//!
//! If a file has changed or vanished since the check, there is no excerpt.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::ReportOptions;
use landfall_layout::finding::{Finding, Place};
use landfall_layout::source::{Files, Span};

pub(super) struct Texts<'a> {
    pub files: Files,
    by_path: FxHashMap<&'a str, u32>,
}

impl<'a> Texts<'a> {
    pub fn new(findings: &[&'a Finding], options: &ReportOptions<'_>) -> Texts<'a> {
        let mut texts = Texts { files: Files::default(), by_path: FxHashMap::default() };
        let mut asked = rustc_hash::FxHashSet::default();
        for finding in findings {
            let related = finding.related().iter().map(|related| &related.at);
            for place in std::iter::once(finding.place()).chain(related) {
                // Each file is asked for once, whether it is there or not.
                if place.line == 0 || !asked.insert(place.path.as_str()) {
                    continue;
                }
                if let Some(text) = (options.text)(&place.path) {
                    // Places do not count a byte-order mark.
                    let text = text.strip_prefix('\u{feff}').map_or(Arc::clone(&text), Arc::from);
                    let file = texts.files.add(place.path.clone(), text);
                    texts.by_path.insert(&place.path, file);
                }
            }
        }
        texts
    }

    /// The byte range of a place in its text, if the text still has it.
    pub fn span(&self, place: &Place) -> Option<Span> {
        if place.line == 0 {
            return None;
        }
        let file = *self.by_path.get(place.path.as_str())?;
        let text = &self.files.get(file)?.text;
        let bytes = Span { file, start: place.start, end: place.end };
        // The bytes count only if they still are at this line and column.
        let found = place.start <= place.end
            && place.end as usize <= text.len()
            && text.is_char_boundary(place.start as usize)
            && text.is_char_boundary(place.end as usize)
            && self.is_at(bytes, place);
        if found {
            return Some(bytes);
        }
        // Bytes are zero where only line and column are known.
        if (place.start, place.end) != (0, 0) {
            return None;
        }
        let start = byte(text, place.line, place.column)?;
        let end = byte(text, place.end_line, place.end_column).unwrap_or(start);
        Some(Span { file, start, end: end.max(start) })
    }

    fn is_at(&self, span: Span, place: &Place) -> bool {
        let from = self.files.locate(span);
        (from.line, from.column) == (place.line, place.column)
    }
}

/// Returns the byte at a line and column.
fn byte(text: &str, line: u32, column: u32) -> Option<u32> {
    let line = (line as usize).checked_sub(1)?;
    let column = (column as usize).checked_sub(1)?;
    let mut start = 0;
    for _ in 0..line {
        start += text[start..].find('\n')? + 1;
    }
    let here = text[start..].split('\n').next().unwrap_or("");
    // A column may be one past the last character.
    let ends = here.char_indices().map(|(i, _)| i).chain([here.len()]);
    u32::try_from(start + ends.into_iter().nth(column)?).ok()
}
