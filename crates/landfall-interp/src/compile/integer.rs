//! Compiles math functions of integers: bit operations, packing, and those shared with floats.

use std::rc::Rc;

use naga::{MathFunction, Scalar, ScalarKind};

use super::super::code::{Cast, Class, Op, RealBinary, Reg, WordBinary, WordUnary};
use super::function::Function;

impl Function<'_, '_> {
    pub fn integer_math(
        &mut self,
        fun: MathFunction,
        scalar: Scalar,
        a: &[Reg],
        [b, c, d]: [&[Reg]; 3],
    ) -> Result<Rc<[Reg]>, String> {
        use MathFunction as M;
        let sint = scalar.kind == ScalarKind::Sint;
        let pick = |signed: WordBinary, unsigned: WordBinary| if sint { signed } else { unsigned };
        let (least, greatest) = (
            pick(WordBinary::MinSint, WordBinary::MinUint),
            pick(WordBinary::MaxSint, WordBinary::MaxUint),
        );
        match fun {
            M::Min => return Ok(self.i2(least, scalar, a, b)),
            M::Max => return Ok(self.i2(greatest, scalar, a, b)),
            M::Clamp => {
                // `min(max(x, low), high)` by WGSL and by GLSL.
                let above = self.i2(greatest, scalar, a, b);
                return Ok(self.i2(least, scalar, &above, c));
            }
            M::Abs if !sint => return Ok(a.into()),
            M::Abs if scalar.width == 8 => {
                return Ok(self.each1(Op::DAbsSint, Class::Wide, a));
            }
            M::Sign if scalar.width == 8 => {
                return Ok(self.each1(Op::DSignSint, Class::Wide, a));
            }
            M::Dot => {
                // Integers wrap, so that the order of the sum does not matter.
                let products = self.i2(WordBinary::Mul, scalar, a, b);
                let mut sum = products[0];
                for product in &products[1..] {
                    sum = self.i2(WordBinary::Add, scalar, &[sum], &[*product])[0];
                }
                return Ok([sum].into());
            }
            _ => {}
        }
        if scalar.width == 8 {
            return Err(format!("the function `{fun:?}` on 64-bit integers"));
        }
        let one = match fun {
            M::Abs => Some(WordUnary::AbsSint),
            M::Sign => Some(WordUnary::SignSint),
            M::CountTrailingZeros => Some(WordUnary::TrailingZeros),
            M::CountLeadingZeros => Some(WordUnary::LeadingZeros),
            M::CountOneBits => Some(WordUnary::Ones),
            M::ReverseBits => Some(WordUnary::Reverse),
            M::FirstTrailingBit => Some(WordUnary::FirstTrailing),
            M::FirstLeadingBit if sint => Some(WordUnary::FirstLeadingSint),
            M::FirstLeadingBit => Some(WordUnary::FirstLeadingUint),
            _ => None,
        };
        if let Some(one) = one {
            return Ok(self.each1(Op::WordUnary(one), Class::Word, a));
        }
        Ok(match fun {
            M::Dot4I8Packed => self.i2(WordBinary::Dot4Sint, scalar, a, b),
            M::Dot4U8Packed => self.i2(WordBinary::Dot4Uint, scalar, a, b),
            M::ExtractBits if sint => self.each3(Op::ExtractSint, Class::Word, a, b, c),
            M::ExtractBits => self.each3(Op::ExtractUint, Class::Word, a, b, c),
            M::InsertBits => {
                let to = self.b.temporaries(Class::Word, a.len());
                let mut operands = Vec::new();
                for (i, to) in to.iter().enumerate() {
                    operands.extend([to.0, a[i].0, b[i].0]);
                    // A single offset and count apply to all components.
                    operands.extend([c[i % c.len()].0, d[i % d.len()].0]);
                }
                self.b.push(Op::Insert, &[], &operands);
                to.into()
            }
            M::Pack4xI8 | M::Pack4xU8 => self.pack_fields(a, 8),
            M::Pack4xI8Clamp => {
                let (low, high) = (self.b.word(-128i32 as u32), self.b.word(127));
                let above = self.i2(WordBinary::MaxSint, scalar, a, &[low]);
                let clamped = self.i2(WordBinary::MinSint, scalar, &above, &[high]);
                self.pack_fields(&clamped, 8)
            }
            M::Pack4xU8Clamp => {
                let high = self.b.word(255);
                let clamped = self.i2(WordBinary::MinUint, scalar, a, &[high]);
                self.pack_fields(&clamped, 8)
            }
            M::Unpack4xI8 => self.apart(a[0], 8, true),
            M::Unpack4xU8 => self.apart(a[0], 8, false),
            M::Unpack4x8snorm => self.unpack(a[0], 8, 127.0, true),
            M::Unpack4x8unorm => self.unpack(a[0], 8, 255.0, false),
            M::Unpack2x16snorm => self.unpack(a[0], 16, 32767.0, true),
            M::Unpack2x16unorm => self.unpack(a[0], 16, 65535.0, false),
            M::Unpack2x16float => {
                let high = self.each1(Op::Cast(Cast::HighHalf), Class::Real, a)[0];
                let low = self.each1(Op::Cast(Cast::LowHalf), Class::Real, a)[0];
                [low, high].into()
            }
            other => return Err(format!("the function `{other:?}` on these types")),
        })
    }

    /// Returns the fields of a word from the lowest bits on, each extended to 32 bits.
    fn apart(&mut self, word: Reg, bits: u32, signed: bool) -> Rc<[Reg]> {
        let offsets: Vec<Reg> = (0..32 / bits).map(|i| self.b.word(i * bits)).collect();
        let count = self.b.word(bits);
        let op = if signed { Op::ExtractSint } else { Op::ExtractUint };
        self.each3(op, Class::Word, &[word], &offsets, &[count])
    }

    /// Compiles `max(field / scale, -1)`: WGSL §17.10.
    fn unpack(&mut self, word: Reg, bits: u32, scale: f32, signed: bool) -> Rc<[Reg]> {
        let fields = self.apart(word, bits, signed);
        let cast = if signed { Cast::SintToReal } else { Cast::UintToReal };
        let floats = self.each1(Op::Cast(cast), Class::Real, &fields);
        let scale = self.b.real(scale);
        let scaled = self.f2(RealBinary::Div, Scalar::F32, &floats, &[scale]);
        if !signed {
            return scaled;
        }
        let low = self.b.real(-1.0);
        self.f2(RealBinary::Max, Scalar::F32, &scaled, &[low])
    }
}
