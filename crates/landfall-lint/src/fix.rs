//! Applies the edits of findings to texts, leaving every byte outside an edit unchanged.
//!
//! Reads and writes no files: the command writes the results, checks them again and applies the
//! next round of edits.

use std::collections::BTreeMap;
use std::sync::Arc;

use landfall_layout::finding::{Edit, Finding};
use landfall_layout::source::{Files, Span};

/// A file with its edits applied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fixed {
    /// The path as in the findings.
    pub path: String,
    /// The text before the edits.
    pub old: Arc<str>,
    /// The text after the edits; always different.
    pub new: String,
    /// The number of edits applied.
    pub edits: usize,
}

/// Applies every edit that does not touch another, and returns the changed files sorted by path.
///
/// Earlier findings take precedence, each with all of its edits or none; findings whose edits
/// overlap an applied one are left for the next round. An edit whose bytes are no longer at its
/// line and column is skipped; an edit that two findings share is applied once. `text` is called
/// once for each file; a byte order mark at the start of a file is kept and, as in lints, not
/// counted.
pub fn apply(findings: &[Finding], text: &dyn Fn(&str) -> Option<Arc<str>>) -> Vec<Fixed> {
    let mut targets: BTreeMap<&str, Option<EditedFile<'_>>> = BTreeMap::new();
    for finding in findings {
        // An edit that is listed twice would touch itself.
        let mut edits: Vec<&Edit> = Vec::new();
        for edit in &finding.fix {
            if !edits.contains(&edit) {
                edits.push(edit);
            }
            let path = edit.at.path.as_str();
            targets
                .entry(path)
                .or_insert_with(|| text(path).map(|text| EditedFile::new(path, text)));
        }
        // All edits of a finding or none: each alone may break the code.
        let fits = edits.iter().enumerate().all(|(i, edit)| {
            let alone = edits[..i].iter().all(|other| !touch(edit, other));
            let target = targets.get(edit.at.path.as_str()).and_then(Option::as_ref);
            alone && target.is_some_and(|target| target.takes(edit))
        });
        if !fits {
            continue;
        }
        for edit in edits {
            if let Some(Some(target)) = targets.get_mut(edit.at.path.as_str()) {
                target.put(edit);
            }
        }
    }
    targets.into_values().flatten().filter_map(EditedFile::fixed).collect()
}

const BYTE_ORDER_MARK: char = '\u{feff}';

/// A file and the edits to apply to it.
struct EditedFile<'a> {
    /// The whole file.
    old: Arc<str>,
    /// The text without a byte order mark.
    files: Files,
    /// The edits by their first byte; an insertion comes before a replacement at the same byte.
    edits: BTreeMap<(u32, u32), &'a Edit>,
}

impl<'a> EditedFile<'a> {
    fn new(path: &str, text: Arc<str>) -> EditedFile<'a> {
        let mut files = Files::default();
        let seen = match text.strip_prefix(BYTE_ORDER_MARK) {
            Some(rest) => rest.into(),
            None => Arc::clone(&text),
        };
        files.add(path, seen);
        EditedFile { old: text, files, edits: BTreeMap::new() }
    }

    fn text(&self) -> &str {
        &self.files.get(0).expect("added when the target was made").text
    }

    /// Returns whether an edit matches this text and touches no edit of other findings.
    fn takes(&self, edit: &Edit) -> bool {
        let place = &edit.at;
        let (start, end) = (place.start, place.end);
        let text = self.text();
        // `get` refuses a range that divides a character.
        let inside = start <= end && text.get(start as usize..end as usize).is_some();
        let at = |start: u32| {
            let found = self.files.locate(Span { file: 0, start, end: start });
            (found.line, found.column)
        };
        // In a text that has changed, these bytes are at another line or column.
        let stays = inside
            && at(start) == (place.line, place.column)
            && at(end) == (place.end_line, place.end_column);
        // Accepted edits do not touch one another, so only the nearest on either side can touch it.
        let before = self.edits.range(..=(start, u32::MAX)).next_back();
        let after = self.edits.range((start, 0)..).next();
        let near = before.into_iter().chain(after).map(|(_, other)| *other);
        stays && near.into_iter().all(|other| other == edit || !touch(edit, other))
    }

    fn put(&mut self, edit: &'a Edit) {
        let Edit { at: place, new } = edit;
        // An edit that changes nothing is not counted.
        if self.text()[place.start as usize..place.end as usize] != **new {
            self.edits.insert((place.start, place.end), edit);
        }
    }

    fn fixed(self) -> Option<Fixed> {
        if self.edits.is_empty() {
            return None;
        }
        let text = self.text();
        let mut new = String::with_capacity(self.old.len());
        if text.len() < self.old.len() {
            new.push(BYTE_ORDER_MARK);
        }
        let mut at = 0;
        for edit in self.edits.values() {
            new.push_str(&text[at..edit.at.start as usize]);
            new.push_str(&edit.new);
            at = edit.at.end as usize;
        }
        new.push_str(&text[at..]);
        let path = self.files.get(0)?.path.clone();
        let EditedFile { old, edits, .. } = self;
        (*new != *old).then_some(Fixed { path, old, new, edits: edits.len() })
    }
}

/// Returns whether two edits touch: they share a byte, or one is an insertion where the other
/// begins or ends.
fn touch(a: &Edit, b: &Edit) -> bool {
    let (a, b) = (&a.at, &b.at);
    if a.path != b.path {
        return false;
    }
    if a.start == a.end || b.start == b.end {
        return a.start <= b.end && b.start <= a.end;
    }
    a.start < b.end && b.start < a.end
}
