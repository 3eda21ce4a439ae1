//! The roundings that make intervals enclosures, each of which tests can turn round to see that
//! samples then lie outside.

/// A rounding of the bounds of intervals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outward {
    /// Of a lower bound to an `f32`.
    SingleLow,
    /// Of an upper bound to an `f32`.
    SingleHigh,
    /// Of a lower bound by a permitted error.
    PermittedLow,
    /// Of a sum in `f64`, down.
    Sum,
    /// Of a product in `f64`, down.
    Product,
    /// Of a quotient in `f64`, down.
    Quotient,
    /// Of the rest of an affine form, up.
    Rest,
}

#[cfg(test)]
thread_local! {
    static REVERSED: std::cell::Cell<Option<Outward>> = const { std::cell::Cell::new(None) };
}

impl Outward {
    /// Whether it goes the wrong way, in a test.
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

/// Runs something with a rounding the wrong way.
#[cfg(test)]
pub(super) fn with_reversed<T>(which: Outward, run: impl FnOnce() -> T) -> T {
    REVERSED.set(Some(which));
    let result = run();
    REVERSED.set(None);
    result
}
