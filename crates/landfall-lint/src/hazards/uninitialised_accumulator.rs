//! `uninitialised-accumulator`: a sum whose variable is not initialised.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::occurrence::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "uninitialised-accumulator",
    // It is undefined whatever the input; drivers that clear registers hide it.
    level: Level::Warn,
    what: "a sum of lights whose variable is not initialised",
    why: "A GLSL variable without an initialiser holds an undefined value. On drivers that clear \
          registers nothing shows; on others the picture flickers, or one NaN makes the whole sum \
          NaN. WGSL initialises its variables to zero.",
    example: "\
#version 330 core
struct PointLight { vec3 position; vec3 color; float constant; float linear; float quadratic; };
uniform PointLight light;
in vec3 at;
in vec3 normal;
out vec4 color;
void main() {
    vec3 total;
    for (int i = 0; i < 4; i++) {
        total += light.color; // undefined + colour
    }
    color = vec4(total, 1.0);
}
",
    fix: "Initialise it where it is declared: `vec3 total = vec3(0.0);`.",
    check: Check::Hazard(Kind::UninitialisedAccumulator, message),
};

fn message(site: &HazardSite<'_>) -> HazardMessage {
    HazardMessage::new(
        format!("{} is added to before it is initialised", site.about()),
        "undefined here",
        "initialise it where it is declared: `= vec3(0.0)`",
    )
}
