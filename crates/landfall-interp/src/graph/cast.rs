//! Conversions between floats, integers and bits.

use super::super::code::Cast;
use super::super::interval::Interval;
use super::super::undefined::UndefinedKind as K;
use super::arithmetic;
use super::exact::{self, between, contains, is_empty, point, size};
use super::fault::Faults;
use super::value::{Applied, Arithmetic, without_fault};
use super::word;
use landfall_ir::analysis::undefined::condition::conversion;

pub(super) fn converted(how: Arithmetic, cast: Cast, x: Interval) -> Applied {
    let plain = without_fault;
    if is_empty(x) {
        return plain(x);
    }
    let most = f64::from(f32::MAX);
    let whole = |low: f64, high: f64| {
        // Outside of the range is a fault; what goes on is the nearest number inside.
        let value = exact::step(x, |x| x.trunc().clamp(low, high));
        Applied { value, faults: Faults::any([conversion(x.into(), low, high)]) }
    };
    let number = |x: Interval| match how {
        Arithmetic::Exact => plain(x),
        Arithmetic::Nearest => plain(exact::step(x, |x| f64::from(x as f32))),
        Arithmetic::Permitted => plain(x.rounded()),
    };
    match cast {
        Cast::RealToSint => whole(-2_147_483_648.0, 2_147_483_647.0),
        Cast::RealToUint => whole(0.0, 4_294_967_295.0),
        // Zero alone is false.
        Cast::RealToBool | Cast::WordToBool => plain(match (contains(x, 0.0), x.low == x.high) {
            (true, true) => point(0.0),
            (true, false) => word::BIT,
            (false, _) => point(1.0),
        }),
        Cast::SintToReal => number(word::signed(x, true)),
        Cast::UintToReal => number(word::signed(x, false)),
        // The bits of numbers that are not negative grow with them.
        Cast::RealBits if x.low >= 0.0 => {
            let bits = |x: f64, up: bool| {
                let near = x as f32;
                let low = f64::from(near) > x && !up;
                let high = f64::from(near) < x && up;
                let near = if low { near.next_down() } else { near };
                f64::from((if high { near.next_up() } else { near }).to_bits())
            };
            plain(between(bits(x.low, false), bits(x.high, true)))
        }
        Cast::BitsReal => {
            let bits = word::signed(x, false);
            // Above are the bits of infinities, of NaN and of negative numbers, which are in
            // another order.
            let fine = bits.high <= f64::from(f32::MAX.to_bits());
            let of = |bits: f64| f64::from(f32::from_bits(bits as u32));
            match fine {
                true => plain(exact::step(bits, of)),
                false => {
                    Applied { value: between(-most, most), faults: Faults::when(true, K::BornNan) }
                }
            }
        }
        Cast::RoundHalf => arithmetic::half(x),
        Cast::HalfToBits => {
            // From half a unit above the largest `f16` on, the nearest one is infinity.
            let outside = size(x) >= 65520.0;
            Applied {
                value: between(0.0, 65535.0),
                faults: Faults::when(outside, K::ConversionOutOfRange),
            }
        }
        Cast::LowHalf | Cast::HighHalf => {
            // Every finite `f16`.
            Applied { value: between(-65504.0, 65504.0), faults: Faults::when(true, K::BornNan) }
        }
        // The exponents of all `f32`, subnormal ones among them.
        Cast::Exponent => plain(between(-149.0, 128.0)),
        // Doubles and 64-bit integers are not followed.
        Cast::DoubleToReal | Cast::Sint64ToReal | Cast::Uint64ToReal => plain(between(-most, most)),
        Cast::DoubleToBool | Cast::WideToBool => plain(word::BIT),
        Cast::RealBits
        | Cast::DoubleToSint
        | Cast::DoubleToUint
        | Cast::WideToWord
        | Cast::RealToDouble
        | Cast::DoubleToSint64
        | Cast::DoubleToUint64
        | Cast::RealToSint64
        | Cast::RealToUint64
        | Cast::SintToWide
        | Cast::UintToWide
        | Cast::SintToDouble
        | Cast::UintToDouble
        | Cast::Sint64ToDouble
        | Cast::Uint64ToDouble => plain(word::ANY_WORD),
    }
}
