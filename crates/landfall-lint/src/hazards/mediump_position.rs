//! `mediump-position`: a position in 16 bits.

use super::{Check, Level, Lint};
use landfall_ir::analysis::hazards::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "mediump-position",
    // Desktop drivers and many phones compute mediump in 32 bits.
    level: Level::Allow,
    what: "the position of a light in `mediump` or `lowp`, which may be 16 bits wide",
    why: "In 16 bits a distance squared overflows at 256, the light is off by a step of \
          0.25 at 300, and a whole shader in them is 12 8-bit steps wrong in one of a \
          hundred pixels. Colours and attenuation lose less than a step. Allowed unless \
          asked for, because many drivers compute `mediump` in 32 bits.",
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
    fix: "declare positions, directions and distances `highp`, and leave colours `mediump`",
    check: Check::Hazard(Kind::MediumpPosition),
};
