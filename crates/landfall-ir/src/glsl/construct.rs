//! Constructors and initialisers (GLSL 4.60 §4.1.11, §5.4).

use std::rc::Rc;

use super::Lowering;
use super::ast::*;
use super::body::{Body, TypedValue};
use super::constant::Const;
use super::types::{Kind, Structure, Ty, carried};

const MAX_ELEMENTS: usize = 1 << 16;

/// Returns an array type, with unsized dimensions taken from its initialiser.
pub fn sized_by<'a>(ty: Ty, init: &Expr<'a>, constant: &dyn Fn(&Expr<'a>) -> Option<Const>) -> Ty {
    // `float a[] = float[](1, 2, 3)` and `{ … }` fix the size of `a` (GLSL 4.60 §4.1.9), dimension
    // by dimension.
    let Ty::Array(element, len) = &ty else { return ty };
    let (items, written) = match &init.kind {
        ExprKind::List(items) => (items, None),
        ExprKind::Construct(spec, items) if !spec.dims.is_empty() => {
            let size = spec.dims[0].size.as_deref().and_then(constant);
            (items, size.and_then(|c| u32::try_from(c.integer()?).ok()))
        }
        _ => return ty,
    };
    let len = len.or(written).or(u32::try_from(items.len()).ok());
    let element = match items.first() {
        Some(first) => sized_by((**element).clone(), first, constant),
        None => (**element).clone(),
    };
    Ty::Array(Rc::new(element), len)
}

