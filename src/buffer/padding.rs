//! What looks wrong in the bytes of a block: padding that is not zero, NaN, infinity, odd bools.

use std::fmt;

use super::decode::Decoded;
use super::grid::Grid;
use super::number::Datum;
use crate::layout::{BlockLayout, MemberLayout};

/// Findings listed in full; beyond, they are counted.
const MOST_FINDINGS: usize = 1000;

/// Something that looks wrong in a block's bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Finding {
    /// Padding that is not zero: the bytes from the first to the last that is not, and the leaves
    /// before and after it.
    Padding { offset: u64, bytes: Vec<u8>, after: Option<String>, before: Option<String> },
    /// A float that is not a number; the path ends in its component.
    Nan { path: String, offset: u64, datum: Datum },
    /// An infinite float.
    Infinite { path: String, offset: u64, datum: Datum },
    /// A bool that is neither 0 nor 1: drivers differ in what they make of it.
    OddBool { path: String, offset: u64, datum: Datum },
}

impl Finding {
    /// The first byte it is about.
    pub fn offset(&self) -> u64 {
        match self {
            Finding::Padding { offset, .. }
            | Finding::Nan { offset, .. }
            | Finding::Infinite { offset, .. }
            | Finding::OddBool { offset, .. } => *offset,
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Finding::Padding { offset, bytes, after, before } => {
                write!(f, "padding at byte {offset} is not zero:")?;
                for byte in bytes.iter().take(16) {
                    write!(f, " {byte:02x}")?;
                }
                if bytes.len() > 16 {
                    write!(f, " … ({} bytes)", bytes.len())?;
                }
                match (after, before) {
                    (Some(after), Some(before)) => write!(f, ", between `{after}` and `{before}`"),
                    (Some(after), None) => write!(f, ", after `{after}`"),
                    (None, Some(before)) => write!(f, ", before `{before}`"),
                    (None, None) => Ok(()),
                }
            }
            Finding::Nan { path, offset, datum } => {
                write!(f, "`{path}` at byte {offset} is not a number: {datum}")
            }
            Finding::Infinite { path, offset, datum } => {
                write!(f, "`{path}` at byte {offset} is infinite: {datum}")
            }
            Finding::OddBool { path, offset, datum } => {
                write!(f, "`{path}` at byte {offset} is a bool, but neither 0 nor 1: {datum}")
            }
        }
    }
}

/// All that looks wrong in a block's bytes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Findings {
    /// The first thousand, in order of their offsets.
    pub list: Vec<Finding>,
    /// How many more there are.
    pub more: usize,
}

/// Looks through the bytes of a block.
pub(crate) fn find(decoded: &Decoded<'_>) -> Findings {
    let mut used = vec![0u64; decoded.bytes.len() / 64 + 1];
    let mut found = Findings::default();
    decoded.for_each(|element| {
        let grid = element.grid;
        for (datum, (column, row)) in element.cells.iter().zip(grid.cells()) {
            let offset = element.offset + grid.component(column, row) as u64;
            for byte in offset as usize..offset as usize + usize::from(grid.scalar.width) {
                used[byte / 64] |= 1 << (byte % 64);
            }
            if let Some(finding) = finding(*datum, element.path, &grid, (column, row), offset) {
                found.push(finding);
            }
        }
    });
    let is_used = |byte: usize| used[byte / 64] & 1 << (byte % 64) != 0;
    let mut at = 0;
    while at < decoded.bytes.len() {
        if is_used(at) {
            at += 1;
            continue;
        }
        let end = (at..decoded.bytes.len()).find(|&b| is_used(b)).unwrap_or(decoded.bytes.len());
        let hole = &decoded.bytes[at..end];
        if let Some(first) = hole.iter().position(|&byte| byte != 0) {
            let last = hole.iter().rposition(|&byte| byte != 0).unwrap_or(first);
            let name = |byte: Option<usize>| name_at(decoded.block, byte? as u64);
            found.push(Finding::Padding {
                offset: (at + first) as u64,
                bytes: hole[first..=last].to_vec(),
                after: name(at.checked_sub(1)),
                before: name(Some(end).filter(|&end| end < decoded.bytes.len())),
            });
        }
        at = end;
    }
    found.list.sort_by_key(Finding::offset);
    found
}

impl Findings {
    fn push(&mut self, finding: Finding) {
        if self.list.len() < MOST_FINDINGS {
            self.list.push(finding);
        } else {
            self.more += 1;
        }
    }
}

/// What looks wrong with one component.
fn finding(
    datum: Datum,
    path: &str,
    grid: &Grid,
    (column, row): (usize, usize),
    offset: u64,
) -> Option<Finding> {
    let wrong = datum.is_nan() || datum.is_infinite() || datum.is_odd_bool();
    let path = wrong.then(|| match (grid.columns, grid.rows) {
        (1, 1) => path.to_string(),
        (1, _) => format!("{path}.{}", ["x", "y", "z", "w"][row]),
        _ => format!("{path}[{column}].{}", ["x", "y", "z", "w"][row]),
    })?;
    Some(if datum.is_nan() {
        Finding::Nan { path, offset, datum }
    } else if datum.is_infinite() {
        Finding::Infinite { path, offset, datum }
    } else {
        Finding::OddBool { path, offset, datum }
    })
}

/// The path of the leaf that a byte of the block belongs to; `None` for padding.
pub(crate) fn name_at(block: &BlockLayout, byte: u64) -> Option<String> {
    let mut path = String::new();
    name_in(&block.members, byte, &mut path).then_some(path)
}

/// Adds the path of the leaf below `members` that a byte from their start belongs to.
fn name_in(members: &[MemberLayout], byte: u64, path: &mut String) -> bool {
    let before = path.len();
    for member in members {
        let Some(mut rest) = member.offset.and_then(|offset| byte.checked_sub(offset)) else {
            continue;
        };
        if member.size.is_some_and(|size| rest >= size) {
            continue;
        }
        if before > 0 {
            path.push('.');
        }
        path.push_str(&member.name);
        for stride in member.strides.iter().map(|&stride| stride.max(1)) {
            path.push_str(&format!("[{}]", rest / stride));
            rest %= stride;
        }
        let inside = match Grid::of_member(member) {
            Some(grid) => rest < grid.span() as u64,
            None => name_in(&member.members, rest, path),
        };
        if inside {
            return true;
        }
        path.truncate(before);
    }
    false
}
