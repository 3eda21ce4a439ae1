//! Built-in functions of numbers (GLSL 4.60 §8.1 to §8.8) that naga supports.
//!
//! A table lists their argument types; [`math_expanded`](super::math_expanded) expands the others.

use naga::{DerivativeAxis, DerivativeControl, Expression, Handle, MathFunction as M, ScalarKind};

use super::Lowering;
use super::ast::Binary;
use super::body::{Body, TypedValue};
use super::operators::comparison;
use super::types::{Kind, Ty};
use landfall_layout::text::word_list::WordList;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Parameters {
    /// Scalars or vectors of floats, all of one size; a scalar fills a vector.
    Floats,
    /// Scalars or vectors of any numbers, with the same rule.
    Numbers,
    /// One or more vectors of floats.
    Vectors,
    /// Integers; the result is `int`.
    Bits,
    Square,
}

/// Functions with a counterpart in naga: name, number of arguments, argument types, naga's
/// function.
const TABLE: &[(&str, usize, Parameters, M)] = &[
    ("radians", 1, Parameters::Floats, M::Radians),
    ("degrees", 1, Parameters::Floats, M::Degrees),
    ("sin", 1, Parameters::Floats, M::Sin),
    ("cos", 1, Parameters::Floats, M::Cos),
    ("tan", 1, Parameters::Floats, M::Tan),
    ("asin", 1, Parameters::Floats, M::Asin),
    ("acos", 1, Parameters::Floats, M::Acos),
    ("atan", 1, Parameters::Floats, M::Atan),
    ("atan", 2, Parameters::Floats, M::Atan2),
    ("sinh", 1, Parameters::Floats, M::Sinh),
    ("cosh", 1, Parameters::Floats, M::Cosh),
    ("tanh", 1, Parameters::Floats, M::Tanh),
    ("asinh", 1, Parameters::Floats, M::Asinh),
    ("acosh", 1, Parameters::Floats, M::Acosh),
    ("atanh", 1, Parameters::Floats, M::Atanh),
    ("pow", 2, Parameters::Floats, M::Pow),
    ("exp", 1, Parameters::Floats, M::Exp),
    ("log", 1, Parameters::Floats, M::Log),
    ("exp2", 1, Parameters::Floats, M::Exp2),
    ("log2", 1, Parameters::Floats, M::Log2),
    ("sqrt", 1, Parameters::Floats, M::Sqrt),
    ("inversesqrt", 1, Parameters::Floats, M::InverseSqrt),
    ("abs", 1, Parameters::Numbers, M::Abs),
    ("sign", 1, Parameters::Numbers, M::Sign),
    ("floor", 1, Parameters::Floats, M::Floor),
    ("trunc", 1, Parameters::Floats, M::Trunc),
    ("round", 1, Parameters::Floats, M::Round),
    // GLSL 4.60 §8.3 leaves the direction of a half in `round` open; to even is one of those
    // allowed.
    ("roundEven", 1, Parameters::Floats, M::Round),
    ("ceil", 1, Parameters::Floats, M::Ceil),
    ("fract", 1, Parameters::Floats, M::Fract),
    ("min", 2, Parameters::Numbers, M::Min),
    ("max", 2, Parameters::Numbers, M::Max),
    ("clamp", 3, Parameters::Numbers, M::Clamp),
    ("step", 2, Parameters::Floats, M::Step),
    ("smoothstep", 3, Parameters::Floats, M::SmoothStep),
    ("fma", 3, Parameters::Floats, M::Fma),
    ("cross", 2, Parameters::Vectors, M::Cross),
    ("bitfieldReverse", 1, Parameters::Numbers, M::ReverseBits),
    ("bitCount", 1, Parameters::Bits, M::CountOneBits),
    ("findLSB", 1, Parameters::Bits, M::FirstTrailingBit),
    ("findMSB", 1, Parameters::Bits, M::FirstLeadingBit),
    ("determinant", 1, Parameters::Square, M::Determinant),
    ("inverse", 1, Parameters::Square, M::Inverse),
];

