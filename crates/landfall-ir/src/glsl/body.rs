//! A function under construction: its expressions, blocks and scopes.
//!
//! The modules that lower [`ast`](super::ast) build on this one, which is independent of GLSL's
//! semantics.

use naga::{Expression, Handle, Literal, LocalVariable, Range, Statement};
use rustc_hash::FxHashMap;

use super::constant::Const;
use super::lvalue::{Lvalue, LvalueMemory};
use super::opaque::HandlePair;
use super::types::{Kind, Ty};
use super::{Lowerer, Lowering, refuse};
use landfall_layout::source::Span;

/// A value: a naga expression and its GLSL type.
#[derive(Clone, Debug)]
pub struct TypedValue {
    pub expr: Handle<Expression>,
    pub ty: Ty,
}

/// The meaning of a name in a function body.
#[derive(Clone, Debug)]
pub enum Symbol {
    /// A variable.
    Lvalue(Lvalue),
    Value(TypedValue),
    /// A constant whose integer value is known.
    Const(TypedValue, Const),
    /// A parameter that is or contains handles: their path, and its other values.
    Handles(String, Ty, Option<Box<Symbol>>),
    Structure(Ty),
}

/// A function being lowered.
/// naga evaluates expressions at `Emit` statements. They are collected in `pending` as a range and
/// emitted before the next statement; expressions of no statement (literals, globals, arguments)
/// break the range.
pub struct Body<'l, 'a> {
    pub cx: &'l mut Lowerer<'a>,
    pub function: naga::Function,
    /// The open blocks, outermost first.
    blocks: Vec<naga::Block>,
    /// The statements before all others, for constants of the shader.
    pub prologue: naga::Block,
    /// The first and last expression that is not emitted yet.
    pending: Option<(Handle<Expression>, Handle<Expression>)>,
    literals: FxHashMap<(u8, u64), Handle<Expression>>,
    globals: FxHashMap<Handle<naga::GlobalVariable>, Handle<Expression>>,
    locals: FxHashMap<Handle<LocalVariable>, Handle<Expression>>,
    /// The shader's constants that this function has lowered, by index.
    pub constants: FxHashMap<usize, TypedValue>,
    pub scopes: Vec<FxHashMap<&'a str, Symbol>>,
    /// The handles passed as arguments, by path.
    pub handles: FxHashMap<String, HandlePair>,
    pub returns: Ty,
    pub span: Span,
    /// Whether the block ended with a jump.
    pub dead: bool,
}

impl<'l, 'a> Body<'l, 'a> {
    pub fn new(cx: &'l mut Lowerer<'a>, returns: Ty, span: Span) -> Body<'l, 'a> {
        Body {
            cx,
            function: naga::Function::default(),
            blocks: vec![naga::Block::new()],
            prologue: naga::Block::new(),
            pending: None,
            literals: FxHashMap::default(),
            globals: FxHashMap::default(),
            locals: FxHashMap::default(),
            constants: FxHashMap::default(),
            scopes: vec![FxHashMap::default()],
            handles: FxHashMap::default(),
            returns,
            span,
            dead: false,
        }
    }

    pub fn finish(mut self) -> naga::Function {
        self.flush();
        let body = self.blocks.pop().expect("the outermost block is never taken away");
        // Constants of the shader come first, so that every block after them can use them.
        let mut whole = std::mem::take(&mut self.prologue);
        for (statement, span) in body.span_into_iter() {
            whole.push(statement, span);
        }
        self.function.body = whole;
        self.function
    }

    pub fn naga_span(&self) -> naga::Span {
        self.cx.naga_span(self.span)
    }

    /// Appends an expression; it is emitted with its neighbours.
    pub fn add(&mut self, expression: Expression) -> Handle<Expression> {
        let early = expression.needs_pre_emit();
        if early {
            self.flush();
        }
        // An expression that is never emitted must not lie within an emitted range.
        let span = self.naga_span();
        let handle = self.function.expressions.append(expression, span);
        if !early {
            let first = self.pending.map_or(handle, |(first, _)| first);
            self.pending = Some((first, handle));
        }
        handle
    }

