//! `mediump-position`: a position in 16 bits.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::occurrence::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "mediump-position",
    // Desktop drivers and many phones compute mediump in 32 bits.
    level: Level::Allow,
    what: "the position of a light in `mediump` or `lowp`, which may be 16 bits wide",
    why: "In 16 bits, squaring a distance overflows at 256, and a light is off by a step of 0.25 at \
          300. Shading with a highlight of exponent 32, computed entirely in 16 bits, is off by 1.7 \
          8-bit steps or more in one of a hundred fragments within 10 of the origin, and by 7 within \
          100, where the light is 1 to 4 away. Colours and attenuation lose less than a step. Allowed \
          by default, because many drivers compute `mediump` in 32 bits.",
    example: "\
#version 300 es
precision mediump float;
struct PointLight { vec3 position; vec3 color; };
uniform PointLight light;
in vec3 at;
out vec4 color;
void main() {
    float d = length(light.position - at);
    color = vec4(light.color / (1.0 + d * d), 1.0);
}
",
    fix: "Declare positions, directions and distances `highp`; colours may stay `mediump`.",
    check: Check::Hazard(Kind::MediumpPosition, message),
};

fn message(site: &HazardSite<'_>) -> HazardMessage {
    HazardMessage::new(
        format!("{} may be 16 bits wide: its squared distance overflows at 256", site.about()),
        "below highp",
        "declare positions, directions and distances `highp`",
    )
}
