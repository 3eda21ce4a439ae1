//! Conversions. A float outside an integer's range becomes the nearest integer in it, NaN becomes 0
//! (WGSL §15.7.6); a 64-bit integer loses its high bits.

use super::super::code::Cast;
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
            macro_rules! convert {
                ($file:ident, $f:expr) => {{
                    let (results, others) = apart(&mut self.$file, to);
                    map1(results, others.column(from), $f);
                }};
                ($from:ident to $to:ident, $f:expr) => {
                    map1(column_mut(&mut self.$to, to), column(&self.$from, from), $f)
                };
            }
            match cast {
                Cast::RealToSint => convert!(reals to words, |x| saturated(x.whole()) as u32),
                Cast::RealToUint => convert!(reals to words, |x| x.whole() as u32),
                Cast::RealToBool => convert!(reals to words, |x| u32::from(x.single() != 0.0)),
                Cast::RealBits => convert!(reals to words, |x| x.single().to_bits()),
                Cast::HalfToBits => {
                    convert!(reals to words, |x| u32::from(half::f16::from_f32(x.single()).to_bits()))
                }
                Cast::Exponent => {
                    convert!(reals to words, |x| frexp(f64::from(x.single())).1 as u32)
                }
                Cast::SintToReal => convert!(words to reals, |x| R::wide(f64::from(x as i32))),
                Cast::UintToReal => convert!(words to reals, |x| R::wide(f64::from(x))),
                Cast::BitsReal => convert!(words to reals, |x| R::narrow(f32::from_bits(x))),
                Cast::LowHalf => convert!(words to reals, |x| R::narrow(half(x))),
                Cast::HighHalf => convert!(words to reals, |x| R::narrow(half(x >> 16))),
                Cast::WordToBool => convert!(words, |x| u32::from(x != 0)),
                Cast::RoundHalf => convert!(reals, R::half),
                Cast::RealToDouble => convert!(reals to wides, |x| x.double().to_bits()),
                Cast::RealToSint64 => convert!(reals to wides, |x| x.whole() as i64 as u64),
                Cast::RealToUint64 => convert!(reals to wides, |x| x.whole() as u64),
                Cast::DoubleToReal => convert!(wides to reals, |x| R::wide(f64::from_bits(x))),
                Cast::Sint64ToReal => convert!(wides to reals, |x| R::sint(x as i64)),
                Cast::Uint64ToReal => convert!(wides to reals, R::uint),
                Cast::DoubleToSint => convert!(wides to words, |x| f64::from_bits(x) as i32 as u32),
                Cast::DoubleToUint => convert!(wides to words, |x| f64::from_bits(x) as u32),
                Cast::DoubleToBool => {
                    convert!(wides to words, |x| u32::from(f64::from_bits(x) != 0.0))
                }
                Cast::WideToWord => convert!(wides to words, |x| x as u32),
                Cast::WideToBool => convert!(wides to words, |x| u32::from(x != 0)),
                Cast::SintToWide => convert!(words to wides, |x| i64::from(x as i32) as u64),
                Cast::UintToWide => convert!(words to wides, u64::from),
                Cast::SintToDouble => convert!(words to wides, |x| f64::from(x as i32).to_bits()),
                Cast::UintToDouble => convert!(words to wides, |x| f64::from(x).to_bits()),
                Cast::DoubleToSint64 => convert!(wides, |x| f64::from_bits(x) as i64 as u64),
                Cast::DoubleToUint64 => convert!(wides, |x| f64::from_bits(x) as u64),
                Cast::Sint64ToDouble => convert!(wides, |x| (x as i64 as f64).to_bits()),
                Cast::Uint64ToDouble => convert!(wides, |x| (x as f64).to_bits()),
            }
        }
    }
}
