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
pub fn lanes_of(words: &[u32; LANES]) -> u64 {
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

/// Returns the numbers of the lanes of a mask, from the lowest.
#[inline(always)]
pub fn lane_numbers(mut rest: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = rest.trailing_zeros() as usize;
        // Without its lowest bit.
        rest &= rest.checked_sub(1)?;
        Some(lane)
    })
}

/// 2^52, from which to 2^53 a number's last bits are a whole number's.
const WHOLE: f64 = (1u64 << 52) as f64;

/// Returns `x as i32` by operations that are vectorised: the processor's own conversion does not
/// saturate, so the compiler converts one number after the other.
#[inline(always)]
pub fn saturated(x: f64) -> i32 {
    // NaN fails the first comparison and becomes zero; a number below the range becomes its least.
    let x = if x > f64::from(i32::MIN) { x } else { f64::from(i32::MIN) * f64::from(x <= 0.0) };
    let x = if x < f64::from(i32::MAX) { x } else { f64::from(i32::MAX) };
    // From 2^52 to 2^53 the unit in the last place is 1: the low 32 bits of the sum are the whole
    // number in two's complement. The half on top keeps negative ones in that range.
    (x.trunc() + 1.5 * WHOLE).to_bits() as i32
}

/// Returns `a / b` without its fraction, by operations that are vectorised; `a` for a division by zero.
/// A quotient below an integer is so by at least 1 / b, far more than an `f64` is rounded by.
#[inline(always)]
pub fn quotient(a: u32, b: u32) -> u32 {
    // The bits of 2^52 + n, without a conversion.
    let number = |n: u32| f64::from_bits(WHOLE.to_bits() | u64::from(n)) - WHOLE;
    let whole = ((number(a) / number(b)).floor() + WHOLE).to_bits() as u32;
    if b == 0 { a } else { whole }
}

/// Returns what a division leaves, 0 for one by zero.
#[inline(always)]
pub fn remainder(a: u32, b: u32) -> u32 {
    let rest = a.wrapping_sub(quotient(a, b).wrapping_mul(b));
    if b == 0 { 0 } else { rest }
}
