//! The layouts of Rust's and of math crates' types, by name.
//!
//! glam's types are those with SIMD, as on x86-64, aarch64 and wasm with simd128; its feature
//! `scalar-math` aligns `Vec4`, `Quat` and the matrices to 4 instead.

use super::rust_type::{RustType, TypeArgument};
use landfall_layout::shape::ScalarKind;

/// Returns the type of a path; `globs` are crates imported as a whole.
pub(super) fn named(
    path: &[String],
    globs: &[&str],
    arguments: &[TypeArgument],
) -> Option<RustType> {
    let name = path.last()?.as_str();
    // A name alone may be of any crate that is imported as a whole.
    let root = if path.len() > 1 { path.first().map(String::as_str) } else { None };
    match root {
        None => std(name, arguments)
            .or_else(|| globs.iter().find_map(|glob| of_crate(glob, name, arguments)))
            // No import says where it comes from: a name that several crates lay out alike.
            .or_else(|| glam(name).filter(|_| arguments.is_empty()))
            .or_else(|| generic(name, arguments)),
        Some("std" | "core" | "alloc") => std(name, arguments),
        Some(root) => of_crate(root, name, arguments),
    }
}

fn of_crate(root: &str, name: &str, arguments: &[TypeArgument]) -> Option<RustType> {
    match root {
        "glam" | "bevy" | "bevy_math" | "bevy_color" | "macaw" | "spirv_std" => {
            glam(name).or_else(|| bevy(root, name)).filter(|_| arguments.is_empty())
        }
        "cgmath" | "nalgebra" | "na" | "mint" => generic(name, arguments),
        "nalgebra_glm" | "glm" | "ultraviolet" => unaligned(name).filter(|_| arguments.is_empty()),
        "half" => half(name),
        _ => None,
    }
}

fn std(name: &str, arguments: &[TypeArgument]) -> Option<RustType> {
    let scalar = |kind, name, width| Some(RustType::scalar(kind, name, width));
    match name {
        "f32" => scalar(ScalarKind::Float, "f32", 4),
        "f64" => scalar(ScalarKind::Float, "f64", 8),
        "i8" => scalar(ScalarKind::Sint, "i8", 1),
        "i16" | "AtomicI16" | "NonZeroI16" => scalar(ScalarKind::Sint, "i16", 2),
        "i32" | "AtomicI32" | "NonZeroI32" => scalar(ScalarKind::Sint, "i32", 4),
        "i64" | "AtomicI64" | "NonZeroI64" => scalar(ScalarKind::Sint, "i64", 8),
        "u8" => scalar(ScalarKind::Uint, "u8", 1),
        "u16" | "AtomicU16" | "NonZeroU16" => scalar(ScalarKind::Uint, "u16", 2),
        "u32" | "AtomicU32" | "NonZeroU32" | "c_uint" => scalar(ScalarKind::Uint, "u32", 4),
        "u64" | "AtomicU64" | "NonZeroU64" => scalar(ScalarKind::Uint, "u64", 8),
        "c_float" => scalar(ScalarKind::Float, "f32", 4),
        "c_int" => scalar(ScalarKind::Sint, "i32", 4),
        "bool" => scalar(ScalarKind::Bool, "bool", 1),
        // Transparent around their one argument.
        "Wrapping" | "MaybeUninit" | "ManuallyDrop" | "Cell" | "UnsafeCell" => match arguments {
            [TypeArgument::Type(ty)] => Some(ty.clone()),
            _ => None,
        },
        _ => None,
    }
}

fn half(name: &str) -> Option<RustType> {
    match name {
        "f16" => Some(RustType::scalar(ScalarKind::Float, "f16", 2)),
        "bf16" => Some(RustType::scalar(ScalarKind::Bfloat, "bf16", 2)),
        _ => None,
    }
}

fn vector(kind: ScalarKind, name: &'static str, width: u64, len: u64) -> Option<RustType> {
    RustType::array(RustType::scalar(kind, name, width), len)
}

fn floats(len: u64) -> Option<RustType> {
    vector(ScalarKind::Float, "f32", 4, len)
}

