//! Comments that are bare numbers in columns: `// 16   // 32`, `// 0`, `// 16 - 28`.
//!
//! A bare number is a claim only in a column that a line above names, or whose numbers fit the
//! layout next to most members.

use super::checks::{Base, member, ranges};
use super::claims::{LayoutClaim, is_code, range_end};
use super::owners::Owner;
use super::tokens::{CommentNumber, Kind, Sign, has_digit, tokens};
use landfall_layout::source::Span;

/// The most columns of a table next to members.
const MAX_COLUMNS: usize = 8;

/// One number or range of a row.
#[derive(Clone, Debug)]
pub(super) struct ColumnCell {
    pub number: CommentNumber,
    pub to: Option<CommentNumber>,
}

/// The numbers next to one member.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub index: usize,
    /// 0 on the member's own line; 1 for the first line after it, and so on.
    pub step: u64,
    pub comment: Span,
    pub cells: Vec<ColumnCell>,
}

/// The cells of a comment that is nothing but numbers, and a word on the last in parentheses.
pub(super) fn cells(comment: &str) -> Option<Vec<ColumnCell>> {
    if !has_digit(comment) || is_code(comment) {
        return None;
    }
    let parts = parts(comment);
    let last = parts.len().checked_sub(1).filter(|&last| last < MAX_COLUMNS)?;
    let cell = |(at, &(start, part)): (usize, &(usize, &str))| {
        // Most comments are words, which need not be split.
        if part.starts_with(char::is_alphabetic) {
            return None;
        }
        let tokens = tokens(part);
        let Sign::Number(number) = &tokens.first()?.sign else { return None };
        let mut number = number.clone();
        let (mut to, next) = match range_end(&tokens, 1) {
            Some((to, next)) => (Some(to), next),
            None => (None, 1),
        };
        let ends = match tokens.get(next).map(|token| &token.sign) {
            None => true,
            Some(Sign::Mark('(')) => at == last,
            Some(_) => false,
        };
        // The ranges are those in the part; in the comment they begin later.
        for number in std::iter::once(&mut number).chain(&mut to) {
            number.range = number.range.start + start..number.range.end + start;
        }
        ends.then_some(ColumnCell { number, to })
    };
    parts.iter().enumerate().map(cell).collect()
}

/// The columns a comment names: `// base alignment   // aligned offset`.
pub(super) fn header(comment: &str) -> Option<Vec<Kind>> {
    let parts = parts(comment);
    if parts.len() < 2 {
        return None;
    }
    let column = |(_, part): &(usize, &str)| {
        let tokens = tokens(part);
        let number = tokens.iter().any(|token| matches!(token.sign, Sign::Number(_) | Sign::Odd));
        let mut kinds = tokens.iter().filter_map(|token| match token.sign {
            Sign::Keyword(kind) => Some(kind),
            Sign::Unit | Sign::Number(_) | Sign::Text | Sign::Mark(_) | Sign::Odd => None,
        });
        let kind = kinds.next()?;
        (!number && kinds.next().is_none()).then_some(kind)
    };
    parts.iter().map(column).collect()
}

/// The parts of a comment between `//` and `|`, with where they start.
fn parts(comment: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    let mut start = 0;
    let mut at = 0;
    while at < comment.len() {
        let rest = &comment[at..];
        let skip = match rest {
            _ if rest.starts_with("//") => 2,
            _ if rest.starts_with('|') => 1,
            _ => 0,
        };
        if skip > 0 {
            found.push((start, &comment[start..at]));
            start = at + skip;
        }
        at += skip.max(rest.chars().next().map_or(1, char::len_utf8));
    }
    found.push((start, &comment[start..]));
    found.retain(|(_, part)| !part.trim().is_empty());
    found
}

/// Returns the quantities in the columns of a structure's comments, where they can be inferred.
pub(super) fn kinds(
    owner: &Owner<'_>,
    named: Option<Vec<Kind>>,
    rows: &[Row],
) -> Vec<Option<Kind>> {
    if let Some(named) = named {
        return named.into_iter().map(Some).collect();
    }
    let columns = rows.iter().map(|row| row.cells.len()).max().unwrap_or(0);
    let offset = (0..columns).find(|&column| is_offsets(owner, column, rows));
    let kind = |column: usize| {
        if Some(column) == offset {
            return Some(Kind::Offset);
        }
        // Next to a column of offsets, one of alignments or sizes.
        offset?;
        let fits = |kind: Kind| {
            let (right, all) = tally(owner, column, rows, kind);
            (right >= 3 && right * 3 >= all * 2).then_some((right, kind))
        };
        // Of two that fit, the one that more numbers do.
        let fitting = [Kind::Size, Kind::Align].into_iter().filter_map(fits);
        fitting.max_by_key(|(right, _)| *right).map(|(_, kind)| kind)
    };
    (0..columns).map(kind).collect()
}

/// Whether a column can only be the members' offsets: its numbers rise, and enough of them fit.
fn is_offsets(owner: &Owner<'_>, column: usize, rows: &[Row]) -> bool {
    let cells: Vec<(&Row, &ColumnCell)> =
        rows.iter().filter_map(|row| Some((row, row.cells.get(column)?))).collect();
    let starts: Vec<u64> = cells.iter().map(|(_, cell)| cell.number.value).collect();
    if !starts.windows(2).all(|pair| pair[0] < pair[1]) {
        return false;
    }
    // Ranges agree by chance less often, so that fewer of them are enough.
    if cells.iter().all(|(_, cell)| cell.to.is_some()) {
        let fits = |(row, cell): &&(&Row, &ColumnCell)| {
            let said = (cell.number.value, cell.to.as_ref().map_or(0, |to| to.value));
            owner.places.iter().any(|placed| ranges(placed, row.index).contains(&said))
        };
        let right = cells.iter().filter(fits).count();
        return cells.len() >= 2 && right >= 1 && right * 3 >= cells.len();
    }
    let (right, all) = tally(owner, column, rows, Kind::Offset);
    // The first member is at 0 in any layout: that says nothing.
    let first = cells.iter().filter(|(_, cell)| cell.number.value == 0).count();
    right >= 2 + first && right * 2 >= all
}

/// Counts the cells of a column that are right under that quantity, and all cells.
fn tally(owner: &Owner<'_>, column: usize, rows: &[Row], kind: Kind) -> (usize, usize) {
    let cells = rows.iter().filter_map(|row| Some((row, row.cells.get(column)?)));
    cells.fold((0, 0), |(right, all), (row, cell)| {
        // Lines below a member's own continue its columns, and are not judged here.
        let wrong = member(owner, row.index, &claim(kind, cell), Base::Structure).is_some();
        (right + usize::from(!wrong || row.step > 0), all + 1)
    })
}

/// A cell as a claim.
pub(super) fn claim(kind: Kind, cell: &ColumnCell) -> LayoutClaim {
    LayoutClaim {
        kind,
        number: cell.number.clone(),
        to: cell.to.clone().filter(|_| kind == Kind::Offset),
        unit: true,
        keyword: true,
    }
}
