//! Numbers that stand in the same place of several members' comments, whatever the words around them
//! and their language: `смещение 16`, `[16, 28)`, `+0x10`, `12 + 4 = 16`, `floats 4..6`.
//!
//! What they count is inferred from the layout: a column is one of offsets, ends, sizes or
//! alignments, in bytes or in floats, only if most of its numbers, or most of the steps between
//! them, are those of the layout. Used by [`stale_comment`](super).

use super::claims::is_code;
use super::owners::{Owner, PlacedComment, element_size, end_of};
use super::tokens::{CommentNumber, Kind};
use landfall_layout::source::Span;

/// The most numbers of a comment that are read.
const MAX_NUMBERS: usize = 6;

/// A comment on a member's line.
#[derive(Clone, Copy)]
pub(super) struct Line<'t> {
    pub index: usize,
    pub comment: Span,
    pub text: &'t str,
}

/// A number, and what stands before it since the number before.
struct NumberCell {
    number: CommentNumber,
    mark: String,
    /// Whether it counts floats.
    floats: bool,
}

/// What a column counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColumnQuantity {
    Offset,
    /// One past the last byte, and the last byte; with the padding behind it or without.
    End,
    PaddedEnd,
    Last,
    PaddedLast,
    Size,
    Align,
}

const QUANTITIES: &[ColumnQuantity] = &[
    ColumnQuantity::Offset,
    ColumnQuantity::End,
    ColumnQuantity::PaddedEnd,
    ColumnQuantity::Last,
    ColumnQuantity::PaddedLast,
    ColumnQuantity::Size,
    ColumnQuantity::Align,
];

impl ColumnQuantity {
    fn of(self, placed: &PlacedComment<'_>, index: usize) -> Option<u64> {
        let member = &placed.members[index];
        match self {
            ColumnQuantity::Offset => member.offset,
            ColumnQuantity::End => Some(end_of(member)),
            ColumnQuantity::PaddedEnd => Some(placed.next(index)),
            ColumnQuantity::Last => end_of(member).checked_sub(1),
            ColumnQuantity::PaddedLast => placed.next(index).checked_sub(1),
            ColumnQuantity::Size => member.size,
            ColumnQuantity::Align => member.align,
        }
    }

    /// Returns the number that a comment states, in units of so many bytes.
    fn stated(self, placed: &PlacedComment<'_>, index: usize, unit: u64) -> Option<u64> {
        let value = self.of(placed, index)?;
        match self {
            // The last of several floats.
            ColumnQuantity::Last | ColumnQuantity::PaddedLast => {
                ((value + 1) / unit).checked_sub(1)
            }
            _ if value.is_multiple_of(unit) => Some(value / unit),
            _ => None,
        }
    }

    fn rises(self) -> bool {
        !matches!(self, ColumnQuantity::Size | ColumnQuantity::Align)
    }

    pub fn kind(self) -> Kind {
        match self {
            ColumnQuantity::Align => Kind::Align,
            ColumnQuantity::Size => Kind::Size,
            _ => Kind::Offset,
        }
    }
}

/// A number that is wrong, and the right one.
pub(super) struct Wrong {
    pub index: usize,
    pub comment: Span,
    pub number: CommentNumber,
    pub right: u64,
    pub quantity: ColumnQuantity,
    /// The bytes of one unit: 1, or 4 where floats are counted.
    pub unit: u64,
}

