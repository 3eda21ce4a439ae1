//! The old and the new block side by side, or one above the other if that is too wide.

use unicode_width::UnicodeWidthStr;

use crate::format::paint::{ADDED, FAINT, REMOVED};
use crate::format::{Paint, phrases};
use crate::layout::measure::element_size;
use crate::layout::padding::{MemberOrGap, PaddingOwner, in_text_order};
use crate::layout::{BlockLayout, MemberLayout};
use crate::shape::{AddressSpace, Type};
use crate::source::Language;

/// The available width.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// The columns of a terminal.
    Columns(usize),
    /// A unified diff, as of `diff -u`.
    Unified,
}

impl Width {
    pub(super) fn less(self, columns: usize) -> Width {
        match self {
            Width::Columns(all) => Width::Columns(all.saturating_sub(columns)),
            Width::Unified => Width::Unified,
        }
    }
}

/// The number of rows of context around a change.
const AROUND: usize = 2;

/// The most rows of a block that is aligned row by row.
const MAX_ROWS: usize = 2000;

#[derive(Clone, PartialEq, Eq)]
struct ListingRow {
    /// The key that matches rows of both sides: a member's path, or the one before padding.
    key: String,
    offset: Option<u64>,
    size: Option<u64>,
    text: String,
}

/// Renders two blocks side by side, with unchanged rows only near changes.
pub fn side_by_side(
    old: Option<(&BlockLayout, Language)>,
    new: Option<(&BlockLayout, Language)>,
    width: Width,
    paint: Paint,
) -> String {
    let rows = |side: Option<(&BlockLayout, Language)>| {
        side.map(|(block, language)| rows(block, language)).unwrap_or_default()
    };
    let (old, new) = (rows(old), rows(new));
    let digits = |of: fn(&ListingRow) -> Option<u64>| {
        let longest = old.iter().chain(&new).filter_map(of).max();
        longest.map_or(0, |n| n.to_string().len())
    };
    let widths = (digits(|row| row.offset), digits(|row| row.size));
    let cells =
        |rows: &[ListingRow]| rows.iter().map(|row| cell(row, widths)).collect::<Vec<String>>();
    let (left, right) = (cells(&old), cells(&new));
    let pairs = align(&old, &new);
    let differs: Vec<bool> = pairs
        .iter()
        .map(|pair| match *pair {
            (Some(a), Some(b)) => old[a] != new[b],
            (Some(_), None) | (None, Some(_)) | (None, None) => true,
        })
        .collect();
    let shown = |i: usize| {
        let near = i.saturating_sub(AROUND)..(i + AROUND + 1).min(pairs.len());
        differs[near].contains(&true)
    };
    let widest = left.iter().map(|cell| cell.width()).max().unwrap_or(0);
    // Three columns between the sides: the mark, with a blank on either side of it.
    let total = widest + 3 + right.iter().map(|cell| cell.width()).max().unwrap_or(0);
    let columns = match width {
        Width::Columns(room) if total <= room => Some(widest),
        Width::Columns(_) | Width::Unified => None,
    };
    let mut text = String::new();
    // New rows of a change, which follow all of its old ones.
    let mut held: Vec<String> = Vec::new();
    let mut skipped = false;
    for (i, pair) in pairs.iter().enumerate() {
        if !shown(i) {
            skipped = true;
            continue;
        }
        let (a, b) = (pair.0.map(|a| left[a].as_str()), pair.1.map(|b| right[b].as_str()));
        match columns {
            Some(widest) => {
                if std::mem::take(&mut skipped) {
                    text.push_str(&paint.text(FAINT, "…\n"));
                }
                text.push_str(&one_line((a, b), differs[i], widest, paint));
            }
            None => {
                if std::mem::take(&mut skipped) {
                    // New rows that are held belong before the gap.
                    text.extend(held.drain(..));
                    text.push_str(&paint.text(FAINT, "  …\n"));
                }
                if !differs[i] {
                    text.extend(held.drain(..));
                    text.push_str(&format!("  {}\n", a.unwrap_or("")));
                    continue;
                }
                // All old rows of a change come before the new ones.
                if let Some(a) = a {
                    text.push_str(&paint.text(REMOVED, &format!("- {a}")));
                    text.push('\n');
                }
                held.extend(b.map(|b| format!("{}\n", paint.text(ADDED, &format!("+ {b}")))));
            }
        }
    }
    text.extend(held);
    text
}

fn one_line(
    (a, b): (Option<&str>, Option<&str>),
    differs: bool,
    widest: usize,
    paint: Paint,
) -> String {
    let mark = match (a, b) {
        (Some(_), Some(_)) if differs => '|',
        (Some(_), None) => '<',
        (None, Some(_)) => '>',
        (Some(_), Some(_)) | (None, None) => ' ',
    };
    let left = a.unwrap_or("");
    let room = " ".repeat(widest - left.width());
    let (left, right) = match differs {
        true => (paint.text(REMOVED, left), paint.text(ADDED, b.unwrap_or(""))),
        false => (left.to_string(), b.unwrap_or("").to_string()),
    };
    let line = format!("{left}{room} {mark} {right}");
    format!("{}\n", line.trim_end())
}

fn cell(row: &ListingRow, (offset, size): (usize, usize)) -> String {
    let number = |n: Option<u64>, width: usize| match n {
        Some(n) => format!("{n:>width$}"),
        None => " ".repeat(width),
    };
    // Loose uniforms have neither offsets nor sizes.
    if offset == 0 && size == 0 {
        return row.text.clone();
    }
    format!("{} {}  {}", number(row.offset, offset), number(row.size, size), row.text)
}