    /// Appends an expression that a statement evaluates: the result of a call.
    pub fn add_result(&mut self, expression: Expression) -> Handle<Expression> {
        self.flush();
        let span = self.naga_span();
        self.function.expressions.append(expression, span)
    }

    /// Emits the pending expressions.
    pub fn flush(&mut self) {
        if let Some((first, last)) = self.pending.take() {
            let span = self.naga_span();
            // After a jump nothing is reachable: naga refuses statements there.
            if !self.dead {
                let block = self.blocks.last_mut().expect("there is always a block");
                block.push(Statement::Emit(Range::new_from_bounds(first, last)), span);
            }
        }
    }

    pub fn statement(&mut self, statement: Statement) {
        self.flush();
        if self.dead {
            return;
        }
        let span = self.naga_span();
        self.dead = matches!(
            statement,
            Statement::Break | Statement::Continue | Statement::Return { .. } | Statement::Kill
        );
        self.blocks.last_mut().expect("there is always a block").push(statement, span);
    }

    /// Lowers into a new block.
    pub fn nested<T>(
        &mut self,
        fill: impl FnOnce(&mut Self) -> Lowering<T>,
    ) -> Lowering<(naga::Block, T)> {
        self.flush();
        // A jump in the new block does not end the one around it.
        let dead = std::mem::take(&mut self.dead);
        self.blocks.push(naga::Block::new());
        let result = fill(self);
        self.flush();
        self.dead = dead;
        let block = self.blocks.pop().expect("just pushed");
        Ok((block, result?))
    }

    pub fn resume_block(
        &mut self,
        block: naga::Block,
        fill: impl FnOnce(&mut Self) -> Lowering<()>,
    ) -> Lowering<naga::Block> {
        let (block, ()) = self.nested(|this| {
            *this.blocks.last_mut().expect("just pushed") = block;
            fill(this)
        })?;
        Ok(block)
    }

    /// Lowers into the statements before all others.
    pub fn in_prologue<T>(&mut self, fill: impl FnOnce(&mut Self) -> Lowering<T>) -> Lowering<T> {
        let (block, result) = self.nested(|this| {
            // A shader's constant must not see the function's local names.
            let scopes = std::mem::replace(&mut this.scopes, vec![FxHashMap::default()]);
            let result = fill(this);
            this.scopes = scopes;
            result
        })?;
        for (statement, span) in block.span_into_iter() {
            self.prologue.push(statement, span);
        }
        Ok(result)
    }

    pub fn scoped<T>(&mut self, fill: impl FnOnce(&mut Self) -> Lowering<T>) -> Lowering<T> {
        self.scopes.push(FxHashMap::default());
        let result = fill(self);
        self.scopes.pop();
        result
    }

    pub fn declare(&mut self, name: &'a str, symbol: Symbol) {
        self.scopes.last_mut().expect("there is always a scope").insert(name, symbol);
    }

    pub fn symbol(&self, name: &str) -> Option<&Symbol> {
        // The innermost scope first.
        self.scopes.iter().rev().find_map(|scope| scope.get(name))
    }

    pub fn local(&mut self, name: &str, ty: &Ty) -> Lowering<Handle<LocalVariable>> {
        let handle = self.cx.value_type(ty, self.span)?;
        let span = self.naga_span();
        let name = (!name.is_empty()).then(|| name.to_string());
        let variable = LocalVariable { name, ty: handle, init: None };
        Ok(self.function.local_variables.append(variable, span))
    }

    pub fn local_pointer(&mut self, local: Handle<LocalVariable>) -> Handle<Expression> {
        if let Some(&pointer) = self.locals.get(&local) {
            return pointer;
        }
        let pointer = self.add(Expression::LocalVariable(local));
        self.locals.insert(local, pointer);
        pointer
    }

    pub fn global_pointer(&mut self, global: Handle<naga::GlobalVariable>) -> Handle<Expression> {
        if let Some(&pointer) = self.globals.get(&global) {
            return pointer;
        }
        let pointer = self.add(Expression::GlobalVariable(global));
        self.globals.insert(global, pointer);
        pointer
    }

    pub fn local_place(&mut self, local: Handle<LocalVariable>, ty: &Ty) -> Lvalue {
        // Each pointer expression is made once per function; naga permits their use in any block.
        Lvalue::new(LvalueMemory::Own(self.local_pointer(local)), ty.clone())
    }

