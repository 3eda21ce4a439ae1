//! The source lines shown with a finding, bounded in number and length.

use std::ops::Range;

use crate::diagnostic::Label;
use crate::format::place::Places;
use crate::source::{Files, Location};

/// The most characters of a line shown around a label; shorter lines are shown whole.
const WINDOW: usize = 160;

/// The characters shown before the label in a truncated line.
const BEFORE: usize = 60;

/// The most lines between two labels of one file that share an excerpt.
const APART: u32 = 10_000;

/// A part of one file, with marks.
#[derive(Debug)]
pub(super) struct Excerpt {
    /// The file.
    pub path: String,
    /// The line number of the text's first line, from 1.
    pub first_line: u32,
    /// Its lines; lines without marks are empty.
    pub text: String,
    pub marks: Vec<ExcerptMark>,
    /// The marks in truncated lines.
    pub cuts: Vec<TruncationMark>,
    /// Labels that did not fit, to be written as notes.
    pub elsewhere: Vec<String>,
}

/// A marked range of an excerpt's text.
#[derive(Debug)]
pub(super) struct ExcerptMark {
    pub range: Range<usize>,
    pub text: String,
    pub primary: bool,
}

/// A mark in a truncated line.
#[derive(Debug)]
pub(super) struct TruncationMark {
    pub at: Location,
    /// Its column in the truncated line.
    pub shown_column: usize,
}

/// A label with its line.
struct PlacedLabel<'a> {
    label: &'a Label,
    at: Location,
    primary: bool,
}

/// The excerpts of a finding's labels, in order; `main` is the index of the main label.
pub(super) fn excerpts(
    labels: &[Label],
    main: Option<usize>,
    files: &Files,
    places: &mut Places<'_>,
) -> Vec<Excerpt> {
    let resolved = |label: &Label| Label { at: files.resolve(label.at), text: label.text.clone() };
    let labels: Vec<Label> = labels.iter().map(resolved).collect();
    let mut groups: Vec<Vec<PlacedLabel<'_>>> = Vec::new();
    for (i, label) in labels.iter().enumerate() {
        if files.get(label.at.file).is_none() {
            continue;
        }
        let placed = PlacedLabel { label, at: places.locate(label.at), primary: main == Some(i) };
        // Labels of one file share an excerpt unless they are far apart.
        let near = groups.iter_mut().find(|group| {
            group[0].label.at.file == label.at.file
                && group[0].at.line.abs_diff(placed.at.line) <= APART / 2
        });
        match near {
            Some(group) => group.push(placed),
            None => groups.push(vec![placed]),
        }
    }
    groups.iter().map(|group| excerpt(group, files)).collect()
}

fn excerpt(group: &[PlacedLabel<'_>], files: &Files) -> Excerpt {
    let first_line = group.iter().map(|p| p.at.line).min().unwrap_or(1);
    let last_line = group.iter().map(|p| p.at.line).max().unwrap_or(1);
    let mut result = Excerpt {
        path: group[0].at.path.clone(),
        first_line,
        text: String::new(),
        marks: Vec::new(),
        cuts: Vec::new(),
        elsewhere: Vec::new(),
    };
    // Lines without labels stay empty, and are folded when they are shown.
    for line in first_line..=last_line {
        let here: Vec<&PlacedLabel<'_>> = group.iter().filter(|p| p.at.line == line).collect();
        if let Some(first) = here.first() {
            let text = files.get(first.label.at.file).map_or("", |file| &file.text);
            push_line(text, &here, &mut result);
        }
        result.text.push('\n');
    }
    result
}

/// Adds the line of the labels, truncated to a window if it is long.
fn push_line(text: &str, here: &[&PlacedLabel<'_>], result: &mut Excerpt) {
    let at = |p: &PlacedLabel<'_>| boundary(text, p.label.at.start as usize);
    // The first label of the line decides which part of it is shown.
    let anchor = at(here[0]);
    let start = text[..anchor].rfind('\n').map_or(0, |i| i + 1);
    let end = text[anchor..].find('\n').map_or(text.len(), |i| anchor + i);
    let end = if text[start..end].ends_with('\r') { end - 1 } else { end };
    let window = window(text, start..end, anchor.min(end));
    let line_start = result.text.len();
    if window.start > start {
        result.text.push('…');
    }
    let shift = result.text.len();
    result.text.push_str(&text[window.clone()]);
    if window.end < end {
        result.text.push('…');
    }
    for placed in here {
        let from = at(placed).min(end);
        let to = boundary(text, placed.label.at.end as usize).clamp(from, end.max(from));
        if from < window.start || from > window.end {
            let Location { path, line, column } = &placed.at;
            let text = &placed.label.text;
            let text = if text.is_empty() { "and here" } else { text };
            result.elsewhere.push(format!("{text}: {path}:{line}:{column}"));
            continue;
        }
        // Bytes of the file become bytes of the excerpt.
        let range = from - window.start + shift..to.min(window.end) - window.start + shift;
        if window.start > start {
            let shown_column = result.text[line_start..range.start].chars().count() + 1;
            result.cuts.push(TruncationMark { at: placed.at.clone(), shown_column });
        }
        result.marks.push(ExcerptMark {
            range,
            text: placed.label.text.clone(),
            primary: placed.primary,
        });
    }
}

/// The part of a line that is shown for a label at `anchor`.
fn window(text: &str, line: Range<usize>, anchor: usize) -> Range<usize> {
    // In characters, not bytes: a short line of wide characters is shown whole.
    if text[line.clone()].chars().nth(WINDOW).is_none() {
        return line;
    }
    let start = text[line.start..anchor]
        .char_indices()
        .rev()
        .nth(BEFORE - 1)
        .map_or(line.start, |(i, _)| line.start + i);
    let end = text[start..line.end].char_indices().nth(WINDOW).map_or(line.end, |(i, _)| start + i);
    start..end
}

/// The last character boundary at or before `at`.
fn boundary(text: &str, at: usize) -> usize {
    let at = at.min(text.len());
    (0..=at).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0)
}
