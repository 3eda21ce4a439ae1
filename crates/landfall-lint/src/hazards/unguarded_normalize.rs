//! `unguarded-normalize`: a direction between two points that may be one.

use super::{Check, Level, Lint};
use landfall_ir::analysis::hazards::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "unguarded-normalize",
    // A light is seldom exactly on a surface, and most shaders take the risk.
    level: Level::Allow,
    what: "a direction to a light or to the camera that has no guard against the two points being one",
    why: "Where a light is at the surface point, or the camera is, the difference is the \
          zero vector and `normalize` of it is undefined: NaN by the formula, and with \
          `max` after it the light silently goes out on some drivers. Seen through \
          functions and conditions: a guard around it keeps the lint silent. Allowed \
          unless asked for, because a light is seldom exactly on a surface.",
    example: "\
#version 330 core
struct PointLight { vec3 position; vec3 color; float constant; float linear; float quadratic; };
uniform PointLight light;
in vec3 at;
in vec3 normal;
out vec4 color;
void main() {
    vec3 l = normalize(light.position - at); // light.position == at
    color = vec4(light.color * max(dot(normalize(normal), l), 0.0), 1.0);
}
",
    fix: "multiply with `inversesqrt(max(dot(v, v), 1.0e-30))`: the zero vector stays zero",
    check: Check::Hazard(Kind::UnguardedNormalize),
};
