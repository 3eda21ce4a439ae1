//! `pow-of-negative`: a power of a dot product that may be negative.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::occurrence::{Certainty, Kind};

pub(crate) const LINT: Lint = Lint {
    code: "pow-of-negative",
    // A dot product is negative for half of all directions.
    level: Level::Warn,
    what: "a power of a dot product that may be negative",
    why: "`pow(x, y)` is undefined for a negative x in GLSL and WGSL, even for a whole y: exp2(y * \
          log2(x)) is NaN. A dot product of two directions is negative for half of them. Bases \
          that only rounding takes below 0, such as 1 - dot, are reported by `landfall lights` \
          only.",
    example: "\
#version 330 core
struct PointLight { vec3 position; vec3 color; float constant; float linear; float quadratic; };
uniform PointLight light;
in vec3 at;
in vec3 normal;
out vec4 color;
uniform vec3 eye;
void main() {
    vec3 l = normalize(light.position - at);
    vec3 r = reflect(-l, normalize(normal));
    color = vec4(light.color * pow(dot(r, normalize(eye - at)), 32.0), 1.0);
}
",
    fix: "Clamp the base: `pow(clamp(x, 0.0, 1.0), n)`.",
    check: Check::Hazard(Kind::PowOfNegative, message),
};

fn message(site: &HazardSite<'_>) -> HazardMessage {
    let how = match site.occurrence.certainty {
        Certainty::Possible => "may be negative by rounding",
        Certainty::Likely | Certainty::Certain => "is negative for half of all directions",
    };
    HazardMessage::new(
        format!("the base of this power {how}, which makes the result undefined"),
        "negative base",
        "clamp the base: `pow(clamp(x, 0.0, 1.0), n)`",
    )
}
