//! Compiles math functions. Functions that the specifications define by a formula follow it in its
//! order: `reflect` is `e1 - 2 * dot(e2, e1) * e2` (WGSL §17.5, GLSL 4.60 §8.5).

use std::rc::Rc;

use naga::MathFunction as M;
use naga::{Expression, Handle, MathFunction, Scalar, ScalarKind, TypeInner};

use super::super::code::{
    Cast, Class, Cmp, Op, RealBinary, RealTernary, RealUnary, Reg, WordBinary,
};
use super::function::Function;
use super::operators::scalar_of;

impl Function<'_, '_> {
    pub fn math(
        &mut self,
        fun: MathFunction,
        arg: Handle<Expression>,
        more: [Option<Handle<Expression>>; 3],
    ) -> Result<Rc<[Reg]>, String> {
        let inner = self.ty(arg).clone();
        let scalar = scalar_of(&inner)?;
        let a = self.regs(arg)?;
        let mut rest: [Rc<[Reg]>; 3] = [Rc::from([]), Rc::from([]), Rc::from([])];
        for (rest, more) in rest.iter_mut().zip(more) {
            if let Some(more) = more {
                *rest = self.regs(more)?;
            }
        }
        let [b, c, d] = rest;
        if scalar.kind != ScalarKind::Float {
            return self.integer_math(fun, scalar, &a, [&b, &c, &d]);
        }
        if let Some(f) = single(fun) {
            return Ok(self.f1(f, scalar, &a));
        }
        let matrix = |fun| matches!(fun, M::Determinant | M::Inverse | M::Transpose);
        // By component, then functions of matrices, of whole vectors, and packing.
        let regs = match self.by_component(fun, scalar, [&a, &b, &c]) {
            None if matrix(fun) => return self.matrix_math(fun, scalar, &inner, &a),
            None => match self.geometric(fun, scalar, [&a, &b, &c]) {
                None => self.packed(fun, &a),
                regs => regs,
            },
            regs => regs,
        };
        regs.ok_or_else(|| format!("the function `{fun:?}` on these types"))
    }

    /// Compiles functions of several operands that work component by component.
    fn by_component(
        &mut self,
        fun: MathFunction,
        scalar: Scalar,
        [a, b, c]: [&[Reg]; 3],
    ) -> Option<Rc<[Reg]>> {
        Some(match fun {
            M::Min => self.f2(RealBinary::Min, scalar, a, b),
            M::Max => self.f2(RealBinary::Max, scalar, a, b),
            M::Pow => self.f2(RealBinary::Pow, scalar, a, b),
            M::Atan2 => self.f2(RealBinary::Atan2, scalar, a, b),
            M::Step => self.f2(RealBinary::Step, scalar, a, b),
            M::Clamp => self.f3(RealTernary::Clamp, scalar, a, b, c),
            M::Fma => self.f3(RealTernary::Fma, scalar, a, b, c),
            // The single instruction rounds its result alone; at `f16` each step has to be rounded.
            M::Mix if scalar.width == 4 && self.b.rounds => self.mix_by_steps(a, b, c),
            M::SmoothStep if scalar.width == 4 && self.b.rounds => {
                self.smoothstep_by_steps(a, b, c)
            }
            M::Mix => self.f3(RealTernary::Mix, scalar, a, b, c),
            M::SmoothStep => self.f3(RealTernary::SmoothStep, scalar, a, b, c),
            // As in `__modf_result` and `__frexp_result` of WGSL §17.5: the fraction before the
            // other part.
            M::Modf => {
                let whole = self.f1(RealUnary::Trunc, scalar, a);
                let fract = self.f2(RealBinary::Sub, scalar, a, &whole);
                fract.iter().chain(whole.iter()).copied().collect()
            }
            M::Frexp => {
                let fract = self.f1(RealUnary::FrexpFract, scalar, a);
                // The exponent of a double beyond the range of `f32` is lost.
                let from = self.as_real(scalar, a);
                let exponent = self.each1(Op::Cast(Cast::Exponent), Class::Word, &from);
                fract.iter().chain(exponent.iter()).copied().collect()
            }
            M::Ldexp if scalar.width != 8 => {
                let regs = self.each2(Op::Ldexp, Class::Real, a, b);
                self.narrowed(scalar, regs)
            }
            _ => return None,
        })
    }

