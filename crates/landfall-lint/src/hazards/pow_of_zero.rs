//! `pow-of-zero`: zero to a power that may be zero.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::occurrence::Kind;
use landfall_layout::source::Language;

pub(crate) const LINT: Lint = Lint {
    code: "pow-of-zero",
    // Only a shininess of 0 or less triggers it.
    level: Level::Allow,
    what: "a power whose base may be 0 while its exponent may be 0 or less",
    why: "`pow(0, 0)` is undefined in GLSL and WGSL: the C library returns 1, exp2(0 * log2(0)) is \
          NaN, and lavapipe returns 0. A highlight has base 0 wherever it is clamped, and a \
          material that was never set has exponent 0. Allowed by default, because only a shininess \
          of 0 or less is affected.",
    example: "\
#version 330 core
struct PointLight { vec3 position; vec3 color; float constant; float linear; float quadratic; };
uniform PointLight light;
in vec3 at;
in vec3 normal;
out vec4 color;
uniform vec3 eye;
uniform float shininess;
void main() {
    vec3 l = normalize(light.position - at);
    vec3 r = reflect(-l, normalize(normal));
    float highlight = pow(max(dot(r, normalize(eye - at)), 0.0), shininess);
    color = vec4(light.color * highlight, 1.0);
}
",
    fix: "Take the power only where the base is above 0: `x > 0.0 ? pow(min(x, 1.0), n) : 0.0`.",
    check: Check::Hazard(Kind::PowOfZero, message),
};

fn message(site: &HazardSite<'_>) -> HazardMessage {
    let exponent = site.path().map_or("the exponent".to_string(), |path| format!("`{path}`"));
    HazardMessage::new(
        format!("the base of this power may be 0: the result is undefined where {exponent} is 0"),
        "0 to the power of 0",
        match site.language {
            Language::Glsl | Language::SpirV => "write `x > 0.0 ? pow(min(x, 1.0), n) : 0.0`",
            Language::Wgsl => "write `select(0.0, pow(min(x, 1.0), n), x > 0.0)`",
        },
    )
}
