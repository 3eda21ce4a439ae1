//! Assignment of comments to declarations, of which the lexer keeps only the places.

use super::lexer::{Kind, WgslToken};
use crate::source::Span;

type Ranges = [(u32, u32)];

/// Splits the comments between the end of one declaration and the first token of the next: those
/// after the first on its own line, and those on the lines directly before the second.
// Comments belong to what they touch: those on the line where the first ends to it, a block of
// lines that ends right above the second to that. What stands between with blank lines around
// belongs to none.
pub(super) fn split<'c>(
    text: &str,
    comments: &'c Ranges,
    end: u32,
    next: WgslToken,
) -> (&'c Ranges, &'c Ranges) {
    let mut trailing = 0;
    let mut at = end;
    while trailing < comments.len() && breaks(text, at, comments[trailing].0) == 0 {
        at = comments[trailing].1;
        trailing += 1;
    }
    // `a: f32, /* of b */ b: f32`: on one line the comment is of what follows.
    let on_one_line = breaks(text, at, next.start) == 0;
    if end == 0 || (on_one_line && !matches!(next.kind, Kind::End | Kind::Sign(b'}'))) {
        trailing = 0;
    }
    let mut first = comments.len();
    let mut below = next.start;
    while first > trailing && breaks(text, comments[first - 1].1, below) <= 1 {
        first -= 1;
        below = comments[first].0;
    }
    let before = if next.kind == Kind::End { &[] } else { &comments[first..] };
    (&comments[..trailing], before)
}

/// Returns the spans of byte ranges in the shader's own file.
pub(super) fn spans(ranges: &Ranges) -> impl Iterator<Item = Span> + '_ {
    ranges.iter().map(|&(start, end)| Span { file: 0, start, end })
}

fn breaks(text: &str, from: u32, to: u32) -> usize {
    let between = text.as_bytes().get(from as usize..to as usize).unwrap_or(&[]);
    between.iter().filter(|&&b| b == b'\n').count()
}
