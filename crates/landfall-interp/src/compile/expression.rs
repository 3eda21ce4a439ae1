//! Compiles expressions: constants, parts of values, loads. Computations are in
//! [`operators`](super::operators) and [`math`](super::math).

use std::rc::Rc;

use naga::{AddressSpace, Expression, Handle, Literal, ScalarKind, TypeInner};

use super::super::code::{Access, Class, DerivativeAxis, Dynamic, ElementCount, Op, Reg};
use super::super::flatten::class;
use super::super::program::Floats;
use super::CompiledGlobal;
use super::function::{ExpressionTypes, Function};
use super::value::{PointerRoot, Value};

impl Function<'_, '_> {
    /// Compiles an expression; its result is rounded to `f16` where the program's [`Floats`] ask
    /// for it.
    pub fn expression(&mut self, handle: Handle<Expression>) -> Result<Value, String> {
        let rounds = self.is_rounded(handle);
        // Of this node only: each operand, compiled within, has a precision of its own.
        let outer = std::mem::replace(&mut self.b.rounds, rounds);
        let value = self.unrounded(handle);
        self.b.rounds = outer;
        match value? {
            Value::Regs(regs) if rounds => Ok(Value::Regs(self.round_to_half(&regs))),
            value => Ok(value),
        }
    }

    /// Returns whether a value is rounded to `f16`.
    pub fn is_rounded(&self, handle: Handle<Expression>) -> bool {
        match self.b.floats {
            Floats::AsWritten => false,
            Floats::Half => true,
            Floats::Mediump => {
                let range = self.arena.get_span(handle).to_range();
                let span = range.map(|range| (range.start as u32, range.end as u32));
                // A literal has no precision of its own.
                let literal = matches!(self.arena[handle], Expression::Literal(_));
                span.is_some_and(|span| self.b.reduced.contains(&span)) && !literal
            }
        }
    }

    /// Compiles an expression whose operations are rounded, but not its operands.
    fn unrounded(&mut self, handle: Handle<Expression>) -> Result<Value, String> {
        let arena = self.arena;
        let regs = match &arena[handle] {
            Expression::Literal(literal) => [self.literal(*literal)?].into(),
            Expression::Constant(constant) => {
                let init = self.b.ir.constants[*constant].init;
                self.global(init)?
            }
            Expression::Override(given) => self.given(*given)?,
            Expression::ZeroValue(ty) => {
                let inner = &self.b.ir.types[*ty].inner;
                self.zero(inner)?
            }
            Expression::Compose { components, .. } => {
                let mut all = Vec::new();
                for component in components {
                    // A component may be a vector, of several scalars.
                    all.extend_from_slice(&self.regs(*component)?);
                }
                all.into()
            }
            Expression::Splat { size, value } => {
                let value = self.scalar(*value)?;
                vec![value; *size as usize].into()
            }
            Expression::Swizzle { size, vector, pattern } => {
                let from = self.regs(*vector)?;
                pattern[..*size as usize].iter().map(|c| from[*c as usize]).collect()
            }
            Expression::AccessIndex { base, index } => return self.part(*base, *index),
            Expression::Access { base, index } => return self.part_at(*base, *index),
            Expression::FunctionArgument(_)
            | Expression::LocalVariable(_)
            | Expression::GlobalVariable(_) => return self.variable(handle),
            Expression::Load { pointer } => {
                let pointer = self.pointer(*pointer)?;
                return self.load(&pointer);
            }
            Expression::ImageSample { .. }
            | Expression::ImageLoad { .. }
            | Expression::ImageQuery { .. } => self.image(handle)?,
            Expression::Unary { op, expr } => self.unary(*op, *expr)?,
            Expression::Binary { op, left, right } => self.binary(*op, *left, *right)?,
            Expression::Select { condition, accept, reject } => {
                let condition = self.regs(*condition)?;
                let (accept, reject) = (self.regs(*accept)?, self.regs(*reject)?);
                self.select(&condition, &accept, &reject)
            }
            Expression::Derivative { axis, ctrl, expr } => self.derivative(*axis, *ctrl, *expr)?,
            Expression::Relational { fun, argument } => self.relational(*fun, *argument)?,
            Expression::Math { fun, arg, arg1, arg2, arg3 } => {
                self.math(*fun, *arg, [*arg1, *arg2, *arg3])?
            }
            Expression::As { expr, kind, convert } => self.cast(*expr, *kind, *convert)?,
            Expression::ArrayLength(array) => [self.array_length(*array)?].into(),
            // Its statement sets the value, in `values`; without one this is reached.
            Expression::CallResult(_)
            | Expression::AtomicResult { .. }
            | Expression::WorkGroupUniformLoadResult { .. } => {
                return Err("the result of a call that has not run yet".into());
            }
            Expression::RayQueryVertexPositions { .. }
            | Expression::RayQueryProceedResult
            | Expression::RayQueryGetIntersection { .. } => return Err("ray queries".into()),
            Expression::SubgroupBallotResult | Expression::SubgroupOperationResult { .. } => {
                return Err("subgroup operations".into());
            }
            Expression::CooperativeLoad { .. } | Expression::CooperativeMultiplyAdd { .. } => {
                return Err("cooperative matrices".into());
            }
        };
        Ok(Value::Regs(regs))
    }

