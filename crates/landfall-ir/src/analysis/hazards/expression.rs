//! Turns expressions into nodes, and runs [`checks`](super::checks) on each.

use naga::{Expression, Handle, Literal, MathFunction as M};

use super::graph::{GraphOp, Id};
use super::memory::{Projection, Value};
use super::walk::{Walk, WalkFrame};
use landfall_layout::source::Span;

impl<'m> Walk<'m> {
    /// Returns the value of an expression, evaluated on demand.
    pub fn value(&mut self, frame: &mut WalkFrame<'m>, handle: Handle<Expression>) -> Id {
        match self.pointer(frame, handle) {
            Value::Is(id) => id,
            at @ Value::At(..) => self.load(&at, None),
        }
    }

    /// Returns the value of an expression, or the variable it points to.
    pub fn pointer(&mut self, frame: &mut WalkFrame<'m>, handle: Handle<Expression>) -> Value {
        if let Some(value) = frame.values.get(&handle) {
            return value.clone();
        }
        let value = self.evaluate(frame, handle);
        // A pointer into a variable is the same at every evaluation; a value may not be.
        // Expressions that naga evaluates at an `Emit` are inserted there; those of no statement
        // (literals, globals, arguments) are the same everywhere.
        if frame.function.expressions[handle].needs_pre_emit() {
            frame.values.insert(handle, value.clone());
        }
        value
    }

    pub fn place(&self, frame: &WalkFrame<'m>, handle: Handle<Expression>) -> Option<Span> {
        self.module.locate(frame.function.expressions.get_span(handle))
    }

    pub fn literal(&mut self, literal: &Literal) -> Id {
        let number = match *literal {
            Literal::F64(v) | Literal::AbstractFloat(v) => v,
            Literal::F32(v) => f64::from(v),
            Literal::F16(v) => v.to_f64(),
            Literal::U16(v) => f64::from(v),
            Literal::I16(v) => f64::from(v),
            Literal::U32(v) => f64::from(v),
            Literal::I32(v) => f64::from(v),
            Literal::U64(v) => v as f64,
            // Beyond 2^53 rounded, which no guard depends on.
            Literal::I64(v) | Literal::AbstractInt(v) => v as f64,
            Literal::Bool(v) => f64::from(u8::from(v)),
        };
        self.graph.number(number)
    }

    pub fn composed(&mut self, parts: &[Id]) -> Id {
        // A vector of equal numbers is that number: facts are per component.
        match parts {
            [first, rest @ ..]
                if self.graph.value(*first).is_some() && rest.iter().all(|p| p == first) =>
            {
                *first
            }
            parts => self.graph.add(GraphOp::Compose, parts),
        }
    }

