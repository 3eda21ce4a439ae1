//! `vec3-array`: elements of three components, stored four components apart.

use super::definition::{Check, Lint, Subject};
use super::walk::{Visit, declared, per_member};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::shape::Type;

pub(super) const LINT: Lint = Lint {
    code: "vec3-array",
    // Legal and common; wrong only if the copy is.
    level: Level::Allow,
    what: "an array of `vec3`, whose elements are 16 bytes apart",
    why: "A `vec3` takes 12 bytes but is aligned to 16, so that the elements of an array of them \
          are 16 apart under every layout rule but scalar. An upload of tightly packed `vec3`s is \
          right for element 0 only. Allowed by default, because the shader is correct.",
    example: "\
#version 330 core
layout(std140) uniform Kernel {
    vec3 samples[7]; // 112 bytes, not 84
};
void main() {}
",
    fix: "Upload 4 floats per element, or declare the array as `vec4` and use the fourth \
          component.",
    check: Check::Shader(|subject, _| per_member(subject, padded_elements)),
};

fn padded_elements(subject: &Subject<'_>, visit: &Visit<'_>) -> Option<Finding> {
    let member = visit.member();
    let Type::Vector { scalar, rows: 3 } = *member.ty.innermost() else { return None };
    let stride = *member.strides.last()?;
    let packed = 3 * u64::from(scalar.width);
    if stride <= packed {
        return None;
    }
    let language = subject.shader.language;
    let ty = member.ty.innermost().spelled(language);
    let message = format!(
        "elements of `{}` are {stride} bytes apart: packed `{ty}`s are {packed} apart, and only \
         the first is read correctly",
        member.name,
    );
    let four = with_innermost(&member.ty, &Type::Vector { scalar, rows: 4 });
    let size = match member.size {
        Some(size) => format!("{size} bytes"),
        None => format!("{stride} bytes per element"),
    };
    Some(
        visit
            .finding(subject, LINT.code, message)
            .with_text(format!("array stride {stride}"))
            .with_help(format!(
                "upload 4 components per element, or declare `{}`: {size} as before, and the \
                 fourth component is free to use",
                declared(&member.name, &four, language),
            )),
    )
}

/// Returns the array with another innermost element.
pub(super) fn with_innermost(ty: &Type, innermost: &Type) -> Type {
    let Type::Array { element, len } = ty else { return innermost.clone() };
    let element = std::sync::Arc::new(with_innermost(element, innermost));
    Type::Array { element, len: len.clone() }
}