    /// Compiles functions of whole vectors: products, lengths, directions.
    fn geometric(
        &mut self,
        fun: MathFunction,
        scalar: Scalar,
        [a, b, c]: [&[Reg]; 3],
    ) -> Option<Rc<[Reg]>> {
        let n = a.len();
        Some(match fun {
            M::Dot => self.dots(scalar, &[(a.to_vec(), b.to_vec())]),
            M::Outer => {
                let mut product = Vec::with_capacity(n * b.len());
                for column in b.iter() {
                    product.extend_from_slice(&self.f2(RealBinary::Mul, scalar, a, &[*column]));
                }
                product.into()
            }
            // In `f32` one instruction computes all components; doubles and rounded steps follow
            // the formula.
            M::Cross if scalar.width == 4 && !self.b.rounds => {
                let to = self.b.temporaries(Class::Real, 3);
                let operands: Vec<u32> =
                    to.iter().chain(a.iter()).chain(b.iter()).map(|reg| reg.0).collect();
                self.b.push(Op::Cross, &[], &operands);
                to.into()
            }
            M::Cross => {
                let turn = |v: &[Reg], by: usize| -> Vec<Reg> {
                    (0..3).map(|i| v[(i + by) % 3]).collect()
                };
                let left = self.f2(RealBinary::Mul, scalar, &turn(a, 1), &turn(b, 2));
                let right = self.f2(RealBinary::Mul, scalar, &turn(a, 2), &turn(b, 1));
                self.f2(RealBinary::Sub, scalar, &left, &right)
            }
            M::Length => self.length(scalar, a),
            M::Distance if scalar.width == 4 && !self.b.rounds => {
                let operands: Vec<u32> = a.iter().chain(b.iter()).map(|reg| reg.0).collect();
                self.fused(Op::Distance(n as u8), 1, &operands)
            }
            M::Distance => {
                let between = self.f2(RealBinary::Sub, scalar, a, b);
                self.length(scalar, &between)
            }
            M::Normalize if scalar.width == 4 && !self.b.rounds => {
                let operands: Vec<u32> = a.iter().map(|reg| reg.0).collect();
                self.fused(Op::Normalize(n as u8), n, &operands)
            }
            M::Normalize => {
                let length = self.length(scalar, a);
                self.f2(RealBinary::Div, scalar, a, &length)
            }
            M::FaceForward => {
                // `dot(Nref, I) < 0 ? N : -N`: GLSL 4.60 §8.5.
                let facing = self.dots(scalar, &[(c.to_vec(), b.to_vec())]);
                let zero = self.number(scalar, 0.0);
                let op = if scalar.width == 8 { Op::DCmp(Cmp::Lt) } else { Op::FCmp(Cmp::Lt) };
                let condition = self.each2(op, Class::Word, &facing, &[zero]);
                let away = self.f1(RealUnary::Neg, scalar, a);
                self.select(&condition, a, &away)
            }
            M::Reflect => {
                let dot = self.dots(scalar, &[(b.to_vec(), a.to_vec())]);
                let two = self.number(scalar, 2.0);
                let twice = self.f2(RealBinary::Mul, scalar, &[two], &dot);
                let along = self.f2(RealBinary::Mul, scalar, &twice, b);
                self.f2(RealBinary::Sub, scalar, a, &along)
            }
            M::Refract => self.refract(scalar, a, b, c),
            _ => return None,
        })
    }

    fn matrix_math(
        &mut self,
        fun: MathFunction,
        scalar: Scalar,
        ty: &TypeInner,
        a: &[Reg],
    ) -> Result<Rc<[Reg]>, String> {
        let TypeInner::Matrix { columns, rows, .. } = *ty else {
            return Err("a matrix function of a non-matrix".into());
        };
        let (columns, rows) = (columns as usize, rows as usize);
        Ok(match fun {
            M::Determinant => [self.determinant(scalar, a, columns)].into(),
            M::Inverse => self.inverse(scalar, a, columns),
            _ => (0..rows)
                .flat_map(|r| (0..columns).map(move |c| (c, r)))
                .map(|(c, r)| a[c * rows + r])
                .collect(),
        })
    }

    /// Compiles functions that pack numbers into a word.
    fn packed(&mut self, fun: MathFunction, a: &[Reg]) -> Option<Rc<[Reg]>> {
        Some(match fun {
            M::Pack4x8snorm => self.pack(a, 8, -1.0, 127.0, false),
            M::Pack4x8unorm => self.pack(a, 8, 0.0, 255.0, true),
            M::Pack2x16snorm => self.pack(a, 16, -1.0, 32767.0, false),
            M::Pack2x16unorm => self.pack(a, 16, 0.0, 65535.0, true),
            M::Pack2x16float => {
                let bits = self.each1(Op::Cast(Cast::HalfToBits), Class::Word, a);
                self.pack_fields(&bits, 16)
            }
            _ => return None,
        })
    }