/// Packing functions: name, argument, result, naga's function.
const PACKING: &[(&str, Ty, Ty, M)] = &[
    ("packSnorm4x8", Ty::Vector(Kind::Float, 4), Ty::UINT, M::Pack4x8snorm),
    ("packUnorm4x8", Ty::Vector(Kind::Float, 4), Ty::UINT, M::Pack4x8unorm),
    ("packSnorm2x16", Ty::Vector(Kind::Float, 2), Ty::UINT, M::Pack2x16snorm),
    ("packUnorm2x16", Ty::Vector(Kind::Float, 2), Ty::UINT, M::Pack2x16unorm),
    ("packHalf2x16", Ty::Vector(Kind::Float, 2), Ty::UINT, M::Pack2x16float),
    ("unpackSnorm4x8", Ty::UINT, Ty::Vector(Kind::Float, 4), M::Unpack4x8snorm),
    ("unpackUnorm4x8", Ty::UINT, Ty::Vector(Kind::Float, 4), M::Unpack4x8unorm),
    ("unpackSnorm2x16", Ty::UINT, Ty::Vector(Kind::Float, 2), M::Unpack2x16snorm),
    ("unpackUnorm2x16", Ty::UINT, Ty::Vector(Kind::Float, 2), M::Unpack2x16unorm),
    ("unpackHalf2x16", Ty::UINT, Ty::Vector(Kind::Float, 2), M::Unpack2x16float),
];

/// Functions with other signatures, lowered here and in [`math_expanded`](super::math_expanded).
const OTHERS: WordList = WordList(
    "mod mix isnan isinf floatBitsToInt floatBitsToUint intBitsToFloat uintBitsToFloat ldexp \
     length distance dot normalize faceforward reflect refract matrixCompMult outerProduct \
     transpose packDouble2x32 unpackDouble2x32 lessThan lessThanEqual greaterThan \
     greaterThanEqual equal notEqual any all not bitfieldExtract bitfieldInsert dFdx dFdy fwidth \
     dFdxFine dFdyFine fwidthFine dFdxCoarse dFdyCoarse fwidthCoarse",
);

pub fn is_known(name: &str) -> bool {
    TABLE.iter().any(|row| row.0 == name)
        || PACKING.iter().any(|row| row.0 == name)
        || OTHERS.contains(name)
        || super::call::OUTPUTS.contains(&name)
}

impl Body<'_, '_> {
    pub fn math(&mut self, fun: M, arguments: &[Handle<Expression>]) -> Handle<Expression> {
        let of = |i: usize| arguments.get(i).copied();
        let arg = arguments[0];
        self.add(Expression::Math { fun, arg, arg1: of(1), arg2: of(2), arg3: of(3) })
    }

