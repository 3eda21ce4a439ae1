//! `ambient-per-light`: an ambient term in every light of an array.

use super::{Check, Level, Lint};
use landfall_ir::analysis::hazards::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "ambient-per-light",
    // It is a model, and often wanted.
    level: Level::Allow,
    what: "an array of lights that each have an ambient term of their own",
    why: "Every light adds its ambient term wherever it shines from: five of them are 13 \
          % of the red in the published scene of six lights, and 128 saturate the \
          picture. One ambient light beside the array costs 16 bytes once instead of 16 \
          a light. Allowed unless asked for, because it is a model, and often wanted.",
    example: "\
#version 330 core
struct PointLight { vec3 position; vec3 ambient; vec3 diffuse; };
uniform PointLight lights[4];
out vec4 color;
void main() {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4; i++) {
        sum += lights[i].ambient + lights[i].diffuse;
    }
    color = vec4(sum, 1.0);
}
",
    fix: "one ambient light beside the array, added once",
    check: Check::Hazard(Kind::AmbientPerLight),
};
