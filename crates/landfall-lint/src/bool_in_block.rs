//! `bool-in-block`: a `bool` of four bytes.

use super::definition::{Check, Lint, Subject};
use super::walk::{Visit, per_member};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::shape::{Scalar, ScalarKind, Type};

pub(super) const LINT: Lint = Lint {
    code: "bool-in-block",
    // Legal GLSL with one layout; wrong only if the copy is.
    level: Level::Allow,
    what: "a `bool` in a block, which takes 4 bytes there and 1 byte on the CPU",
    why: "A `bool` in a GLSL block has the size of a `uint` and is true for every value but 0. A \
          `bool` in Rust, C and C++ is 1 byte: everything after it is read from the wrong byte, \
          and the 3 bytes beside it decide whether it is true. WGSL does not allow `bool` in \
          buffers, and naga 30 lays it out as 1 byte. Allowed by default, because the layout is \
          defined.",
    example: "\
#version 330 core
layout(std140) uniform Fog {
    vec3 color;
    bool enabled; // 4 bytes
};
void main() {}
",
    fix: "Declare a `uint` and compare it with 0; in a copy on the CPU, write a 32-bit 0 or 1.",
    check: Check::Shader(|subject, _| per_member(subject, truth)),
};

fn truth(subject: &Subject<'_>, visit: &Visit<'_>) -> Option<Finding> {
    let member = visit.member();
    let (components, instead) = match *member.ty.innermost() {
        Type::Scalar(Scalar { kind: ScalarKind::Bool, .. }) => (1, Type::Scalar(Scalar::U32)),
        Type::Vector { scalar: Scalar { kind: ScalarKind::Bool, .. }, rows } => {
            (u64::from(rows), Type::Vector { scalar: Scalar::U32, rows })
        }
        Type::Scalar(_)
        | Type::Atomic(_)
        | Type::Vector { .. }
        | Type::Matrix { .. }
        | Type::Address(_)
        | Type::Struct(_)
        | Type::Array { .. } => return None,
    };
    let language = subject.shader.language;
    let message = format!(
        "`{}` is a `{}` of {} bytes, where the CPU has {components}",
        member.name,
        member.ty.innermost().spelled(language),
        4 * components,
    );
    let instead = super::vec3_array::with_innermost(&member.ty, &instead);
    Some(
        visit
            .finding(subject, LINT.code, message)
            .with_text(format!("{} bytes", 4 * components))
            .with_help(format!(
                "declare `{}`, the same bytes, and compare with 0",
                super::walk::declared(&member.name, &instead, language),
            )),
    )
}