    /// Creates a local variable that holds a value.
    pub fn spill(&mut self, value: &TypedValue) -> Lowering<Lvalue> {
        let local = self.local("", &value.ty)?;
        let pointer = self.local_pointer(local);
        self.statement(Statement::Store { pointer, value: value.expr });
        Ok(Lvalue::new(LvalueMemory::Own(pointer), value.ty.clone()))
    }

    pub fn literal(&mut self, literal: Literal) -> Handle<Expression> {
        let key = match literal {
            Literal::F64(v) => (0, v.to_bits()),
            Literal::F32(v) => (1, v.to_bits().into()),
            Literal::U32(v) => (2, v.into()),
            Literal::I32(v) => (3, v as u64),
            Literal::Bool(v) => (4, v.into()),
            Literal::U64(v) => (5, v),
            Literal::I64(v) => (6, v as u64),
            Literal::U16(v) => (7, v.into()),
            Literal::I16(v) => (8, v as u64),
            Literal::F16(v) => (9, v.to_bits().into()),
            Literal::AbstractInt(v) => (10, v as u64),
            Literal::AbstractFloat(v) => (11, v.to_bits()),
        };
        if let Some(&handle) = self.literals.get(&key) {
            return handle;
        }
        let handle = self.add(Expression::Literal(literal));
        self.literals.insert(key, handle);
        handle
    }

    pub fn u32(&mut self, value: u32) -> Handle<Expression> {
        self.literal(Literal::U32(value))
    }

    /// Returns a number as a scalar of a kind.
    pub fn number(&mut self, kind: Kind, value: f64) -> TypedValue {
        let literal = match kind {
            Kind::Bool => Literal::Bool(value != 0.0),
            // Between integers the bits stay, without the high ones that do not fit (GLSL 4.60
            // §5.4.1, GL_EXT_shader_explicit_arithmetic_types).
            Kind::Int if value > f64::from(i32::MAX) => Literal::I32(value as u32 as i32),
            Kind::Int => Literal::I32(value as i32),
            Kind::Uint if value < 0.0 => Literal::U32(value as i32 as u32),
            Kind::Uint => Literal::U32(value as u32),
            Kind::Float => Literal::F32(value as f32),
            Kind::Double => Literal::F64(value),
            // Through f32 to f16 would round twice; rounding to odd first makes the second
            // rounding the only one.
            Kind::Half => Literal::F16(half::f16::from_f32(
                landfall_layout::buffer::float::round_to_odd(value),
            )),
            Kind::Short => Literal::I16(value as i64 as i16),
            Kind::Ushort => Literal::U16(value as i64 as u16),
            Kind::Long => Literal::I64(value as i64),
            Kind::Ulong if value < 0.0 => Literal::U64(value as i64 as u64),
            Kind::Ulong => Literal::U64(value as u64),
        };
        TypedValue { expr: self.literal(literal), ty: Ty::Scalar(kind) }
    }

    pub fn value_of(&mut self, constant: &Const) -> Option<TypedValue> {
        let (literal, ty) = match constant {
            Const::Bool(value) => (Literal::Bool(*value), Ty::BOOL),
            Const::Int(value) => (Literal::I32(*value), Ty::INT),
            Const::Uint(value) => (Literal::U32(*value), Ty::UINT),
            Const::Long(value) => (Literal::I64(*value), Ty::Scalar(Kind::Long)),
            Const::Ulong(value) => (Literal::U64(*value), Ty::Scalar(Kind::Ulong)),
            Const::Float(value) => (Literal::F32(*value as f32), Ty::FLOAT),
            // Lists and numbers without a type have no scalar literal.
            Const::Abstract(_) | Const::List(_) => return None,
        };
        Some(TypedValue { expr: self.literal(literal), ty })
    }

    pub fn zero(&mut self, ty: &Ty) -> Lowering<TypedValue> {
        let handle = self.cx.value_type(ty, self.span)?;
        Ok(TypedValue { expr: self.add(Expression::ZeroValue(handle)), ty: ty.clone() })
    }

