//! Outward rounding of interval bounds. Tests reverse one rounding at a time and check that samples
//! then lie outside of the bounds.

/// A rounding of the bounds of intervals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outward {
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

#[cfg(test)]
thread_local! {
    static REVERSED: std::cell::Cell<Option<Outward>> = const { std::cell::Cell::new(None) };
}

impl Outward {
    /// Whether a test has reversed it.
    #[cfg(test)]
    pub fn is_reversed(self) -> bool {
        REVERSED.get() == Some(self)
    }

    #[cfg(not(test))]
    #[inline(always)]
    pub fn is_reversed(self) -> bool {
        false
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
#[cfg(test)]
pub(super) fn with_reversed<T>(which: Outward, run: impl FnOnce() -> T) -> T {
    REVERSED.set(Some(which));
    let result = run();
    REVERSED.set(None);
    result
}
