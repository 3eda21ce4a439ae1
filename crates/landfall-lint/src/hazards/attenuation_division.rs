//! `attenuation-division`: an attenuation whose divisor may be 0.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::hazard::Hazard;
use landfall_ir::analysis::occurrence::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "attenuation-division",
    // Programs that set a constant of 1 never trigger it.
    level: Level::Allow,
    what: "an attenuation whose divisor is 0 for some light or distance",
    why: "A light whose three coefficients are 0, as in a buffer of zeros, is divided by 0: the \
          result is infinity, or NaN where its colour is 0 too. Attenuation by the squared \
          distance alone divides by 0 at the light itself. Allowed by default, because programs \
          that always set a constant term of 1 are not affected.",
    example: "\
#version 330 core
struct PointLight { vec3 position; vec3 color; float constant; float linear; float quadratic; };
uniform PointLight light;
in vec3 at;
in vec3 normal;
out vec4 color;
void main() {
    float d = length(light.position - at);
    color = vec4(light.color / (light.constant + light.linear * d + light.quadratic * d * d), 1.0);
}
",
    fix: "Divide by `max(…, 1.0e-4)`.",
    check: Check::Hazard(Kind::AttenuationDivision, message),
};

fn message(site: &HazardSite<'_>) -> HazardMessage {
    let (about, least) = (site.about(), site.least());
    let (message, help) = match site.occurrence.hazard {
        Hazard::AttenuationAtLight => (
            format!(
                "attenuation divides by a squared distance, which is 0 where {about} is at the surface"
            ),
            format!("divide by `max(dot(v, v), {least})`, which is 1 cm in metres"),
        ),
        _ => (
            format!("attenuation divides by 0 if {about} and the other coefficients are 0"),
            format!("write `1.0 / max(constant + d * (linear + quadratic * d), {least})`"),
        ),
    };
    HazardMessage::new(message, "may divide by 0", help)
}