/// Returns the wrong numbers of a structure's comments, in the order of the text.
pub(super) fn wrong(owner: &Owner<'_>, lines: &[Line<'_>]) -> Vec<Wrong> {
    // Where a structure is laid out in several ways, a number may be right in one of them.
    let [placed] = owner.places.as_slice() else { return Vec::new() };
    let rows: Vec<(Line<'_>, Vec<NumberCell>)> = lines
        .iter()
        .filter(|line| !is_code(line.text))
        .map(|line| (*line, cells(line.text)))
        .collect();
    // A column is told by its place and by the sign or word before its numbers.
    let mut columns: Vec<(usize, &str)> = Vec::new();
    for (_, cells) in &rows {
        for (at, cell) in cells.iter().enumerate() {
            if !columns.contains(&(at, &cell.mark)) && columns.len() < MAX_COLUMNS {
                columns.push((at, &cell.mark));
            }
        }
    }
    let mut found = Vec::new();
    // Sizes and alignments are told from other numbers by the offsets beside them.
    let mut beside = false;
    for (at, mark) in columns {
        let column: Vec<(Line<'_>, &CommentNumber)> = rows
            .iter()
            .filter_map(|(line, cells)| {
                Some((*line, &cells.get(at).filter(|cell| cell.mark == mark)?.number))
            })
            .collect();
        let numbers: Vec<(usize, u64)> =
            column.iter().map(|(line, number)| (line.index, number.value)).collect();
        // A table has a number for most members that have a comment.
        if numbers.len() < 3 || numbers.len() * 3 < lines.len() * 2 {
            continue;
        }
        let floats = rows.iter().filter_map(|(_, cells)| cells.get(at)).all(|cell| cell.floats);
        let Some((quantity, unit)) = read_as(placed, &numbers, floats, beside) else { continue };
        beside |= quantity.rises();
        for (line, number) in column {
            let Some(right) = quantity.stated(placed, line.index, unit) else { continue };
            if right != number.value && !is_slot(placed, line.index, quantity, number.value * unit)
            {
                let number = number.clone();
                let Line { index, comment, .. } = line;
                found.push(Wrong { index, comment, number, right, quantity, unit });
            }
        }
    }
    found.sort_by_key(|wrong| (wrong.comment.start, wrong.number.range.start));
    found
}

/// The most columns of a structure's comments.
const MAX_COLUMNS: usize = 16;

/// Returns whether a size may include the padding behind the member, or be an element's.
fn is_slot(placed: &PlacedComment<'_>, index: usize, quantity: ColumnQuantity, bytes: u64) -> bool {
    let member = &placed.members[index];
    let padded = member.offset.and_then(|offset| placed.next(index).checked_sub(offset));
    quantity == ColumnQuantity::Size
        && (padded == Some(bytes) || element_size(member, placed.rules) == bytes)
}

/// Returns what a column counts, and the bytes of a unit; `None` if it may count something else.
fn read_as(
    placed: &PlacedComment<'_>,
    numbers: &[(usize, u64)],
    floats: bool,
    beside: bool,
) -> Option<(ColumnQuantity, u64)> {
    let unit = if floats { 4 } else { 1 };
    let mut best: Option<(usize, ColumnQuantity)> = None;
    for &quantity in QUANTITIES {
        let told = match quantity {
            ColumnQuantity::Size => beside || floats,
            ColumnQuantity::Align => beside,
            _ => true,
        };
        let Some(score) = score(placed, numbers, quantity, unit).filter(|_| told) else { continue };
        if best.is_none_or(|(most, _)| score > most) {
            best = Some((score, quantity));
        }
    }
    best.map(|(_, quantity)| (quantity, unit))
}

/// Returns how well a column fits a quantity; `None` if too few of its numbers do.
fn score(
    placed: &PlacedComment<'_>,
    numbers: &[(usize, u64)],
    quantity: ColumnQuantity,
    unit: u64,
) -> Option<usize> {
    let stated = |index: usize| quantity.stated(placed, index, unit);
    let fits = |index: usize, value: u64| {
        stated(index) == Some(value) || is_slot(placed, index, quantity, value * unit)
    };
    let right = numbers.iter().filter(|(index, value)| fits(*index, *value)).count();
    // A 0 fits by chance.
    let telling = |&&(index, value): &&(usize, u64)| value > 0 && stated(index) == Some(value);
    let nonzero = numbers.iter().filter(telling).count();
    if !quantity.rises() {
        // The same number for every member may be anything.
        let mut values: Vec<u64> = numbers.iter().filter(telling).map(|row| row.1).collect();
        values.sort_unstable();
        values.dedup();
        return (right >= 3 && right * 3 >= numbers.len() * 2 && values.len() > 1).then_some(right);
    }
    // A typing error may break one step; an index or a default value breaks more.
    let falls = numbers.windows(2).filter(|pair| pair[0].1 >= pair[1].1).count();
    let first = numbers[0].1;
    if falls > usize::from(numbers.len() > 3) || (first == 0 && quantity != ColumnQuantity::Offset)
    {
        return None;
    }
    let most = right + 1 >= numbers.len() || (right >= 3 && right * 2 >= numbers.len());
    if nonzero >= 2 && most {
        return Some(right);
    }
    // A member without such a comment was inserted: the numbers are those without it.
    let old = without_others(placed, numbers, quantity, unit)?;
    let still = numbers.iter().zip(&old).filter(|((_, said), old)| said == *old).count();
    // Equal steps are those of an index.
    let differ = old.windows(2).map(|pair| pair[1].checked_sub(pair[0]));
    let mut steps: Vec<Option<u64>> = differ.collect();
    steps.sort_unstable();
    steps.dedup();
    (falls == 0 && still >= 3 && still + 1 >= numbers.len() && steps.len() > 1).then_some(still)
}

/// Returns the numbers that a column would have if the block had no other members.
fn without_others(
    placed: &PlacedComment<'_>,
    numbers: &[(usize, u64)],
    quantity: ColumnQuantity,
    unit: u64,
) -> Option<Vec<u64>> {
    let mut offsets = Vec::with_capacity(numbers.len());
    let mut end = 0u64;
    // Laid out anew, without what is between them.
    for (index, _) in numbers {
        let member = &placed.members[*index];
        let offset = end.checked_next_multiple_of(member.align?)?;
        end = offset.checked_add(member.size?)?;
        offsets.push((offset, end));
    }
    let last = offsets.last().map(|(_, end)| *end)?;
    let next = |at: usize| offsets.get(at + 1).map_or(last, |(offset, _)| *offset);
    let value = |at: usize| match quantity {
        ColumnQuantity::Offset => Some(offsets[at].0 / unit),
        ColumnQuantity::End => Some(offsets[at].1 / unit),
        ColumnQuantity::PaddedEnd => Some(next(at) / unit),
        ColumnQuantity::Last => (offsets[at].1 / unit).checked_sub(1),
        ColumnQuantity::PaddedLast => (next(at) / unit).checked_sub(1),
        ColumnQuantity::Size | ColumnQuantity::Align => None,
    };
    (0..offsets.len()).map(value).collect()
}

/// The words that say that floats are counted.
const COUNTED: &[&str] = &["float", "dword", "word", "f32"];

/// Returns the number of floats or vectors that a comment begins with, and the bytes of one.
pub(super) fn count(comment: &str) -> Option<(CommentNumber, u64)> {
    let cell = cells(comment).into_iter().next()?;
    let behind = comment[cell.number.range.end..].trim_start();
    let word = behind.split(|c: char| !c.is_alphanumeric()).next().unwrap_or("");
    let bytes = match (word, cell.mark.as_str()) {
        ("floats" | "words" | "dwords" | "f32s", "") => 4,
        ("vec4s", "") => 16,
        // `}; // = 48`
        ("", "=") if behind.is_empty() => 1,
        (_, _) => return None,
    };
    Some((cell.number, bytes))
}

/// Returns the numbers of a comment with what stands before each.
fn cells(comment: &str) -> Vec<NumberCell> {
    let mut found: Vec<NumberCell> = Vec::new();
    let (mut at, mut last) = (0, 0);
    while let Some(start) = comment[at..].find(|c: char| c.is_ascii_digit()).map(|to| at + to) {
        let rest = &comment[start..];
        let hex = rest.strip_prefix("0x").or_else(|| rest.strip_prefix("0X"));
        let (digits, radix, skip) = hex.map_or((rest, 10, 0), |digits| (digits, 16, 2));
        let length = digits.find(|c: char| !c.is_digit(radix)).unwrap_or(digits.len());
        let end = start + skip + length;
        let before = comment[..start].chars().next_back();
        let after = comment[end..].chars().next();
        let second = comment[end..].chars().nth(1);
        // `v2` and `#3` are names; an arrow may stand before a number.
        let joined = before
            .is_some_and(|c| c.is_alphanumeric() || matches!(c, '_' | '#' | '$' | '<' | '>'))
            && !comment[..start].ends_with("->")
            && !comment[..start].ends_with("=>");
        // `-3`, but not the end of `16-28`.
        let negative = before == Some('-')
            && !comment[..start - 1].trim_end().ends_with(|c: char| c.is_ascii_hexdigit());
        // `50%`, `4x4`, `2*3`, `1.5`.
        let part = after.is_some_and(|c| c.is_alphanumeric() || matches!(c, '%' | '_' | '*'))
            || matches!(after, Some('.' | ',')) && second.is_some_and(|c| c.is_ascii_digit())
            || before == Some('.') && !comment[..start].ends_with("..");
        let value = u64::from_str_radix(&digits[..length], radix).ok();
        match value.filter(|_| !joined && !negative && !part) {
            Some(value) if found.len() < MAX_NUMBERS => {
                let number = CommentNumber { value, range: start..end, hex: skip > 0 };
                let before = &comment[last..start];
                let behind = comment[end..].trim_start();
                // The end of a range counts what its start does.
                let goes_on = found.last().is_some_and(|cell| {
                    cell.floats && !before.contains(|c: char| c.is_alphabetic() || c == ',')
                });
                let floats = goes_on
                    || COUNTED.iter().any(|word| before.contains(word) || behind.starts_with(word));
                found.push(NumberCell { number, mark: mark(before), floats });
                last = end;
            }
            // What is no whole number is text; a comment with such numbers is no table.
            Some(_) | None => return found,
        }
        at = end;
    }
    found
}

/// Returns what tells a column: the sign before a number, or the word.
fn mark(before: &str) -> String {
    let before = before.trim_start_matches(['/', '*', '!', '<']).trim();
    let word = |text: &str| {
        let text = text.trim_end();
        let start = text
            .rfind(|c: char| !c.is_alphabetic())
            .map_or(0, |at| at + text[at..].chars().next().map_or(1, char::len_utf8));
        text[start..].to_lowercase()
    };
    match before.chars().next_back() {
        None => String::new(),
        Some(sign @ (':' | '：')) => {
            format!("{}{sign}", word(&before[..before.len() - sign.len_utf8()]))
        }
        Some(sign) if sign.is_alphabetic() => word(before),
        Some(sign) => sign.to_string(),
    }
}
