//! The lines of text a finding shows: few, and short, whatever the file is like.

use std::ops::Range;

use crate::diagnostic::Label;
use crate::format::place::Places;
use crate::source::{Files, Location};

/// Characters of a line that are shown around a label; shorter lines are shown whole.
const WINDOW: usize = 160;

/// Characters shown before the label in a line that is cut.
const BEFORE: usize = 60;

/// Lines apart that two labels of one file may be to share an excerpt.
const APART: u32 = 10_000;

/// A piece of one file with marks.
#[derive(Debug)]
pub(super) struct Excerpt {
    /// The file.
    pub path: String,
    /// Number of the text's first line, from 1.
    pub first_line: u32,
    /// Its lines; those nothing is marked in are empty.
    pub text: String,
    pub marks: Vec<Mark>,
    /// Marks in lines that were cut.
    pub cuts: Vec<Cut>,
    /// What did not fit: to be written as notes.
    pub elsewhere: Vec<String>,
}

/// A marked range of an excerpt's text.
#[derive(Debug)]
pub(super) struct Mark {
    pub range: Range<usize>,
    pub text: String,
    pub primary: bool,
}

/// A mark in a line that was cut.
#[derive(Debug)]
pub(super) struct Cut {
    pub at: Location,
    /// Its column in what is left of the line.
    pub shown_column: usize,
}

/// A label with its line.
struct Placed<'a> {
    label: &'a Label,
    at: Location,
    primary: bool,
}

/// The excerpts of a finding's labels, in their order; `main` is the index of the main one.
pub(super) fn excerpts(
    labels: &[Label],
    main: Option<usize>,
    files: &Files,
    places: &mut Places<'_>,
) -> Vec<Excerpt> {
    let mut groups: Vec<Vec<Placed<'_>>> = Vec::new();
    for (i, label) in labels.iter().enumerate() {
        if files.get(label.span.file).is_none() {
            continue;
        }
        let placed = Placed { label, at: places.locate(label.span), primary: main == Some(i) };
        let near = groups.iter_mut().find(|group| {
            group[0].label.span.file == label.span.file
                && group[0].at.line.abs_diff(placed.at.line) <= APART / 2
        });
        match near {
            Some(group) => group.push(placed),
            None => groups.push(vec![placed]),
        }
    }
    groups.iter().map(|group| excerpt(group, files)).collect()
}

fn excerpt(group: &[Placed<'_>], files: &Files) -> Excerpt {
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
    for line in first_line..=last_line {
        let here: Vec<&Placed<'_>> = group.iter().filter(|p| p.at.line == line).collect();
        if let Some(first) = here.first() {
            let text = files.get(first.label.span.file).map_or("", |file| &file.text);
            push_line(text, &here, &mut result);
        }
        result.text.push('\n');
    }
    result
}

/// Adds the line the labels stand on, cut to a window when it is long.
fn push_line(text: &str, here: &[&Placed<'_>], result: &mut Excerpt) {
    let at = |p: &Placed<'_>| boundary(text, p.label.span.start as usize);
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
        let to = boundary(text, placed.label.span.end as usize).clamp(from, end.max(from));
        if from < window.start || from > window.end {
            let Location { path, line, column } = &placed.at;
            let text = &placed.label.text;
            let text = if text.is_empty() { "and here" } else { text };
            result.elsewhere.push(format!("{text}: {path}:{line}:{column}"));
            continue;
        }
        let range = from - window.start + shift..to.min(window.end) - window.start + shift;
        if window.start > start {
            let shown_column = result.text[line_start..range.start].chars().count() + 1;
            result.cuts.push(Cut { at: placed.at.clone(), shown_column });
        }
        result.marks.push(Mark { range, text: placed.label.text.clone(), primary: placed.primary });
    }
}

/// The part of a line that is shown when the label starts at `anchor`.
fn window(text: &str, line: Range<usize>, anchor: usize) -> Range<usize> {
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

/// The nearest place between characters at or before `at`.
fn boundary(text: &str, at: usize) -> usize {
    let at = at.min(text.len());
    (0..=at).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0)
}
