//! Table rows: text aligned left, numbers right.
//!
//! Used by the tables of `landfall devices` and `landfall lights`.

use unicode_width::UnicodeWidthStr as _;

/// The separator of two columns.
pub const GAP: &str = "  ";

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
