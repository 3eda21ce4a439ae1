//! The Rust type that has a member's bytes where the shader reads them, for a help.

use super::fit::{MemberView, components};
use super::library::MirrorWriter;
use landfall_layout::layout::measure::{fixed, matrix_vector};
use landfall_layout::shape::{Scalar, ScalarKind, Type};

/// A type as it is written, with its size and alignment in bytes.
pub(super) struct Suggestion {
    pub text: String,
    pub size: u64,
    pub align: u64,
}

/// Returns the type for a member, or its elements below some dimension; `None` for structures, and
/// for what the library has no type for.
pub(super) fn suggested(view: MemberView<'_>) -> Option<Suggestion> {
    let dims = view.member.dims.get(view.dim..)?;
    // An element may need padding that a single leaf does not.
    let mut found = match view.member.strides.last().filter(|_| !dims.is_empty()) {
        Some(stride) => element(view, *stride)?,
        None => leaf(view)?,
    };
    for len in dims.iter().rev() {
        let len = fixed(len)?;
        found.text = format!("[{}; {len}]", found.text);
        found.size = found.size.checked_mul(len)?;
    }
    Some(found)
}

/// An element of an array of that stride.
fn element(view: MemberView<'_>, stride: u64) -> Option<Suggestion> {
    let leaf = leaf(view)?;
    let (scalar, _) = components(view.member);
    let width = u64::from(scalar.width);
    match view.writer {
        MirrorWriter::Memory if leaf.size == stride => Some(leaf),
        MirrorWriter::Memory if stride.is_multiple_of(width) => Some(Suggestion {
            text: format!("[{}; {}]", rust_name(scalar), stride / width),
            size: stride,
            align: width,
        }),
        MirrorWriter::Memory => None,
        MirrorWriter::Encase if leaf.size.checked_next_multiple_of(leaf.align) == Some(stride) => {
            Some(Suggestion { size: stride, ..leaf })
        }
        MirrorWriter::Encase => {
            vector(scalar, stride / width).filter(|padded| padded.size == stride)
        }
        // crevice has no arrays.
        MirrorWriter::Std140 | MirrorWriter::Std430 => None,
    }
}

/// A scalar, vector or matrix.
fn leaf(view: MemberView<'_>) -> Option<Suggestion> {
    let member = view.member;
    let (scalar, offsets) = components(member);
    let width = u64::from(scalar.width);
    let columns = matrix_vector(member).zip(member.matrix_stride);
    if matches!(member.ty.innermost(), Type::Struct(_)) {
        return None;
    }
    let is_library = match view.writer {
        MirrorWriter::Memory => false,
        MirrorWriter::Encase | MirrorWriter::Std140 | MirrorWriter::Std430 => true,
    };
    match columns {
        Some((vector, stride)) if !is_library => Some(Suggestion {
            text: format!("[[{}; {}]; {}]", rust_name(scalar), stride / width, vector.count),
            size: stride * vector.count,
            align: width,
        }),
        Some((columns, stride)) => {
            let rows = columns.bytes / width;
            // glam has square matrices of `f32`, stored by columns.
            let square = rows == columns.count && !member.row_major && width == 4;
            // std140 aligns each column to 16 bytes.
            let least = if view.writer == MirrorWriter::Std140 { 16 } else { 1 };
            if square && stride == columns.bytes.next_power_of_two().max(least) {
                let text = format!("glam::Mat{rows}");
                return Some(Suggestion { text, size: stride * rows, align: stride });
            }
            let column =
                vector(scalar, stride / width).filter(|_| view.writer == MirrorWriter::Encase)?;
            (column.size == stride).then(|| Suggestion {
                text: format!("[{}; {}]", column.text, columns.count),
                size: stride * columns.count,
                align: column.align,
            })
        }
        None if is_library && offsets.len() > 1 => vector(scalar, offsets.len() as u64),
        None if is_library && width != 4 => None,
        None if offsets.len() == 1 => {
            Some(Suggestion { text: rust_name(scalar).to_string(), size: width, align: width })
        }
        None => Some(Suggestion {
            text: format!("[{}; {}]", rust_name(scalar), offsets.len()),
            size: width * offsets.len() as u64,
            align: width,
        }),
    }
}

/// glam's vector of so many components, as a library aligns it.
fn vector(scalar: Scalar, count: u64) -> Option<Suggestion> {
    let prefix = match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 4) => "",
        (ScalarKind::Sint, 4) => "I",
        (ScalarKind::Uint | ScalarKind::Bool, 4) => "U",
        (_, _) => return None,
    };
    let size = count.checked_mul(4)?;
    (2..=4).contains(&count).then(|| Suggestion {
        text: format!("glam::{prefix}Vec{count}"),
        size,
        align: size.next_power_of_two(),
    })
}

/// Returns the Rust type of a component.
fn rust_name(scalar: Scalar) -> &'static str {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 8) => "f64",
        (ScalarKind::Float, 2) => "half::f16",
        (ScalarKind::Float, _) => "f32",
        (ScalarKind::Bfloat, _) => "half::bf16",
        (ScalarKind::Sint, 1) => "i8",
        (ScalarKind::Sint, 2) => "i16",
        (ScalarKind::Sint, 8) => "i64",
        (ScalarKind::Sint, _) => "i32",
        (ScalarKind::Uint, 2) => "u16",
        (ScalarKind::Uint, 8) => "u64",
        (ScalarKind::Uint | ScalarKind::Bool, 4) => "u32",
        // Rust has no such number type: its bits.
        (_, 1) => "u8",
        (_, 2) => "u16",
        (_, 8) => "u64",
        (_, _) => "u32",
    }
}
