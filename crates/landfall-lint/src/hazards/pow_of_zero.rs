//! `pow-of-zero`: zero to the power of what may be zero.

use super::{Check, Level, Lint};
use landfall_ir::analysis::hazards::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "pow-of-zero",
    // Only a shininess of 0 or less meets it.
    level: Level::Allow,
    what: "a power whose base may be 0 while its exponent may be 0 or less",
    why: "`pow(0, 0)` is undefined in GLSL and WGSL: 1 by the C library, NaN by exp2(0 * \
          log2(0)), 0 on lavapipe. A highlight has base 0 wherever it is clamped, and a \
          material that was never set has exponent 0. Allowed unless asked for, because \
          only a shininess of 0 or less meets it.",
    example: "\
#version 330 core
struct PointLight { vec3 position; vec3 color; float constant; float linear; float quadratic; };
uniform PointLight light;
in vec3 at;
in vec3 normal;
out vec4 color;
uniform vec3 eye;
uniform float shininess;
void main() {
    vec3 l = normalize(light.position - at);
    vec3 r = reflect(-l, normalize(normal));
    float highlight = pow(max(dot(r, normalize(eye - at)), 0.0), shininess);
    color = vec4(light.color * highlight, 1.0);
}
",
    fix: "take the power only where the base is above 0: `x > 0.0 ? pow(min(x, 1.0), n) : 0.0`",
    check: Check::Hazard(Kind::PowOfZero),
};
