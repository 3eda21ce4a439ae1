//! Outward rounding of interval bounds. Tests reverse one rounding at a time and check that samples
//! then lie outside of the bounds.

use std::cell::Cell;

/// A rounding of the bounds of intervals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outward {
    /// A lower bound to an `f32`.
    SingleLow,
    /// An upper bound to an `f32`.
    SingleHigh,
    /// A lower bound by a permitted error.
    PermittedLow,
    /// A sum in `f64`, down.
    Sum,
    /// A product in `f64`, down.
    Product,
    /// A quotient in `f64`, down.
    Quotient,
    /// The rest of an affine form, up.
    Rest,
}

thread_local! {
    static REVERSED: Cell<Option<Outward>> = const { Cell::new(None) };
}

impl Outward {
    /// Whether a test has reversed it; never in a release.
    #[inline(always)]
    pub fn is_reversed(self) -> bool {
        cfg!(debug_assertions) && REVERSED.get() == Some(self)
    }

    /// Returns an `f64` rounded to nearest, or its neighbour below if it lost `lost` upward.
    #[inline(always)]
    pub fn below(self, rounded: f64, lost: f64) -> f64 {
        if self.is_reversed() {
            return if lost > 0.0 { rounded.next_up() } else { rounded };
        }
        if lost < 0.0 { rounded.next_down() } else { rounded }
    }
}

/// Runs a closure with one rounding reversed.
pub fn with_reversed<T>(which: Outward, run: impl FnOnce() -> T) -> T {
    REVERSED.set(Some(which));
    let result = run();
    REVERSED.set(None);
    result
}