    pub fn evaluate(&mut self, frame: &mut WalkFrame<'m>, handle: Handle<Expression>) -> Value {
        let span = self.place(frame, handle);
        let id = match &frame.function.expressions[handle] {
            Expression::Literal(literal) => self.literal(literal),
            Expression::Constant(constant) => self.constant(self.ir.constants[*constant].init),
            Expression::Override(handle) => {
                let (name, ty) = {
                    let known = &self.ir.overrides[*handle];
                    (known.name.clone().unwrap_or_default(), known.ty)
                };
                self.outside(&name, ty, super::graph::Origin::Other)
            }
            Expression::ZeroValue(_) => self.graph.number(0.0),
            Expression::Compose { ty, components } => {
                let parts: Vec<Id> =
                    components.iter().map(|&part| self.value(frame, part)).collect();
                self.composite(*ty, &parts)
            }
            Expression::Splat { value, .. } => self.value(frame, *value),
            Expression::Access { base, index } => {
                let index = self.value(frame, *index);
                match self.pointer(frame, *base) {
                    // A path into a variable stays a path until it is loaded or stored.
                    Value::At(cell, mut steps) => {
                        steps.push(Projection::Element(index));
                        return Value::At(cell, steps);
                    }
                    Value::Is(base) => self.element(base, index, span),
                }
            }
            Expression::AccessIndex { base, index } => match self.pointer(frame, *base) {
                Value::At(cell, mut steps) => {
                    steps.push(Projection::Part(*index));
                    return Value::At(cell, steps);
                }
                Value::Is(base) => self.part(base, *index),
            },
            Expression::Swizzle { size, vector, pattern } => {
                let of = self.value(frame, *vector);
                self.swizzled(of, &pattern[..*size as usize])
            }
            Expression::FunctionArgument(number) => match frame.arguments.get(*number as usize) {
                Some(value) => return value.clone(),
                None => self.graph.opaque(&[]),
            },
            Expression::GlobalVariable(handle) => return self.global_value(*handle),
            Expression::LocalVariable(handle) => {
                return Value::At(frame.locals + handle.index(), Vec::new());
            }
            Expression::Load { pointer } => {
                let from = self.pointer(frame, *pointer);
                self.load(&from, span)
            }
            Expression::Unary { op, expr } => {
                let of = self.value(frame, *expr);
                self.unary(*op, of)
            }
            Expression::Binary { op, left, right } => {
                let (a, b) = (self.value(frame, *left), self.value(frame, *right));
                let id = self.graph.add(GraphOp::Binary(*op), &[a, b]);
                if let Some(span) = span {
                    self.look_at_binary(*op, a, b, id, span);
                }
                id
            }
            Expression::Select { condition, accept, reject } => {
                let condition = self.value(frame, *condition);
                let (yes, no) = (self.value(frame, *accept), self.value(frame, *reject));
                self.selected(condition, yes, no)
            }
            Expression::Math { fun, arg, arg1, arg2, arg3 } => {
                let given = [Some(*arg), *arg1, *arg2, *arg3];
                let args: Vec<Id> =
                    given.into_iter().flatten().map(|arg| self.value(frame, arg)).collect();
                let id = self.math(*fun, &args);
                if let Some(span) = span {
                    let wide = self.is_four_wide(frame, *arg);
                    self.look_at_math(*fun, &args, id, span, wide);
                }
                id
            }
            Expression::As { expr, .. } => {
                let of = self.value(frame, *expr);
                // Conversions of constants are dropped: `float(1)` compares equal to 1.0.
                let known = self.graph.value(of).is_some();
                if known { of } else { self.graph.add(GraphOp::Convert, &[of]) }
            }
            Expression::Relational { fun, argument } => {
                let of = self.value(frame, *argument);
                self.relational(*fun, of)
            }
            Expression::ArrayLength(array) => {
                let of = self.value(frame, *array);
                self.array_length(of)
            }
            other => self.unknown(frame, other),
        };
        Value::Is(id)
    }

    /// Returns a value of which nothing is known, with what it is made of.
    fn unknown(&mut self, frame: &mut WalkFrame<'m>, expression: &Expression) -> Id {
        let id = self.graph.opaque(&[]);
        // Texture coordinates and derivatives decide the value, although it is unknown: `falloff`
        // asks what depends on a light.
        if let Expression::ImageSample { coordinate: of, .. }
        | Expression::ImageLoad { coordinate: of, .. }
        | Expression::Derivative { expr: of, .. } = expression
        {
            let of = self.value(frame, *of);
            self.control.hidden.insert(id, vec![of]);
        }
        id
    }

    /// Returns a vector, matrix, array or structure of those parts.
    fn composite(&mut self, ty: Handle<naga::Type>, parts: &[Id]) -> Id {
        let id = self.composed(parts);
        // `vec4(v, 1.0)` has fewer arguments than components, so argument `n` is not component
        // `n`.
        let wanted = match self.ir.types[ty].inner {
            naga::TypeInner::Vector { size, .. } => size as usize,
            naga::TypeInner::Matrix { columns, .. } => columns as usize,
            _ => parts.len(),
        };
        if wanted == parts.len() {
            self.whole_parts.insert(id);
        }
        id
    }

