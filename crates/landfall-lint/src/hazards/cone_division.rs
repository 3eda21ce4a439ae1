//! `cone-division`: a cone whose two angles may be equal.

use super::{Check, Level, Lint};
use landfall_ir::analysis::hazards::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "cone-division",
    // Cones with two equal angles are rare, and the host can refuse them.
    level: Level::Allow,
    what: "a cone factor divided by the difference of two cosines that may be equal",
    why: "A spotlight whose inner and outer angle are the same divides by 0: infinity \
          inside, and 0/0 exactly on the edge. A cutoff of 0 degrees does it too, where \
          one cosine is subtracted from 1: rounding lifts a cosine above 1 in one of \
          seven fragments on the axis, and they sparkle. Allowed unless asked for, \
          because such cones are rare.",
    example: "\
#version 330 core
struct SpotLight { vec3 position; vec3 direction; vec3 color; float cutOff; float outerCutOff; };
uniform SpotLight light;
in vec3 at;
out vec4 color;
void main() {
    vec3 l = normalize(light.position - at);
    float theta = dot(l, normalize(-light.direction));
    float edge = (theta - light.outerCutOff) / (light.cutOff - light.outerCutOff);
    color = vec4(light.color * clamp(edge, 0.0, 1.0), 1.0);
}
",
    fix: "divide by `max(inner - outer, 1.0e-4)`, or refuse such a light in the program",
    check: Check::Hazard(Kind::ConeDivision),
};