    pub fn f3(
        &mut self,
        f: RealTernary,
        scalar: Scalar,
        a: &[Reg],
        b: &[Reg],
        c: &[Reg],
    ) -> Rc<[Reg]> {
        let regs = match scalar.width {
            8 => self.each3(Op::D3(f), Class::Wide, a, b, c),
            _ => self.each3(Op::RealTernary(f), Class::Real, a, b, c),
        };
        self.narrowed(scalar, regs)
    }

    /// Returns a constant of the scalar's width.
    pub fn number(&mut self, scalar: Scalar, value: f32) -> Reg {
        match scalar.width {
            8 => self.b.constant(Class::Wide, f64::from(value).to_bits()),
            _ => self.b.real(value),
        }
    }

    /// Compiles `x * (1 - a) + y * a`, each step rounded: GLSL 4.60 §8.3.
    fn mix_by_steps(&mut self, x: &[Reg], y: &[Reg], a: &[Reg]) -> Rc<[Reg]> {
        let (f32, one) = (Scalar::F32, self.b.real(1.0));
        let rest = self.f2(RealBinary::Sub, f32, &[one], a);
        let left = self.f2(RealBinary::Mul, f32, x, &rest);
        let right = self.f2(RealBinary::Mul, f32, y, a);
        self.f2(RealBinary::Add, f32, &left, &right)
    }

    /// Compiles `t * t * (3 - 2 * t)`, each step rounded: GLSL 4.60 §8.3.
    fn smoothstep_by_steps(&mut self, low: &[Reg], high: &[Reg], x: &[Reg]) -> Rc<[Reg]> {
        let f32 = Scalar::F32;
        let [zero, one, two, three] = [0.0, 1.0, 2.0, 3.0].map(|x| self.b.real(x));
        let past = self.f2(RealBinary::Sub, f32, x, low);
        let width = self.f2(RealBinary::Sub, f32, high, low);
        let quotient = self.f2(RealBinary::Div, f32, &past, &width);
        let t = self.f3(RealTernary::Clamp, f32, &quotient, &[zero], &[one]);
        let twice = self.f2(RealBinary::Mul, f32, &[two], &t);
        let rest = self.f2(RealBinary::Sub, f32, &[three], &twice);
        let square = self.f2(RealBinary::Mul, f32, &t, &t);
        self.f2(RealBinary::Mul, f32, &square, &rest)
    }

    fn fused(&mut self, op: Op, results: usize, operands: &[u32]) -> Rc<[Reg]> {
        let to = self.b.temporaries(Class::Real, results);
        let all: Vec<u32> = to.iter().map(|reg| reg.0).chain(operands.iter().copied()).collect();
        self.b.push(op, &[], &all);
        to.into()
    }

    fn length(&mut self, scalar: Scalar, a: &[Reg]) -> Rc<[Reg]> {
        if a.len() == 1 {
            return self.f1(RealUnary::Abs, scalar, a);
        }
        if scalar.width == 4 && !self.b.rounds {
            let operands: Vec<u32> = a.iter().map(|reg| reg.0).collect();
            return self.fused(Op::Length(a.len() as u8), 1, &operands);
        }
        let dot = self.dots(scalar, &[(a.to_vec(), a.to_vec())]);
        self.f1(RealUnary::Sqrt, scalar, &dot)
    }

    fn refract(&mut self, scalar: Scalar, i: &[Reg], n: &[Reg], eta: &[Reg]) -> Rc<[Reg]> {
        // k = 1 - eta^2 * (1 - dot(N, I)^2); eta * I - (eta * dot(N, I) + sqrt(k)) * N, and zeros
        // where k is negative: GLSL 4.60 §8.5, WGSL §17.5.
        let zero = self.number(scalar, 0.0);
        let one = self.number(scalar, 1.0);
        let dot = self.dots(scalar, &[(n.to_vec(), i.to_vec())]);
        let square = self.f2(RealBinary::Mul, scalar, &dot, &dot);
        let sine = self.f2(RealBinary::Sub, scalar, &[one], &square);
        let ratio = self.f2(RealBinary::Mul, scalar, eta, eta);
        let product = self.f2(RealBinary::Mul, scalar, &ratio, &sine);
        let k = self.f2(RealBinary::Sub, scalar, &[one], &product);
        let op = if scalar.width == 8 { Op::DCmp(Cmp::Lt) } else { Op::FCmp(Cmp::Lt) };
        let total = self.each2(op, Class::Word, &k, &[zero]);
        // No root is taken in case of total reflection.
        let positive = self.f2(RealBinary::Max, scalar, &k, &[zero]);
        let root = self.f1(RealUnary::Sqrt, scalar, &positive);
        let along = self.f2(RealBinary::Mul, scalar, eta, &dot);
        let factor = self.f2(RealBinary::Add, scalar, &along, &root);
        let bent = self.f2(RealBinary::Mul, scalar, eta, i);
        let back = self.f2(RealBinary::Mul, scalar, &factor, n);
        let through = self.f2(RealBinary::Sub, scalar, &bent, &back);
        let nothing = vec![zero; i.len()];
        self.select(&total, &nothing, &through)
    }