fn glam(name: &str) -> Option<RustType> {
    match name {
        "Vec3A" => Some(floats(3)?.aligned(16)),
        "Vec4" | "Quat" => Some(floats(4)?.aligned(16)),
        "Mat2" => Some(RustType::array(floats(2)?, 2)?.aligned(16)),
        "Mat3A" => RustType::array(floats(3)?.aligned(16), 3),
        "Affine3A" => RustType::array(floats(3)?.aligned(16), 4),
        "Mat4" => RustType::array(floats(4)?.aligned(16), 4),
        _ => unaligned(name),
    }
}

/// bevy_color's colours are `repr(C)` with four components.
fn bevy(root: &str, name: &str) -> Option<RustType> {
    match name {
        "LinearRgba" | "Srgba" if matches!(root, "bevy" | "bevy_color") => floats(4),
        _ => None,
    }
}

/// The components of glam's types by the beginnings of their names.
// `I64` and the like before `I`, which they begin with.
const COMPONENTS: &[(&str, ScalarKind, &str, u64)] = &[
    ("D", ScalarKind::Float, "f64", 8),
    ("I64", ScalarKind::Sint, "i64", 8),
    ("U64", ScalarKind::Uint, "u64", 8),
    ("I16", ScalarKind::Sint, "i16", 2),
    ("U16", ScalarKind::Uint, "u16", 2),
    ("I8", ScalarKind::Sint, "i8", 1),
    ("U8", ScalarKind::Uint, "u8", 1),
    ("I", ScalarKind::Sint, "i32", 4),
    ("U", ScalarKind::Uint, "u32", 4),
    ("", ScalarKind::Float, "f32", 4),
];

/// Vectors and matrices aligned like their components.
fn unaligned(name: &str) -> Option<RustType> {
    let (kind, scalar, width, rest) = COMPONENTS.iter().find_map(|row| {
        let (prefix, kind, scalar, width) = *row;
        Some((kind, scalar, width, name.strip_prefix(prefix)?))
    })?;
    let count = |digit: &str| match digit {
        "2" => Some(2),
        "3" => Some(3),
        "4" => Some(4),
        _ => None,
    };
    if let Some(digit) = rest.strip_prefix("Vec") {
        return vector(kind, scalar, width, count(digit)?);
    }
    if kind != ScalarKind::Float {
        return None;
    }
    if rest == "Quat" {
        return vector(kind, scalar, width, 4);
    }
    let n = count(rest.strip_prefix("Mat")?)?;
    RustType::array(vector(kind, scalar, width, n)?, n)
}

/// `Vector3<f32>`, `Matrix4<f32>`: components in order, matrices by columns.
fn generic(name: &str, arguments: &[TypeArgument]) -> Option<RustType> {
    let (component, numbers) = match arguments {
        [TypeArgument::Type(ty), numbers @ ..] => (ty.clone(), numbers),
        _ => return None,
    };
    match (name, numbers) {
        ("SVector", [TypeArgument::Number(n)]) => return RustType::array(component, *n),
        ("SMatrix", [TypeArgument::Number(rows), TypeArgument::Number(columns)]) => {
            return RustType::array(RustType::array(component, *rows)?, *columns);
        }
        ("Deg" | "Rad", []) => return Some(component),
        ("Quaternion" | "UnitQuaternion", []) => return RustType::array(component, 4),
        (_, []) => {}
        (_, _) => return None,
    }
    let count = |digits: &str| digits.parse().ok().filter(|n| (1..=4).contains(n));
    for prefix in ["Vector", "Point"] {
        if let Some(digits) = name.strip_prefix(prefix) {
            return RustType::array(component, count(digits)?);
        }
    }
    let digits =
        ["ColumnMatrix", "RowMatrix", "Matrix"].iter().find_map(|p| name.strip_prefix(p))?;
    match digits.split_once('x') {
        // nalgebra's `Matrix3x4` has 3 rows; mint's, stored by rows, are left out.
        Some((rows, columns)) if name.starts_with('M') => {
            RustType::array(RustType::array(component, count(rows)?)?, count(columns)?)
        }
        Some(_) => None,
        None => {
            let n = count(digits)?;
            RustType::array(RustType::array(component, n)?, n)
        }
    }
}
