//! Lines and columns of many spans: [`Files::locate`] with cached line starts.

use crate::source::{Files, Location, Span};

/// The line starts of a shader's files.
pub(super) struct Places<'a> {
    files: &'a Files,
    /// The start byte of each line, per file, computed on first use.
    lines: Vec<Option<Vec<usize>>>,
    /// The last result, to continue from: file, byte, line, column.
    last: (u32, usize, usize, u32),
}

impl<'a> Places<'a> {
    pub fn new(files: &'a Files) -> Places<'a> {
        Places { files, lines: vec![None; files.iter().count()], last: (u32::MAX, 0, 0, 0) }
    }

    /// The line and column of a span's first byte, as [`Files::locate`] returns them.
    pub fn locate(&mut self, span: Span) -> Location {
        let span = self.files.resolve(span);
        let Some(file) = self.files.get(span.file) else { return self.files.locate(span) };
        let text = file.text.as_bytes();
        let lines = self.lines[span.file as usize].get_or_insert_with(|| line_starts(text));
        let at = (span.start as usize).min(text.len());
        let line = lines.partition_point(|&start| start <= at);
        // Spans come mostly in the order of the text, many on one line: counting on from the last
        // one keeps a long line linear.
        let (last_file, last_at, last_line, last_column) = self.last;
        let (from, column) = if last_file == span.file && last_line == line && last_at <= at {
            (last_at, last_column)
        } else {
            (lines[line - 1], 1)
        };
        // Continuation bytes of UTF-8 do not start a character.
        let more = text[from..at].iter().filter(|&&b| b & 0xc0 != 0x80).count() as u32;
        self.last = (span.file, at, line, column + more);
        Location { path: file.path.clone(), line: line as u32, column: column + more }
    }
}

fn line_starts(text: &[u8]) -> Vec<usize> {
    let newlines = text.iter().enumerate().filter(|(_, b)| **b == b'\n');
    std::iter::once(0).chain(newlines.map(|(i, _)| i + 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_agree_with_the_slow_way() {
        let mut files = Files::default();
        let text = "a\r\nüb c\n\n  d\t漢字 e";
        files.add("a.frag", text.into());
        let mut places = Places::new(&files);
        let starts: Vec<u32> =
            (0..=text.len() as u32).filter(|&i| text.is_char_boundary(i as usize)).collect();
        for &start in starts.iter().chain(starts.iter().rev()) {
            let span = Span { file: 0, start, end: start };
            assert_eq!(places.locate(span), files.locate(span), "byte {start}");
        }
    }
}
