//! Suspicious bytes of a block: non-zero padding, NaN, infinity, invalid bools.

use crate::diagnostic::Code;
use std::fmt;

use super::grid::ComponentGrid;
use super::number::ComponentBits;
use crate::layout::BlockLayout;
use crate::layout::byte::{ByteOwner, owner_of_byte};
use crate::text::counts;

/// The limit on findings listed; further ones are only counted.
const MAX_FINDINGS: usize = 1000;

/// A suspicious value in a block's bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
#[non_exhaustive]
pub enum Finding {
    /// Non-zero padding: the bytes from the first to the last that is not zero, and the leaves
    /// before and after.
    Padding { offset: u64, bytes: Vec<u8>, after: Option<String>, before: Option<String> },
    /// A NaN; the path ends in its component.
    Nan { path: String, offset: u64, datum: ComponentBits },
    /// An infinite float.
    Infinite { path: String, offset: u64, datum: ComponentBits },
    /// A bool that is neither 0 nor 1; drivers differ in how they interpret it.
    OddBool { path: String, offset: u64, datum: ComponentBits },
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
                // At most 16 bytes, a `vec4`, are printed.
                write!(f, "padding at byte {offset} is not zero:")?;
                for byte in bytes.iter().take(16) {
                    write!(f, " {byte:02x}")?;
                }
                if bytes.len() > 16 {
                    write!(f, " … ({})", counts::bytes(bytes.len() as u64))?;
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

impl Findings {
    pub(super) fn push(&mut self, finding: Finding) {
        if self.list.len() < MAX_FINDINGS {
            self.list.push(finding);
        } else {
            self.more += 1;
        }
    }
}

/// Returns the finding about one component, if any.
pub(super) fn finding(
    datum: ComponentBits,
    path: &str,
    grid: &ComponentGrid,
    (column, row): (usize, usize),
    offset: u64,
) -> Option<Finding> {
    let wrong = datum.is_nan() || datum.is_infinite() || datum.is_odd_bool();
    // The path is only made for what is reported, as almost no component is.
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
