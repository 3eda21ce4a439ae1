//! The brief reports of `bench`, `render` and `stress`: the answer, in at most ten lines.

use landfall_layout::format::paint::{FAINT, Paint};

/// The most lines of a brief report.
pub(super) const LINES: usize = 10;

/// Cuts a report that is longer, and says where the rest is.
pub(super) fn cut(text: String, paint: Paint) -> String {
    if text.lines().count() <= LINES {
        return text;
    }
    let kept: String = text.split_inclusive('\n').take(LINES - 1).collect();
    kept + &paint.text(FAINT, "--details prints the rest") + "\n"
}