impl<'a> Body<'_, 'a> {
    /// Lowers the initialiser of a variable of that type.
    pub fn initial(&mut self, init: &Expr<'a>, ty: &Ty) -> Lowering<TypedValue> {
        let ExprKind::List(items) = &init.kind else {
            let value = self.value(init)?;
            self.span = init.span;
            // An array without a size takes that of its initialiser, whatever it is.
            if let (Ty::Array(_, None), Ty::Array(..)) = (ty, &value.ty) {
                return Ok(value);
            }
            return self.coerce(&value, ty);
        };
        self.deeper(|this| this.listed(items, ty, init))
    }

    fn listed(&mut self, items: &[Expr<'a>], ty: &Ty, whole: &Expr<'a>) -> Lowering<TypedValue> {
        if items.is_empty() {
            return self.zero(ty); // GL_EXT_null_initializer
        }
        // The types of the elements, which nested `{ … }` are read with (GLSL 4.60 §4.1.11).
        let wanted: Vec<Ty> = match ty {
            // Members that hold handles are not part of values.
            Ty::Struct(s) => carried(s).map(|field| field.ty.clone()).collect(),
            other => match other.indexed() {
                Some((element, Some(len))) if len as usize <= MAX_ELEMENTS => {
                    vec![element; len as usize]
                }
                _ => return self.refuse(format!("expected `{ty}`, found `{{ … }}`")),
            },
        };
        self.of_parts(items, wanted.iter(), ty, whole)
    }

    /// Lowers the values of each part of a type, of which there must be as many.
    fn of_parts<'t>(
        &mut self,
        items: &[Expr<'a>],
        wanted: impl ExactSizeIterator<Item = &'t Ty>,
        ty: &Ty,
        whole: &Expr<'a>,
    ) -> Lowering<TypedValue> {
        if wanted.len() != items.len() {
            self.span = whole.span;
            let (has, wants) = (items.len(), wanted.len());
            return self.refuse(format!("expected {wants} values for `{ty}`, found {has}"));
        }
        let mut parts = Vec::new();
        for (item, ty) in items.iter().zip(wanted) {
            parts.push(self.initial(item, ty)?.expr);
        }
        self.span = whole.span;
        self.compose(ty, parts)
    }

    /// `vec3(…)`, `float[](…)`, `Light[2](…)`.
    pub fn construct(
        &mut self,
        spec: &TypeSpec<'a>,
        arguments: &[Expr<'a>],
        whole: &Expr<'a>,
    ) -> Lowering<TypedValue> {
        let TypeBase::Name(name) = spec.base else {
            return self.refuse("structures cannot be declared in expressions");
        };
        let base = self.named_type(name, spec.span)?;
        if spec.dims.is_empty() {
            return self.construct_one(&base, arguments, whole);
        }
        let dims = self.dims(&spec.dims)?;
        let ty = super::Lowerer::arrayed(base, &dims, &[]);
        let ty = {
            let scope: &Self = self;
            // `float[](…)` has as many elements as arguments.
            sized_by(ty, whole, &|e| scope.constant(e))
        };
        let Some((mut element, Some(len))) = ty.indexed() else {
            return self.refuse(format!("unsupported constructor of `{ty}`"));
        };
        if arguments.len() > MAX_ELEMENTS {
            return self
                .refuse(format!("an initialiser cannot have more than {MAX_ELEMENTS} elements"));
        }
        if len as usize != arguments.len() {
            return self.refuse(format!(
                "wrong number of arguments for the constructor of `{ty}`: {}",
                arguments.len()
            ));
        }
        let mut parts = Vec::new();
        for argument in arguments {
            let value = self.initial(argument, &element)?;
            if let Ty::Array(_, None) = element {
                // An inner `[]` takes its size from the first element, and the others must agree.
                element = value.ty.clone();
            }
            parts.push(value.expr);
        }
        self.span = whole.span;
        self.compose(&Ty::Array(Rc::new(element), Some(len)), parts)
    }

    // GLSL 4.60 §5.4: a scalar from the first component, a vector from components in order, a
    // matrix by columns, from one scalar its diagonal, or from another matrix.
    fn construct_one(
        &mut self,
        ty: &Ty,
        arguments: &[Expr<'a>],
        whole: &Expr<'a>,
    ) -> Lowering<TypedValue> {
        if let Ty::Struct(s) = ty {
            let s = s.clone();
            return self.construct_structure(&s, arguments, whole);
        }
        let values = self.values(arguments)?;
        self.span = whole.span;
        if values.is_empty() || values.iter().any(|value| value.ty.kind().is_none()) {
            return self.refuse(format!("wrong argument type for the constructor of `{ty}`"));
        }
        match ty {
            Ty::Scalar(kind) => {
                let first = self.first_component(&values[0])?;
                self.convert(&first, &Ty::Scalar(*kind))
            }
            Ty::Vector(kind, size) => self.vector_of(*kind, *size, &values),
            Ty::Matrix(kind, columns, rows) => self.matrix_of(*kind, *columns, *rows, &values),
            Ty::Void | Ty::Array(..) | Ty::Struct(_) | Ty::Opaque(_) => {
                self.refuse(format!("`{ty}` has no constructor"))
            }
        }
    }

    pub fn construct_structure(
        &mut self,
        s: &Rc<Structure>,
        arguments: &[Expr<'a>],
        whole: &Expr<'a>,
    ) -> Lowering<TypedValue> {
        let ty = Ty::Struct(s.clone());
        if s.opaque {
            return self
                .refuse(format!("`{ty}` contains samplers or images and has no constructor"));
        }
        self.of_parts(arguments, s.members.iter().map(|field| &field.ty), &ty, whole)
    }

    fn first_component(&mut self, value: &TypedValue) -> Lowering<TypedValue> {
        match value.ty {
            Ty::Vector(kind, _) => {
                Ok(TypedValue { expr: self.part(value.expr, 0), ty: Ty::Scalar(kind) })
            }
            Ty::Matrix(kind, ..) => {
                let column = self.part(value.expr, 0);
                Ok(TypedValue { expr: self.part(column, 0), ty: Ty::Scalar(kind) })
            }
            _ => Ok(value.clone()),
        }
    }

    /// Returns a vector of the components of all values, up to its size.
    fn vector_of(&mut self, kind: Kind, size: u8, values: &[TypedValue]) -> Lowering<TypedValue> {
        let ty = Ty::Vector(kind, size);
        // One scalar fills the vector.
        if let ([value], Some((_, 1))) = (values, values[0].ty.components()) {
            let value = self.convert(value, &Ty::Scalar(kind))?;
            return self.splat(&value, size);
        }
        let mut parts = Vec::new();
        let mut left = size;
        for value in self.vectors(values)? {
            if left == 0 {
                break;
            }
            let (_, mut count) = value.ty.components().unwrap_or((kind, 1));
            let mut value = self.convert(&value, &value.ty.with_kind(kind))?;
            // Components past the size are dropped, as long as some of the argument were used
            // (GLSL 4.60 §5.4.2).
            if count > left {
                let picks: Vec<u8> = (0..left).collect();
                value = self.select(&value, &picks)?;
                count = left;
            }
            left -= count;
            // `vec3(v4)`, and `vec3(v3)` of another kind: no composition is needed.
            if count == size {
                return Ok(value);
            }
            parts.push(value.expr);
        }
        if left > 0 {
            return self.refuse(format!("too few components for `{ty}`: expected {size}"));
        }
        self.compose(&ty, parts)
    }

    /// Splits matrices among the values into columns.
    fn vectors(&mut self, values: &[TypedValue]) -> Lowering<Vec<TypedValue>> {
        let mut vectors = Vec::new();
        for value in values {
            let Ty::Matrix(kind, columns, rows) = value.ty else {
                vectors.push(value.clone());
                continue;
            };
            for i in 0..u32::from(columns) {
                let expr = self.part(value.expr, i);
                vectors.push(TypedValue { expr, ty: Ty::Vector(kind, rows) });
            }
        }
        Ok(vectors)
    }

    fn matrix_of(
        &mut self,
        kind: Kind,
        columns: u8,
        rows: u8,
        values: &[TypedValue],
    ) -> Lowering<TypedValue> {
        let ty = Ty::Matrix(kind, columns, rows);
        let mut parts = Vec::new();
        match values {
            [value] if matches!(value.ty, Ty::Scalar(_)) => {
                let value = self.convert(value, &Ty::Scalar(kind))?;
                let zero = self.number(kind, 0.0);
                for column in 0..columns {
                    let column =
                        (0..rows).map(|row| if row == column { value.expr } else { zero.expr });
                    let column = column.collect();
                    parts.push(self.compose(&Ty::Vector(kind, rows), column)?.expr);
                }
            }
            [value] if matches!(value.ty, Ty::Matrix(..)) => {
                return self.matrix_of_matrix(&ty, value);
            }
            _ => {
                let mut components = Vec::new();
                for value in self.vectors(values)? {
                    let value = self.convert(&value, &value.ty.with_kind(kind))?;
                    // Where a column begins and an argument has just its size, the column is taken
                    // whole.
                    let whole = components.len() % usize::from(rows) == 0;
                    let (_, count) = value.ty.components().unwrap_or((kind, 1));
                    if whole && count == rows {
                        // A column as it stands.
                        components.extend((0..count).map(|i| (value.expr, Some(i))));
                        continue;
                    }
                    for i in 0..count {
                        let expr =
                            if count == 1 { value.expr } else { self.part(value.expr, i.into()) };
                        components.push((expr, None));
                    }
                }
                let wanted = usize::from(columns) * usize::from(rows);
                if components.len() < wanted {
                    return self
                        .refuse(format!("too few components for `{ty}`: expected {wanted}"));
                }
                for column in components[..wanted].chunks(rows.into()) {
                    if let (first, Some(0)) = column[0] {
                        parts.push(first);
                        continue;
                    }
                    let mut scalars = Vec::new();
                    for &(expr, index) in column {
                        scalars.push(match index {
                            Some(index) => self.part(expr, index.into()),
                            None => expr,
                        });
                    }
                    parts.push(self.compose(&Ty::Vector(kind, rows), scalars)?.expr);
                }
            }
        }
        self.compose(&ty, parts)
    }

    /// Returns a matrix of another size, cut or filled up from the identity (GLSL 4.60 §5.4.2).
    fn matrix_of_matrix(&mut self, ty: &Ty, from: &TypedValue) -> Lowering<TypedValue> {
        let (Ty::Matrix(kind, columns, rows), Ty::Matrix(_, has_columns, has_rows)) =
            (ty, &from.ty)
        else {
            return self.refuse("only a matrix can be constructed from a matrix");
        };
        let (kind, columns, rows) = (*kind, *columns, *rows);
        let (has_columns, has_rows) = (*has_columns, *has_rows);
        if (columns, rows) == (has_columns, has_rows) {
            return self.convert(from, ty);
        }
        let from = self.convert(from, &Ty::Matrix(kind, has_columns, has_rows))?;
        let (one, zero) = (self.number(kind, 1.0), self.number(kind, 0.0));
        let mut parts = Vec::new();
        for column in 0..columns {
            let mut scalars = Vec::new();
            let given = (column < has_columns).then(|| self.part(from.expr, column.into()));
            if let (Some(given), true) = (given, rows == has_rows) {
                parts.push(given);
                continue;
            }
            for row in 0..rows {
                scalars.push(match given {
                    Some(given) if row < has_rows => self.part(given, row.into()),
                    _ if row == column => one.expr,
                    _ => zero.expr,
                });
            }
            parts.push(self.compose(&Ty::Vector(kind, rows), scalars)?.expr);
        }
        self.compose(ty, parts)
    }
}
