//! Operators and conversions (GLSL 4.60 §4.1.10, §5.9).

use naga::{BinaryOperator as B, Expression, Handle, RelationalFunction};

use super::Lowering;
use super::ast::Binary;
use super::body::{Body, TypedValue};
use super::types::{Kind, Ty, carried};

/// The most components that a comparison expands to.
/// Arrays and structures compare element by element, each an expression.
const MAX_COMPARED: u64 = 1024;

impl Body<'_, '_> {
    /// Converts a value implicitly.
    pub fn coerce(&mut self, value: &TypedValue, ty: &Ty) -> Lowering<TypedValue> {
        if !value.ty.converts_to(ty) {
            return self.refuse(format!("expected `{ty}`, found `{}`", value.ty));
        }
        self.convert(value, ty)
    }

    /// Converts the components of a scalar, vector or matrix.
    pub fn convert(&mut self, value: &TypedValue, ty: &Ty) -> Lowering<TypedValue> {
        // Constructors convert freely, `coerce` only implicitly (GLSL 4.60 §5.4.1, §4.1.10).
        if value.ty == *ty {
            return Ok(value.clone());
        }
        let (Some(from), Some(to)) = (value.ty.kind(), ty.kind()) else {
            return self.refuse(format!("`{}` cannot be converted to `{ty}`", value.ty));
        };
        if value.ty.with_kind(to) != *ty {
            return self.refuse(format!("`{}` cannot be converted to `{ty}`", value.ty));
        }
        if from == to {
            return Ok(TypedValue { expr: value.expr, ty: ty.clone() });
        }
        // Literals are converted here, so that constant expressions stay literals.
        if let Expression::Literal(literal) = &self.function.expressions[value.expr] {
            if let Some(number) = number_of(literal) {
                return Ok(self.number(to, number));
            }
        }
        let scalar = to.scalar();
        if let Ty::Matrix(_, columns, rows) = ty {
            // naga converts matrices of one width only.
            if scalar.width != from.scalar().width {
                let mut parts = Vec::new();
                for i in 0..*columns {
                    let expr = self.part(value.expr, i.into());
                    let (kind, convert) = (scalar.kind, Some(scalar.width));
                    parts.push(self.add(Expression::As { expr, kind, convert }));
                }
                return self.compose(&Ty::Matrix(to, *columns, *rows), parts);
            }
        }
        let expr = value.expr;
        let expr =
            self.add(Expression::As { expr, kind: scalar.kind, convert: Some(scalar.width) });
        Ok(TypedValue { expr, ty: ty.clone() })
    }

    /// Returns the common type of two operands of the same shape.
    pub fn common(&self, a: &Ty, b: &Ty) -> Lowering<Ty> {
        // The conversion that is possible in one direction (GLSL 4.60 §4.1.10): `int` and `float`
        // meet in `float`.
        if a.converts_to(b) {
            Ok(b.clone())
        } else if b.converts_to(a) {
            Ok(a.clone())
        } else {
            self.refuse(format!("mismatched types `{a}` and `{b}`"))
        }
    }

    fn common_kind(&self, a: &Ty, b: &Ty) -> Lowering<Kind> {
        match (a.kind(), b.kind()) {
            (Some(x), Some(y)) if x.converts_to(y) => Ok(y),
            (Some(x), Some(y)) if y.converts_to(x) => Ok(x),
            _ => self.refuse(format!("mismatched types `{a}` and `{b}`")),
        }
    }

