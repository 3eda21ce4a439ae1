//! `unnormalised-normal`: an interpolated normal used without normalising it.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::occurrence::Kind;
use landfall_layout::source::Language;

pub(crate) const LINT: Lint = Lint {
    code: "unnormalised-normal",
    // Interpolation shortens every normal between vertices that differ.
    level: Level::Warn,
    what: "an interpolated normal in `reflect` or `dot` that was not normalised",
    why: "Between two vertices whose normals differ, the interpolated one is shorter than 1. With \
          `reflect` the error is raised to the power of the shininess: where light and camera are \
          at a right angle, vertex normals 20 degrees apart leave 0.38 of the peak of a highlight \
          with exponent 32, 40 degrees 0.02; a normal 10 % too long makes it 446 times too bright.",
    example: "\
#version 330 core
struct PointLight { vec3 position; vec3 color; float constant; float linear; float quadratic; };
uniform PointLight light;
in vec3 at;
in vec3 normal;
out vec4 color;
uniform vec3 eye;
void main() {
    vec3 l = normalize(light.position - at);
    float x = dot(reflect(-l, normal), normalize(eye - at));
    color = vec4(light.color * pow(clamp(x, 0.0, 1.0), 32.0), 1.0);
}
",
    fix: "Normalise it once at the top of the fragment shader, and use the result.",
    check: Check::Hazard(Kind::UnnormalisedNormal, message),
};

fn message(site: &HazardSite<'_>) -> HazardMessage {
    let path = site.path().unwrap_or_default();
    // In GLSL a member of a block without an instance is called by its own name alone.
    let help = match (site.language, path.contains('.')) {
        (Language::Glsl | Language::SpirV, true) => "wrap it in `normalize()`".to_string(),
        (Language::Glsl | Language::SpirV, false) | (Language::Wgsl, _) => {
            format!("use `normalize({path})`")
        }
    };
    HazardMessage::new(
        format!("{} is interpolated but not normalised before it is used here", site.about()),
        "not of length 1",
        help,
    )
}
