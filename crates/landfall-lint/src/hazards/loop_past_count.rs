//! `loop-past-count`: a loop over all slots of an array that has a count.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::occurrence::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "loop-past-count",
    // Unused slots hold arbitrary values; zeros give NaN.
    level: Level::Warn,
    what: "a loop over all slots of an array of lights although a count says how many are in use",
    why: "A slot of zeros has no attenuation: 1 / 0 is infinity, times its colour of 0 it is NaN, \
          and one NaN makes the whole sum NaN. With the published shader every pixel of the \
          picture was lost. Unused slots also take time: of 128 slots for 2 lights, 126 are \
          evaluated for nothing.",
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
    fix: "Loop to `min(count, 16)`.",
    check: Check::Hazard(Kind::LoopPastCount, message),
};

fn message(site: &HazardSite<'_>) -> HazardMessage {
    let (array, count) = site.array_and_count();
    let slots = site.slots();
    let message = HazardMessage::new(
        format!("this loop visits all {slots} slots of `{array}`, of which `{count}` are in use"),
        "every slot",
        format!("loop to `min({count}, {slots})`"),
    );
    message.with_note("a slot of zeros is 1 / 0 times 0, which makes the whole sum NaN")
}