    pub fn operate(&mut self, op: Binary, a: &TypedValue, b: &TypedValue) -> Lowering<TypedValue> {
        match op {
            // GLSL 4.60 §5.9: `==` takes any two values of one type.
            Binary::Equal | Binary::NotEqual => {
                let ty = self.common(&a.ty, &b.ty)?;
                let (a, b) = (self.convert(a, &ty)?, self.convert(b, &ty)?);
                let expr = self.equal(a.expr, b.expr, &ty, op == Binary::Equal)?;
                Ok(TypedValue { expr, ty: Ty::BOOL })
            }
            Binary::Less | Binary::LessEqual | Binary::Greater | Binary::GreaterEqual => {
                let ty = self.common(&a.ty, &b.ty)?;
                // `<` takes scalars alone; vectors have `lessThan`.
                if !matches!(ty, Ty::Scalar(kind) if kind != Kind::Bool) {
                    return self.refuse(format!("relational operators do not take a `{ty}`"));
                }
                let (a, b) = (self.convert(a, &ty)?, self.convert(b, &ty)?);
                Ok(TypedValue { expr: self.binary(comparison(op), a.expr, b.expr), ty: Ty::BOOL })
            }
            // `^^` of booleans is `!=`.
            Binary::Xor => {
                let (a, b) = (self.coerce(a, &Ty::BOOL)?, self.coerce(b, &Ty::BOOL)?);
                Ok(TypedValue { expr: self.binary(B::NotEqual, a.expr, b.expr), ty: Ty::BOOL })
            }
            Binary::And | Binary::Or => {
                let (a, b) = (self.coerce(a, &Ty::BOOL)?, self.coerce(b, &Ty::BOOL)?);
                let op = if op == Binary::And { B::LogicalAnd } else { B::LogicalOr };
                Ok(TypedValue { expr: self.binary(op, a.expr, b.expr), ty: Ty::BOOL })
            }
            Binary::ShiftLeft | Binary::ShiftRight => self.shift(op, a, b),
            Binary::BitAnd | Binary::BitOr | Binary::BitXor | Binary::Modulo => {
                let kind = self.common_kind(&a.ty, &b.ty)?;
                if !kind.is_integer() {
                    let (a, b) = (&a.ty, &b.ty);
                    return self.refuse(format!("this operator does not take a `{a}` and a `{b}`"));
                }
                let (a, b) = self.same_shape(a, b, kind)?;
                Ok(TypedValue { expr: self.binary(arithmetic(op), a.expr, b.expr), ty: a.ty })
            }
            Binary::Add | Binary::Subtract | Binary::Multiply | Binary::Divide => {
                let kind = self.common_kind(&a.ty, &b.ty)?;
                if kind == Kind::Bool {
                    return self.refuse("this operator does not take a `bool`");
                }
                let a = self.convert(a, &a.ty.with_kind(kind))?;
                let b = self.convert(b, &b.ty.with_kind(kind))?;
                // Products of matrices are linear algebra; all other operators go component by
                // component (§5.10).
                if matches!(a.ty, Ty::Matrix(..)) || matches!(b.ty, Ty::Matrix(..)) {
                    return self.with_matrix(op, &a, &b);
                }
                // naga multiplies a vector of floats by a scalar as it stands.
                let mixed = op == Binary::Multiply
                    && kind.is_float()
                    && (matches!(a.ty, Ty::Scalar(_)) != matches!(b.ty, Ty::Scalar(_)));
                if mixed {
                    let ty = if matches!(a.ty, Ty::Scalar(_)) { &b.ty } else { &a.ty };
                    let ty = ty.clone();
                    return Ok(TypedValue { expr: self.binary(B::Multiply, a.expr, b.expr), ty });
                }
                let (a, b) = self.same_shape(&a, &b, kind)?;
                Ok(TypedValue { expr: self.binary(arithmetic(op), a.expr, b.expr), ty: a.ty })
            }
        }
    }

    /// Converts two scalars or vectors to one size and kind.
    pub fn same_shape(
        &mut self,
        a: &TypedValue,
        b: &TypedValue,
        kind: Kind,
    ) -> Lowering<(TypedValue, TypedValue)> {
        let a = self.convert(a, &a.ty.with_kind(kind))?;
        let b = self.convert(b, &b.ty.with_kind(kind))?;
        match (a.ty.components(), b.ty.components()) {
            (Some((_, x)), Some((_, y))) if x == y => Ok((a, b)),
            (Some((_, 1)), Some((_, y))) => Ok((self.splat(&a, y)?, b)),
            (Some((_, x)), Some((_, 1))) => {
                let b = self.splat(&b, x)?;
                Ok((a, b))
            }
            _ => self.refuse(format!("mismatched types `{}` and `{}`", a.ty, b.ty)),
        }
    }

    fn shift(&mut self, op: Binary, a: &TypedValue, b: &TypedValue) -> Lowering<TypedValue> {
        let (Some((kind, size)), Some((by, width))) = (a.ty.components(), b.ty.components()) else {
            return self.refuse(format!("a `{}` cannot be shifted", a.ty));
        };
        if !kind.is_integer() || !by.is_integer() || (width != 1 && width != size) {
            return self.refuse(format!("a `{}` cannot be shifted by a `{}`", a.ty, b.ty));
        }
        // naga's count is unsigned.
        let by = self.convert(b, &b.ty.with_kind(Kind::Uint))?;
        let by = if width == 1 { self.splat(&by, size)? } else { by };
        let op = if op == Binary::ShiftLeft { B::ShiftLeft } else { B::ShiftRight };
        Ok(TypedValue { expr: self.binary(op, a.expr, by.expr), ty: a.ty.clone() })
    }

