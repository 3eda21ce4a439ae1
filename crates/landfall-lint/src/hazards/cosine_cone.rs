//! `cosine-cone`: a cone by the difference of two cosines.

use super::{Check, Level, Lint};
use landfall_ir::analysis::hazards::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "cosine-cone",
    // Cones wider than a degree lose nothing.
    level: Level::Allow,
    what: "a cone by cosines, which loses digits for angles of a fraction of a degree",
    why: "Cosines of small angles are all next to 1, where an `f32` has steps of 6e-8: 1 - cos of \
          1 degree is 2555 of them, of 0.1 degrees 26. With directions normalised in the shader \
          the edge of a cone of 0.5 to 1 degree is up to 0.7 of an 8-bit step wrong, one of 0.1 \
          to 0.2 degrees 19 steps, and of 0.05 to 0.06 degrees all 255. The squared \
          chord between two unit vectors is 2 - 2 cos and keeps its digits. Allowed \
          unless asked for, because cones of a degree and more lose nothing.",
    example: "\
#version 330 core
struct SpotLight { vec3 position; vec3 direction; vec3 color; float cutOff; float outerCutOff; };
uniform SpotLight light;
in vec3 at;
out vec4 color;
void main() {
    vec3 l = normalize(light.position - at);
    float theta = dot(l, normalize(-light.direction));
    color = theta > light.cutOff ? vec4(light.color, 1.0) : vec4(0.0);
}
",
    fix: "compare half the squared chord, `0.5 * dot(e, e)` with `e` the difference of the two unit vectors, with `1.0 - cosine`",
    check: Check::Hazard(Kind::CosineCone),
};
