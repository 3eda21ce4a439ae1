//! Built-in functions that naga lacks, or lacks for some types, expanded to operators.

use naga::{BinaryOperator as B, Expression, MathFunction as M};

use super::Lowering;
use super::ast::{Binary, Expr};
use super::body::{Body, TypedValue};
use super::types::{Kind, Ty};

impl<'a> Body<'_, 'a> {
    /// Lowers a function; `None` if it does not take these arguments.
    pub fn expanded_call(
        &mut self,
        name: &str,
        values: &[TypedValue],
    ) -> Lowering<Option<TypedValue>> {
        match (name, values) {
            ("mod", [_, _]) => {
                let Some(values) = self.convert_to_common_type(values, true)? else {
                    return Ok(None);
                };
                // GLSL 4.60 §8.3: x - y * floor(x / y).
                let (x, y) = (values[0].expr, values[1].expr);
                let quotient = self.binary(B::Divide, x, y);
                let whole = self.math(M::Floor, &[quotient]);
                let product = self.binary(B::Multiply, y, whole);
                let expr = self.binary(B::Subtract, x, product);
                Ok(Some(TypedValue { expr, ty: values[0].ty.clone() }))
            }
            // By a bool, `mix` chooses the second value where it is true (GLSL 4.60 §8.3).
            ("mix", [a, b, t]) if t.ty.kind() == Some(Kind::Bool) => {
                let ty = self.common(&a.ty, &b.ty)?;
                let (a, b) = (self.convert(a, &ty)?, self.convert(b, &ty)?);
                self.select_value(t.expr, &b, &a).map(Some)
            }
            ("mix", [_, _, _]) => {
                let Some(values) = self.convert_to_common_type(values, true)? else {
                    return Ok(None);
                };
                let expr = self.math(M::Mix, &[values[0].expr, values[1].expr, values[2].expr]);
                Ok(Some(TypedValue { expr, ty: values[0].ty.clone() }))
            }
            ("matrixCompMult", [a, b]) => {
                let (Ty::Matrix(kind, columns, rows), true) = (a.ty.clone(), a.ty == b.ty) else {
                    return Ok(None);
                };
                let mut parts = Vec::new();
                for i in 0..u32::from(columns) {
                    let (left, right) = (self.part(a.expr, i), self.part(b.expr, i));
                    parts.push(self.binary(B::Multiply, left, right));
                }
                self.compose(&Ty::Matrix(kind, columns, rows), parts).map(Some)
            }
            // Column i is the first vector times component i of the second (GLSL 4.60 §8.6).
            ("outerProduct", [c, r]) => {
                let (c, r) = (self.float(c)?, self.float(r)?);
                let (Ty::Vector(kind, rows), Ty::Vector(_, columns)) = (&c.ty, &r.ty) else {
                    return Ok(None);
                };
                let (kind, rows, columns) = (*kind, *rows, *columns);
                let mut parts = Vec::new();
                for i in 0..u32::from(columns) {
                    let factor = self.part(r.expr, i);
                    parts.push(self.binary(B::Multiply, c.expr, factor));
                }
                self.compose(&Ty::Matrix(kind, columns, rows), parts).map(Some)
            }
            _ => self.geometric_call(name, values),
        }
    }

    /// Lowers the geometric functions (GLSL 4.60 §8.5), which naga has for vectors only.
    fn geometric_call(
        &mut self,
        name: &str,
        values: &[TypedValue],
    ) -> Lowering<Option<TypedValue>> {
        match (name, values) {
            ("length", [x]) => {
                let x = self.float(x)?;
                let kind = x.ty.kind().unwrap_or(Kind::Float);
                // Of a scalar the length is its absolute value.
                let fun = if matches!(x.ty, Ty::Scalar(_)) { M::Abs } else { M::Length };
                Ok(Some(TypedValue { expr: self.math(fun, &[x.expr]), ty: Ty::Scalar(kind) }))
            }
            ("distance", [a, b]) => {
                let difference = self.operate(Binary::Subtract, a, b)?;
                self.geometric_call("length", &[difference])
            }
            ("dot", [_, _]) => {
                let Some(values) = self.convert_to_common_type(values, true)? else {
                    return Ok(None);
                };
                self.dot(&values[0], &values[1]).map(Some)
            }
            ("normalize", [x]) => {
                let x = self.float(x)?;
                // A scalar normalised is its sign.
                if let Ty::Scalar(_) = x.ty {
                    return Ok(Some(TypedValue { expr: self.math(M::Sign, &[x.expr]), ty: x.ty }));
                }
                Ok(Some(TypedValue { expr: self.math(M::Normalize, &[x.expr]), ty: x.ty }))
            }
            ("faceforward", [n, _, _]) => {
                let Some(values) = self.convert_to_common_type(values, true)? else {
                    return Ok(None);
                };
                // Nref . I < 0 returns N, else -N.
                let toward = self.dot(&values[2], &values[1])?;
                let kind = n.ty.kind().filter(|k| k.is_float()).unwrap_or(Kind::Float);
                let zero = self.number(kind, 0.0);
                let faces = self.binary(B::Less, toward.expr, zero.expr);
                let n = values[0].clone();
                let op = naga::UnaryOperator::Negate;
                let away = self.add(Expression::Unary { op, expr: n.expr });
                let away = TypedValue { expr: away, ty: n.ty.clone() };
                self.select_value(faces, &n, &away).map(Some)
            }
            ("reflect", [_, _]) => {
                let Some(values) = self.convert_to_common_type(values, true)? else {
                    return Ok(None);
                };
                let [i, n] = &values[..] else { return Ok(None) };
                if !matches!(i.ty, Ty::Scalar(_)) {
                    let expr = self.math(M::Reflect, &[i.expr, n.expr]);
                    return Ok(Some(TypedValue { expr, ty: i.ty.clone() }));
                }
                // GLSL 4.60 §8.5: I - 2 * dot(N, I) * N.
                let two = self.number(i.ty.kind().unwrap_or(Kind::Float), 2.0);
                let dot = self.dot(n, i)?;
                let twice = self.operate(Binary::Multiply, &two, &dot)?;
                let along = self.operate(Binary::Multiply, &twice, n)?;
                self.operate(Binary::Subtract, i, &along).map(Some)
            }
            ("refract", [i, n, eta]) => {
                let Some(pair) = self.convert_to_common_type(&[i.clone(), n.clone()], true)? else {
                    return Ok(None);
                };
                let kind = pair[0].ty.kind().unwrap_or(Kind::Float);
                let eta = self.coerce(eta, &Ty::Scalar(kind))?;
                if matches!(pair[0].ty, Ty::Scalar(_)) {
                    return self.refract_scalar(&pair[0], &pair[1], &eta).map(Some);
                }
                let expr = self.math(M::Refract, &[pair[0].expr, pair[1].expr, eta.expr]);
                Ok(Some(TypedValue { expr, ty: pair[0].ty.clone() }))
            }
            _ => Ok(None),
        }
    }

    /// GLSL 4.60 §8.5: k = 1 - eta² (1 - (N·I)²); 0 if k < 0, else eta I - (eta N·I + √k) N.
    fn refract_scalar(
        &mut self,
        i: &TypedValue,
        n: &TypedValue,
        eta: &TypedValue,
    ) -> Lowering<TypedValue> {
        let kind = i.ty.kind().unwrap_or(Kind::Float);
        let (one, zero) = (self.number(kind, 1.0).expr, self.number(kind, 0.0));
        let dot = self.binary(B::Multiply, n.expr, i.expr);
        let square = self.binary(B::Multiply, dot, dot);
        let rest = self.binary(B::Subtract, one, square);
        let eta2 = self.binary(B::Multiply, eta.expr, eta.expr);
        let lost = self.binary(B::Multiply, eta2, rest);
        let k = self.binary(B::Subtract, one, lost);
        // The root is taken of max(k, 0): `select` evaluates both sides.
        let bends = self.binary(B::GreaterEqual, k, zero.expr);
        let inside = self.math(M::Max, &[k, zero.expr]);
        let root = self.math(M::Sqrt, &[inside]);
        let along = self.binary(B::Multiply, eta.expr, dot);
        let along = self.binary(B::Add, along, root);
        let along = self.binary(B::Multiply, along, n.expr);
        let through = self.binary(B::Multiply, eta.expr, i.expr);
        let bent = self.binary(B::Subtract, through, along);
        self.select_value(bends, &TypedValue { expr: bent, ty: i.ty.clone() }, &zero)
    }

    fn dot(&mut self, a: &TypedValue, b: &TypedValue) -> Lowering<TypedValue> {
        let kind = a.ty.kind().unwrap_or(Kind::Float);
        let expr = match a.ty {
            Ty::Scalar(_) => self.binary(B::Multiply, a.expr, b.expr),
            _ => self.math(M::Dot, &[a.expr, b.expr]),
        };
        Ok(TypedValue { expr, ty: Ty::Scalar(kind) })
    }

    /// Lowers functions that write to their arguments.
    pub fn output_call(
        &mut self,
        name: &str,
        arguments: &[Expr<'a>],
        e: &Expr<'a>,
    ) -> Lowering<TypedValue> {
        match (name, arguments) {
            ("modf", [x, whole]) => {
                let x = self.value(x)?;
                let place = self.place(whole)?;
                self.span = e.span;
                let x = self.float(&x)?;
                // GLSL 4.60 §8.3: both parts have the sign of x.
                let whole = TypedValue { expr: self.math(M::Trunc, &[x.expr]), ty: x.ty.clone() };
                let expr = self.binary(B::Subtract, x.expr, whole.expr);
                let kept = self.coerce(&whole, &place.ty)?;
                self.store(&place, &kept)?;
                Ok(TypedValue { expr, ty: x.ty })
            }
            ("frexp", [x, exponent]) => {
                let x = self.value(x)?;
                let place = self.place(exponent)?;
                self.span = e.span;
                let x = self.float(&x)?;
                let (kept, value) = self.frexp(&x)?;
                self.store(&place, &kept)?;
                Ok(value)
            }
            ("uaddCarry" | "usubBorrow", [a, b, out]) => {
                let (a, b) = (self.value(a)?, self.value(b)?);
                let place = self.place(out)?;
                self.span = e.span;
                let (a, b) = (a.expr, b.expr);
                let ty = place.ty.clone();
                // A sum wrapped round is less than its operands; a difference borrows where a < b
                // (GLSL 4.60 §8.8).
                let (expr, over) = if name == "uaddCarry" {
                    let sum = self.binary(B::Add, a, b);
                    (sum, self.binary(B::Less, sum, a))
                } else {
                    (self.binary(B::Subtract, a, b), self.binary(B::Less, a, b))
                };
                let bit = self.bit(over, &ty)?;
                self.store(&place, &bit)?;
                Ok(TypedValue { expr, ty })
            }
            ("umulExtended" | "imulExtended", [a, b, high, low]) => {
                let (a, b) = (self.value(a)?, self.value(b)?);
                let (high, low) = (self.place(high)?, self.place(low)?);
                self.span = e.span;
                self.multiply_extended(name == "imulExtended", &a, &b, &high, &low)
            }
            _ => self.refuse(format!("`{name}` does not take {} arguments", arguments.len())),
        }
    }

    /// Returns 1 where a comparison holds, else 0.
    fn bit(&mut self, holds: naga::Handle<Expression>, ty: &Ty) -> Lowering<TypedValue> {
        let size = ty.components().map_or(1, |(_, size)| size);
        let kind = ty.kind().unwrap_or(Kind::Uint);
        let value = TypedValue { expr: holds, ty: Ty::new(Kind::Bool, size) };
        self.convert(&value, &Ty::new(kind, size))
    }

    /// Returns the exponent and significand of a float from its bits, because not every backend
    /// supports naga's function.
    fn frexp(&mut self, x: &TypedValue) -> Lowering<(TypedValue, TypedValue)> {
        let Some((Kind::Float, size)) = x.ty.components() else {
            return self.refuse("`frexp` supports floats only");
        };
        let number = |this: &mut Self, kind, value: f64| {
            let scalar = this.number(kind, value);
            this.splat(&scalar, size)
        };
        // A subnormal is brought into the range of normal numbers first.
        let tiny = number(self, Kind::Float, f64::from(f32::MIN_POSITIVE))?;
        let scale = number(self, Kind::Float, 2f64.powi(24))?;
        let magnitude = self.math(M::Abs, &[x.expr]);
        let small = self.binary(B::Less, magnitude, tiny.expr);
        let scaled = self.binary(B::Multiply, x.expr, scale.expr);
        let normal = self.selected(small, scaled, x.expr);
        let uint = Ty::new(Kind::Uint, size);
        let kind = naga::ScalarKind::Uint;
        let bits = self.add(Expression::As { expr: normal, kind, convert: None });
        let by = number(self, Kind::Uint, 23.0)?;
        // The exponent of an IEEE 754 binary32 is in bits 23 to 30.
        let mask = number(self, Kind::Uint, 255.0)?;
        let exponent = self.binary(B::ShiftRight, bits, by.expr);
        let exponent = self.binary(B::And, exponent, mask.expr);
        let exponent = TypedValue { expr: exponent, ty: uint };
        let exponent = self.convert(&exponent, &Ty::new(Kind::Int, size))?;
        // The bias 127 less one, since the significand is in [0.5, 1); plus 24 for a scaled
        // subnormal.
        let (plain, shifted) = (number(self, Kind::Int, 126.0)?, number(self, Kind::Int, 150.0)?);
        let bias = self.selected(small, shifted.expr, plain.expr);
        let exponent = self.binary(B::Subtract, exponent.expr, bias);
        // 0x807fffff keeps sign and fraction, 0x3f000000 is the exponent of [0.5, 1).
        let keep = number(self, Kind::Uint, f64::from(0x807f_ffffu32))?;
        let half = number(self, Kind::Uint, f64::from(0x3f00_0000u32))?;
        let kept = self.binary(B::And, bits, keep.expr);
        let made = self.binary(B::InclusiveOr, kept, half.expr);
        let kind = naga::ScalarKind::Float;
        let significand = self.add(Expression::As { expr: made, kind, convert: None });
        let zero = number(self, Kind::Float, 0.0)?;
        let none = number(self, Kind::Int, 0.0)?;
        // Zero has exponent 0 and significand 0 (GLSL 4.60 §8.3).
        let is_zero = self.binary(B::Equal, x.expr, zero.expr);
        let exponent = self.selected(is_zero, none.expr, exponent);
        let value = self.selected(is_zero, x.expr, significand);
        let exponent = TypedValue { expr: exponent, ty: Ty::new(Kind::Int, size) };
        Ok((exponent, TypedValue { expr: value, ty: x.ty.clone() }))
    }

    /// Returns the two words of a 64-bit number, the low one first.
    pub(super) fn split_into_words(
        &mut self,
        value: &TypedValue,
        kind: Kind,
    ) -> Lowering<TypedValue> {
        let value = self.convert(value, &Ty::new(kind, 1))?;
        let uint = naga::ScalarKind::Uint;
        let bits = self.add(Expression::As { expr: value.expr, kind: uint, convert: None });
        let by = self.u32(32);
        let high = self.binary(B::ShiftRight, bits, by);
        let words = [bits, high]
            .map(|expr| self.add(Expression::As { expr, kind: uint, convert: Some(4) }));
        self.compose(&Ty::Vector(Kind::Uint, 2), words.to_vec())
    }

    /// Returns a 64-bit number from its two words.
    pub(super) fn joined(&mut self, words: &TypedValue, kind: Kind) -> Lowering<TypedValue> {
        let words = self.convert(words, &Ty::Vector(Kind::Uint, 2))?;
        let uint = naga::ScalarKind::Uint;
        let mut halves = Vec::new();
        for half in 0..2 {
            let expr = self.select(&words, &[half])?.expr;
            halves.push(self.add(Expression::As { expr, kind: uint, convert: Some(8) }));
        }
        let by = self.u32(32);
        let high = self.binary(B::ShiftLeft, halves[1], by);
        let bits = self.binary(B::InclusiveOr, halves[0], high);
        let to = kind.scalar().kind;
        let expr = self.add(Expression::As { expr: bits, kind: to, convert: None });
        Ok(TypedValue { expr, ty: Ty::new(kind, 1) })
    }

    /// Returns all 64 bits of a product, from products of 16-bit halves.
    fn multiply_extended(
        &mut self,
        signed: bool,
        a: &TypedValue,
        b: &TypedValue,
        high: &super::lvalue::Lvalue,
        low: &super::lvalue::Lvalue,
    ) -> Lowering<TypedValue> {
        let size = a.ty.components().map_or(1, |(_, size)| size);
        let uint = Ty::new(Kind::Uint, size);
        let (x, y) = (self.convert(a, &uint)?.expr, self.convert(b, &uint)?.expr);
        let sixteen = self.number(Kind::Uint, 16.0);
        let sixteen = self.splat(&sixteen, size)?.expr;
        let mask = self.number(Kind::Uint, 65535.0);
        let mask = self.splat(&mask, size)?.expr;
        // (x1 2^16 + x0) (y1 2^16 + y0), by schoolbook multiplication: no partial sum overflows 32
        // bits.
        let (x0, x1) = (self.binary(B::And, x, mask), self.binary(B::ShiftRight, x, sixteen));
        let (y0, y1) = (self.binary(B::And, y, mask), self.binary(B::ShiftRight, y, sixteen));
        let low_low = self.binary(B::Multiply, x0, y0);
        let cross = self.binary(B::Multiply, x1, y0);
        let carried = self.binary(B::ShiftRight, low_low, sixteen);
        let middle = self.binary(B::Add, cross, carried);
        let middle_low = self.binary(B::And, middle, mask);
        let other = self.binary(B::Multiply, x0, y1);
        let middle_low = self.binary(B::Add, middle_low, other);
        let top = self.binary(B::Multiply, x1, y1);
        let up = self.binary(B::ShiftRight, middle, sixteen);
        let top = self.binary(B::Add, top, up);
        let up = self.binary(B::ShiftRight, middle_low, sixteen);
        let mut upper = self.binary(B::Add, top, up);
        let lower = self.binary(B::Multiply, x, y);
        if signed {
            // A negative factor counts 2^32 too much of the other one.
            let zero = self.zero(&a.ty)?.expr;
            let none = self.zero(&uint)?.expr;
            for (factor, other) in [(a.expr, y), (b.expr, x)] {
                let negative = self.binary(B::Less, factor, zero);
                let surplus = self.selected(negative, other, none);
                upper = self.binary(B::Subtract, upper, surplus);
            }
        }
        for (place, expr) in [(high, upper), (low, lower)] {
            let value = self.convert(&TypedValue { expr, ty: uint.clone() }, &place.ty)?;
            self.store(place, &value)?;
        }
        Ok(TypedValue { expr: lower, ty: Ty::Void })
    }
}