    fn with_matrix(&mut self, op: Binary, a: &TypedValue, b: &TypedValue) -> Lowering<TypedValue> {
        let wrong =
            |this: &Self| this.refuse(format!("mismatched types `{}` and `{}`", a.ty, b.ty));
        if op == Binary::Multiply {
            // M v, v M and M N by their inner dimensions (GLSL 4.60 §5.10).
            let ty = match (&a.ty, &b.ty) {
                (Ty::Matrix(..), Ty::Scalar(_)) => a.ty.clone(),
                (Ty::Scalar(_), Ty::Matrix(..)) => b.ty.clone(),
                (Ty::Matrix(kind, columns, rows), Ty::Vector(_, size)) if columns == size => {
                    Ty::Vector(*kind, *rows)
                }
                (Ty::Vector(kind, size), Ty::Matrix(_, columns, rows)) if size == rows => {
                    Ty::Vector(*kind, *columns)
                }
                (Ty::Matrix(kind, columns, rows), Ty::Matrix(_, other, inner))
                    if columns == inner =>
                {
                    Ty::Matrix(*kind, *other, *rows)
                }
                _ => return wrong(self),
            };
            return Ok(TypedValue { expr: self.binary(B::Multiply, a.expr, b.expr), ty });
        }
        let (ty, columns) = match (&a.ty, &b.ty) {
            (Ty::Matrix(_, columns, _), other) if *other == a.ty => (a.ty.clone(), *columns),
            (Ty::Matrix(_, columns, _), Ty::Scalar(_)) => (a.ty.clone(), *columns),
            (Ty::Scalar(_), Ty::Matrix(_, columns, _)) => (b.ty.clone(), *columns),
            _ => return wrong(self),
        };
        // naga adds and subtracts matrices of one type, and divides none.
        if a.ty == b.ty && op != Binary::Divide {
            return Ok(TypedValue { expr: self.binary(arithmetic(op), a.expr, b.expr), ty });
        }
        let mut parts = Vec::new();
        for i in 0..u32::from(columns) {
            let left = self.column_or_scalar(a, i);
            let right = self.column_or_scalar(b, i);
            parts.push(self.operate(op, &left, &right)?.expr);
        }
        self.compose(&ty, parts)
    }

    fn column_or_scalar(&mut self, value: &TypedValue, index: u32) -> TypedValue {
        match value.ty {
            Ty::Matrix(kind, _, rows) => {
                TypedValue { expr: self.part(value.expr, index), ty: Ty::Vector(kind, rows) }
            }
            _ => value.clone(),
        }
    }

    /// Lowers `==` or `!=` of two values of one type.
    pub fn equal(
        &mut self,
        a: Handle<Expression>,
        b: Handle<Expression>,
        ty: &Ty,
        same: bool,
    ) -> Lowering<Handle<Expression>> {
        let (op, fun, join) = match same {
            // Equal if all parts are, unequal if any is.
            true => (B::Equal, RelationalFunction::All, B::LogicalAnd),
            false => (B::NotEqual, RelationalFunction::Any, B::LogicalOr),
        };
        if ty.leaves() > MAX_COMPARED {
            return self.refuse(format!("values of `{ty}` are too large to compare"));
        }
        let parts: Vec<(u32, Ty)> = match ty {
            Ty::Scalar(_) => return Ok(self.binary(op, a, b)),
            Ty::Vector(..) => {
                let argument = self.binary(op, a, b);
                return Ok(self.add(Expression::Relational { fun, argument }));
            }
            Ty::Matrix(kind, columns, rows) => {
                (0..*columns).map(|i| (i.into(), Ty::Vector(*kind, *rows))).collect()
            }
            Ty::Array(element, Some(len)) => (0..*len).map(|i| (i, (**element).clone())).collect(),
            Ty::Struct(s) => {
                carried(s).enumerate().map(|(i, f)| (i as u32, f.ty.clone())).collect()
            }
            Ty::Array(..) | Ty::Void | Ty::Opaque(_) => {
                return self.refuse(format!("values of `{ty}` cannot be compared"));
            }
        };
        let mut result = None;
        for (index, ty) in parts {
            let (left, right) = (self.part(a, index), self.part(b, index));
            let part = self.equal(left, right, &ty, same)?;
            result = Some(match result {
                Some(before) => self.binary(join, before, part),
                None => part,
            });
        }
        match result {
            Some(result) => Ok(result),
            None => self.refuse(format!("a `{ty}` holds nothing that can be compared")),
        }
    }
}

pub fn comparison(op: Binary) -> B {
    match op {
        Binary::Less => B::Less,
        Binary::LessEqual => B::LessEqual,
        Binary::Greater => B::Greater,
        Binary::GreaterEqual => B::GreaterEqual,
        Binary::NotEqual => B::NotEqual,
        _ => B::Equal,
    }
}

fn arithmetic(op: Binary) -> B {
    match op {
        Binary::Subtract => B::Subtract,
        Binary::Multiply => B::Multiply,
        Binary::Divide => B::Divide,
        Binary::Modulo => B::Modulo,
        Binary::BitAnd => B::And,
        Binary::BitOr => B::InclusiveOr,
        Binary::BitXor => B::ExclusiveOr,
        _ => B::Add,
    }
}

fn number_of(literal: &naga::Literal) -> Option<f64> {
    use naga::Literal as L;
    Some(match *literal {
        L::F64(v) => v,
        L::F32(v) => v.into(),
        L::U32(v) => v.into(),
        L::I32(v) if v >= 0 => v.into(),
        L::Bool(v) => u8::from(v).into(),
        _ => return None,
    })
}