    /// Lowers a function of numbers; `None` if it does not take these arguments.
    pub fn math_call(&mut self, name: &str, values: &[TypedValue]) -> Lowering<Option<TypedValue>> {
        // By name and number of arguments: `atan` has a form of one and of two.
        let row = TABLE.iter().find(|row| row.0 == name && row.1 == values.len());
        if let Some((_, _, takes, fun)) = row {
            return self.tabled(*takes, *fun, values);
        }
        if let ([value], Some((_, from, to, fun))) =
            (values, PACKING.iter().find(|row| row.0 == name))
        {
            let value = self.coerce(value, from)?;
            let expr = self.math(*fun, &[value.expr]);
            return Ok(Some(TypedValue { expr, ty: to.clone() }));
        }
        match (name, values) {
            ("isnan" | "isinf", [x]) => {
                let Some((_, size)) = x.ty.components() else { return Ok(None) };
                let x = self.float(x)?;
                let fun = match name {
                    "isnan" => naga::RelationalFunction::IsNan,
                    _ => naga::RelationalFunction::IsInf,
                };
                let expr = self.add(Expression::Relational { fun, argument: x.expr });
                Ok(Some(TypedValue { expr, ty: Ty::new(Kind::Bool, size) }))
            }
            ("any" | "all", [x]) if matches!(x.ty, Ty::Vector(Kind::Bool, _)) => {
                let fun = match name {
                    "any" => naga::RelationalFunction::Any,
                    _ => naga::RelationalFunction::All,
                };
                let expr = self.add(Expression::Relational { fun, argument: x.expr });
                Ok(Some(TypedValue { expr, ty: Ty::BOOL }))
            }
            // `not` of a vector of booleans, component by component (GLSL 4.60 §8.7).
            ("not", [x]) if x.ty.kind() == Some(Kind::Bool) => {
                Ok(Some(TypedValue { expr: self.not(x.expr), ty: x.ty.clone() }))
            }
            ("floatBitsToInt", [x]) => self.bits(x, Kind::Float, Kind::Int),
            ("floatBitsToUint", [x]) => self.bits(x, Kind::Float, Kind::Uint),
            ("intBitsToFloat", [x]) => self.bits(x, Kind::Int, Kind::Float),
            ("uintBitsToFloat", [x]) => self.bits(x, Kind::Uint, Kind::Float),
            ("unpackDouble2x32", [x]) => self.split_into_words(x, Kind::Double).map(Some),
            ("packDouble2x32", [x]) => self.joined(x, Kind::Double).map(Some),
            ("transpose", [x]) => {
                let Ty::Matrix(kind, columns, rows) = x.ty else { return Ok(None) };
                let expr = self.transpose(x.expr);
                Ok(Some(TypedValue { expr, ty: Ty::Matrix(kind, rows, columns) }))
            }
            ("lessThan", [a, b]) => self.compare(Binary::Less, a, b),
            ("lessThanEqual", [a, b]) => self.compare(Binary::LessEqual, a, b),
            ("greaterThan", [a, b]) => self.compare(Binary::Greater, a, b),
            ("greaterThanEqual", [a, b]) => self.compare(Binary::GreaterEqual, a, b),
            ("equal", [a, b]) => self.compare(Binary::Equal, a, b),
            ("notEqual", [a, b]) => self.compare(Binary::NotEqual, a, b),
            ("bitfieldExtract", [x, offset, bits]) => {
                // naga's offset and count are `u32`, GLSL's are `int`.
                let (offset, bits) = (self.unsigned(offset)?, self.unsigned(bits)?);
                let expr = self.math(M::ExtractBits, &[x.expr, offset, bits]);
                Ok(Some(TypedValue { expr, ty: x.ty.clone() }))
            }
            ("bitfieldInsert", [base, insert, offset, bits]) => {
                let insert = self.coerce(insert, &base.ty)?;
                let (offset, bits) = (self.unsigned(offset)?, self.unsigned(bits)?);
                let expr = self.math(M::InsertBits, &[base.expr, insert.expr, offset, bits]);
                Ok(Some(TypedValue { expr, ty: base.ty.clone() }))
            }
            ("ldexp", [x, exponent]) => {
                let x = self.float(x)?;
                // The exponents may be scalars of another integer type.
                let exponent = self.convert(exponent, &exponent.ty.with_kind(Kind::Int))?;
                let expr = self.math(M::Ldexp, &[x.expr, exponent.expr]);
                Ok(Some(TypedValue { expr, ty: x.ty }))
            }
            _ if name.starts_with("dFd") || name.starts_with("fwidth") => {
                let [x] = values else { return Ok(None) };
                self.derivative(name, x).map(Some)
            }
            _ => self.expanded_call(name, values),
        }
    }

    fn tabled(
        &mut self,
        takes: Parameters,
        fun: M,
        values: &[TypedValue],
    ) -> Lowering<Option<TypedValue>> {
        if takes == Parameters::Square {
            let Ty::Matrix(kind, columns, rows) = values[0].ty else { return Ok(None) };
            if columns != rows {
                return Ok(None);
            }
            let expr = self.math(fun, &[values[0].expr]);
            let scalar = fun == M::Determinant;
            let ty = if scalar { Ty::Scalar(kind) } else { values[0].ty.clone() };
            return Ok(Some(TypedValue { expr, ty }));
        }
        let Some(mut values) = self.convert_to_common_type(
            values,
            // `cross` is of three components (GLSL 4.60 §8.5).
            takes != Parameters::Numbers && takes != Parameters::Bits,
        )?
        else {
            return Ok(None);
        };
        let mut ty = values[0].ty.clone();
        if takes == Parameters::Vectors && ty.components().is_none_or(|(_, size)| size != 3) {
            return Ok(None);
        }
        let kind = ty.kind().unwrap_or(Kind::Float);
        // GLSL's bit counts are `int` for unsigned operands as well (§8.8); naga's have the
        // operand's type. naga's `abs` of an unsigned number is not in every backend, and changes
        // nothing.
        if fun == M::Abs && kind.is_integer() && !kind.is_signed() {
            return Ok(values.pop());
        }
        let arguments: Vec<_> = values.iter().map(|value| value.expr).collect();
        let mut expr = self.math(fun, &arguments);
        if takes == Parameters::Bits && kind == Kind::Uint {
            ty = ty.with_kind(Kind::Int);
            expr = self.add(Expression::As { expr, kind: ScalarKind::Sint, convert: Some(4) });
        }
        Ok(Some(TypedValue { expr, ty }))
    }

