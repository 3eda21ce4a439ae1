//! Table rows: text aligned left, numbers right; and wrapped text.

use std::borrow::Cow;

use anstyle::Style;
use unicode_width::UnicodeWidthStr as _;

use super::paint::{FAINT, Paint};

/// The separator of two columns.
pub const GAP: &str = "  ";
/// Width in columns that tables and wrapped text keep to where they can.
pub const WIDTH: usize = 80;

/// Formats one row. Columns from index `numbers` on are aligned right; `paint` gets the column
/// index and the cell.
pub fn row(
    cells: &[String],
    widths: &[usize],
    numbers: usize,
    paint: impl Fn(usize, &str) -> String,
) -> String {
    let mut text = String::new();
    for (at, (cell, width)) in cells.iter().zip(widths).enumerate() {
        let space = " ".repeat(width.saturating_sub(cell.width()));
        if at > 0 {
            text.push_str(GAP);
        }
        if at >= numbers {
            text.push_str(&space);
        }
        text.push_str(&paint(at, cell));
        if at < numbers {
            text.push_str(&space);
        }
    }
    let end = text.trim_end().len();
    text.truncate(end);
    text.push('\n');
    text
}

/// The separator of the facts of a heading.
const AND: &str = " · ";

/// Joins the facts of a heading; those that do not fit the width go on in further lines.
pub fn heading(facts: &[(Style, String)], paint: Paint) -> String {
    let mut text = String::new();
    let mut end = 0;
    for (nth, (style, fact)) in facts.iter().enumerate() {
        if nth > 0 && end + AND.width() + fact.width() > WIDTH {
            text.push_str("\n    ");
            end = 4;
        } else if nth > 0 {
            text.push_str(&paint.text(FAINT, AND));
            end += AND.width();
        }
        text.push_str(&paint.text(*style, fact));
        end += fact.width();
    }
    text.push('\n');
    text
}

/// Returns cells, with their widths, behind `taken` columns of a line; in lines of their own where
/// they do not all fit.
pub fn cells_behind(cells: &[(String, usize)], taken: usize, indent: usize) -> String {
    let whole: usize = cells.iter().map(|(_, width)| GAP.len() + width).sum();
    // If they do not all fit, the line counts as full, so that the first of them begins a new one.
    let mut end = if taken + whole <= WIDTH { taken } else { WIDTH };
    let mut text = String::new();
    for (cell, width) in cells {
        if end + GAP.len() + width > WIDTH {
            text.push('\n');
            text.push_str(&" ".repeat(indent));
            end = indent + width;
        } else {
            text.push_str(GAP);
            end += GAP.len() + width;
        }
        text.push_str(cell);
    }
    text
}

/// Wraps text at spaces to lines of at most `width` columns; a longer word has a line of its own.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    let mut end = 0;
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("never empty");
        let wide = unpainted(word).width();
        if !line.is_empty() && end + 1 + wide > width {
            lines.push(word.to_string());
            end = wide;
            continue;
        }
        if !line.is_empty() {
            line.push(' ');
            end += 1;
        }
        line.push_str(word);
        end += wide;
    }
    lines
}

/// A text without colours.
pub fn unpainted(text: &str) -> Cow<'_, str> {
    let Some((before, rest)) = text.split_once('\x1b') else { return Cow::Borrowed(text) };
    let mut plain = before.to_string();
    for part in rest.split('\x1b') {
        plain.push_str(part.split_once('m').map_or("", |(_, rest)| rest));
    }
    Cow::Owned(plain)
}