    pub fn compose(
        &mut self,
        ty: &Ty,
        components: Vec<Handle<Expression>>,
    ) -> Lowering<TypedValue> {
        let handle = self.cx.value_type(ty, self.span)?;
        Ok(TypedValue {
            expr: self.add(Expression::Compose { ty: handle, components }),
            ty: ty.clone(),
        })
    }

    pub fn part(&mut self, base: Handle<Expression>, index: u32) -> Handle<Expression> {
        self.add(Expression::AccessIndex { base, index })
    }

    pub fn binary(
        &mut self,
        op: naga::BinaryOperator,
        left: Handle<Expression>,
        right: Handle<Expression>,
    ) -> Handle<Expression> {
        self.add(Expression::Binary { op, left, right })
    }

    pub fn selected(
        &mut self,
        condition: Handle<Expression>,
        accept: Handle<Expression>,
        reject: Handle<Expression>,
    ) -> Handle<Expression> {
        self.add(Expression::Select { condition, accept, reject })
    }

    /// Lowers a `switch` over the elements of an array.
    pub fn switch_over(
        &mut self,
        index: Handle<Expression>,
        len: u32,
        mut each: impl FnMut(&mut Self, u32) -> Lowering<()>,
    ) -> Lowering<()> {
        let kind = naga::ScalarKind::Uint;
        let selector = self.add(Expression::As { expr: index, kind, convert: Some(4) });
        let mut cases = Vec::new();
        for i in 0..len {
            let (body, ()) = self.nested(|this| each(this, i))?;
            // The last one takes every other index, which GLSL leaves undefined (GLSL 4.60 §5.7).
            let last = i + 1 == len;
            let value = if last { naga::SwitchValue::Default } else { naga::SwitchValue::U32(i) };
            cases.push(naga::SwitchCase { value, body, fall_through: false });
        }
        self.statement(Statement::Switch { selector, cases });
        Ok(())
    }

    /// Lowers an `if` with two results.
    pub fn choose(
        &mut self,
        condition: Handle<Expression>,
        ty: &Ty,
        accept: impl FnOnce(&mut Self) -> Lowering<TypedValue>,
        reject: impl FnOnce(&mut Self) -> Lowering<TypedValue>,
    ) -> Lowering<TypedValue> {
        // naga has no phi: both sides store to a local, which is loaded after the `if`.
        let local = self.local("", ty)?;
        let pointer = self.local_pointer(local);
        let (accept, ()) = self.nested(|this| {
            let value = accept(this)?;
            this.statement(Statement::Store { pointer, value: value.expr });
            Ok(())
        })?;
        let (reject, ()) = self.nested(|this| {
            let value = reject(this)?;
            this.statement(Statement::Store { pointer, value: value.expr });
            Ok(())
        })?;
        self.statement(Statement::If { condition, accept, reject });
        Ok(TypedValue { expr: self.add(Expression::Load { pointer }), ty: ty.clone() })
    }

    /// Lowers a loop that runs `each` with 0 up to `count`, exclusive.
    pub fn repeat(
        &mut self,
        count: Handle<Expression>,
        each: impl FnOnce(&mut Self, Handle<Expression>) -> Lowering<()>,
    ) -> Lowering<()> {
        let counter = self.local("", &Ty::UINT)?;
        let pointer = self.local_pointer(counter);
        let (zero, one) = (self.u32(0), self.u32(1));
        self.statement(Statement::Store { pointer, value: zero });
        let (body, ()) = self.nested(|this| {
            let index = this.add(Expression::Load { pointer });
            let done = this.binary(naga::BinaryOperator::GreaterEqual, index, count);
            let (stop, ()) = this.nested(|this| {
                this.statement(Statement::Break);
                Ok(())
            })?;
            this.statement(Statement::If {
                condition: done,
                accept: stop,
                reject: naga::Block::new(),
            });
            each(this, index)
        })?;
        let (continuing, ()) = self.nested(|this| {
            let index = this.add(Expression::Load { pointer });
            let value = this.binary(naga::BinaryOperator::Add, index, one);
            this.statement(Statement::Store { pointer, value });
            Ok(())
        })?;
        self.statement(Statement::Loop { body, continuing, break_if: None });
        Ok(())
    }

    pub fn refuse<T>(&self, message: impl Into<String>) -> Lowering<T> {
        Err(refuse(self.span, message))
    }
}
