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
    /// Copies some lanes.
    fn blend(&mut self, from: &Self, lanes: u64);
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
    fn blend(&mut self, from: &[T; LANES], lanes: u64) {
        let (low, high) = self.split_at_mut(LANES / 2);
        let (from_low, from_high) = from.split_at(LANES / 2);
        blend_half(low, from_low, lanes as u32);
        blend_half(high, from_high, (lanes >> (LANES / 2)) as u32);
    }
}

/// Copies some of half the lanes. Both numbers are read whatever the lane: that is vectorised.
#[inline(always)]
fn blend_half<T: Copy>(to: &mut [T], from: &[T], lanes: u32) {
    for lane in 0..LANES / 2 {
        let (old, new) = (to[lane], from[lane]);
        to[lane] = if lanes >> lane & 1 == 1 { new } else { old };
    }
}

/// Returns the lanes of the words whose last bit is 1.
#[inline(always)]
pub(super) fn lanes_of(words: &[u32; LANES]) -> u64 {
    let mut bytes = [0; LANES];
    for (byte, word) in bytes.iter_mut().zip(words) {
        *byte = (word & 1) as u8;
    }
    let mut lanes = 0;
    for (i, chunk) in bytes.chunks_exact(8).enumerate() {
        let chunk = u64::from_le_bytes(chunk.try_into().expect("a chunk has eight bytes"));
        // Each bit is shifted to its place in the highest byte; no two meet.
        let byte = chunk.wrapping_mul(0x0102_0408_1020_4080) >> 56;
        lanes |= byte << (8 * i);
    }
    lanes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_are_those_of_the_last_bits() {
        let mut rng = fastrand::Rng::with_seed(3);
        for _ in 0..1000 {
            let words = [0; LANES].map(|_| rng.u32(..));
            let lanes = lanes_of(&words);
            assert!((0..LANES).all(|lane| lanes >> lane & 1 == u64::from(words[lane] & 1)));
        }
    }
}
