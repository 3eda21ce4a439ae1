//! Lowers operators, assignments and selections.
//!
//! The other half of [`expression`](super::expression).

use naga::{Expression, UnaryOperator};

use super::Lowering;
use super::ast::*;
use super::body::{Body, TypedValue};
use super::name_usage::is_simple;
use super::types::{Kind, Ty};

impl<'a> Body<'_, 'a> {
    pub fn unary(&mut self, op: Unary, inner: &Expr<'a>, whole: &Expr<'a>) -> Lowering<TypedValue> {
        // `-2147483648` is the least `int`, although 2147483648 is none.
        if let (Unary::Minus, ExprKind::Number(text)) = (op, &inner.kind) {
            return self.literal_of(text, true);
        }
        let value = self.value(inner)?;
        self.span = whole.span;
        let kind = value.ty.kind();
        let (op, fits) = match op {
            Unary::Plus => return Ok(value),
            Unary::Minus => (UnaryOperator::Negate, kind.is_some_and(|k| k != Kind::Bool)),
            Unary::Not => (UnaryOperator::LogicalNot, value.ty == Ty::BOOL),
            Unary::Complement => (UnaryOperator::BitwiseNot, kind.is_some_and(Kind::is_integer)),
        };
        if !fits {
            return self.refuse(format!("this operator does not take a `{}`", value.ty));
        }
        // naga negates no unsigned numbers: 0 - x is the same bits.
        if op == UnaryOperator::Negate && kind.is_some_and(|k| k.is_integer() && !k.is_signed()) {
            let zero = self.zero(&value.ty)?;
            let expr = self.binary(naga::BinaryOperator::Subtract, zero.expr, value.expr);
            return Ok(TypedValue { expr, ty: value.ty });
        }
        // Nor matrices: column by column.
        if let Ty::Matrix(_, columns, _) = value.ty {
            let mut parts = Vec::new();
            for i in 0..u32::from(columns) {
                let expr = self.part(value.expr, i);
                parts.push(self.add(Expression::Unary { op, expr }));
            }
            return self.compose(&value.ty, parts);
        }
        let expr = self.add(Expression::Unary { op, expr: value.expr });
        Ok(TypedValue { expr, ty: value.ty })
    }

    pub fn not(&mut self, expr: naga::Handle<Expression>) -> naga::Handle<Expression> {
        self.add(Expression::Unary { op: UnaryOperator::LogicalNot, expr })
    }

    pub fn binary_of(
        &mut self,
        op: Binary,
        a: &Expr<'a>,
        b: &Expr<'a>,
        whole: &Expr<'a>,
    ) -> Lowering<TypedValue> {
        // `&&` and `||` evaluate the right side only if the left one leaves the result open (GLSL
        // 4.60 §5.9). A side without effects may be evaluated anyway, which keeps the code flat.
        if matches!(op, Binary::And | Binary::Or) {
            let left = self.boolean(a)?;
            if is_simple(b) {
                let right = self.boolean(b)?;
                self.span = whole.span;
                let op = match op {
                    Binary::And => naga::BinaryOperator::LogicalAnd,
                    _ => naga::BinaryOperator::LogicalOr,
                };
                let expr = self.binary(op, left.expr, right.expr);
                return Ok(TypedValue { expr, ty: Ty::BOOL });
            }
            let known = |this: &mut Self| {
                let expr = this.literal(naga::Literal::Bool(op == Binary::Or));
                Ok(TypedValue { expr, ty: Ty::BOOL })
            };
            return match op {
                Binary::And => self.choose(left.expr, &Ty::BOOL, |t| t.boolean(b), known),
                _ => self.choose(left.expr, &Ty::BOOL, known, |t| t.boolean(b)),
            };
        }
        let left = self.value(a)?;
        let right = self.value(b)?;
        self.span = whole.span;
        self.operate(op, &left, &right)
    }

    // assignment = unary-expression assignment-operator assignment-expression (GLSL 4.60 §5.8);
    // the value is what was stored.
    pub fn assign(
        &mut self,
        op: Option<Binary>,
        left: &Expr<'a>,
        right: &Expr<'a>,
        whole: &Expr<'a>,
    ) -> Lowering<TypedValue> {
        // The place first, then the value: indices on the left are evaluated once.
        let place = self.place(left)?;
        let mut value = match (op, &right.kind) {
            (None, ExprKind::List(_)) => self.initial(right, &place.ty)?,
            _ => self.value(right)?,
        };
        self.span = whole.span;
        if let Some(op) = op {
            let before = self.load(&place)?;
            value = self.operate(op, &before, &value)?;
        }
        let value = self.coerce(&value, &place.ty)?;
        self.store(&place, &value)?;
        Ok(value)
    }

    pub fn step_value(
        &mut self,
        step: IncrementOp,
        inner: &Expr<'a>,
        whole: &Expr<'a>,
    ) -> Lowering<TypedValue> {
        let place = self.place(inner)?;
        self.span = whole.span;
        let before = self.load(&place)?;
        let Some(kind) = before.ty.kind().filter(|&k| k != Kind::Bool) else {
            return self.refuse(format!("`++` and `--` do not take a `{}`", before.ty));
        };
        let one = self.number(kind, 1.0);
        let op = if step.increment { Binary::Add } else { Binary::Subtract };
        let after = self.operate(op, &before, &one)?;
        self.store(&place, &after)?;
        // `x++` has the value before, `++x` the one after.
        Ok(if step.before { after } else { before })
    }

    pub fn choice(
        &mut self,
        condition: &Expr<'a>,
        accept: &Expr<'a>,
        reject: &Expr<'a>,
        whole: &Expr<'a>,
    ) -> Lowering<TypedValue> {
        let condition = self.boolean(condition)?;
        // Without side effects both sides are evaluated and selected; else each in a block of its
        // own (GLSL 4.60 §5.9).
        if is_simple(accept) && is_simple(reject) {
            let accept = self.value(accept)?;
            let reject = self.value(reject)?;
            self.span = whole.span;
            let ty = self.common(&accept.ty, &reject.ty)?;
            let accept = self.convert(&accept, &ty)?;
            let reject = self.convert(&reject, &ty)?;
            return self.select_value(condition.expr, &accept, &reject);
        }
        let (accept_block, accept) = self.nested(|this| this.value(accept))?;
        let (reject_block, reject) = self.nested(|this| this.value(reject))?;
        self.span = whole.span;
        // Only after both are lowered is the common type known, so the stores are added to the
        // blocks later.
        let ty = self.common(&accept.ty, &reject.ty)?;
        let local = self.local("", &ty)?;
        let pointer = self.local_pointer(local);
        let mut keep = |block, value: &TypedValue| {
            self.resume_block(block, |this| {
                let value = this.convert(value, &ty)?;
                this.statement(naga::Statement::Store { pointer, value: value.expr });
                Ok(())
            })
        };
        let accept = keep(accept_block, &accept)?;
        let reject = keep(reject_block, &reject)?;
        self.statement(naga::Statement::If { condition: condition.expr, accept, reject });
        let expr = self.add(Expression::Load { pointer });
        Ok(TypedValue { expr, ty })
    }

    pub fn select_value(
        &mut self,
        condition: naga::Handle<Expression>,
        accept: &TypedValue,
        reject: &TypedValue,
    ) -> Lowering<TypedValue> {
        let ty = accept.ty.clone();
        if ty.components().is_none() {
            // naga selects scalars and vectors only.
            let (accept, reject) = (accept.clone(), reject.clone());
            return self.choose(condition, &ty, |_| Ok(accept), |_| Ok(reject));
        }
        let expr = self.selected(condition, accept.expr, reject.expr);
        Ok(TypedValue { expr, ty })
    }
}
