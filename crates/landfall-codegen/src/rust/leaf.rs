//! The Rust type of a scalar, vector or matrix.
//!
//! Called by [`super::array`] and [`super::plan`] for leaves. A type is used only where its
//! alignment, on any target and with any features of glam, does not exceed the guaranteed
//! alignment of its place.

use landfall_layout::shape::{Scalar, ScalarKind, Type};

use super::Vectors;
use super::plan::Plan;
use super::types::{Component, GeneratedType, LeafType, RustType, Shape, Sized, component};

/// The type of a leaf at a place guaranteed to be aligned to `align` bytes.
pub(super) fn leaf(
    plan: &mut Plan,
    ty: &Type,
    matrix_stride: Option<u64>,
    row_major: bool,
    align: u64,
) -> Sized {
    match ty {
        Type::Scalar(scalar) | Type::Atomic(scalar) => scalar_type(plan, *scalar, align),
        // An address is a 64-bit number.
        Type::Address(_) => scalar_type(plan, Scalar::U64, align),
        Type::Vector { scalar, rows } => vector(plan, *scalar, *rows, align),
        Type::Matrix { scalar, columns, rows } => {
            let stride = matrix_stride.expect("a placed matrix has a stride");
            let shape = Shape::Matrix { columns: *columns, rows: *rows, stride, row_major };
            matrix(plan, *scalar, shape, align)
        }
        Type::Struct(_) | Type::Array { .. } => {
            unreachable!("structures and arrays are no leaves")
        }
    }
}

fn scalar_type(plan: &mut Plan, scalar: Scalar, align: u64) -> Sized {
    let size = u64::from(scalar.width);
    // A type aligned more than its place would be moved by `repr(C)`.
    if size > align {
        return generated(plan, LeafType { scalar, shape: Shape::Scalar, unaligned: true }, size);
    }
    Sized { ty: component_type(plan, scalar), size }
}

fn vector(plan: &mut Plan, scalar: Scalar, rows: u8, align: u64) -> Sized {
    let width = u64::from(scalar.width);
    let size = width * u64::from(rows);
    let shape = Shape::Vector { rows };
    if width > align {
        return generated(plan, LeafType { scalar, shape, unaligned: true }, size);
    }
    let ty = match plan.vectors {
        Vectors::Array => None,
        Vectors::Glam => glam_vector(scalar, rows),
    };
    // glam's `Vec4` may be aligned to 16, and a place of std430 or scalar less.
    match ty {
        Some(ty) if glam_vector_align(scalar, rows) <= align => {
            Sized { ty: RustType::Named(ty), size }
        }
        Some(_) => generated(plan, LeafType { scalar, shape, unaligned: false }, size),
        None => {
            let component = component_type(plan, scalar);
            Sized { ty: RustType::Array(Box::new(component), rows.into()), size }
        }
    }
}

fn matrix(plan: &mut Plan, scalar: Scalar, shape: Shape, align: u64) -> Sized {
    let Shape::Matrix { columns, rows, stride, row_major } = shape else {
        unreachable!("called for matrices")
    };
    let width = u64::from(scalar.width);
    let size = stride * u64::from(shape.stored().0);
    let unaligned = width > align;
    // Columns without padding: any other matrix is a type of its own.
    let tight = stride == width * u64::from(rows);
    if unaligned || row_major || !tight {
        return generated(plan, LeafType { scalar, shape, unaligned }, size);
    }
    // glam's square matrices are arrays of their columns, but aligned as a whole.
    let square = match plan.vectors {
        Vectors::Glam if columns == rows => glam_matrix(scalar, columns),
        Vectors::Glam | Vectors::Array => None,
    };
    match square {
        Some((ty, own)) if own <= align => return Sized { ty: RustType::Named(ty), size },
        Some(_) => return generated(plan, LeafType { scalar, shape, unaligned }, size),
        None => {}
    }
    let column = vector(plan, scalar, rows, align);
    match column.ty {
        // One type for the whole matrix instead of an array of small ones.
        RustType::GeneratedType(_) => generated(plan, LeafType { scalar, shape, unaligned }, size),
        RustType::Named(_) | RustType::User(_) | RustType::Array(..) => {
            Sized { ty: RustType::Array(Box::new(column.ty), columns.into()), size }
        }
    }
}

