//! `ungated-specular`: a highlight that shines through the surface.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::occurrence::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "ungated-specular",
    // The published lighting models compute it in this way.
    level: Level::Allow,
    what: "a highlight that is not cut off where the light is behind the surface",
    why: "The mirrored direction may still point at the eye when the light is a little below the \
          horizon: at a grazing view, a light with dot(n, l) = -0.2 adds a highlight of exponent 32 \
          of 0.52 times its colour. It also keeps a renderer from skipping lights that a surface \
          faces away from. Allowed by default, because the reference model is published that way.",
    example: "\
#version 330 core
struct PointLight { vec3 position; vec3 color; float constant; float linear; float quadratic; };
uniform PointLight light;
in vec3 at;
in vec3 normal;
out vec4 color;
uniform vec3 eye;
void main() {
    vec3 n = normalize(normal);
    vec3 l = normalize(light.position - at);
    float highlight = pow(max(dot(reflect(-l, n), normalize(eye - at)), 0.0), 32.0);
    color = vec4(light.color * (max(dot(n, l), 0.0) + highlight), 1.0);
}
",
    fix: "Add the highlight only where `dot(n, l) > 0.0`.",
    check: Check::Hazard(Kind::UngatedSpecular, message),
};

fn message(_: &HazardSite<'_>) -> HazardMessage {
    HazardMessage::new(
        "a light behind the surface still makes a highlight on it",
        "not cut off at the horizon",
        "add it only where `dot(n, l) > 0.0`, which also allows skipping whole lights there",
    )
}
