//! Compiles operators, comparisons and conversions.

use std::rc::Rc;

use naga::{
    BinaryOperator, Bytes, Expression, Handle, RelationalFunction, Scalar, ScalarKind, TypeInner,
    UnaryOperator,
};

use super::super::code::{
    Cast, Class, Cmp, Op, RealBinary, RealUnary, Reg, Test, WideBinary, WordBinary, WordUnary,
};
use super::super::flatten::class;
use super::function::Function;

pub(super) fn scalar_of(inner: &TypeInner) -> Result<Scalar, String> {
    match inner {
        TypeInner::Scalar(scalar)
        | TypeInner::Vector { scalar, .. }
        | TypeInner::Matrix { scalar, .. }
        | TypeInner::Atomic(scalar) => Ok(*scalar),
        other => Err(format!("arithmetic on {}", super::super::flatten::kind_name(other))),
    }
}

impl Function<'_, '_> {
    /// Emits an operation on each scalar.
    pub fn each1(&mut self, op: Op, to: Class, a: &[Reg]) -> Rc<[Reg]> {
        let to = self.b.temporaries(to, a.len());
        let operands: Vec<u32> = to.iter().zip(a).flat_map(|(to, a)| [to.0, a.0]).collect();
        self.b.push(op, &[], &operands);
        to.into()
    }

    /// Emits an operation on each pair of scalars; a single scalar is paired with all of the other
    /// operand.
    pub fn each2(&mut self, op: Op, to: Class, a: &[Reg], b: &[Reg]) -> Rc<[Reg]> {
        let to = self.b.temporaries(to, a.len().max(b.len()));
        let mut operands = Vec::with_capacity(3 * to.len());
        for (i, to) in to.iter().enumerate() {
            operands.extend([to.0, a[i % a.len()].0, b[i % b.len()].0]);
        }
        self.b.push(op, &[], &operands);
        to.into()
    }

    /// Emits an operation on each triple of scalars.
    pub fn each3(&mut self, op: Op, to: Class, a: &[Reg], b: &[Reg], c: &[Reg]) -> Rc<[Reg]> {
        let to = self.b.temporaries(to, a.len().max(b.len()).max(c.len()));
        let mut operands = Vec::with_capacity(4 * to.len());
        for (i, to) in to.iter().enumerate() {
            operands.extend([to.0, a[i % a.len()].0, b[i % b.len()].0, c[i % c.len()].0]);
        }
        self.b.push(op, &[], &operands);
        to.into()
    }

    /// Rounds floats of 16 or 32 bits to the nearest `f16`.
    pub fn round_to_half(&mut self, regs: &[Reg]) -> Rc<[Reg]> {
        let half = |this: &mut Self, reg: &Reg| match reg.class() {
            Class::Real => this.each1(Op::Cast(Cast::RoundHalf), Class::Real, &[*reg])[0],
            Class::Word | Class::Wide => *reg,
        };
        regs.iter().map(|reg| half(self, reg)).collect()
    }

    /// Wraps or rounds 16-bit scalars to their width.
    pub fn narrowed(&mut self, scalar: Scalar, regs: Rc<[Reg]>) -> Rc<[Reg]> {
        match (scalar.kind, scalar.width) {
            (ScalarKind::Float, 4) if self.b.rounds => {
                self.each1(Op::Cast(Cast::RoundHalf), Class::Real, &regs)
            }
            (ScalarKind::Float, 2) => self.each1(Op::Cast(Cast::RoundHalf), Class::Real, &regs),
            (ScalarKind::Sint, 2) => {
                self.each1(Op::WordUnary(WordUnary::Narrow16Sint), Class::Word, &regs)
            }
            (ScalarKind::Uint, 2) => {
                self.each1(Op::WordUnary(WordUnary::Narrow16Uint), Class::Word, &regs)
            }
            _ => regs,
        }
    }

