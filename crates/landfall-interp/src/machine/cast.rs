//! Conversions. A float outside an integer's range becomes the nearest integer in it, NaN becomes 0
//! (WGSL §15.7.6); a 64-bit integer loses its high bits.

use super::super::code::{Cast, LANES};
use super::super::lanes::{Lanes, saturated};
use super::super::real::Real;
use super::float::frexp;
use super::kernel::map1;
use super::{Machine, apart, column, column_mut};

fn half(bits: u32) -> f32 {
    half::f16::from_bits(bits as u16).to_f32()
}

impl<R: Real> Machine<'_, '_, R> {
    #[inline(always)]
    pub(super) fn cast(&mut self, cast: Cast, operands: &[u32]) {
        for group in operands.chunks_exact(2) {
            let [to, from] = [group[0], group[1]];
            // Close to a whole number, one that is less exact is truncated to another integer.
            if R::PERMITTED && matches!(cast, Cast::RealToSint | Cast::RealToUint) {
                for (lane, x) in column(&self.reals, from).each().enumerate() {
                    self.unsure |= u64::from(x.unsure_whole()) << lane & self.active;
                }
            }
            match cast {
                Cast::RealToSint => self.real_word(to, from, |x| saturated(x.whole()) as u32),
                Cast::RealToUint => self.real_word(to, from, |x| x.whole() as u32),
                Cast::RealToBool => self.real_word(to, from, |x| u32::from(x.single() != 0.0)),
                Cast::RealBits => self.real_word(to, from, |x| x.single().to_bits()),
                Cast::HalfToBits => self
                    .real_word(to, from, |x| u32::from(half::f16::from_f32(x.single()).to_bits())),
                Cast::Exponent => {
                    self.real_word(to, from, |x| frexp(f64::from(x.single())).1 as u32);
                }
                Cast::SintToReal => self.word_real(to, from, |x| R::wide(f64::from(x as i32))),
                Cast::UintToReal => self.word_real(to, from, |x| R::wide(f64::from(x))),
                Cast::BitsReal => self.word_real(to, from, |x| R::narrow(f32::from_bits(x))),
                Cast::LowHalf => self.word_real(to, from, |x| R::narrow(half(x))),
                Cast::HighHalf => self.word_real(to, from, |x| R::narrow(half(x >> 16))),
                Cast::WordToBool => {
                    let (column_, others) = apart(&mut self.words, to);
                    map1(column_, others.column(from), |x| u32::from(x != 0));
                }
                Cast::RoundHalf => {
                    let (column_, others) = apart(&mut self.reals, to);
                    map1(column_, others.column(from), R::half);
                }
                Cast::RealToDouble => self.real_wide(to, from, |x| x.double().to_bits()),
                Cast::RealToSint64 => self.real_wide(to, from, |x| x.whole() as i64 as u64),
                Cast::RealToUint64 => self.real_wide(to, from, |x| x.whole() as u64),
                Cast::DoubleToReal => self.wide_real(to, from, |x| R::wide(f64::from_bits(x))),
                Cast::Sint64ToReal => self.wide_real(to, from, |x| R::sint(x as i64)),
                Cast::Uint64ToReal => self.wide_real(to, from, R::uint),
                Cast::DoubleToSint => self.wide_word(to, from, |x| f64::from_bits(x) as i32 as u32),
                Cast::DoubleToUint => self.wide_word(to, from, |x| f64::from_bits(x) as u32),
                Cast::DoubleToBool => {
                    self.wide_word(to, from, |x| u32::from(f64::from_bits(x) != 0.0));
                }
                Cast::WideToWord => self.wide_word(to, from, |x| x as u32),
                Cast::WideToBool => self.wide_word(to, from, |x| u32::from(x != 0)),
                Cast::SintToWide => self.word_wide(to, from, |x| i64::from(x as i32) as u64),
                Cast::UintToWide => self.word_wide(to, from, u64::from),
                Cast::SintToDouble => {
                    self.word_wide(to, from, |x| f64::from(x as i32).to_bits());
                }
                Cast::UintToDouble => self.word_wide(to, from, |x| f64::from(x).to_bits()),
                Cast::DoubleToSint64 => {
                    self.wide_wide(to, from, |x| f64::from_bits(x) as i64 as u64);
                }
                Cast::DoubleToUint64 => self.wide_wide(to, from, |x| f64::from_bits(x) as u64),
                Cast::Sint64ToDouble => self.wide_wide(to, from, |x| (x as i64 as f64).to_bits()),
                Cast::Uint64ToDouble => self.wide_wide(to, from, |x| (x as f64).to_bits()),
            }
        }
    }

    #[inline(always)]
    fn real_word(&mut self, to: u32, from: u32, f: impl Fn(R) -> u32) {
        let to = column_mut(&mut self.words, to);
        map1(to, column(&self.reals, from), f);
    }

    #[inline(always)]
    fn word_real(&mut self, to: u32, from: u32, f: impl Fn(u32) -> R) {
        let to = column_mut(&mut self.reals, to);
        map1(to, column(&self.words, from), f);
    }

    #[inline(always)]
    fn real_wide(&mut self, to: u32, from: u32, f: impl Fn(R) -> u64) {
        let to = column_mut(&mut self.wides, to);
        map1(to, column(&self.reals, from), f);
    }

    #[inline(always)]
    fn wide_real(&mut self, to: u32, from: u32, f: impl Fn(u64) -> R) {
        let to = column_mut(&mut self.reals, to);
        map1(to, column(&self.wides, from), f);
    }

    #[inline(always)]
    fn wide_word(&mut self, to: u32, from: u32, f: impl Fn(u64) -> u32) {
        let to = column_mut(&mut self.words, to);
        map1(to, column(&self.wides, from), f);
    }

    #[inline(always)]
    fn word_wide(&mut self, to: u32, from: u32, f: impl Fn(u32) -> u64) {
        let to = column_mut(&mut self.wides, to);
        map1(to, column(&self.words, from), f);
    }

    #[inline(always)]
    fn wide_wide(&mut self, to: u32, from: u32, f: impl Fn(u64) -> u64) {
        let (results, others) = apart(&mut self.wides, to);
        let a: &[u64; LANES] = others.column(from);
        map1(results, a, f);
    }
}
