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

/// A scalar type and its names.
pub(crate) struct ScalarSpelling {
    pub(crate) scalar: Scalar,
    pub(crate) glsl: &'static str,
    /// What GLSL's names of its vectors and matrices begin with.
    pub(crate) glsl_prefix: &'static str,
    /// The name in WGSL, or an analogous one where WGSL has none.
    pub(crate) wgsl: &'static str,
}

const fn names(
    kind: ScalarKind,
    width: u8,
    glsl: &'static str,
    glsl_prefix: &'static str,
    wgsl: &'static str,
) -> ScalarSpelling {
    ScalarSpelling { scalar: Scalar { kind, width }, glsl, glsl_prefix, wgsl }
}

/// Every scalar type, of each kind the usual one first.
pub(crate) static SCALARS: [ScalarSpelling; 15] = [
    names(ScalarKind::Float, 4, "float", "", "f32"),
    names(ScalarKind::Sint, 4, "int", "i", "i32"),
    names(ScalarKind::Uint, 4, "uint", "u", "u32"),
    // A bool in a block takes the 4 bytes of a uint (OpenGL 4.6 §7.6.2.2).
    names(ScalarKind::Bool, 4, "bool", "b", "bool"),
    names(ScalarKind::Float, 8, "double", "d", "f64"),
    names(ScalarKind::Float, 2, "float16_t", "f16", "f16"),
    names(ScalarKind::Bfloat, 2, "bfloat16_t", "bf16", "bf16"),
    names(ScalarKind::FloatE5m2, 1, "floate5m2_t", "fe5m2", "f8e5m2"),
    names(ScalarKind::FloatE4m3, 1, "floate4m3_t", "fe4m3", "f8e4m3"),
    names(ScalarKind::Sint, 1, "int8_t", "i8", "i8"),
    names(ScalarKind::Uint, 1, "uint8_t", "u8", "u8"),
    names(ScalarKind::Sint, 2, "int16_t", "i16", "i16"),
    names(ScalarKind::Uint, 2, "uint16_t", "u16", "u16"),
    names(ScalarKind::Sint, 8, "int64_t", "i64", "i64"),
    names(ScalarKind::Uint, 8, "uint64_t", "u64", "u64"),
];

fn names_of(scalar: Scalar) -> &'static ScalarSpelling {
    let exact = SCALARS.iter().find(|names| names.scalar == scalar);
    exact.unwrap_or_else(|| {
        let mut all = SCALARS.iter();
        all.find(|names| names.scalar.kind == scalar.kind).expect("every kind is there")
    })
}

fn glsl_name(ty: &Type, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match ty {
        Type::Scalar(s) | Type::Atomic(s) => f.write_str(names_of(*s).glsl),
        Type::Vector { scalar, rows } => write!(f, "{}vec{rows}", names_of(*scalar).glsl_prefix),
        Type::Matrix { scalar, columns, rows } => {
            write!(f, "{}mat{columns}", names_of(*scalar).glsl_prefix)?;
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
    names_of(scalar).wgsl
}