    /// Emits a float operation of the scalar's width.
    pub fn f1(&mut self, f: RealUnary, scalar: Scalar, a: &[Reg]) -> Rc<[Reg]> {
        let regs = match scalar.width {
            8 => self.each1(Op::D1(f), Class::Wide, a),
            _ => self.each1(Op::RealUnary(f), Class::Real, a),
        };
        self.narrowed(scalar, regs)
    }

    pub fn f2(&mut self, f: RealBinary, scalar: Scalar, a: &[Reg], b: &[Reg]) -> Rc<[Reg]> {
        let regs = match scalar.width {
            8 => self.each2(Op::WideBinary(WideBinary::Float(f)), Class::Wide, a, b),
            _ => self.each2(Op::RealBinary(f), Class::Real, a, b),
        };
        self.narrowed(scalar, regs)
    }

    /// Emits an integer operation of the scalar's width.
    pub fn i2(&mut self, f: WordBinary, scalar: Scalar, a: &[Reg], b: &[Reg]) -> Rc<[Reg]> {
        let regs = match scalar.width {
            8 => self.each2(Op::WideBinary(WideBinary::Int(f)), Class::Wide, a, b),
            _ => self.each2(Op::WordBinary(f), Class::Word, a, b),
        };
        self.narrowed(scalar, regs)
    }

    pub fn select(&mut self, condition: &[Reg], accept: &[Reg], reject: &[Reg]) -> Rc<[Reg]> {
        let mut to = Vec::with_capacity(accept.len());
        let mut operands: [Vec<u32>; 3] = Default::default();
        for (i, (accept, reject)) in accept.iter().zip(reject).enumerate() {
            let class = accept.class();
            let reg = self.b.temporary(class);
            let condition = condition[i % condition.len()];
            operands[class as usize].extend([reg.0, condition.0, accept.0, reject.0]);
            to.push(reg);
        }
        for class in [Class::Real, Class::Word, Class::Wide] {
            let operands = &operands[class as usize];
            if !operands.is_empty() {
                self.b.push(Op::Select(class), &[], operands);
            }
        }
        to.into()
    }

    pub fn unary(
        &mut self,
        op: UnaryOperator,
        of: Handle<Expression>,
    ) -> Result<Rc<[Reg]>, String> {
        let scalar = scalar_of(self.ty(of))?;
        let a = self.regs(of)?;
        Ok(match (op, scalar.kind, class(scalar)?) {
            (UnaryOperator::Negate, ScalarKind::Float, _) => self.f1(RealUnary::Neg, scalar, &a),
            (UnaryOperator::Negate, _, Class::Wide) => self.each1(Op::DNeg, Class::Wide, &a),
            (UnaryOperator::Negate, ..) => {
                let regs = self.each1(Op::WordUnary(WordUnary::Neg), Class::Word, &a);
                self.narrowed(scalar, regs)
            }
            (UnaryOperator::LogicalNot, ..) | (UnaryOperator::BitwiseNot, ScalarKind::Bool, _) => {
                self.each1(Op::WordUnary(WordUnary::LogicalNot), Class::Word, &a)
            }
            (UnaryOperator::BitwiseNot, _, Class::Wide) => self.each1(Op::DNot, Class::Wide, &a),
            (UnaryOperator::BitwiseNot, ..) => {
                let regs = self.each1(Op::WordUnary(WordUnary::Not), Class::Word, &a);
                self.narrowed(scalar, regs)
            }
        })
    }

