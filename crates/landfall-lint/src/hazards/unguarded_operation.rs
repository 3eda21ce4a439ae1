//! `unguarded-operation`: an operation without a defined value for operands that may occur.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::occurrence::{Certainty, Kind};
use landfall_ir::analysis::undefined::UndefinedKind;

pub(crate) const LINT: Lint = Lint {
    code: "unguarded-operation",
    // What excludes the operands may be known to the program alone.
    level: Level::Allow,
    what: "a division, root, logarithm, arc cosine, `smoothstep` or `normalize` that is undefined for \
           operands which may occur",
    why: "The dot product of two unit vectors is up to 2.4e-7 above 1, where `acos` and \
          `sqrt(1.0 - x * x)` are NaN; a division by a squared length is infinite at the point \
          itself. Values are followed through functions and conditions, so that a guard in any of \
          them is recognised. Allowed by default, because what excludes such operands may be known \
          to the program alone.",
    example: "\
#version 330 core
struct PointLight { vec3 position; vec3 color; };
uniform PointLight light;
in vec3 at;
in vec3 normal;
out vec4 color;
void main() {
    vec3 v = light.position - at;
    vec3 l = v * inversesqrt(max(dot(v, v), 1.0e-30));
    float angle = acos(dot(normalize(normal), l)); // 1.0000001 at a light straight above
    color = vec4(light.color * (1.0 - angle / 1.5708), 1.0);
}
",
    fix: "Keep the operand in the domain of the operation: `acos(clamp(x, -1.0, 1.0))`, \
          `sqrt(max(x, 0.0))`, a divisor of `max(x, 1.0e-30)`.",
    check: Check::Hazard(Kind::UnguardedOperation, message),
};

fn message(site: &HazardSite<'_>) -> HazardMessage {
    let undefined = site.occurrence.undefined.unwrap_or(UndefinedKind::BornNan);
    let (verb, label) = match site.occurrence.certainty {
        Certainty::Possible => ("is possible", "undefined for some operands"),
        Certainty::Likely => ("is likely", "undefined for ordinary operands"),
        Certainty::Certain => ("is certain", "undefined"),
    };
    HazardMessage::new(format!("{undefined} {verb}"), label, undefined.remedy())
}
