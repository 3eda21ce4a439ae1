//! `loop-past-count`: a loop over all slots of an array that has a count.

use super::{Check, Level, Lint};
use landfall_ir::analysis::hazards::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "loop-past-count",
    // Slots that are not used hold anything; of zeros they make NaN.
    level: Level::Warn,
    what: "a loop over every slot of an array of lights, beside a count of those in use",
    why: "A slot of zeros has no attenuation: 1 / 0 is infinity, times its colour of 0 \
          it is NaN, and one NaN is the whole sum. With the published shader every pixel \
          of the picture was lost. It costs the lights that are not there besides: 128 \
          slots for 2 lights took 14 times as long.",
    example: "\
#version 330 core
struct PointLight { vec3 pos; vec3 color; };
layout(std140) uniform Lights { PointLight data[16]; int count; } lights;
in vec3 at;
out vec4 color;
void main() {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 16; i++) {
        vec3 l = lights.data[i].pos - at;
        sum += lights.data[i].color / dot(l, l);
    }
    color = vec4(sum, 1.0);
}
",
    fix: "loop to `min(count, 16)`",
    check: Check::Hazard(Kind::LoopPastCount),
};