    pub fn binary(
        &mut self,
        op: BinaryOperator,
        left: Handle<Expression>,
        right: Handle<Expression>,
    ) -> Result<Rc<[Reg]>, String> {
        let (left_ty, right_ty) = (self.ty(left).clone(), self.ty(right).clone());
        let scalar = scalar_of(&left_ty)?;
        let (a, b) = (self.regs(left)?, self.regs(right)?);
        if op == BinaryOperator::Multiply {
            if let Some(product) = self.matrix_product(&left_ty, &right_ty, &a, &b) {
                return Ok(product);
            }
        }
        let float = scalar.kind == ScalarKind::Float;
        let sint = scalar.kind == ScalarKind::Sint;
        let pick = |signed: WordBinary, unsigned: WordBinary| if sint { signed } else { unsigned };
        use BinaryOperator as B;
        // The operation on floats, if there is one, and that on integers and bools. A bool is 0 or
        // 1, so that a bitwise operator is a logical one as well.
        let (floats, ints) = match op {
            B::Add => (Some(RealBinary::Add), WordBinary::Add),
            B::Subtract => (Some(RealBinary::Sub), WordBinary::Sub),
            B::Multiply => (Some(RealBinary::Mul), WordBinary::Mul),
            B::Divide => (Some(RealBinary::Div), pick(WordBinary::DivSint, WordBinary::DivUint)),
            B::Modulo => (Some(RealBinary::Rem), pick(WordBinary::RemSint, WordBinary::RemUint)),
            B::And | B::LogicalAnd => (None, WordBinary::And),
            B::ExclusiveOr => (None, WordBinary::Xor),
            B::InclusiveOr | B::LogicalOr => (None, WordBinary::Or),
            B::ShiftLeft => (None, WordBinary::Shl),
            B::ShiftRight => (None, pick(WordBinary::ShrSint, WordBinary::ShrUint)),
            B::Equal => return self.compare(Cmp::Eq, scalar, &a, &b),
            B::NotEqual => return self.compare(Cmp::Ne, scalar, &a, &b),
            B::Less => return self.compare(Cmp::Lt, scalar, &a, &b),
            B::LessEqual => return self.compare(Cmp::Le, scalar, &a, &b),
            B::Greater => return self.compare(Cmp::Gt, scalar, &a, &b),
            B::GreaterEqual => return self.compare(Cmp::Ge, scalar, &a, &b),
        };
        match floats {
            Some(f) if float => Ok(self.f2(f, scalar, &a, &b)),
            _ if float => Err("a bitwise operator on floats".into()),
            // The shift amount of a 64-bit integer has 32 bits.
            _ if matches!(op, B::ShiftLeft | B::ShiftRight) && scalar.width == 8 => {
                let by = self.each1(Op::Cast(Cast::UintToWide), Class::Wide, &b);
                Ok(self.i2(ints, scalar, &a, &by))
            }
            _ => Ok(self.i2(ints, scalar, &a, &b)),
        }
    }

    fn compare(
        &mut self,
        cmp: Cmp,
        scalar: Scalar,
        a: &[Reg],
        b: &[Reg],
    ) -> Result<Rc<[Reg]>, String> {
        let op = match (class(scalar)?, scalar.kind) {
            (Class::Real, _) => Op::FCmp(cmp),
            (Class::Wide, ScalarKind::Float) => Op::DCmp(cmp),
            (Class::Wide, ScalarKind::Sint) => Op::DCmpSint(cmp),
            (Class::Wide, _) => Op::DCmpUint(cmp),
            (Class::Word, ScalarKind::Sint) => Op::CmpSint(cmp),
            (Class::Word, _) => Op::CmpUint(cmp),
        };
        Ok(self.each2(op, Class::Word, a, b))
    }

    pub fn relational(
        &mut self,
        fun: RelationalFunction,
        of: Handle<Expression>,
    ) -> Result<Rc<[Reg]>, String> {
        let a = self.regs(of)?;
        let join = |this: &mut Self, op: WordBinary| {
            // Bools are 0 or 1, so that bitwise operators join them.
            let mut joined = a[0];
            for next in &a[1..] {
                joined = this.each2(Op::WordBinary(op), Class::Word, &[joined], &[*next])[0];
            }
            Rc::from([joined])
        };
        let wide = a[0].class() == Class::Wide;
        let test = |test| if wide { Op::DTest(test) } else { Op::FTest(test) };
        Ok(match fun {
            RelationalFunction::All => join(self, WordBinary::And),
            RelationalFunction::Any => join(self, WordBinary::Or),
            RelationalFunction::IsNan => self.each1(test(Test::IsNan), Class::Word, &a),
            RelationalFunction::IsInf => self.each1(test(Test::IsInf), Class::Word, &a),
        })
    }

