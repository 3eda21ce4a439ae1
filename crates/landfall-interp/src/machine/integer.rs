//! Integers and bools. Operations wrap; a division by zero returns the dividend, a
//! remainder by zero returns 0 (WGSL §8.7), a shift uses the low five bits of its amount.

use super::super::code::{Cast, Class, Cmp, LANES, Op, WordBinary, WordUnary};
use super::super::lanes::{Lanes, quotient, remainder};
use super::super::real::Real;
use super::kernel::{map1, map2, map3};
use super::{Machine, apart, column};

pub(super) fn unary(f: WordUnary, x: u32) -> u32 {
    match f {
        WordUnary::Neg => x.wrapping_neg(),
        WordUnary::Not => !x,
        WordUnary::LogicalNot => x ^ 1,
        WordUnary::AbsSint => (x as i32).wrapping_abs() as u32,
        WordUnary::SignSint => (x as i32).signum() as u32,
        WordUnary::TrailingZeros => x.trailing_zeros(),
        WordUnary::LeadingZeros => x.leading_zeros(),
        WordUnary::Ones => x.count_ones(),
        WordUnary::Reverse => x.reverse_bits(),
        WordUnary::FirstTrailing => {
            if x == 0 {
                u32::MAX
            } else {
                x.trailing_zeros()
            }
        }
        // Of zero it is -1: GLSL 4.60 §8.8 `findMSB`, WGSL §17.5.
        WordUnary::FirstLeadingUint => 31u32.wrapping_sub(x.leading_zeros()),
        WordUnary::FirstLeadingSint => {
            // Of a negative number, the highest bit that is 0.
            let sign = ((x as i32) >> 31) as u32;
            31u32.wrapping_sub((x ^ sign).leading_zeros())
        }
        WordUnary::Narrow16Sint => i32::from(x as i16) as u32,
        WordUnary::Narrow16Uint => u32::from(x as u16),
    }
}

macro_rules! binaries {
    ($($visible:vis fn $name:ident: $unsigned:ident, $signed:ident;)*) => {$(
        $visible fn $name(f: WordBinary, a: $unsigned, b: $unsigned) -> $unsigned {
            let (x, y) = (a as $signed, b as $signed);
            match f {
                WordBinary::Add => a.wrapping_add(b),
                WordBinary::Sub => a.wrapping_sub(b),
                WordBinary::Mul => a.wrapping_mul(b),
                WordBinary::DivSint => (if y == 0 { x } else { x.wrapping_div(y) }) as $unsigned,
                WordBinary::DivUint => a.checked_div(b).unwrap_or(a),
                WordBinary::RemSint => (if y == 0 { 0 } else { x.wrapping_rem(y) }) as $unsigned,
                WordBinary::RemUint => a.checked_rem(b).unwrap_or(0),
                WordBinary::And => a & b,
                WordBinary::Or => a | b,
                WordBinary::Xor => a ^ b,
                // The low bits of an amount count, as many as number the bits of an integer.
                WordBinary::Shl => a.wrapping_shl(b as u32),
                WordBinary::ShrSint => x.wrapping_shr(b as u32) as $unsigned,
                WordBinary::ShrUint => a.wrapping_shr(b as u32),
                WordBinary::MinSint => x.min(y) as $unsigned,
                WordBinary::MinUint => a.min(b),
                WordBinary::MaxSint => x.max(y) as $unsigned,
                WordBinary::MaxUint => a.max(b),
                // Defined for words only.
                WordBinary::Dot4Sint => dot4(a as u32, b as u32, |x| i32::from(x as i8)) as $unsigned,
                WordBinary::Dot4Uint => dot4(a as u32, b as u32, i32::from) as $unsigned,
            }
        }
    )*};
}

binaries! {
    pub(crate) fn binary: u32, i32;
    pub(super) fn binary_wide: u64, i64;
}

/// Returns the dot product of two packed vectors of bytes.
fn dot4(a: u32, b: u32, number: impl Fn(u8) -> i32) -> i32 {
    let bytes = a.to_le_bytes().into_iter().zip(b.to_le_bytes());
    bytes.map(|(a, b)| number(a) * number(b)).sum()
}

/// Returns `count` bits from `offset` on, both clamped to the word: WGSL §17.5 (`extractBits`).
pub(super) fn extract(signed: bool, x: u32, offset: u32, count: u32) -> u32 {
    let offset = offset.min(32);
    let count = count.min(32 - offset);
    // A shift by 32 would overflow.
    if count == 0 {
        return 0;
    }
    // First up, so that the shift down extends the sign.
    let up = x << (32 - count - offset);
    if signed { ((up as i32) >> (32 - count)) as u32 } else { up >> (32 - count) }
}

/// Replaces `count` bits from `offset` on, both clamped to the word.
pub(super) fn insert(x: u32, new: u32, offset: u32, count: u32) -> u32 {
    let offset = offset.min(32);
    let count = count.min(32 - offset);
    if count == 0 {
        return x;
    }
    let mask = u32::MAX >> (32 - count) << offset;
    x & !mask | new << offset & mask
}

impl<R: Real> Machine<'_, '_, R> {
    #[inline(always)]
    pub(super) fn i1(&mut self, f: WordUnary, operands: &[u32]) {
        for group in operands.chunks_exact(2) {
            let (to, others) = apart(&mut self.words, group[0]);
            let a = others.column(group[1]);
            // An operation chosen outside of the loop over lanes lets the loop be vectorised.
            match f {
                WordUnary::LogicalNot => map1(to, a, |x| x ^ 1),
                WordUnary::Neg => map1(to, a, u32::wrapping_neg),
                WordUnary::Not => map1(to, a, |x: u32| !x),
                _ => map1(to, a, |x| unary(f, x)),
            }
        }
    }

