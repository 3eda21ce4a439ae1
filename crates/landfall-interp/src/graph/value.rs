//! The possible values of a node over a box.

use super::super::interval::Interval;
use super::fault::Faults;

/// The arithmetic whose results the values of a graph enclose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Arithmetic {
    /// The values of every conformant device, for the expressions as written.
    #[default]
    Permitted,
    /// The exact real numbers.
    Exact,
    /// At a point: one value, rounded to the nearest `f32` after each operation.
    Nearest,
}

/// The values of an operation over its operands, and the faults possible there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Applied {
    pub value: Interval,
    pub faults: Faults,
}

pub(super) fn without_fault(value: Interval) -> Applied {
    Applied { value, faults: Faults::NONE }
}
