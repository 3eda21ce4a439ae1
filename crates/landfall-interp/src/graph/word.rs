//! Integers of 32 bits and bools over enclosures of their operands.
//!
//! A word is enclosed by numbers from -2^31 to 2^32, each of which stands for its lowest 32 bits.

use super::super::code::{Cmp, WordBinary, WordUnary};
use super::super::condition::undefined_integer;
use super::super::interval::Interval;
use super::exact::{self, between, is_empty, point};
use super::fault::Faults;
use super::value::{Applied, without_fault};

const HALF: f64 = 2_147_483_648.0;
const WHOLE: f64 = 4_294_967_296.0;

/// Any word.
pub(super) const ANY_WORD: Interval = Interval { low: -HALF, high: WHOLE - 1.0 };

/// A bool.
pub(super) const BIT: Interval = Interval { low: 0.0, high: 1.0 };

/// Returns the numbers that words stand for with or without a sign.
pub(super) fn signed(x: Interval, signed: bool) -> Interval {
    let (least, most) = if signed { (-HALF, HALF - 1.0) } else { (0.0, WHOLE - 1.0) };
    let shift = if signed { -WHOLE } else { WHOLE };
    if is_empty(x) || x.low >= least && x.high <= most {
        x
    } else if x.low + shift >= least && x.high + shift <= most {
        // All of them are on the other side of the sign, 2^32 away.
        between(x.low + shift, x.high + shift)
    } else {
        between(least, most)
    }
}

/// Returns the words of numbers that may be too large.
fn wrapped(x: Interval) -> Interval {
    if x.low >= -HALF && x.high < WHOLE { x } else { ANY_WORD }
}

fn bit(x: bool) -> Interval {
    point(f64::from(u8::from(x)))
}

pub(super) fn unary(f: WordUnary, x: Interval) -> Interval {
    if is_empty(x) {
        return x;
    }
    match f {
        WordUnary::LogicalNot => between(1.0 - x.high.min(1.0), 1.0 - x.low.max(0.0)),
        WordUnary::Neg => wrapped(exact::neg(signed(x, true))),
        WordUnary::Not => wrapped(exact::sub(point(-1.0), signed(x, true))),
        WordUnary::AbsSint => wrapped(exact::abs(signed(x, true))),
        WordUnary::SignSint => {
            exact::step(signed(x, true), |x| if x == 0.0 { 0.0 } else { x.signum() })
        }
        WordUnary::TrailingZeros | WordUnary::LeadingZeros | WordUnary::Ones => between(0.0, 32.0),
        WordUnary::FirstTrailing | WordUnary::FirstLeadingSint | WordUnary::FirstLeadingUint => {
            between(-1.0, 31.0)
        }
        WordUnary::Narrow16Sint => between(-32768.0, 32767.0),
        WordUnary::Narrow16Uint => between(0.0, 65535.0),
        WordUnary::Reverse => ANY_WORD,
    }
}

/// Returns the least number of ones that covers a number.
fn ones(x: f64) -> f64 {
    let bits = 64 - (x as u64).leading_zeros();
    ((1u64 << bits) - 1) as f64
}

