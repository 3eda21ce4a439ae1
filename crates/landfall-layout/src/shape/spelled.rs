//! Types in the spelling of a language.

use std::fmt;

use super::{ArrayLen, Scalar, ScalarKind, Type};
use crate::source::Language;

/// Displays a type in the spelling of a language.
pub struct Spelled<'a> {
    pub(super) ty: &'a Type,
    pub(super) language: Language,
}

impl fmt::Display for Spelled<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.language {
            // SPIR-V has no spelling of its own that a program would show.
            Language::Glsl | Language::SpirV => glsl_name(self.ty, f),
            Language::Wgsl => wgsl_name(self.ty, f),
        }
    }
}

/// A dimension as a suffix: `[2]`, `[]`, `[COUNT]`.
impl fmt::Display for ArrayLen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ArrayLen::Fixed(n) => write!(f, "[{n}]"),
            ArrayLen::Runtime => f.write_str("[]"),
            ArrayLen::Override(name) => write!(f, "[{name}]"),
        }
    }
}

fn glsl_name(ty: &Type, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match ty {
        Type::Scalar(s) | Type::Atomic(s) => f.write_str(match (s.kind, s.width) {
            (ScalarKind::Bool, _) => "bool",
            (ScalarKind::Sint, 1) => "int8_t",
            (ScalarKind::Sint, 2) => "int16_t",
            (ScalarKind::Sint, 8) => "int64_t",
            (ScalarKind::Sint, _) => "int",
            (ScalarKind::Uint, 1) => "uint8_t",
            (ScalarKind::Uint, 2) => "uint16_t",
            (ScalarKind::Uint, 8) => "uint64_t",
            (ScalarKind::Uint, _) => "uint",
            (ScalarKind::Float, 2) => "float16_t",
            (ScalarKind::Float, 8) => "double",
            (ScalarKind::Float, _) => "float",
            (ScalarKind::Bfloat, _) => "bfloat16_t",
            (ScalarKind::FloatE5m2, _) => "floate5m2_t",
            (ScalarKind::FloatE4m3, _) => "floate4m3_t",
        }),
        Type::Vector { scalar, rows } => write!(f, "{}vec{rows}", glsl_prefix(*scalar)),
        Type::Matrix { scalar, columns, rows } => {
            write!(f, "{}mat{columns}", glsl_prefix(*scalar))?;
            if columns != rows {
                write!(f, "x{rows}")?;
            }
            Ok(())
        }
        Type::Address(name) => f.write_str(name),
        Type::Struct(s) if s.name.is_empty() => f.write_str("struct"),
        Type::Struct(s) => f.write_str(&s.name),
        Type::Array { .. } => {
            // The outermost dimension comes first behind the element type (GLSL 4.60 §4.1.9).
            glsl_name(ty.innermost(), f)?;
            ty.dims().iter().try_for_each(|len| write!(f, "{len}"))
        }
    }
}

fn glsl_prefix(scalar: Scalar) -> &'static str {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Bool, _) => "b",
        (ScalarKind::Sint, 1) => "i8",
        (ScalarKind::Sint, 2) => "i16",
        (ScalarKind::Sint, 8) => "i64",
        (ScalarKind::Sint, _) => "i",
        (ScalarKind::Uint, 1) => "u8",
        (ScalarKind::Uint, 2) => "u16",
        (ScalarKind::Uint, 8) => "u64",
        (ScalarKind::Uint, _) => "u",
        (ScalarKind::Float, 2) => "f16",
        (ScalarKind::Float, 8) => "d",
        (ScalarKind::Float, _) => "",
        (ScalarKind::Bfloat, _) => "bf16",
        (ScalarKind::FloatE5m2, _) => "fe5m2",
        (ScalarKind::FloatE4m3, _) => "fe4m3",
    }
}

fn wgsl_name(ty: &Type, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match ty {
        Type::Scalar(s) => f.write_str(wgsl_scalar(*s)),
        Type::Atomic(s) => write!(f, "atomic<{}>", wgsl_scalar(*s)),
        Type::Vector { scalar, rows } => write!(f, "vec{rows}<{}>", wgsl_scalar(*scalar)),
        Type::Matrix { scalar, columns, rows } => {
            write!(f, "mat{columns}x{rows}<{}>", wgsl_scalar(*scalar))
        }
        Type::Address(name) => f.write_str(name),
        Type::Struct(s) => f.write_str(&s.name),
        Type::Array { element, len } => {
            f.write_str("array<")?;
            wgsl_name(element, f)?;
            match len {
                ArrayLen::Fixed(n) => write!(f, ", {n}>"),
                ArrayLen::Runtime => f.write_str(">"),
                ArrayLen::Override(name) => write!(f, ", {name}>"),
            }
        }
    }
}

/// Returns WGSL's name of a scalar, or an analogous one where WGSL has none.
pub(crate) fn wgsl_scalar(scalar: Scalar) -> &'static str {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Bool, _) => "bool",
        (ScalarKind::Sint, 1) => "i8",
        (ScalarKind::Sint, 2) => "i16",
        (ScalarKind::Sint, 8) => "i64",
        (ScalarKind::Sint, _) => "i32",
        (ScalarKind::Uint, 1) => "u8",
        (ScalarKind::Uint, 2) => "u16",
        (ScalarKind::Uint, 8) => "u64",
        (ScalarKind::Uint, _) => "u32",
        (ScalarKind::Float, 2) => "f16",
        (ScalarKind::Float, 8) => "f64",
        (ScalarKind::Float, _) => "f32",
        // Not in WGSL.
        (ScalarKind::Bfloat, _) => "bf16",
        (ScalarKind::FloatE5m2, _) => "f8e5m2",
        (ScalarKind::FloatE4m3, _) => "f8e4m3",
    }
}
