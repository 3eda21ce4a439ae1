//! Builds a function of naga's IR statement by statement.
//!
//! Used by [`module`](super::module) for its entry point.

use naga::{
    ArraySize, BinaryOperator, Block, Expression, Function, Handle, Literal, LocalVariable,
    MathFunction, Range, Scalar, ScalarKind, Span, Statement, Type, TypeInner, UniqueArena,
};

use super::packing::width;

/// A function under construction and its current block.
pub(super) struct KernelBuilder<'m> {
    pub types: &'m mut UniqueArena<Type>,
    pub function: Function,
    block: Block,
    /// The first expression that is not yet emitted.
    pending: Option<usize>,
    /// A 1 that compilers cannot fold, if there is one.
    one: Option<Handle<Expression>>,
}

/// The address of words in a buffer: a computed index plus a constant.
#[derive(Clone, Copy)]
pub(super) struct At {
    pub buffer: Handle<Expression>,
    pub base: Handle<Expression>,
    pub offset: u32,
}

impl At {
    fn on(self, words: u32) -> At {
        At { offset: self.offset + words, ..self }
    }
}

/// The longest array whose elements are read and written without a loop.
const UNROLLED: u32 = 4;

/// The operation on a part of a variable, given its pointer, type and words.
type Each<'m> = dyn Fn(&mut KernelBuilder<'m>, Handle<Expression>, Handle<Type>, At) -> Option<()>;