    #[inline(always)]
    pub(super) fn i2(&mut self, f: WordBinary, operands: &[u32]) {
        for group in operands.chunks_exact(3) {
            let (to, others) = apart(&mut self.words, group[0]);
            let (a, b) = (others.column(group[1]), others.column(group[2]));
            match f {
                WordBinary::Add => map2(to, a, b, u32::wrapping_add),
                WordBinary::Sub => map2(to, a, b, u32::wrapping_sub),
                WordBinary::Mul => map2(to, a, b, u32::wrapping_mul),
                WordBinary::And => map2(to, a, b, |a: u32, b: u32| a & b),
                WordBinary::Or => map2(to, a, b, |a: u32, b: u32| a | b),
                WordBinary::Xor => map2(to, a, b, |a: u32, b: u32| a ^ b),
                WordBinary::DivUint => map2(to, a, b, quotient),
                WordBinary::RemUint => map2(to, a, b, remainder),
                _ => map2(to, a, b, |a, b| binary(f, a, b)),
            }
        }
    }

    #[inline(always)]
    pub(super) fn compare_words(&mut self, cmp: Cmp, signed: bool, operands: &[u32]) {
        for group in operands.chunks_exact(3) {
            let (to, others) = apart(&mut self.words, group[0]);
            let (a, b) = (others.column(group[1]), others.column(group[2]));
            // Adding 2^31 maps the order of signed numbers to that of unsigned ones.
            let flip = if signed { 1 << 31 } else { 0 };
            match cmp {
                Cmp::Eq => map2(to, a, b, |a, b| u32::from(a == b)),
                Cmp::Ne => map2(to, a, b, |a, b| u32::from(a != b)),
                Cmp::Lt => map2(to, a, b, |a, b| u32::from(a ^ flip < b ^ flip)),
                Cmp::Le => map2(to, a, b, |a, b| u32::from(a ^ flip <= b ^ flip)),
                Cmp::Gt => map2(to, a, b, |a, b| u32::from(a ^ flip > b ^ flip)),
                Cmp::Ge => map2(to, a, b, |a, b| u32::from(a ^ flip >= b ^ flip)),
            }
        }
    }

    pub(super) fn extract(&mut self, signed: bool, operands: &[u32]) {
        for group in operands.chunks_exact(4) {
            let (to, others) = apart(&mut self.words, group[0]);
            let [a, b, c] = [1, 2, 3].map(|i| others.column(group[i]));
            for lane in 0..LANES {
                to[lane] = extract(signed, a[lane], b[lane], c[lane]);
            }
        }
    }

    pub(super) fn insert(&mut self, operands: &[u32]) {
        for group in operands.chunks_exact(5) {
            let (to, others) = apart(&mut self.words, group[0]);
            let [a, b, c, d] = [1, 2, 3, 4].map(|i| others.column(group[i]));
            for lane in 0..LANES {
                to[lane] = insert(a[lane], b[lane], c[lane], d[lane]);
            }
        }
    }

    #[inline(always)]
    pub(super) fn select(&mut self, class: Class, operands: &[u32]) {
        macro_rules! choose {
            ($file:ident) => {
                for group in operands.chunks_exact(4) {
                    let (to, others) = apart(&mut self.$file, group[0]);
                    let [yes, no] = [others.column(group[2]), others.column(group[3])];
                    let is = column(&self.words, group[1]);
                    map3(to, is, yes, no, |is, yes, no| if is != 0 { yes } else { no });
                }
            };
        }
        match class {
            Class::Real => choose!(reals),
            Class::Wide => choose!(wides),
            // The condition is in the same file.
            Class::Word => {
                for group in operands.chunks_exact(4) {
                    let (to, others) = apart(&mut self.words, group[0]);
                    let [yes, no] = [others.column(group[2]), others.column(group[3])];
                    let is = others.column(group[1]);
                    map3(to, is, yes, no, |is, yes, no| if is != 0 { yes } else { no });
                }
            }
        }
    }

    /// Copies all lanes.
    #[inline(always)]
    pub(super) fn shift(&mut self, class: Class, operands: &[u32]) {
        macro_rules! copy {
            ($file:ident) => {
                for group in operands.chunks_exact(2) {
                    // The others of `apart` lack the register itself.
                    if group[0] != group[1] {
                        let (to, others) = apart(&mut self.$file, group[0]);
                        map1(to, others.column(group[1]), |x| x);
                    }
                }
            };
        }
        match class {
            Class::Real => copy!(reals),
            Class::Word => copy!(words),
            Class::Wide => copy!(wides),
        }
    }

    /// Copies the active lanes.
    #[inline(always)]
    pub(super) fn store(&mut self, class: Class, operands: &[u32]) {
        if self.active == u64::MAX {
            return self.shift(class, operands);
        }
        if self.active == 0 {
            return;
        }
        let active = self.active;
        macro_rules! copy {
            ($file:ident) => {
                for group in operands.chunks_exact(2) {
                    if group[0] != group[1] {
                        let (to, others) = apart(&mut self.$file, group[0]);
                        to.blend(others.column(group[1]), active);
                    }
                }
            };
        }
        match class {
            Class::Real => copy!(reals),
            Class::Word => copy!(words),
            Class::Wide => copy!(wides),
        }
    }
}

/// Returns the value of an operand of an integer operation.
pub(super) fn operand(op: Op, word: u32) -> f64 {
    match op {
        Op::WordBinary(WordBinary::DivSint | WordBinary::RemSint | WordBinary::ShrSint)
        | Op::CmpSint(_)
        | Op::Cast(Cast::RealToSint | Cast::SintToReal) => f64::from(word as i32),
        _ => f64::from(word),
    }
}
