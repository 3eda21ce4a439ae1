//! `scalar-after-vec3`: a scalar in the last quarter of a `vec3`'s slot.

use super::definition::{Check, Lint, Subject};
use super::show::bytes;
use super::walk::{Visit, per_member};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::shape::{Rules, Type};

pub(super) const LINT: Lint = Lint {
    code: "scalar-after-vec3",
    // Most shaders do this, most of them on purpose: it saves 4 bytes.
    level: Level::Allow,
    what: "a scalar in the 4 bytes after a `vec3`",
    why: "A `vec3` is aligned to 16 bytes but takes 12, so that a scalar after it is at +12. In a \
          copy of the structure whose `vec3` takes 16 bytes (an aligned math type, a `float[4]`) \
          the scalar is at +16, and everything after it is read from the wrong byte. Allowed by \
          default, because the layout itself is a good one: `rust-mirror` and emitted mirrors \
          check the copy.",
    example: "\
#version 330 core
layout(std140) uniform Light {
    vec3 color;      // 0
    float intensity; // 12, not 16
};
void main() {}
",
    fix: "In the copy, give the `vec3` 12 bytes (`[f32; 3]`) and let the scalar follow directly; \
          or declare one `vec4` for both.",
    check: Check::Shader(|subject, _| per_member(subject, in_the_slot)),
};

fn in_the_slot(subject: &Subject<'_>, visit: &Visit<'_>) -> Option<Finding> {
    // There a `vec3` has no slot of 16 bytes.
    if visit.block.rules == Rules::Scalar {
        return None;
    }
    let vector = visit.siblings.get(visit.index.checked_sub(1)?)?;
    let member = visit.member();
    let Type::Vector { scalar, rows: 3 } = vector.ty else { return None };
    let (start, at) = (vector.offset?, member.offset?);
    let (own, slot) = (3 * u64::from(scalar.width), 4 * u64::from(scalar.width));
    if at < start + own || at >= start + slot {
        return None;
    }
    let ty = vector.ty.spelled(subject.shader.language);
    let message = format!(
        "`{}` is at {at}, in the last {} of the {slot} that `{}` is aligned to: a copy whose \
         `{ty}` takes {slot} bytes has it at {}",
        member.name,
        bytes(slot - own),
        vector.name,
        start + slot,
    );
    let place = landfall_layout::finding::Place::new(&subject.shader.files, vector.span);
    Some(
        visit
            .finding(subject, LINT.code, message)
            .with_text(format!("offset {at}"))
            .with_label(place, format!("the `{ty}` at {start}, {own} bytes"))
            .with_help(format!(
                "in the copy, give `{}` {own} bytes and let `{}` follow directly",
                vector.name, member.name,
            )),
    )
}
