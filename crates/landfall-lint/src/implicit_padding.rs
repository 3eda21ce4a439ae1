//! `implicit-padding`: bytes between members that no member declares.

use super::definition::{Check, Lint, Subject};
use super::walk::{Visit, per_member};
use landfall_layout::finding::{Finding, Level};

pub(super) const LINT: Lint = Lint {
    code: "implicit-padding",
    // Every shader has some; only who writes the bytes by hand wants each declared.
    level: Level::Allow,
    what: "bytes before a member that hold nothing, because the layout rules align it",
    why: "A structure that a program writes by hand needs the same bytes between the same members. \
          Where a shader declares them, both read alike, and a compiler of other rules places the \
          members alike. Allowed by default, because the shader is correct.",
    example: "\
#version 330 core
layout(std140) uniform Fog {
    float density;
    vec3 color; // at byte 16: 12 bytes before it hold nothing
};
out vec4 shade;
void main() { shade = vec4(color, density); }
",
    fix: "Declare members in these bytes, or put smaller members there.",
    check: Check::Shader(|subject, _| per_member(subject, hole_before)),
};

fn hole_before(subject: &Subject<'_>, visit: &Visit<'_>) -> Option<Finding> {
    let member = visit.member();
    let offset = member.offset?;
    // By offset, as members with explicit ones may be declared in another order.
    let before = visit.siblings.iter().filter(|other| other.offset < member.offset);
    let ends = before.filter_map(|other| Some((other.offset? + other.size?, &other.name)));
    let (end, before) = ends.max_by_key(|(end, _)| *end)?;
    let bytes = offset.checked_sub(end).filter(|bytes| *bytes > 0)?;
    let message = format!(
        "{bytes} bytes before `{}` hold nothing: `{before}` ends at {end}, and it is at {offset}",
        member.name
    );
    Some(
        visit
            .finding(subject, LINT.code, message)
            .with_text(format!("offset {offset} by {}", visit.block.rules.name()))
            .with_help("declare members in these bytes, or move smaller members there"),
    )
}