    /// Compiles an argument, a local variable or a global one.
    fn variable(&mut self, handle: Handle<Expression>) -> Result<Value, String> {
        let arena = self.arena;
        match &arena[handle] {
            Expression::FunctionArgument(number) => {
                let argument = &self.arguments[*number as usize];
                let regs = Rc::from(&argument.regs[..]);
                if !argument.pointer {
                    return Ok(Value::Regs(regs));
                }
                let root = PointerRoot::Variable(regs);
                Ok(self.whole(root, self.pointee(handle)?))
            }
            Expression::LocalVariable(local) => {
                let root = PointerRoot::Variable(self.locals[local.index()].clone());
                let ty = self.function.local_variables[*local].ty;
                Ok(self.whole(root, naga::proc::TypeResolution::Handle(ty)))
            }
            Expression::GlobalVariable(variable) => {
                let global = self.globals[variable.index()].clone();
                let variable = &self.b.ir.global_variables[*variable];
                let ty = naga::proc::TypeResolution::Handle(variable.ty);
                let root = match global {
                    CompiledGlobal::Buffer { number, read_only } => {
                        PointerRoot::Buffer { number, read_only }
                    }
                    CompiledGlobal::Private(regs) => PointerRoot::Variable(regs),
                    CompiledGlobal::Image(number) => return Ok(Value::Regs([number].into())),
                    CompiledGlobal::Refused(why) => return Err(why),
                };
                debug_assert!(variable.space != AddressSpace::Handle);
                Ok(self.whole(root, ty))
            }
            _ => Err("an expression that is not a variable".into()),
        }
    }

    fn derivative(
        &mut self,
        axis: naga::DerivativeAxis,
        control: naga::DerivativeControl,
        of: Handle<Expression>,
    ) -> Result<Rc<[Reg]>, String> {
        let from = self.regs(of)?;
        let axis = match axis {
            naga::DerivativeAxis::X => DerivativeAxis::X,
            naga::DerivativeAxis::Y => DerivativeAxis::Y,
            naga::DerivativeAxis::Width => DerivativeAxis::Width,
        };
        let op = match control {
            naga::DerivativeControl::Coarse => Op::DerivativeCoarse(axis),
            // Without a control the choice is the implementation's: WGSL §17.6, GLSL 4.60 §8.14.
            naga::DerivativeControl::Fine | naga::DerivativeControl::None => {
                Op::DerivativeFine(axis)
            }
        };
        Ok(self.each1(op, Class::Real, &from))
    }

    /// Compiles the number of elements of a runtime-sized array.
    fn array_length(&mut self, array: Handle<Expression>) -> Result<Reg, String> {
        let pointer = self.pointer(array)?;
        let inner = pointer.ty.inner_with(&self.b.ir.types);
        let (PointerRoot::Buffer { number, .. }, TypeInner::Array { stride, .. }) =
            (&pointer.root, inner)
        else {
            return Err("the length of anything but an array in a buffer".into());
        };
        // What fits in the binding: WGSL §17.4.1.
        let bound = ElementCount::Runtime { offset: pointer.bytes, stride: *stride };
        let dynamics = vec![Dynamic { strides: [0; 3], bound }];
        let access = self.b.access(Access { buffer: *number, dynamics, change: None });
        let to = self.b.temporary(Class::Word);
        self.b.push(Op::ArrayLength(access), &[], &[to.0]);
        Ok(to)
    }

    fn literal(&mut self, literal: Literal) -> Result<Reg, String> {
        let (class, bits) = match literal {
            Literal::F64(x) => (Class::Wide, x.to_bits()),
            Literal::F32(x) => (Class::Real, u64::from(x.to_bits())),
            Literal::F16(x) => (Class::Real, u64::from(x.to_f32().to_bits())),
            Literal::U16(x) => (Class::Word, u64::from(x)),
            Literal::I16(x) => (Class::Word, u64::from(i32::from(x) as u32)),
            Literal::U32(x) => (Class::Word, u64::from(x)),
            Literal::I32(x) => (Class::Word, u64::from(x as u32)),
            Literal::U64(x) => (Class::Wide, x),
            Literal::I64(x) => (Class::Wide, x as u64),
            Literal::Bool(x) => (Class::Word, u64::from(x)),
            Literal::AbstractInt(_) | Literal::AbstractFloat(_) => {
                return Err("abstract numbers".into());
            }
        };
        Ok(self.b.constant(class, bits))
    }

