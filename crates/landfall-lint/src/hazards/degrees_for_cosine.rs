//! `degrees-for-cosine`: a cosine compared with an angle.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::occurrence::{Certainty, Kind};

pub(crate) const LINT: Lint = Lint {
    code: "degrees-for-cosine",
    // The comparison is always true, or never.
    level: Level::Warn,
    what: "a cosine compared with an angle in degrees or radians",
    why: "The dot product of two unit vectors lies between -1 and 1. A hard cone that compares it \
          with 12.5 lights nothing, and a soft cone with the edges 12.5 and 17.5 lights \
          everything. Reported where a constant above 1, the cosine of a constant above pi, or a \
          comment or name that mentions degrees shows it.",
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
    fix: "Compare with the cosine, `cos(radians(12.5))`, best computed once by the program.",
    check: Check::Hazard(Kind::DegreesForCosine, message),
};

fn message(site: &HazardSite<'_>) -> HazardMessage {
    let angle = match (site.occurrence.number, site.occurrence.certainty) {
        (Some(number), _) => format!("`{number}`, which is not a cosine"),
        (None, Certainty::Possible) => format!("{}, which is an angle by its name", site.about()),
        (None, _) => format!("{}, which is an angle by its name or comment", site.about()),
    };
    HazardMessage::new(
        format!("a cosine is compared with {angle}"),
        "angle instead of a cosine",
        "compare with the cosine: `cos(radians(angle))`, computed once by the program",
    )
}