    pub fn cast(
        &mut self,
        of: Handle<Expression>,
        kind: ScalarKind,
        convert: Option<Bytes>,
    ) -> Result<Rc<[Reg]>, String> {
        let from = scalar_of(self.ty(of))?;
        let a = self.regs(of)?;
        let width = convert.unwrap_or(from.width);
        let to = Scalar { kind, width };
        let class = class(to)?;
        if from == to {
            return Ok(a);
        }
        if convert.is_none() {
            // The bits are kept: `bitcast` of WGSL §17.2. A half is held as a real of the same
            // value, so its 16 bits are made and read by a conversion.
            let half = from.width == 2;
            return Ok(match (from.kind, kind) {
                (ScalarKind::Float, ScalarKind::Float) => a,
                (ScalarKind::Float, _) if half => {
                    let bits = self.each1(Op::Cast(Cast::HalfToBits), Class::Word, &a);
                    self.narrowed(to, bits)
                }
                (_, ScalarKind::Float) if half => {
                    self.each1(Op::Cast(Cast::LowHalf), Class::Real, &a)
                }
                (ScalarKind::Float, _) if class == Class::Word => {
                    self.each1(Op::Cast(Cast::RealBits), class, &a)
                }
                (_, ScalarKind::Float) if class == Class::Real => {
                    self.each1(Op::Cast(Cast::BitsReal), class, &a)
                }
                // Doubles and 64-bit integers share a register file; so do signed and unsigned
                // words.
                _ => self.narrowed(to, a),
            });
        }
        use ScalarKind::{Bool, Float, Sint, Uint};
        // A bool is a word whatever its width.
        let wide = |scalar: Scalar| scalar.width == 8 && scalar.kind != Bool;
        let cast = match (from.kind, wide(from), kind, wide(to)) {
            (Float, false, Float, false) => return Ok(self.narrowed(to, a)),
            (Float, false, Float, true) => Cast::RealToDouble,
            (Float, true, Float, false) => Cast::DoubleToReal,
            (Float, false, Sint, false) => Cast::RealToSint,
            (Float, false, Uint, false) => Cast::RealToUint,
            (Float, false, Sint, true) => Cast::RealToSint64,
            (Float, false, Uint, true) => Cast::RealToUint64,
            (Float, true, Sint, false) => Cast::DoubleToSint,
            (Float, true, Uint, false) => Cast::DoubleToUint,
            (Float, true, Sint, true) => Cast::DoubleToSint64,
            (Float, true, Uint, true) => Cast::DoubleToUint64,
            (Float, false, Bool, _) => Cast::RealToBool,
            (Float, true, Bool, _) => Cast::DoubleToBool,
            (_, true, Bool, _) => Cast::WideToBool,
            (_, false, Bool, _) => Cast::WordToBool,
            (Sint, false, Float, false) => Cast::SintToReal,
            (_, false, Float, false) => Cast::UintToReal,
            (Sint, false, Float, true) => Cast::SintToDouble,
            (_, false, Float, true) => Cast::UintToDouble,
            (Sint, true, Float, false) => Cast::Sint64ToReal,
            (_, true, Float, false) => Cast::Uint64ToReal,
            (Sint, true, Float, true) => Cast::Sint64ToDouble,
            (_, true, Float, true) => Cast::Uint64ToDouble,
            (Sint, false, _, true) => Cast::SintToWide,
            (_, false, _, true) => Cast::UintToWide,
            (_, true, _, false) => Cast::WideToWord,
            (_, _, Sint | Uint, _) => return Ok(self.narrowed(to, a)),
            (_, _, ScalarKind::AbstractInt | ScalarKind::AbstractFloat, _) => {
                return Err("abstract numbers".into());
            }
        };
        let regs = self.each1(Op::Cast(cast), class, &a);
        Ok(self.narrowed(to, regs))
    }
}
