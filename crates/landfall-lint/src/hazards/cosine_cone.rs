//! `cosine-cone`: a cone computed from the difference of two cosines.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::occurrence::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "cosine-cone",
    // Cones wider than a degree lose nothing.
    level: Level::Allow,
    what: "a cone computed from cosines, which lose precision for angles below a degree",
    why: "Cosines of small angles are all close to 1, where an `f32` has steps of 6e-8: 1 - cos of \
          1 degree is 2555 of them, of 0.1 degrees 26. With directions normalised in the shader, \
          the edge of a cone of 0.5 to 1 degree is up to 0.7 of an 8-bit step wrong, that of a \
          cone of 0.1 to 0.2 degrees 19 steps, and of 0.05 to 0.06 degrees all 255. The squared \
          chord between two unit vectors, 2 - 2 cos, keeps its digits. Allowed by default, because \
          cones of a degree and more lose nothing.",
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
    fix: "Compare half the squared chord with `1.0 - cosine`: `0.5 * dot(e, e)`, where `e` is the \
          difference of the two unit vectors.",
    check: Check::Hazard(Kind::CosineCone, message),
};

fn message(site: &HazardSite<'_>) -> HazardMessage {
    HazardMessage::new(
        format!(
            "the cone compares a cosine with {}: cosines lose precision below 1 degree",
            site.about()
        ),
        "cosines near 1",
        "with `e = l - axis` of the unit vectors, compare `0.5 * dot(e, e)` with `1.0 - cosine`",
    )
}
