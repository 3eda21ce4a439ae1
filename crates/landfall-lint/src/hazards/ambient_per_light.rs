//! `ambient-per-light`: an ambient term in every light of an array.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::occurrence::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "ambient-per-light",
    // Some lighting models intend it.
    level: Level::Allow,
    what: "an array of lights, each with an ambient term of its own",
    why: "Every light adds its ambient term, wherever it shines: five of 0.05 are 15 % of the red \
          of the surfaces in the published scene of six lights, and 128 saturate the picture. One \
          ambient light beside the array costs 16 bytes once instead of 16 bytes per light. \
          Allowed by default, because it is a valid model and often intended.",
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
    fix: "Declare one ambient light beside the array and add it once.",
    check: Check::Hazard(Kind::AmbientPerLight, message),
};

fn message(site: &HazardSite<'_>) -> HazardMessage {
    HazardMessage::new(
        format!("the ambient light {} is added for every light", site.about()),
        "added for every light",
        "keep one ambient light beside the array, and add it once",
    )
}
