//! A text that is put together from parts of files, with the place of each.

use std::sync::Arc;

use super::{File, Files, Source, Span};

/// The files of a shader that was put together.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub struct Linked {
    pub(crate) files: Files,
    /// The name here of the structure that is to be laid out.
    pub(crate) structure: Option<String>,
    /// Whether all that its functions use was found.
    pub(crate) is_complete: bool,
}

impl Source {
    /// Whether functions use names that the files of its imports do not have, by its conditions or
    /// because a file is missing.
    pub fn lacks_imports(&self) -> bool {
        self.linked.as_ref().is_some_and(|linked| !linked.is_complete)
    }
}

impl Files {
    /// Returns the files of a shader that is known so far: its own, or those it was put together from.
    pub fn from_source(source: &Source) -> Files {
        match &source.linked {
            Some(linked) => linked.files.clone(),
            None => {
                let mut files = Files::default();
                files.add(source.path.clone(), source.text.clone());
                files
            }
        }
    }

    /// Sets the first file's text to one that was put together from the others.
    pub(crate) fn join(&mut self, joined: Joined) {
        let path = self.files[0].path.clone();
        self.files[0] = File::new(path, joined.text.as_str().into());
        self.joined = Some(Arc::new(joined));
    }

    /// Returns the files as they are written, without a text that was put together from them.
    pub fn written(&self) -> impl Iterator<Item = &File> {
        self.files.iter().skip(usize::from(self.joined.is_some()))
    }

    /// Returns the span in the file where its text stands.
    pub fn resolve(&self, span: Span) -> Span {
        match &self.joined {
            Some(joined) if span.file == 0 => joined.place(span),
            _ => span,
        }
    }
}

/// A text and where its parts stand.
#[derive(Clone, Debug, Default)]
pub(crate) struct Joined {
    pub(crate) text: String,
    pieces: Vec<JoinedPart>,
}

/// A part from its start to the next part's.
#[derive(Clone, Copy, Debug)]
struct JoinedPart {
    start: u32,
    from: Span,
    /// Whether it is the text of its place, byte for byte; otherwise it stands for all of it.
    is_verbatim: bool,
}

impl Joined {
    /// Adds a text that stands for a place.
    pub(crate) fn push(&mut self, text: &str, from: Span) {
        if text.is_empty() {
            return;
        }
        // As many bytes as its place: the text itself, whose bytes can be told apart. A text of a
        // place that happens to have its length is taken for it, which costs precision, not the
        // place.
        let is_verbatim = (from.end - from.start) as usize == text.len();
        let start = self.text.len() as u32;
        self.text.push_str(text);
        // Parts that follow each other in the file become one, so that lookups stay short.
        let continues = self.pieces.last().is_some_and(|last| {
            let length = start - last.start;
            is_verbatim
                && last.is_verbatim
                && last.from.file == from.file
                && last.from.start + length == from.start
        });
        match self.pieces.last_mut() {
            Some(last) if continues => last.from.end = from.end,
            _ => self.pieces.push(JoinedPart { start, from, is_verbatim }),
        }
    }

    /// Adds a part of another text.
    pub(crate) fn push_part(&mut self, other: &Joined, start: u32, end: u32) {
        // The part in which the range begins, and those after it up to its end.
        let first = other.pieces.partition_point(|piece| piece.start <= start).saturating_sub(1);
        let mut at = start;
        for (index, piece) in other.pieces.iter().enumerate().skip(first) {
            if at >= end {
                return;
            }
            let next = other.pieces.get(index + 1).map_or(other.text.len() as u32, |p| p.start);
            let to = next.min(end);
            let from = piece.place(at, to);
            self.push(&other.text[at as usize..to as usize], from);
            at = to;
        }
    }

    /// Replaces the text by one of the same length.
    pub(crate) fn with_text(self, text: String) -> Joined {
        debug_assert_eq!(self.text.len(), text.len(), "parts keep their places");
        Joined { text, ..self }
    }

    /// Returns the place of a span of the text; of its first part if it has several in other files.
    pub(crate) fn place(&self, span: Span) -> Span {
        let index = |at: u32| self.pieces.partition_point(|piece| piece.start <= at).checked_sub(1);
        let Some(first) = index(span.start) else { return span };
        let next = |at: usize| self.pieces.get(at + 1).map_or(self.text.len() as u32, |p| p.start);
        let from = self.pieces[first].place(span.start, span.end.min(next(first)));
        // Of the last part's place the end counts, if it is in the same file.
        let last = index(span.end.saturating_sub(1)).unwrap_or(first);
        if last == first {
            return from;
        }
        let end = self.pieces[last].place(self.pieces[last].start, span.end);
        from.to(end)
    }
}

impl JoinedPart {
    /// The place of a range in the piece.
    fn place(self, start: u32, end: u32) -> Span {
        if !self.is_verbatim {
            return self.from;
        }
        let at = |offset: u32| self.from.start + (offset - self.start);
        Span { start: at(start), end: at(end.max(start)), ..self.from }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(file: u32, start: u32, end: u32) -> Span {
        Span { file, start, end }
    }

    #[test]
    fn places_lead_back_through_two_texts() {
        let mut inner = Joined::default();
        inner.push("abc", span(1, 10, 13));
        inner.push("def", span(1, 13, 16));
        inner.push("long name", span(2, 5, 6));
        inner.push("xyz", span(1, 20, 23));
        let mut outer = Joined::default();
        outer.push("__", span(3, 0, 2));
        outer.push_part(&inner, 2, 17);
        assert_eq!(outer.text, "__cdeflong namexy");
        for (given, expected) in [
            (span(0, 0, 1), span(3, 0, 1)),
            (span(0, 2, 4), span(1, 12, 14)),
            (span(0, 3, 6), span(1, 13, 16)),
            (span(0, 8, 10), span(2, 5, 6)),
            (span(0, 15, 16), span(1, 20, 21)),
            (span(0, 2, 17), span(1, 12, 22)),
            (span(0, 0, 4), span(3, 0, 2)),
        ] {
            assert_eq!(outer.place(given), expected, "{given:?}");
        }
    }
}