pub(super) fn binary(f: WordBinary, a: Interval, b: Interval) -> Applied {
    // A condition that is never evaluated does not hold.
    if f == WordBinary::And && (is_empty(a) || is_empty(b)) {
        return without_fault(point(0.0));
    }
    if is_empty(a) || is_empty(b) {
        return without_fault(exact::EMPTY);
    }
    let is_signed = matches!(
        f,
        WordBinary::Add
            | WordBinary::Sub
            | WordBinary::Mul
            | WordBinary::DivSint
            | WordBinary::RemSint
            | WordBinary::ShrSint
            | WordBinary::MinSint
            | WordBinary::MaxSint
    );
    let [x, y] = [a, b].map(|v| signed(v, is_signed));
    let exactly = a.low == a.high && b.low == b.high;
    let shifts = matches!(f, WordBinary::Shl | WordBinary::ShrSint | WordBinary::ShrUint);
    let divides = matches!(
        f,
        WordBinary::DivSint | WordBinary::DivUint | WordBinary::RemSint | WordBinary::RemUint
    );
    // A single pair of words is computed as the machine does.
    if exactly && !shifts && !divides {
        // Their lowest 32 bits.
        let [a, b] = [a.low, b.low].map(|x| x as i64 as u32);
        let word = super::super::machine::binary(f, a, b);
        return without_fault(point(match is_signed {
            true => f64::from(word as i32),
            false => f64::from(word),
        }));
    }
    let whole = |x: Interval| x.low as i128..=x.high as i128;
    // The amount of a shift has no sign.
    let by = signed(b, false);
    let right = if shifts { by } else { y };
    let faults = Faults::any(undefined_integer(f, whole(x), whole(right), 32));
    let value = match f {
        WordBinary::Add => wrapped(exact::add(x, y)),
        WordBinary::Sub => wrapped(exact::sub(x, y)),
        WordBinary::Mul => wrapped(exact::mul(x, y)),
        // `&` is no larger than either operand, `|` no smaller; no bit above their highest is set.
        WordBinary::And => between(0.0, x.high.min(y.high)),
        WordBinary::Or => between(x.low.max(y.low), ones(x.high.max(y.high))),
        WordBinary::Xor => between(0.0, ones(x.high.max(y.high))),
        WordBinary::MinSint | WordBinary::MinUint => between(x.low.min(y.low), x.high.min(y.high)),
        WordBinary::MaxSint | WordBinary::MaxUint => between(x.low.max(y.low), x.high.max(y.high)),
        WordBinary::Shl => {
            // A larger amount is a fault, and cut off here.
            let by = between(by.low.min(31.0), by.high.min(31.0));
            wrapped(exact::mul(x, exact::step(by, f64::exp2)))
        }
        WordBinary::ShrSint | WordBinary::ShrUint => {
            let by = between(by.low.min(31.0), by.high.min(31.0));
            let corner = |x: f64, by: f64| (x / by.exp2()).floor();
            let all = [(x.low, by.low), (x.low, by.high), (x.high, by.low), (x.high, by.high)];
            all.map(|(x, by)| point(corner(x, by))).into_iter().fold(exact::EMPTY, exact::hull)
        }
        WordBinary::DivSint | WordBinary::DivUint => {
            // Without 0, which is a fault, on both sides of it.
            let parts = [between(y.low.max(1.0), y.high), between(y.low, y.high.min(-1.0))];
            let parts = parts.into_iter().filter(|part| !is_empty(*part));
            let quotients = parts.map(|part| exact::step(exact::div(x, part), f64::trunc));
            wrapped(quotients.fold(exact::EMPTY, exact::hull))
        }
        WordBinary::RemSint | WordBinary::RemUint => {
            // Smaller than the divisor, no larger than the dividend, and with the dividend's sign.
            let most = (exact::size(y) - 1.0).max(0.0).min(exact::size(x));
            let low = if x.low < 0.0 { -most } else { 0.0 };
            between(low, if x.high > 0.0 { most } else { 0.0 })
        }
        WordBinary::Dot4Sint | WordBinary::Dot4Uint => ANY_WORD,
    };
    Applied { value, faults }
}

/// Compares numbers; a bool.
pub(super) fn compare(cmp: Cmp, a: Interval, b: Interval) -> Interval {
    if is_empty(a) || is_empty(b) {
        return exact::EMPTY;
    }
    let one = a.low == a.high && b.low == b.high;
    let (always, never) = match cmp {
        Cmp::Eq => (one && a.low == b.low, a.high < b.low || b.high < a.low),
        Cmp::Ne => (a.high < b.low || b.high < a.low, one && a.low == b.low),
        Cmp::Lt => (a.high < b.low, a.low >= b.high),
        Cmp::Le => (a.high <= b.low, a.low > b.high),
        Cmp::Gt => (a.low > b.high, a.high <= b.low),
        Cmp::Ge => (a.low >= b.high, a.high < b.low),
    };
    match (always, never) {
        (true, _) => bit(true),
        (_, true) => bit(false),
        (false, false) => BIT,
    }
}
