//! `kahan-without-precise`: a compensated sum that a compiler may undo.

use super::{Check, Level, Lint};
use crate::hazard_text::{HazardMessage, HazardSite};
use landfall_ir::analysis::occurrence::Kind;
use landfall_layout::source::Language;

pub(crate) const LINT: Lint = Lint {
    code: "kahan-without-precise",
    // Compilers may simplify the sum, and a widely used one does.
    level: Level::Warn,
    what: "a compensated sum whose compensation a compiler may simplify to 0",
    why: "(t - s) - y is 0 in real numbers, and without `precise` a compiler may replace it by 0: \
          what remains is the plain sum at four times the cost. WGSL has no `precise`; Mesa \
          cancels the compensation of a shader that naga translated. A sum in four lanes, or a \
          pairwise sum, loses as little, and no compiler can undo it.",
    example: "\
#version 450
struct PointLight { vec3 position; float intensity; };
layout(std140, binding = 0) uniform Lights { PointLight data[64]; } lights;
layout(location = 0) out vec4 color;
void main() {
    float sum = 0.0;
    float lost = 0.0;
    for (int i = 0; i < 64; i++) {
        float y = lights.data[i].intensity - lost;
        float t = sum + y;
        lost = (t - sum) - y;
        sum = t;
    }
    color = vec4(sum);
}
",
    fix: "Declare the variables `precise`; in WGSL, sum in several lanes, or pairwise.",
    check: Check::Hazard(Kind::KahanWithoutPrecise, message),
};

fn message(site: &HazardSite<'_>) -> HazardMessage {
    HazardMessage::new(
        "this compensation is 0 in real numbers, and a compiler may simplify it to 0",
        "may be simplified to 0",
        match site.language {
            Language::Glsl | Language::SpirV => {
                "declare the sum, its parts and the compensation `precise`"
            }
            Language::Wgsl => "sum in several lanes, or pairwise: WGSL has no `precise`",
        },
    )
}
