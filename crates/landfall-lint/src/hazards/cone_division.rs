//! `cone-division`: a cone whose two angles may be equal.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::hazard::Hazard;
use landfall_ir::analysis::occurrence::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "cone-division",
    // Cones with two equal angles are rare, and the host can refuse them.
    level: Level::Allow,
    what: "a cone factor divided by a difference of two cosines that may be equal",
    why: "A spotlight whose inner and outer angle are equal divides by 0: infinity inside the \
          cone, and 0 / 0 exactly on its edge. A cutoff of 0 degrees divides by 0 too, where one \
          cosine is subtracted from 1: rounding lifts a cosine above 1 in one of nine fragments \
          on the axis, which then sparkle. Allowed by default, because such cones are rare.",
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
    fix: "Divide by `max(inner - outer, 1.0e-4)`, or refuse such a light in the program.",
    check: Check::Hazard(Kind::ConeDivision, message),
};

fn message(site: &HazardSite<'_>) -> HazardMessage {
    let (about, least) = (site.about(), site.least());
    let (message, help) = match site.occurrence.hazard {
        Hazard::ZeroWidthCone => (
            format!("the cone divides by 0 where the angle of {about} is 0"),
            format!("divide by `max(1.0 - cutoff, {least})`"),
        ),
        _ => (
            format!("the cone divides by 0 where the angle of {about} equals the other one"),
            format!(
                "divide by `max(inner - outer, {least})`, which makes the edge hard where the \
                 angles are equal"
            ),
        ),
    };
    HazardMessage::new(message, "may divide by 0", help)
}