    fn as_real(&mut self, scalar: Scalar, a: &[Reg]) -> Rc<[Reg]> {
        match scalar.width {
            8 => self.each1(Op::Cast(Cast::DoubleToReal), Class::Real, a),
            _ => a.into(),
        }
    }

    /// Compiles `floor(0.5 + scale * clamp(x, low, 1))` into the fields of a word: WGSL §17.9.
    fn pack(&mut self, a: &[Reg], bits: u32, low: f32, scale: f32, unsigned: bool) -> Rc<[Reg]> {
        let numbers = [low, 1.0, scale, 0.5].map(|x| self.b.real(x));
        let f32 = Scalar::F32;
        // The fields have more bits than the significand of an `f16`.
        let rounds = std::mem::replace(&mut self.b.rounds, false);
        let clamped = self.f3(RealTernary::Clamp, f32, a, &numbers[..1], &numbers[1..2]);
        let scaled = self.f2(RealBinary::Mul, f32, &clamped, &numbers[2..3]);
        let shifted = self.f2(RealBinary::Add, f32, &scaled, &numbers[3..]);
        let floored = self.f1(RealUnary::Floor, f32, &shifted);
        self.b.rounds = rounds;
        let cast = if unsigned { Cast::RealToUint } else { Cast::RealToSint };
        let fields = self.each1(Op::Cast(cast), Class::Word, &floored);
        self.pack_fields(&fields, bits)
    }

    /// Combines fields into a word, the first in the lowest bits.
    pub fn pack_fields(&mut self, fields: &[Reg], bits: u32) -> Rc<[Reg]> {
        let mask = self.b.word(u32::MAX >> (32 - bits));
        let kept = self.each2(Op::WordBinary(WordBinary::And), Class::Word, fields, &[mask]);
        let mut word = kept[0];
        for (i, field) in kept.iter().enumerate().skip(1) {
            let by = self.b.word(i as u32 * bits);
            let moved = self.each2(Op::WordBinary(WordBinary::Shl), Class::Word, &[*field], &[by]);
            word = self.each2(Op::WordBinary(WordBinary::Or), Class::Word, &[word], &moved)[0];
        }
        [word].into()
    }
}

/// Returns the operation of a function of one operand that works component by component.
fn single(fun: MathFunction) -> Option<RealUnary> {
    Some(match fun {
        M::Abs => RealUnary::Abs,
        M::Saturate => RealUnary::Saturate,
        M::Cos => RealUnary::Cos,
        M::Cosh => RealUnary::Cosh,
        M::Sin => RealUnary::Sin,
        M::Sinh => RealUnary::Sinh,
        M::Tan => RealUnary::Tan,
        M::Tanh => RealUnary::Tanh,
        M::Acos => RealUnary::Acos,
        M::Asin => RealUnary::Asin,
        M::Atan => RealUnary::Atan,
        M::Asinh => RealUnary::Asinh,
        M::Acosh => RealUnary::Acosh,
        M::Atanh => RealUnary::Atanh,
        M::Radians => RealUnary::Radians,
        M::Degrees => RealUnary::Degrees,
        M::Ceil => RealUnary::Ceil,
        M::Floor => RealUnary::Floor,
        M::Round => RealUnary::Round,
        M::Fract => RealUnary::Fract,
        M::Trunc => RealUnary::Trunc,
        M::Exp => RealUnary::Exp,
        M::Exp2 => RealUnary::Exp2,
        M::Log => RealUnary::Log,
        M::Log2 => RealUnary::Log2,
        M::Sign => RealUnary::Sign,
        M::Sqrt => RealUnary::Sqrt,
        M::InverseSqrt => RealUnary::InverseSqrt,
        M::QuantizeToF16 => RealUnary::Quantize,
        _ => return None,
    })
}
