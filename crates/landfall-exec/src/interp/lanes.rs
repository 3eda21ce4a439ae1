//! The values of a scalar in all lanes, as the machine's registers hold them.

use super::code::LANES;

/// The values of a scalar in all lanes.
pub(super) trait Lanes: Copy + Send + Sync + std::fmt::Debug {
    /// The value of one lane.
    type Item: Copy;
    /// Returns lanes that hold the same value.
    fn filled(value: Self::Item) -> Self;
    fn lane(&self, lane: usize) -> Self::Item;
    fn put(&mut self, lane: usize, value: Self::Item);
    /// Sets every lane to a function of its number. It is called once for each part of a value, and
    /// what the part does not need is dropped by the compiler.
    fn set(&mut self, value: impl Fn(usize) -> Self::Item);
    /// Copies the lanes of a mask of all-ones words.
    fn blend(&mut self, from: &Self, mask: &[u32; LANES]);
    fn each(&self) -> impl Iterator<Item = Self::Item> {
        (0..LANES).map(|lane| self.lane(lane))
    }
}

impl<T: Copy + Send + Sync + std::fmt::Debug> Lanes for [T; LANES] {
    type Item = T;
    #[inline(always)]
    fn filled(value: T) -> [T; LANES] {
        [value; LANES]
    }
    #[inline(always)]
    fn lane(&self, lane: usize) -> T {
        self[lane]
    }
    #[inline(always)]
    fn put(&mut self, lane: usize, value: T) {
        self[lane] = value;
    }
    #[inline(always)]
    fn set(&mut self, value: impl Fn(usize) -> T) {
        for (lane, to) in self.iter_mut().enumerate() {
            *to = value(lane);
        }
    }
    #[inline(always)]
    fn blend(&mut self, from: &[T; LANES], mask: &[u32; LANES]) {
        for lane in 0..LANES {
            self[lane] = if mask[lane] != 0 { from[lane] } else { self[lane] };
        }
    }
}
