//! `mat3-padding`: matrices whose columns, or rows, are shorter than their stride.

use super::definition::{Check, Lint, Subject};
use super::walk::{Visit, per_member};
use landfall_layout::finding::{Finding, Level};
pub use landfall_layout::layout::measure::matrix_vector;
use landfall_layout::shape::{Scalar, ScalarKind, Type};

pub(super) const LINT: Lint = Lint {
    code: "mat3-padding",
    // Every normal matrix in a block does this.
    level: Level::Allow,
    what: "a matrix with padding after each column: a `mat3` takes 48 bytes, not 36",
    why: "A matrix is an array of its columns (rows, if it is row-major). Columns of three \
          components are 16 bytes apart; in std140, columns of two components are too. A packed \
          `mat3` of 36 bytes is right in its first column only. Allowed by default, because the \
          shader is correct.",
    example: "\
#version 330 core
layout(std140) uniform Camera {
    mat3 normal_matrix; // 48 bytes: 3 columns of 12, 16 apart
};
void main() {}
",
    fix: "Upload 4 floats per column (`[[f32; 4]; 3]`), or declare a `mat4` or three `vec4`.",
    check: Check::Shader(|subject, _| per_member(subject, padded)),
};

fn padded(subject: &Subject<'_>, visit: &Visit<'_>) -> Option<Finding> {
    let member = visit.member();
    let Type::Matrix { scalar, .. } = *member.ty.innermost() else { return None };
    let (stride, vector) = (member.matrix_stride?, matrix_vector(member)?);
    if stride <= vector.bytes {
        return None;
    }
    let (vectors, one) = if member.row_major { ("rows", "row") } else { ("columns", "column") };
    let each = if member.dims.is_empty() { "" } else { "each element of " };
    let message = format!(
        "{each}`{}` is {} {vectors} of {} bytes, {stride} apart: {} bytes, where a packed `{}` \
         is {}",
        member.name,
        vector.count,
        vector.bytes,
        stride * vector.count,
        member.ty.innermost().spelled(subject.shader.language),
        vector.bytes * vector.count,
    );
    let slots = stride / u64::from(scalar.width);
    let rust = match rust_name(scalar) {
        Some(name) => format!(" (`[[{name}; {slots}]; {}]`)", vector.count),
        None => String::new(),
    };
    Some(
        visit
            .finding(subject, LINT.code, message)
            .with_text(format!("matrix stride {stride}"))
            .with_help(format!("upload {slots} components per {one}{rust}")),
    )
}

/// Returns the Rust type of a component, if there is one.
fn rust_name(scalar: Scalar) -> Option<&'static str> {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 4) => Some("f32"),
        (ScalarKind::Float, 8) => Some("f64"),
        _ => None,
    }
}
