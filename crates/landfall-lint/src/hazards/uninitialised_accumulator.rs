//! `uninitialised-accumulator`: a sum that begins with whatever was there.

use super::{Check, Level, Lint};
use landfall_ir::analysis::hazards::Kind;

pub(crate) const LINT: Lint = Lint {
    code: "uninitialised-accumulator",
    // It is undefined whatever the input; drivers that clear registers hide it.
    level: Level::Warn,
    what: "a sum of lights whose variable has no value when the first is added",
    why: "A GLSL variable without initialiser holds anything. Drivers that clear \
          registers show nothing; on others the picture flickers, or one NaN stays for \
          the whole sum. WGSL has no such variables: they begin with zero.",
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
    fix: "declare it with a value: `vec3 total = vec3(0.0);`",
    check: Check::Hazard(Kind::UninitialisedAccumulator),
};
