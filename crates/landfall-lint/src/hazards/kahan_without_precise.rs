//! `kahan-without-precise`: a compensated sum that a compiler may undo.

use super::{Check, Level, Lint};
use landfall_ir::analysis::hazards::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "kahan-without-precise",
    // Compilers are free to, and one that is widely used does.
    level: Level::Warn,
    what: "a compensated sum that a compiler is free to simplify to 0",
    why: "(t - s) - y is 0 in real numbers, and without `precise` a compiler may say so: \
          the sum is then the plain one at four times the cost. WGSL has no `precise`; \
          Mesa cancels the compensation of a shader that came through naga. In four \
          lanes, or pairwise, a sum loses as little and nothing can undo it.",
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
    fix: "declare the variables `precise`; in WGSL sum in several lanes, or pairwise",
    check: Check::Hazard(Kind::KahanWithoutPrecise),
};
