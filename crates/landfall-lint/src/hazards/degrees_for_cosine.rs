//! `degrees-for-cosine`: a cosine compared with an angle.

use super::{Check, Level, Lint};
use landfall_ir::analysis::hazards::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "degrees-for-cosine",
    // The comparison is always true, or never.
    level: Level::Warn,
    what: "a cosine compared with an angle, in degrees or radians",
    why: "The dot product of two unit vectors lies between -1 and 1. Compared with 12.5 \
          it never lights anything, and as the edges of a soft cone 12.5 and 17.5 light \
          everything. Reported where a constant past 1, the cosine of a constant past \
          pi, or a comment or name that says degrees shows it.",
    example: "\
#version 330 core
struct SpotLight { vec3 position; vec3 direction; vec3 color; float cutOff; float outerCutOff; };
uniform SpotLight light;
in vec3 at;
out vec4 color;
void main() {
    vec3 l = normalize(light.position - at);
    float theta = dot(l, normalize(-light.direction));
    color = theta > 12.5 ? vec4(light.color, 1.0) : vec4(0.0);
}
",
    fix: "compare with the cosine, `cos(radians(12.5))`, best computed once by the program",
    check: Check::Hazard(Kind::DegreesForCosine),
};
