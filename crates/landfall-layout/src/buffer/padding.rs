//! Suspicious bytes of a block: non-zero padding, NaN, infinity, invalid bools.

use crate::diagnostic::Code;
use std::fmt;

use super::decode::Decoded;
use super::grid::Grid;
use super::number::Datum;
use crate::layout::BlockLayout;
use crate::layout::byte::{ByteOwner, owner_of_byte};

/// The limit on findings listed; further ones are only counted.
const MOST_FINDINGS: usize = 1000;

/// A suspicious value in a block's bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
#[non_exhaustive]
pub enum Finding {
    /// Non-zero padding: the bytes from the first to the last that is not zero, and the leaves
    /// before and after.
    Padding { offset: u64, bytes: Vec<u8>, after: Option<String>, before: Option<String> },
    /// A NaN; the path ends in its component.
    Nan { path: String, offset: u64, datum: Datum },
    /// An infinite float.
    Infinite { path: String, offset: u64, datum: Datum },
    /// A bool that is neither 0 nor 1; drivers differ in how they interpret it.
    OddBool { path: String, offset: u64, datum: Datum },
}

impl Finding {
    /// Returns the diagnostic code.
    pub fn code(&self) -> Code {
        match self {
            Finding::Padding { .. } => Code::NonzeroPadding,
            Finding::Nan { .. } => Code::NotANumber,
            Finding::Infinite { .. } => Code::Infinite,
            Finding::OddBool { .. } => Code::OddBool,
        }
    }

    /// Offset of the first byte of the finding.
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

/// All suspicious values in a block's bytes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Findings {
    /// The first thousand, by offset.
    pub list: Vec<Finding>,
    /// Number of further findings.
    pub more: usize,
}

/// Finds suspicious values in the selected part of a block's bytes.
pub(crate) fn find(decoded: &Decoded<'_>) -> Findings {
    let mut used = vec![0u64; decoded.bytes.len() / 64 + 1];
    let mut found = Findings::default();
    decoded.for_each_of_block(|element| {
        for (column, row) in element.grid.cells() {
            let offset = element.offset as usize + element.grid.component(column, row);
            for byte in offset..offset + usize::from(element.grid.scalar.width) {
                used[byte / 64] |= 1 << (byte % 64);
            }
        }
    });
    decoded.for_each(|element| {
        let grid = element.grid;
        for (datum, (column, row)) in element.cells.iter().zip(grid.cells()) {
            let offset = element.offset + grid.component(column, row) as u64;
            if let Some(finding) = finding(*datum, element.path, &grid, (column, row), offset) {
                found.push(finding);
            }
        }
    });
    let is_used = |byte: usize| used[byte / 64] & 1 << (byte % 64) != 0;
    let range = decoded.range();
    let mut at = range.start;
    while at < range.end {
        if is_used(at) {
            at += 1;
            continue;
        }
        let end = (at..range.end).find(|&byte| is_used(byte)).unwrap_or(range.end);
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

/// Returns the finding about one component, if any.
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

/// Returns the path of the leaf that owns a byte of the block; `None` for padding.
pub(crate) fn name_at(block: &BlockLayout, byte: u64) -> Option<String> {
    match owner_of_byte(block, byte) {
        ByteOwner::Component { leaf, .. } => Some(leaf),
        ByteOwner::Padding { .. } | ByteOwner::Beyond { .. } | ByteOwner::Loose => None,
    }
}
