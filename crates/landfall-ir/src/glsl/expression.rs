//! Lowers names, members, indices, assignments and selections.

use landfall_layout::diagnostic::Code;
use landfall_layout::text::edit_distance::suggestion;
use naga::Expression;

use super::ast::*;
use super::body::{Body, Symbol, TypedValue};
use super::constant::{Const, literal};
use super::globals::Global;
use super::lvalue::{Address, HandlePath, Index, Lvalue, LvalueMemory};
use super::opaque::HandleChoice;
use super::types::{Kind, Ty};
use super::{Help, Lowering, refuse};

/// The result of an expression before it is loaded.
#[derive(Clone, Debug)]
pub enum ExpressionOperand {
    Value(TypedValue),
    Lvalue(Lvalue),
    Handle(HandleChoice),
    /// An array of blocks with the indices applied so far.
    Blocks(usize, Vec<u32>),
}

impl<'a> Body<'_, 'a> {
    pub fn value(&mut self, e: &Expr<'a>) -> Lowering<TypedValue> {
        let operand = self.operand(e)?;
        self.span = e.span;
        self.value_of_operand(operand)
    }

    pub fn values(&mut self, all: &[Expr<'a>]) -> Lowering<Vec<TypedValue>> {
        all.iter().map(|e| self.value(e)).collect()
    }

    pub fn value_of_operand(&mut self, operand: ExpressionOperand) -> Lowering<TypedValue> {
        match operand {
            ExpressionOperand::Value(value) => Ok(value),
            ExpressionOperand::Lvalue(place) => self.load(&place),
            ExpressionOperand::Handle(_) => {
                self.refuse("a sampler or image cannot be used as a value")
            }
            ExpressionOperand::Blocks(..) => {
                self.refuse("an array of blocks cannot be used as a value")
            }
        }
    }

    pub fn place(&mut self, e: &Expr<'a>) -> Lowering<Lvalue> {
        match self.operand(e)? {
            ExpressionOperand::Lvalue(place) => Ok(place),
            ExpressionOperand::Value(_)
            | ExpressionOperand::Handle(_)
            | ExpressionOperand::Blocks(..) => {
                self.span = e.span;
                self.refuse("the left side of the assignment is not writable")
            }
        }
    }

    pub fn effect(&mut self, e: &Expr<'a>) -> Lowering<()> {
        // Where the value is not needed, `i++` is `++i`, which loads once.
        match &e.kind {
            ExprKind::Call(..) | ExprKind::Construct(..) => {
                self.span = e.span;
                self.call_for_effect(e)
            }
            ExprKind::Comma(a, b) => {
                self.effect(a)?;
                self.effect(b)
            }
            ExprKind::Step(step, inner) => {
                self.step_value(IncrementOp { before: true, ..*step }, inner, e).map(|_| ())
            }
            ExprKind::Choose(parts) => {
                let [condition, accept, reject] = &**parts;
                let condition = self.boolean(condition)?.expr;
                let (accept, ()) = self.nested(|this| this.effect(accept))?;
                let (reject, ()) = self.nested(|this| this.effect(reject))?;
                self.statement(naga::Statement::If { condition, accept, reject });
                Ok(())
            }
            _ => self.operand(e).map(|_| ()),
        }
    }

    pub fn operand(&mut self, e: &Expr<'a>) -> Lowering<ExpressionOperand> {
        self.span = e.span;
        self.deeper(|this| this.operand_of(e))
    }

    fn operand_of(&mut self, e: &Expr<'a>) -> Lowering<ExpressionOperand> {
        // One case for each kind of expression of GLSL 4.60 §5.1.
        match &e.kind {
            ExprKind::Number(text) => self.literal_of(text, false).map(ExpressionOperand::Value),
            ExprKind::Bool(value) => {
                let expr = self.literal(naga::Literal::Bool(*value));
                Ok(ExpressionOperand::Value(TypedValue { expr, ty: Ty::BOOL }))
            }
            ExprKind::Name(name) => self.named(name),
            ExprKind::Unary(op, inner) => self.unary(*op, inner, e).map(ExpressionOperand::Value),
            ExprKind::Binary(op, a, b) => {
                self.binary_of(*op, a, b, e).map(ExpressionOperand::Value)
            }
            ExprKind::Assign(op, left, right) => {
                self.assign(*op, left, right, e).map(ExpressionOperand::Value)
            }
            ExprKind::Step(step, inner) => {
                self.step_value(*step, inner, e).map(ExpressionOperand::Value)
            }
            ExprKind::Choose(parts) => {
                let [condition, accept, reject] = &**parts;
                self.choice(condition, accept, reject, e).map(ExpressionOperand::Value)
            }
            ExprKind::Comma(a, b) => {
                // The value of `a, b` is that of `b`, but `a` is evaluated (GLSL 4.60 §5.9).
                self.effect(a)?;
                self.operand(b)
            }
            ExprKind::Index(base, index) => self.indexed(base, index, e),
            ExprKind::Member(base, name) => {
                let base = self.operand(base)?;
                self.span = e.span;
                self.member(base, name.text)
            }
            ExprKind::Call(..) | ExprKind::Construct(..) => self.call(e),
            ExprKind::Length(base) => self.length(base, e).map(ExpressionOperand::Value),
            ExprKind::List(_) => self.refuse("the type of `{ … }` cannot be inferred here"),
        }
    }

    /// Lowers a literal, possibly negated.
    pub fn literal_of(&mut self, text: &str, negative: bool) -> Lowering<TypedValue> {
        let Some((number, kind)) = literal(text) else {
            return self.refuse(format!("unsupported number `{text}`"));
        };
        let number = if negative { -number } else { number };
        // `-1u` is 2^32 - 1 (GLSL 4.60 §4.1.3).
        if kind == Kind::Uint && negative {
            return Ok(self.number(Kind::Uint, f64::from((-number as u32).wrapping_neg())));
        }
        // Out of range for `float` is an error here rather than an infinity in the IR, which naga
        // refuses.
        if kind == Kind::Float && !(number as f32).is_finite() {
            return self.refuse(format!("`{text}` is out of range for `float`"));
        }
        Ok(self.number(kind, number))
    }

    /// Resolves a name.
    pub fn named(&mut self, name: &str) -> Lowering<ExpressionOperand> {
        // Local scopes, then constants of the language, the shader's globals, built-in variables.
        match self.symbol(name).cloned() {
            Some(Symbol::Lvalue(place)) => return Ok(ExpressionOperand::Lvalue(place)),
            Some(Symbol::Value(value) | Symbol::Const(value, _)) => {
                return Ok(ExpressionOperand::Value(value));
            }
            Some(Symbol::Handles(root, ty, rest)) => {
                let path = Some(HandlePath { text: root, dynamic: None });
                let mem = match rest.as_deref() {
                    Some(Symbol::Lvalue(place)) => place.mem.clone(),
                    Some(Symbol::Value(value)) => self.spill(value)?.mem,
                    _ => LvalueMemory::Nothing,
                };
                return Ok(ExpressionOperand::Lvalue(Lvalue { path, ..Lvalue::new(mem, ty) }));
            }
            Some(Symbol::Structure(_)) => {
                return self.refuse(format!("`{name}` is a structure, not a variable"));
            }
            None => {}
        }
        // A declaration of the shader hides a constant of the language, such as
        // `gl_MaxDrawBuffers`.
        let known = self.cx.global_names.get(name).copied();
        match self.cx.language_constant(name) {
            Some(Const::List(items)) if known.is_none() => {
                let parts: Vec<_> =
                    items.iter().filter_map(|c| self.value_of(c)).map(|v| v.expr).collect();
                return self
                    .compose(&Ty::Vector(Kind::Uint, 3), parts)
                    .map(ExpressionOperand::Value);
            }
            Some(value) if known.is_none() => {
                if let Some(value) = self.value_of(&value) {
                    return Ok(ExpressionOperand::Value(value));
                }
            }
            _ => {}
        }
        let known = match known {
            Some(known) => Some(known),
            None => self.cx.predeclared(name, self.span)?,
        };
        if let Some(known) = known {
            return self.global(known, name);
        }
        let mut why = refuse(self.span, format!("there is no variable `{name}`"));
        why.code = Code::UnknownName;
        // Names in scope, for the suggestion.
        let scopes = self.scopes.iter().flat_map(|scope| scope.keys().copied());
        let names = scopes.chain(self.cx.global_names.keys().copied());
        why.help = suggestion(name, names);
        Err(why)
    }

    fn global(&mut self, index: usize, name: &str) -> Lowering<ExpressionOperand> {
        match self.cx.globals[index].clone() {
            Global::Variable { handle, ty, writable } => {
                let pointer = self.global_pointer(handle);
                let place = Lvalue::new(LvalueMemory::Own(pointer), ty);
                Ok(ExpressionOperand::Lvalue(Lvalue { writable, ..place }))
            }
            Global::Shared { handle, block_type } => {
                let pointer = self.global_pointer(handle);
                let ty = block_type.ty.clone();
                let mem = LvalueMemory::BlockType(Address::Pointer(pointer), block_type);
                Ok(ExpressionOperand::Lvalue(Lvalue::new(mem, ty)))
            }
            Global::Block(memory) if self.cx.memories[memory].dims.is_empty() => {
                self.memory(memory, 0).map(ExpressionOperand::Lvalue)
            }
            Global::Block(memory) => Ok(ExpressionOperand::Blocks(memory, Vec::new())),
            Global::Member { memory, ty, .. } => {
                let place = match memory {
                    Some(memory) => {
                        let whole = self.memory(memory, 0)?;
                        let structure = self.cx.memories[memory].structure.clone();
                        // Found by the member's name in the block without an instance name.
                        self.member_of(&whole, &structure, name)?
                    }
                    None => {
                        Lvalue { writable: false, ..Lvalue::new(LvalueMemory::Nothing, ty.clone()) }
                    }
                };
                let path =
                    ty.has_opaque().then(|| HandlePath { text: name.to_string(), dynamic: None });
                Ok(ExpressionOperand::Lvalue(Lvalue { path, ..place }))
            }
            Global::Constant { ty, declaration, index: which, value, .. } => {
                // A constant whose value is exact is a literal; another is computed once per
                // function, in its prologue, as the shader would.
                if let Some(value) = value.and_then(|value| self.value_of(&value)) {
                    return Ok(ExpressionOperand::Value(value));
                }
                if let Some(known) = self.constants.get(&index) {
                    return Ok(ExpressionOperand::Value(known.clone()));
                }
                let span = self.span;
                let init = declaration.names[which].init.as_ref();
                let Some(init) = init else {
                    return self.refuse(format!("the constant `{name}` has no value"));
                };
                let value = self.in_prologue(|this| this.initial(init, &ty))?;
                self.span = span;
                self.constants.insert(index, value.clone());
                Ok(ExpressionOperand::Value(value))
            }
            Global::Refused(mut why) => {
                let used = landfall_layout::Label { at: self.span, text: "used here".to_string() };
                // The label tells where the unsupported declaration is used.
                if why.labels.len() == 1 && why.labels[0].at != self.span {
                    why.labels.push(used);
                }
                Err(why)
            }
        }
    }

    /// Returns a block's memory as a place.
    fn memory(&mut self, memory: usize, element: usize) -> Lowering<Lvalue> {
        let memory = self.cx.memories[memory].clone();
        let block = self.global_pointer(memory.variables[element]);
        // A block that naga has no types for is addressed by bytes.
        let at = match memory.block_type.naga {
            Some(_) => Address::Pointer(block),
            None => Address::Words { block, fours: memory.fours, fixed: 0, dynamic: None },
        };
        let ty = Ty::Struct(memory.structure);
        let place = Lvalue::new(LvalueMemory::BlockType(at, memory.block_type), ty);
        Ok(Lvalue { writable: memory.writable, ..place })
    }

    fn indexed(
        &mut self,
        base: &Expr<'a>,
        index: &Expr<'a>,
        whole: &Expr<'a>,
    ) -> Lowering<ExpressionOperand> {
        let base = self.operand(base)?;
        // Constant indices are checked here; naga and drivers check the others.
        let fixed = self.constant(index).and_then(|c| c.integer());
        let index = match fixed {
            Some(fixed) => match u32::try_from(fixed) {
                Ok(fixed) => Index::Fixed(fixed),
                Err(_) => {
                    self.span = index.span;
                    return self.refuse(format!("negative index {fixed}"));
                }
            },
            None => {
                let value = self.value(index)?;
                if !matches!(value.ty, Ty::INT | Ty::UINT) {
                    return self.refuse(format!(
                        "expected an `int` or `uint` index, found `{}`",
                        value.ty
                    ));
                }
                Index::Dynamic(value.expr)
            }
        };
        self.span = whole.span;
        match base {
            ExpressionOperand::Lvalue(place)
                // A component of a swizzle by a variable index cannot be stored to, only read.
                if place.swizzle.is_some() && matches!(index, Index::Dynamic(_)) =>
            {
                let value = self.load(&place)?;
                self.element(&value, index).map(ExpressionOperand::Value)
            }
            ExpressionOperand::Lvalue(place) => {
                self.element_of(&place, index).map(ExpressionOperand::Lvalue)
            }
            ExpressionOperand::Value(value) => {
                self.element(&value, index).map(ExpressionOperand::Value)
            }
            ExpressionOperand::Handle(_) => self.refuse("a sampler or image cannot be indexed"),
            ExpressionOperand::Blocks(memory, mut taken) => {
                let dims = self.cx.memories[memory].dims.clone();
                let i = match index {
                    Index::Fixed(i) => i,
                    Index::Dynamic(i) if dims.len() == 1 => {
                        return self.one_of_blocks(memory, i).map(ExpressionOperand::Lvalue);
                    }
                    Index::Dynamic(_) => {
                        let message =
                            "variable indices into arrays of arrays of blocks are not supported";
                        return self.refuse(message);
                    }
                };
                if i >= dims[taken.len()] {
                    return self
                        .refuse(format!("index {i} is past the end of the array of blocks"));
                }
                taken.push(i);
                if taken.len() < dims.len() {
                    return Ok(ExpressionOperand::Blocks(memory, taken));
                }
                // Row-major: the last index is the fastest.
                let element = taken.iter().zip(&dims).fold(0u32, |at, (i, len)| at * len + i);
                self.memory(memory, element as usize).map(ExpressionOperand::Lvalue)
            }
        }
    }

    /// Copies the block that a variable index selects, because each is a separate buffer.
    fn one_of_blocks(
        &mut self,
        memory: usize,
        index: naga::Handle<Expression>,
    ) -> Lowering<Lvalue> {
        let chosen = self.cx.memories[memory].clone();
        let ty = Ty::Struct(chosen.structure.clone());
        let runtime = chosen.structure.members.iter().any(|f| matches!(f.ty, Ty::Array(_, None)));
        if chosen.writable || runtime {
            return Err(refuse(
                self.span,
                "variable indices into arrays of buffers are not supported",
            )
            .help("use a constant index: each element is a separate buffer"));
        }
        // A `switch` copies the chosen block; with a write or a runtime-sized array a copy would
        // not do.
        let local = self.local("", &ty)?;
        let copy = self.local_place(local, &ty);
        self.switch_over(index, chosen.variables.len() as u32, |this, i| {
            let block = this.memory(memory, i as usize)?;
            let value = this.load(&block)?;
            this.store(&copy, &value)
        })?;
        Ok(Lvalue { writable: false, ..copy })
    }

    pub fn element(&mut self, value: &TypedValue, index: Index) -> Lowering<TypedValue> {
        let Some((ty, len)) = value.ty.indexed() else {
            return self.refuse(format!("a `{}` cannot be indexed", value.ty));
        };
        match index {
            Index::Fixed(i) => {
                if len.is_some_and(|len| i >= len) {
                    return self.refuse(format!("index {i} is past the end of `{}`", value.ty));
                }
                Ok(TypedValue { expr: self.part(value.expr, i), ty })
            }
            Index::Dynamic(index) if matches!(value.ty, Ty::Vector(..)) => {
                let expr = self.add(Expression::Access { base: value.expr, index });
                Ok(TypedValue { expr, ty })
            }
            // naga indexes matrices and arrays with variables only behind a pointer.
            Index::Dynamic(_) => {
                let place = self.spill(value)?;
                let place = self.element_of(&place, index)?;
                self.load(&place)
            }
        }
    }

    fn member(&mut self, base: ExpressionOperand, name: &str) -> Lowering<ExpressionOperand> {
        match base {
            ExpressionOperand::Lvalue(place) => match place.ty.clone() {
                Ty::Struct(structure) => {
                    self.member_of(&place, &structure, name).map(ExpressionOperand::Lvalue)
                }
                _ => self.swizzle_of(&place, name).map(ExpressionOperand::Lvalue),
            },
            ExpressionOperand::Value(value) => match &value.ty {
                Ty::Struct(structure) => {
                    let Some(index) = structure.carried_index(name) else {
                        return self.refuse(format!("`{}` has no member `{name}`", value.ty));
                    };
                    let ty = structure.member(name).map_or(Ty::Void, |f| f.ty.clone());
                    Ok(ExpressionOperand::Value(TypedValue {
                        expr: self.part(value.expr, index),
                        ty,
                    }))
                }
                _ => {
                    let size = value.ty.components().map_or(0, |(_, size)| size);
                    let Some(picks) = super::lvalue::selection(name, size.into()) else {
                        return self.refuse(format!("a `{}` has no member `{name}`", value.ty));
                    };
                    self.select(&value, &picks).map(ExpressionOperand::Value)
                }
            },
            ExpressionOperand::Handle(_) => {
                self.refuse(format!("a sampler or image has no member `{name}`"))
            }
            ExpressionOperand::Blocks(..) => {
                self.refuse("an array of blocks is used without an index")
            }
        }
    }

    fn length(&mut self, base: &Expr<'a>, whole: &Expr<'a>) -> Lowering<TypedValue> {
        let operand = self.operand(base)?;
        self.span = whole.span;
        let ty = match &operand {
            ExpressionOperand::Value(value) => value.ty.clone(),
            ExpressionOperand::Lvalue(place) => place.ty.clone(),
            ExpressionOperand::Blocks(memory, taken) => {
                let len = self.cx.memories[*memory].dims[taken.len()];
                return Ok(self.number(Kind::Int, len.into()));
            }
            ExpressionOperand::Handle(_) => return self.refuse("a sampler or image has no length"),
        };
        match (&ty, &operand) {
            (Ty::Array(_, None), ExpressionOperand::Lvalue(place)) => self.runtime_length(place),
            _ => match ty.indexed() {
                Some((_, Some(len))) => Ok(self.number(Kind::Int, len.into())),
                _ => self.refuse(format!("a `{ty}` has no length")),
            },
        }
    }
}
