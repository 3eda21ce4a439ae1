//! `vec4-normalise`: a normal normalised together with its fourth component.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::occurrence::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "vec4-normalise",
    // The fourth component is not zero if the matrix translates.
    level: Level::Warn,
    what: "a transformed normal that is normalised as a `vec4`, including its fourth component",
    why: "The transposed inverse of a matrix with a translation gives a normal a fourth component, \
          minus the dot product of normal and translation. Normalised with it, the three others \
          come out too short, by another factor at each vertex, and the interpolated normal bends: \
          halfway between vertex normals 30 degrees apart by up to 3 degrees with the camera 2 \
          units away, by 14 at 100 units. Normalising again in the fragment shader does not \
          correct it.",
    example: "\
#version 330 core
struct PointLight { vec3 position; vec3 color; };
uniform PointLight light;
uniform mat4 view;
in vec3 normal;
out vec3 toLight;
out vec3 viewNormal;
void main() {
    viewNormal = normalize(transpose(inverse(view)) * vec4(normal, 0.0)).xyz;
    toLight = light.position;
    gl_Position = view * vec4(normal, 1.0);
}
",
    fix: "Transform by a `mat3`, or take `.xyz` before normalising.",
    check: Check::Hazard(Kind::Vec4Normalise, message),
};

fn message(_: &HazardSite<'_>) -> HazardMessage {
    HazardMessage::new(
        "the normal is normalised together with its fourth component",
        "four components",
        "write `normalize(mat3(transpose(inverse(m))) * n)`, or take `.xyz` first",
    )
}