/// Pairs the rows of both sides: a longest common subsequence by key, and the rows between in
/// order.
fn align(old: &[ListingRow], new: &[ListingRow]) -> Vec<(Option<usize>, Option<usize>)> {
    let mut pairs = Vec::new();
    let (mut a, mut b) = (0, 0);
    for (next_a, next_b) in common(old, new).into_iter().chain([(old.len(), new.len())]) {
        while a < next_a || b < next_b {
            pairs.push(((a < next_a).then_some(a), (b < next_b).then_some(b)));
            (a, b) = ((a + 1).min(next_a), (b + 1).min(next_b));
        }
        // The last pair is the end of both sides, not a pair of rows.
        if next_a < old.len() {
            pairs.push((Some(next_a), Some(next_b)));
            (a, b) = (next_a + 1, next_b + 1);
        }
    }
    pairs
}

/// The longest common subsequence of keys.
fn common(old: &[ListingRow], new: &[ListingRow]) -> Vec<(usize, usize)> {
    if old.len() > MAX_ROWS || new.len() > MAX_ROWS {
        return Vec::new();
    }
    let (n, m) = (old.len(), new.len());
    // Entry (i, j) is the length of the longest common subsequence from row i and row j on, filled
    // from the end. At most 2000 rows fit `u16`, and the table 8 MB.
    let mut longest = vec![0u16; (n + 1) * (m + 1)];
    for i in (0..n).rev() {
        for j in (0..m).rev() {
            longest[i * (m + 1) + j] = if old[i].key == new[j].key {
                longest[(i + 1) * (m + 1) + j + 1] + 1
            } else {
                longest[(i + 1) * (m + 1) + j].max(longest[i * (m + 1) + j + 1])
            };
        }
    }
    // The way through the table along the longest lengths.
    let mut found = Vec::new();
    let (mut i, mut j) = (0, 0);
    while i < n && j < m {
        if old[i].key == new[j].key {
            found.push((i, j));
            (i, j) = (i + 1, j + 1);
        } else if longest[(i + 1) * (m + 1) + j] >= longest[i * (m + 1) + j + 1] {
            i += 1;
        } else {
            j += 1;
        }
    }
    found
}

fn rows(block: &BlockLayout, language: Language) -> Vec<ListingRow> {
    let mut head = phrases::block_name(block);
    if block.space != AddressSpace::Default {
        head.push_str(&format!(" {}", block.rules.name()));
    }
    let slot = phrases::slot(block, language);
    if !slot.is_empty() {
        head.push_str(&format!(" {slot}"));
    }
    head.push_str(&phrases::dims(&block.count));
    let head = ListingRow { key: "(block)".into(), offset: None, size: block.size, text: head };
    let mut rows = vec![head];
    let base = (block.space != AddressSpace::Default).then_some(0);
    Rows { block, language }.members(&block.members, (base, block.size), "", &mut rows);
    rows
}

struct Rows<'a> {
    block: &'a BlockLayout,
    language: Language,
}

impl Rows<'_> {
    /// Adds rows for members, which start at a byte of the block, and for their padding.
    fn members(
        &self,
        members: &[MemberLayout],
        (base, whole): (Option<u64>, Option<u64>),
        parent: &str,
        rows: &mut Vec<ListingRow>,
    ) {
        // One level for each structure that the path goes through, and one for the block.
        let indent = "  ".repeat(parent.matches('.').count() + 1);
        for one in in_text_order(members, whole) {
            let member = match one {
                MemberOrGap::Member(member) => member,
                MemberOrGap::Gap(gap) => {
                    let what = phrases::padding(gap.kind, PaddingOwner::Block, None);
                    let after = gap.after.map_or("", |after| &members[after].name);
                    rows.push(ListingRow {
                        key: format!("{parent}{after} (padding)"),
                        offset: base.map(|base| base + gap.offset),
                        size: Some(gap.size),
                        text: format!("{indent}-- {what}"),
                    });
                    continue;
                }
            };
            let offset = base.zip(member.offset).map(|(base, offset)| base + offset);
            let path = format!("{parent}{}", member.name);
            rows.push(ListingRow {
                key: path.clone(),
                offset,
                size: member.size,
                text: indent.clone() + &self.declaration(member),
            });
            if let Type::Struct(_) = member.ty.innermost() {
                let whole = offset.map(|_| element_size(member, self.block.rules));
                self.members(&member.members, (offset, whole), &format!("{path}."), rows);
            }
        }
    }

    fn declaration(&self, member: &MemberLayout) -> String {
        let mut text = match self.language {
            Language::Glsl | Language::SpirV => {
                let ty = phrases::type_name(&member.ty, self.language);
                format!("{ty} {}{}", member.name, phrases::dims(&member.dims))
            }
            Language::Wgsl => format!("{}: {}", member.name, member.ty.spelled(self.language)),
        };
        if !member.strides.is_empty() {
            let strides: Vec<String> = member.strides.iter().map(u64::to_string).collect();
            text.push_str(&format!(" stride {}", strides.join(", ")));
        }
        if let Some(stride) = member.matrix_stride {
            let vectors = if member.row_major { "rows" } else { "columns" };
            text.push_str(&format!(" {vectors} {stride}"));
        }
        text
    }
}