impl<'m> KernelBuilder<'m> {
    pub fn new(types: &'m mut UniqueArena<Type>) -> KernelBuilder<'m> {
        KernelBuilder {
            types,
            function: Function::default(),
            block: Block::new(),
            pending: None,
            one: None,
        }
    }

    /// Returns the finished function.
    pub fn finish(mut self) -> Function {
        self.flush();
        self.function.body = self.block;
        self.function
    }

    /// Adds an expression that is evaluated before the body.
    pub fn add_before_body(&mut self, expression: Expression) -> Handle<Expression> {
        // naga rejects an `Emit` over expressions that need none.
        self.flush();
        self.function.expressions.append(expression, Span::UNDEFINED)
    }

    /// Adds an expression that is computed here.
    pub fn computed(&mut self, expression: Expression) -> Handle<Expression> {
        self.pending.get_or_insert(self.function.expressions.len());
        self.function.expressions.append(expression, Span::UNDEFINED)
    }

    pub fn statement(&mut self, statement: Statement) {
        self.flush();
        self.block.push(statement, Span::UNDEFINED);
    }

    /// Makes loops count by a number read from a buffer's length: Mesa unrolls loops of hundreds of
    /// iterations, and LLVM compiles those for minutes (22.3.6).
    pub fn count_by_length(&mut self, buffer: Handle<Expression>) {
        // A buffer has one word at least, which compilers do not know.
        let one = self.number(1);
        let arg = self.computed(Expression::ArrayLength(buffer));
        self.one = Some(self.computed(Expression::Math {
            fun: MathFunction::Min,
            arg,
            arg1: Some(one),
            arg2: None,
            arg3: None,
        }));
    }

    /// Adds the result of a call statement.
    pub fn call_result(&mut self, function: Handle<Function>) -> Handle<Expression> {
        self.add_before_body(Expression::CallResult(function))
    }

    pub fn number(&mut self, number: u32) -> Handle<Expression> {
        self.add_before_body(Expression::Literal(Literal::U32(number)))
    }

    pub fn binary(
        &mut self,
        op: BinaryOperator,
        left: Handle<Expression>,
        right: Handle<Expression>,
    ) -> Handle<Expression> {
        self.computed(Expression::Binary { op, left, right })
    }

    pub fn index(&mut self, base: Handle<Expression>, index: u32) -> Handle<Expression> {
        self.computed(Expression::AccessIndex { base, index })
    }

    /// Adds a local variable and returns a pointer to it.
    pub fn local(&mut self, ty: Handle<Type>) -> Handle<Expression> {
        let local = LocalVariable { name: None, ty, init: None };
        let local = self.function.local_variables.append(local, Span::UNDEFINED);
        self.add_before_body(Expression::LocalVariable(local))
    }

    pub fn ty(&mut self, inner: TypeInner) -> Handle<Type> {
        self.types.insert(Type { name: None, inner }, Span::UNDEFINED)
    }

    fn flush(&mut self) {
        // Expressions are evaluated where an `Emit` covers them; arguments, variables and literals
        // need none.
        if let Some(first) = self.pending.take() {
            let range: Range<Expression> = self.function.expressions.range_from(first);
            self.block.push(Statement::Emit(range), Span::UNDEFINED);
        }
    }

    fn cast(
        &mut self,
        expr: Handle<Expression>,
        kind: ScalarKind,
        convert: Option<u8>,
    ) -> Handle<Expression> {
        self.computed(Expression::As { expr, kind, convert })
    }

    /// Returns a pointer to a word.
    fn word(&mut self, at: At) -> Handle<Expression> {
        let offset = self.number(at.offset);
        let index = self.binary(BinaryOperator::Add, at.base, offset);
        self.computed(Expression::Access { base: at.buffer, index })
    }

    /// Reads a value of a type from the words at an address.
    pub fn load(&mut self, ty: Handle<Type>, at: At) -> Option<Handle<Expression>> {
        if let TypeInner::Scalar(scalar) = self.types[ty].inner {
            return self.load_scalar(scalar, at);
        }
        // Unrolled, a long array takes compilers minutes.
        if self.long_array(ty).is_some() {
            let all = self.local(ty);
            self.load_into(all, ty, at)?;
            return Some(self.computed(Expression::Load { pointer: all }));
        }
        let parts = self.components(ty)?.into_iter();
        let parts = parts.map(|(part, offset)| self.load(part, at.on(offset)));
        let components = parts.collect::<Option<Vec<_>>>()?;
        Some(self.computed(Expression::Compose { ty, components }))
    }

    /// Returns the element type and the length of an array that is read and written in a loop.
    fn long_array(&self, ty: Handle<Type>) -> Option<(Handle<Type>, u32)> {
        match self.types[ty].inner {
            TypeInner::Array { base, size: ArraySize::Constant(len), .. } => {
                (len.get() > UNROLLED).then_some((base, len.get()))
            }
            _ => None,
        }
    }

    /// Returns the components of a type, each with the number of words before it.
    fn components(&mut self, ty: Handle<Type>) -> Option<Vec<(Handle<Type>, u32)>> {
        let (part, count) = match self.types[ty].inner.clone() {
            TypeInner::Vector { size, scalar } => (self.ty(TypeInner::Scalar(scalar)), size as u32),
            TypeInner::Matrix { columns, rows, scalar } => {
                (self.ty(TypeInner::Vector { size: rows, scalar }), columns as u32)
            }
            TypeInner::Array { base, size: ArraySize::Constant(len), .. } => (base, len.get()),
            TypeInner::Struct { members, .. } => {
                let mut components = Vec::with_capacity(members.len());
                let mut offset = 0;
                for member in members {
                    components.push((member.ty, offset));
                    offset += words(self.types, member.ty)?;
                }
                return Some(components);
            }
            _ => return None,
        };
        let step = words(self.types, part)?;
        Some((0..count).map(|i| (part, i * step)).collect())
    }

    /// Reads a value of a type into a variable part by part, so that a large one never exists as a
    /// whole, which compilers would split word by word.
    pub fn load_into(
        &mut self,
        pointer: Handle<Expression>,
        ty: Handle<Type>,
        at: At,
    ) -> Option<()> {
        self.parts(pointer, ty, at, &|new, part, ty, at| {
            let value = new.load(ty, at)?;
            new.statement(Statement::Store { pointer: part, value });
            Some(())
        })
    }

    /// Writes a variable part by part, as [`KernelBuilder::load_into`] reads it.
    pub fn store_from(
        &mut self,
        pointer: Handle<Expression>,
        ty: Handle<Type>,
        at: At,
    ) -> Option<()> {
        self.parts(pointer, ty, at, &|new, part, ty, at| {
            let value = new.computed(Expression::Load { pointer: part });
            new.store(ty, value, at)
        })
    }

    /// Applies an operation to each scalar, vector and matrix in a variable, with its words.
    fn parts(
        &mut self,
        pointer: Handle<Expression>,
        ty: Handle<Type>,
        at: At,
        each: &Each<'m>,
    ) -> Option<()> {
        if let Some((base, len)) = self.long_array(ty) {
            let step = words(self.types, base)?;
            let element = |new: &mut Self, part, at| new.parts(part, base, at, each);
            return self.in_a_loop(pointer, (len, step), at, element);
        }
        if !matches!(self.types[ty].inner, TypeInner::Struct { .. } | TypeInner::Array { .. }) {
            // Scalars, vectors and matrices are small enough to be moved as a whole.
            return each(self, pointer, ty, at);
        }
        for (i, (component, offset)) in (0..).zip(self.components(ty)?) {
            let part = self.index(pointer, i);
            self.parts(part, component, at.on(offset), each)?;
        }
        Some(())
    }

    /// Applies an operation to each element of an array in a loop, with its words.
    fn in_a_loop(
        &mut self,
        pointer: Handle<Expression>,
        (len, step): (u32, u32),
        at: At,
        each: impl FnOnce(&mut Self, Handle<Expression>, At) -> Option<()>,
    ) -> Option<()> {
        let uint = self.ty(TypeInner::Scalar(Scalar::U32));
        let counter = self.local(uint);
        let zero = self.number(0);
        let one = match self.one {
            Some(one) => one,
            None => self.number(1),
        };
        let (step, len) = (self.number(step), self.number(len));
        self.statement(Statement::Store { pointer: counter, value: zero });
        // The loop's blocks are built in place of the block around it, which is put aside.
        let outside = std::mem::take(&mut self.block);
        let number = self.computed(Expression::Load { pointer: counter });
        let over = self.binary(BinaryOperator::GreaterEqual, number, len);
        let mut accept = Block::new();
        accept.push(Statement::Break, Span::UNDEFINED);
        self.statement(Statement::If { condition: over, accept, reject: Block::new() });
        let skipped = self.binary(BinaryOperator::Multiply, number, step);
        let base = self.binary(BinaryOperator::Add, at.base, skipped);
        let part = self.computed(Expression::Access { base: pointer, index: number });
        each(self, part, At { base, ..at })?;
        // Before the block is taken: what is pending belongs to it.
        self.flush();
        let body = std::mem::take(&mut self.block);
        let number = self.computed(Expression::Load { pointer: counter });
        let value = self.binary(BinaryOperator::Add, number, one);
        self.statement(Statement::Store { pointer: counter, value });
        let continuing = std::mem::replace(&mut self.block, outside);
        self.statement(Statement::Loop { body, continuing, break_if: None });
        Some(())
    }

    fn load_scalar(&mut self, scalar: Scalar, at: At) -> Option<Handle<Expression>> {
        let pointer = self.word(at);
        let word = self.computed(Expression::Load { pointer });
        let word = match scalar.width {
            // The lower word is the first.
            8 => {
                let pointer = self.word(at.on(1));
                let high = self.computed(Expression::Load { pointer });
                let low = self.cast(word, ScalarKind::Uint, Some(8));
                let wide = self.cast(high, ScalarKind::Uint, Some(8));
                let half = self.number(32);
                let shifted = self.binary(BinaryOperator::ShiftLeft, wide, half);
                self.binary(BinaryOperator::InclusiveOr, low, shifted)
            }
            _ => word,
        };
        Some(match (scalar.kind, scalar.width) {
            (ScalarKind::Bool, _) => {
                let zero = self.number(0);
                self.binary(BinaryOperator::NotEqual, word, zero)
            }
            (ScalarKind::Uint, 4 | 8) => word,
            (kind @ (ScalarKind::Sint | ScalarKind::Float), 4 | 8) => self.cast(word, kind, None),
            // Types below 32 bits are held as 32-bit types.
            (kind @ (ScalarKind::Sint | ScalarKind::Float), small) => {
                let held = self.cast(word, kind, None);
                self.cast(held, kind, Some(small))
            }
            (ScalarKind::Uint, small) => self.cast(word, ScalarKind::Uint, Some(small)),
            (ScalarKind::AbstractInt | ScalarKind::AbstractFloat, _) => return None,
        })
    }

    /// Writes a value of a type.
    pub fn store(&mut self, ty: Handle<Type>, value: Handle<Expression>, at: At) -> Option<()> {
        if let TypeInner::Scalar(scalar) = self.types[ty].inner {
            return self.store_scalar(scalar, value, at);
        }
        if self.long_array(ty).is_some() {
            // Elements of a value in a variable can be written in a loop.
            let all = self.local(ty);
            self.statement(Statement::Store { pointer: all, value });
            return self.store_from(all, ty, at);
        }
        for (i, (component, offset)) in (0..).zip(self.components(ty)?) {
            let part = self.index(value, i);
            self.store(component, part, at.on(offset))?;
        }
        Some(())
    }

    fn store_scalar(&mut self, scalar: Scalar, value: Handle<Expression>, at: At) -> Option<()> {
        let word = match (scalar.kind, scalar.width) {
            (ScalarKind::Bool, _) => {
                let (accept, reject) = (self.number(1), self.number(0));
                self.computed(Expression::Select { condition: value, accept, reject })
            }
            (ScalarKind::Uint, 4 | 8) => value,
            (ScalarKind::Sint | ScalarKind::Float, 4 | 8) => {
                self.cast(value, ScalarKind::Uint, None)
            }
            (kind @ (ScalarKind::Sint | ScalarKind::Uint | ScalarKind::Float), _) => {
                // As it was loaded: in 32 bits.
                let held = self.cast(value, kind, Some(4));
                self.cast(held, ScalarKind::Uint, None)
            }
            (ScalarKind::AbstractInt | ScalarKind::AbstractFloat, _) => return None,
        };
        if scalar.width != 8 {
            self.store_word(word, at);
            return Some(());
        }
        let low = self.cast(word, ScalarKind::Uint, Some(4));
        self.store_word(low, at);
        let half = self.number(32);
        let high = self.binary(BinaryOperator::ShiftRight, word, half);
        let high = self.cast(high, ScalarKind::Uint, Some(4));
        self.store_word(high, at.on(1));
        Some(())
    }

    pub fn store_word(&mut self, value: Handle<Expression>, at: At) {
        let pointer = self.word(at);
        self.statement(Statement::Store { pointer, value });
    }
}

/// Returns the number of words of a type; `None` if it has no plain value.
fn words(types: &UniqueArena<Type>, ty: Handle<Type>) -> Option<u32> {
    Some(match &types[ty].inner {
        TypeInner::Scalar(scalar) => width(scalar.width),
        TypeInner::Vector { size, scalar } => *size as u32 * width(scalar.width),
        TypeInner::Matrix { columns, rows, scalar } => {
            *columns as u32 * *rows as u32 * width(scalar.width)
        }
        // The length is the shader's, so that the product may be any.
        TypeInner::Array { base, size: ArraySize::Constant(len), .. } => {
            words(types, *base)?.checked_mul(len.get())?
        }
        TypeInner::Struct { members, .. } => {
            let each = members.iter().map(|member| words(types, member.ty));
            each.sum::<Option<u32>>()?
        }
        _ => return None,
    })
}