fn generated(plan: &mut Plan, leaf: LeafType, size: u64) -> Sized {
    debug_assert_eq!(leaf.size(), size);
    if let Component::Bits(bits) = component(leaf.scalar) {
        plan.intern(GeneratedType::Bits(bits));
    }
    Sized { ty: plan.intern(GeneratedType::Leaf(leaf)), size }
}

/// The Rust type of a component, generated where Rust has none.
pub(super) fn component_type(plan: &mut Plan, scalar: Scalar) -> RustType {
    match component(scalar) {
        Component::Plain(name) => RustType::Named(name),
        Component::Bits(bits) => plan.intern(GeneratedType::Bits(bits)),
    }
}

/// The glam vector with `rows` components of type `scalar`, if there is one.
pub(super) fn glam_vector(scalar: Scalar, rows: u8) -> Option<&'static str> {
    let names = match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 4) => ["glam::Vec2", "glam::Vec3", "glam::Vec4"],
        (ScalarKind::Float, 8) => ["glam::DVec2", "glam::DVec3", "glam::DVec4"],
        (ScalarKind::Sint, 1) => ["glam::I8Vec2", "glam::I8Vec3", "glam::I8Vec4"],
        (ScalarKind::Sint, 2) => ["glam::I16Vec2", "glam::I16Vec3", "glam::I16Vec4"],
        (ScalarKind::Sint, 4) => ["glam::IVec2", "glam::IVec3", "glam::IVec4"],
        (ScalarKind::Sint, 8) => ["glam::I64Vec2", "glam::I64Vec3", "glam::I64Vec4"],
        (ScalarKind::Uint, 1) => ["glam::U8Vec2", "glam::U8Vec3", "glam::U8Vec4"],
        (ScalarKind::Uint, 2) => ["glam::U16Vec2", "glam::U16Vec3", "glam::U16Vec4"],
        (ScalarKind::Uint, 4) => ["glam::UVec2", "glam::UVec3", "glam::UVec4"],
        (ScalarKind::Uint, 8) => ["glam::U64Vec2", "glam::U64Vec3", "glam::U64Vec4"],
        (
            ScalarKind::Bool
            | ScalarKind::Sint
            | ScalarKind::Uint
            | ScalarKind::Float
            | ScalarKind::Bfloat
            | ScalarKind::FloatE5m2
            | ScalarKind::FloatE4m3,
            _,
        ) => return None,
    };
    names.get(usize::from(rows) - 2).copied()
}

/// The largest alignment of a glam vector: that of its component, except 16 for `Vec4`, which is
/// aligned to 16 with SIMD and to 4 with `scalar-math`. (`cuda` aligns more, in device code.)
fn glam_vector_align(scalar: Scalar, rows: u8) -> u64 {
    match (scalar.kind, scalar.width, rows) {
        (ScalarKind::Float, 4, 4) => 16,
        _ => scalar.width.into(),
    }
}

/// The square glam matrix of these components, and its largest alignment: `Mat2` and `Mat4` are
/// aligned to 16 with SIMD and to 4 with `scalar-math`.
pub(super) fn glam_matrix(scalar: Scalar, order: u8) -> Option<(&'static str, u64)> {
    match (scalar.kind, scalar.width, order) {
        (ScalarKind::Float, 4, 2) => Some(("glam::Mat2", 16)),
        (ScalarKind::Float, 4, 3) => Some(("glam::Mat3", 4)),
        (ScalarKind::Float, 4, 4) => Some(("glam::Mat4", 16)),
        (ScalarKind::Float, 8, 2) => Some(("glam::DMat2", 8)),
        (ScalarKind::Float, 8, 3) => Some(("glam::DMat3", 8)),
        (ScalarKind::Float, 8, 4) => Some(("glam::DMat4", 8)),
        _ => None,
    }
}
