//! `unguarded-normalize`: a direction between two points that may coincide.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::hazard::Hazard;
use landfall_ir::analysis::occurrence::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "unguarded-normalize",
    // A light is seldom exactly on a surface, and most shaders take the risk.
    level: Level::Allow,
    what: "a normalised direction to a light or to the camera, or between two directions, that may \
           be the zero vector",
    why: "Where the light or the camera is at the surface point, the difference is the zero vector; \
          so is the half vector of opposite directions. `normalize` of it is undefined: NaN by the formula, and with `max` after it the \
          light silently goes out on some drivers. Values are followed through functions and \
          conditions, so that a guard in any of them is recognised. Allowed by default, because a \
          light is seldom exactly on a surface.",
    example: "\
#version 330 core
struct PointLight { vec3 position; vec3 color; float constant; float linear; float quadratic; };
uniform PointLight light;
in vec3 at;
in vec3 normal;
out vec4 color;
void main() {
    vec3 l = normalize(light.position - at); // light.position == at
    color = vec4(light.color * max(dot(normalize(normal), l), 0.0), 1.0);
}
",
    fix: "Multiply by `inversesqrt(max(dot(v, v), 1.0e-30))`, which keeps the zero vector zero.",
    check: Check::Hazard(Kind::UnguardedNormalize, message),
};

fn message(site: &HazardSite<'_>) -> HazardMessage {
    let point = match (site.occurrence.hazard, site.path()) {
        (Hazard::CameraAtFragment, None) => "the camera".to_string(),
        (Hazard::CameraAtFragment, Some(path)) => format!("the camera `{path}`"),
        (_, None) => "the light".to_string(),
        (_, Some(path)) => format!("the light's `{path}`"),
    };
    let what = match site.occurrence.hazard {
        Hazard::OppositeVectors => "the two directions are opposite".to_string(),
        _ => format!("{point} is at the surface"),
    };
    let guard = format!("{}(max(dot(v, v), {}))", site.inverse_sqrt(), site.least_square());
    HazardMessage::new(
        format!("a zero vector is normalised where {what}"),
        "0 / 0",
        format!("write `v * {guard}`, which keeps a zero vector zero"),
    )
}
