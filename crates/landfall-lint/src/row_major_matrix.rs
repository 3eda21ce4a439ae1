//! `row-major-matrix`: matrices that are stored by rows.

use super::definition::{Check, Lint, Subject};
use super::walk::{Visit, per_member};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::shape::Type;

pub(super) const LINT: Lint = Lint {
    code: "row-major-matrix",
    // Right for programs whose matrices have rows first, and for affine matrices of 48 bytes.
    level: Level::Allow,
    what: "a matrix stored row-major, which a column-major copy uploads transposed",
    why: "GLSL stores a matrix by columns unless `row_major` is declared for the member, its block \
          or all blocks; glam, nalgebra, cgmath and GLM store columns, too. A row-major member \
          reads their bytes as the transpose, without an error: a translation ends up in the last \
          row. `glUniformMatrix4fv` can transpose; an upload to a buffer cannot. Allowed by \
          default, because the shader is correct, and because programs whose matrices are stored \
          by rows, such as those of DirectXMath, need it.",
    example: "\
#version 330 core
layout(std140, row_major) uniform Camera {
    mat4 view; // view[1][0] is at byte 4
};
void main() {}
",
    fix: "Declare the matrix `column_major`, or transpose it where it is written to the buffer.",
    check: Check::Shader(|subject, _| per_member(subject, stored_by_rows)),
};

fn stored_by_rows(subject: &Subject<'_>, visit: &Visit<'_>) -> Option<Finding> {
    let member = visit.member();
    let Type::Matrix { scalar, .. } = *member.ty.innermost() else { return None };
    let stride = member.matrix_stride.filter(|_| member.row_major)?;
    let name = &member.name;
    let element = format!("{name}{}", "[0]".repeat(member.dims.len()));
    let message = format!(
        "`{name}` is stored row-major: `{element}[1][0]` is {} bytes after its start, \
         `{element}[0][1]` {stride}, so a column-major copy is read transposed",
        scalar.width,
    );
    // A structure's member takes no layout qualifier (GLSL 4.60 §4.4): its block decides.
    let help = match visit.structure {
        None => format!("declare `layout(column_major)` for `{name}`, or upload its transpose"),
        Some(_) => format!(
            "declare `layout(column_major)` for the member of block `{}` that holds `{name}`, or \
             upload its transpose",
            visit.block.name
        ),
    };
    Some(
        visit
            .finding(subject, LINT.code, message)
            .with_text(format!("rows {stride} bytes apart"))
            .with_help(help),
    )
}
