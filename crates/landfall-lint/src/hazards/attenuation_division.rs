//! `attenuation-division`: a light that weakens by a divisor that may be 0.

use super::{Check, Level, Lint};
use landfall_ir::analysis::hazards::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "attenuation-division",
    // Programs that set a constant of 1 never meet it.
    level: Level::Allow,
    what: "an attenuation whose divisor is 0 for some light or distance",
    why: "A light whose three coefficients are still 0, as in a buffer of zeros, is \
          divided by 0: infinity, and times its colour of 0 NaN. The same happens at the \
          light where only the squared distance divides. Allowed unless asked for, \
          because programs that always set a constant of 1 never meet it.",
    example: "\
#version 330 core
struct PointLight { vec3 position; vec3 color; float constant; float linear; float quadratic; };
uniform PointLight light;
in vec3 at;
in vec3 normal;
out vec4 color;
void main() {
    float d = length(light.position - at);
    color = vec4(light.color / (light.constant + light.linear * d + light.quadratic * d * d), 1.0);
}
",
    fix: "divide by `max(…, 1.0e-4)`",
    check: Check::Hazard(Kind::AttenuationDivision),
};