    /// Converts scalars and vectors to one size and kind; `None` if their sizes differ.
    pub fn convert_to_common_type(
        &mut self,
        values: &[TypedValue],
        floats: bool,
    ) -> Lowering<Option<Vec<TypedValue>>> {
        // Sizes must agree, but a scalar goes with any.
        let mut size = 1;
        let mut common: Option<Kind> = None;
        for value in values {
            let Some((own, count)) = value.ty.components() else { return Ok(None) };
            if own == Kind::Bool || (count != 1 && size != 1 && count != size) {
                return Ok(None);
            }
            size = size.max(count);
            common = common.filter(|kind| !kind.converts_to(own)).or(Some(own));
        }
        // A function of floats takes integers by conversion (GLSL 4.60 §4.1.10).
        let kind = common.filter(|kind| !floats || kind.is_float()).unwrap_or(Kind::Float);
        let mut alike = Vec::new();
        for value in values {
            let value = self.convert(value, &value.ty.with_kind(kind))?;
            let single = matches!(value.ty, Ty::Scalar(_));
            alike.push(if single { self.splat(&value, size)? } else { value });
        }
        Ok(Some(alike))
    }

    /// Converts a scalar or vector to floats.
    pub fn float(&mut self, value: &TypedValue) -> Lowering<TypedValue> {
        match value.ty.kind() {
            Some(kind) if kind.is_float() => Ok(value.clone()),
            _ => self.coerce(value, &value.ty.with_kind(Kind::Float)),
        }
    }

    fn unsigned(&mut self, value: &TypedValue) -> Lowering<Handle<Expression>> {
        Ok(self.convert(value, &Ty::UINT)?.expr)
    }

    fn bits(&mut self, value: &TypedValue, from: Kind, to: Kind) -> Lowering<Option<TypedValue>> {
        let value = self.coerce(value, &value.ty.with_kind(from))?;
        let kind = to.scalar().kind;
        let expr = self.add(Expression::As { expr: value.expr, kind, convert: None });
        Ok(Some(TypedValue { expr, ty: value.ty.with_kind(to) }))
    }

    fn compare(
        &mut self,
        op: Binary,
        a: &TypedValue,
        b: &TypedValue,
    ) -> Lowering<Option<TypedValue>> {
        let ty = self.common(&a.ty, &b.ty)?;
        let Some((_, size)) = ty.components() else { return Ok(None) };
        let (a, b) = (self.convert(a, &ty)?, self.convert(b, &ty)?);
        let expr = self.binary(comparison(op), a.expr, b.expr);
        Ok(Some(TypedValue { expr, ty: Ty::new(Kind::Bool, size) }))
    }

    fn derivative(&mut self, name: &str, x: &TypedValue) -> Lowering<TypedValue> {
        let x = self.float(x)?;
        let axis = match name.as_bytes()[..4] {
            [b'd', b'F', b'd', b'x'] => DerivativeAxis::X,
            [b'd', b'F', b'd', b'y'] => DerivativeAxis::Y,
            _ => DerivativeAxis::Width,
        };
        let ctrl = if name.ends_with("Fine") {
            DerivativeControl::Fine
        } else if name.ends_with("Coarse") {
            DerivativeControl::Coarse
        } else {
            DerivativeControl::None
        };
        let expr = self.add(Expression::Derivative { axis, ctrl, expr: x.expr });
        Ok(TypedValue { expr, ty: x.ty })
    }
}