    /// Compiles an expression of the module's arena, whose handles mean nothing in that of a
    /// function.
    fn global(&mut self, handle: Handle<Expression>) -> Result<Rc<[Reg]>, String> {
        if let ExpressionTypes::Module(_) = self.resolved {
            return self.regs(handle);
        }
        Function::of_module(self.b, self.function, self.globals).regs(handle)
    }

    /// Returns the value of an override: the given one, or its default.
    fn given(&mut self, handle: Handle<naga::Override>) -> Result<Rc<[Reg]>, String> {
        let declared = &self.b.ir.overrides[handle];
        if let Some(value) = self.b.overrides[handle.index()] {
            let TypeInner::Scalar(scalar) = self.b.ir.types[declared.ty].inner else {
                return Err("an override that is not a scalar".into());
            };
            let class = class(scalar)?;
            // It is given as an `f64`, whatever the type of the override.
            let bits = match (scalar.kind, class) {
                (ScalarKind::Float, Class::Wide) => value.to_bits(),
                (ScalarKind::Float, _) => u64::from((value as f32).to_bits()),
                (ScalarKind::Bool, _) => u64::from(value != 0.0),
                (ScalarKind::Sint, Class::Wide) => value as i64 as u64,
                (ScalarKind::Sint, _) => u64::from(value as i32 as u32),
                _ if class == Class::Wide => value as u64,
                _ => u64::from(value as u32),
            };
            return Ok([self.b.constant(class, bits)].into());
        }
        match declared.init {
            Some(init) => self.global(init),
            None => {
                let name = declared.name.clone().unwrap_or_default();
                Err(format!("the override `{name}`, which has no default and was given no value"))
            }
        }
    }

    /// Compiles a part at a constant index.
    fn part(&mut self, base: Handle<Expression>, index: u32) -> Result<Value, String> {
        match self.value(base)? {
            Value::Pointer(pointer) => Ok(Value::Pointer(Rc::new(self.step(&pointer, index)?))),
            // Nothing writes a read-only buffer during the run, so the part may be read where it is
            // used.
            Value::View(pointer) => {
                let part = Rc::new(self.step(&pointer, index)?);
                self.load(&part)
            }
            Value::Regs(regs) => {
                // A part of a value is some of its registers: nothing is computed.
                let step = self.b.types.step(self.ty(base), index)?;
                let count = self.b.types.leaf_count(step.ty.inner_with(&self.b.ir.types))?;
                let at = step.leaves as usize;
                let part = regs.get(at..at + count as usize);
                let part = part.ok_or("an index past the end of a value")?;
                Ok(Value::Regs(part.into()))
            }
        }
    }

    /// Compiles a part at a computed index.
    fn part_at(
        &mut self,
        base: Handle<Expression>,
        index: Handle<Expression>,
    ) -> Result<Value, String> {
        let index = self.scalar(index)?;
        if index.class() != Class::Word {
            return Err("an index of 64 bits".into());
        }
        match self.value(base)? {
            Value::Pointer(pointer) => Ok(Value::Pointer(Rc::new(self.index(&pointer, index)?))),
            Value::View(pointer) => {
                let part = Rc::new(self.index(&pointer, index)?);
                self.load(&part)
            }
            Value::Regs(regs) => {
                let bound = self.b.types.bound(self.ty(base)).unwrap_or(0);
                // A known index needs no choice at run time.
                match self.b.known(index).filter(|&i| i < u64::from(bound)) {
                    Some(index) => self.part(base, index as u32),
                    None => self.element(base, regs, index),
                }
            }
        }
    }

    fn pointee(&self, handle: Handle<Expression>) -> Result<naga::proc::TypeResolution, String> {
        use naga::proc::TypeResolution::{Handle, Value};
        match self.ty(handle) {
            TypeInner::Pointer { base, .. } => Ok(Handle(*base)),
            TypeInner::ValuePointer { size: Some(size), scalar, .. } => {
                Ok(Value(TypeInner::Vector { size: *size, scalar: *scalar }))
            }
            TypeInner::ValuePointer { size: None, scalar, .. } => {
                Ok(Value(TypeInner::Scalar(*scalar)))
            }
            _ => Err("a pointer of unknown type".into()),
        }
    }
}