    fn swizzled(&mut self, of: Id, pattern: &[naga::SwizzleComponent]) -> Id {
        if self.graph.value(of).is_some() {
            return of;
        }
        let mut way = [u8::MAX; 4];
        for (to, from) in way.iter_mut().zip(pattern) {
            *to = *from as u8;
        }
        self.graph.add(GraphOp::Swizzle(way), &[of])
    }

    fn unary(&mut self, op: naga::UnaryOperator, of: Id) -> Id {
        match (op, self.graph.value(of)) {
            (naga::UnaryOperator::Negate, Some(number)) => self.graph.number(-number),
            (naga::UnaryOperator::Negate, None) => self.graph.add(GraphOp::Negate, &[of]),
            (naga::UnaryOperator::LogicalNot, _) => self.graph.add(GraphOp::Not, &[of]),
            (naga::UnaryOperator::BitwiseNot, _) => self.graph.opaque(&[of]),
        }
    }

    /// Evaluates a math function; `distance` is the length of a difference.
    fn math(&mut self, fun: M, args: &[Id]) -> Id {
        match (fun, args) {
            // One form, so that the checks of lengths know distances, too.
            (M::Distance, &[a, b]) => {
                let op = GraphOp::Binary(naga::BinaryOperator::Subtract);
                let apart = self.graph.add(op, &[a, b]);
                self.graph.add(GraphOp::Math(M::Length), &[apart])
            }
            _ => self.graph.add(GraphOp::Math(fun), args),
        }
    }

    fn relational(&mut self, fun: naga::RelationalFunction, of: Id) -> Id {
        match fun {
            naga::RelationalFunction::All | naga::RelationalFunction::Any => {
                // `any` and `all` keep the comparison below, from which a condition learns.
                self.graph.add(GraphOp::Convert, &[of])
            }
            _ => self.graph.opaque(&[of]),
        }
    }

    fn array_length(&mut self, of: Id) -> Id {
        match self.graph.as_leaf(of).cloned() {
            Some(leaf) => {
                let (key, path) =
                    (format!("{}.length()", leaf.key), format!("{}.length()", leaf.path));
                let light = None;
                self.graph.leaf(super::graph::Leaf { key, path, light, role: None, ..leaf })
            }
            None => self.graph.opaque(&[of]),
        }
    }

    fn selected(&mut self, condition: Id, yes: Id, no: Id) -> Id {
        // The operands' own facts under the condition: `x > 0.0 ? x : 1.0` is above zero.
        let mark = self.mark();
        self.assume(condition, true);
        let when_true = self.facts(yes);
        self.reconsider(yes);
        self.forget(mark);
        self.assume(condition, false);
        let when_false = self.facts(no);
        self.reconsider(no);
        self.forget(mark);
        let id = self.graph.add(GraphOp::Chosen, &[condition, yes, no]);
        self.settled.insert(id, when_true.or(when_false));
        id
    }

    fn is_four_wide(&self, frame: &WalkFrame<'m>, handle: Handle<Expression>) -> bool {
        // Types of expressions are known after validation only; the node's shape tells instead.
        let is_quad = |ty: Handle<naga::Type>| {
            let inner = &self.ir.types[ty].inner;
            matches!(inner, naga::TypeInner::Vector { size: naga::VectorSize::Quad, .. })
        };
        match &frame.function.expressions[handle] {
            Expression::Compose { ty, .. } => is_quad(*ty),
            Expression::Load { pointer } => match frame.function.expressions[*pointer] {
                Expression::LocalVariable(v) => is_quad(frame.function.local_variables[v].ty),
                _ => false,
            },
            Expression::Binary { op: naga::BinaryOperator::Multiply, left, right } => {
                self.is_four_wide(frame, *left) || self.is_four_wide(frame, *right)
            }
            _ => false,
        }
    }
}
