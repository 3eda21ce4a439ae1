//! `unclamped-count`: a loop up to a count that may be past the array.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::occurrence::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "unclamped-count",
    // A program that keeps its count in bounds never triggers it.
    level: Level::Allow,
    what: "a loop over lights up to a count that is not clamped to the array's length",
    why: "A count larger than the array makes the shader read past its end: in a uniform block the \
          bytes of the count itself come first, then whatever follows the buffer. Allowed by \
          default, because a program that keeps its count in bounds is not affected.",
    example: "\
#version 330 core
struct PointLight { vec3 pos; vec3 color; };
layout(std140) uniform Lights { PointLight data[16]; int count; } lights;
out vec4 color;
void main() {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < lights.count; i++) {
        sum += lights.data[i].color;
    }
    color = vec4(sum, 1.0);
}
",
    fix: "Loop to `min(count, 16)`.",
    check: Check::Hazard(Kind::UnclampedCount, message),
};

fn message(site: &HazardSite<'_>) -> HazardMessage {
    let (array, count) = site.array_and_count();
    let slots = site.slots();
    HazardMessage::new(
        format!("`{count}` is not clamped to the {slots} slots of `{array}`"),
        "this index may be past the end of the array",
        format!("loop to `min({count}, {slots})`"),
    )
}
