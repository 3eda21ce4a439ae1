//! `unclamped-count`: a loop up to a count that may be past the array.

use super::{Check, Level, Lint};
use landfall_ir::analysis::hazards::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "unclamped-count",
    // A program that keeps its count in bounds never meets it.
    level: Level::Allow,
    what: "a loop over lights up to a count that nothing keeps within the array",
    why: "A count past the array makes the shader read past it: in a uniform block the \
          bytes of the count itself come first, then whatever follows the buffer. \
          Allowed unless asked for, because a program that keeps its count in bounds \
          never meets it.",
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
    fix: "loop to `min(count, 16)`",
    check: Check::Hazard(Kind::UnclampedCount),
};
