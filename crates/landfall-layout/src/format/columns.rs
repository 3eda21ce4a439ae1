//! Table rows: text aligned left, numbers right; and wrapped text.
//!
//! Used by the tables of `landfall devices`, `landfall lights` and `landfall rule`.

use unicode_width::UnicodeWidthStr as _;

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

/// Wraps text at spaces to lines of at most `width` columns; a longer word has a line of its own.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("never empty");
        if !line.is_empty() && line.width() + 1 + word.width() > width {
            lines.push(word.to_string());
            continue;
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    lines
}
