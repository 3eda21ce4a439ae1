//! Lights that end and lights that do not, by code.

use landfall_ir::Module;
use landfall_ir::analysis::hazards::falloff::{FalloffNumbers, LightArray, terms};
use landfall_ir::analysis::roles::{self, Role};
use landfall_layout::{Options, Source};

/// Whether a light of range 2 adds nothing from a distance on; `term` is what a light adds.
fn vanishes(body: &str, distance: f64) -> bool {
    let text = format!(
        "#version 450
layout(location = 0) in vec3 FragPos;
layout(location = 0) out vec4 FragColor;
struct PointLight {{ vec3 position; float range; vec3 color; float intensity; }};
layout(std430, binding = 0) readonly buffer PointLightBlock {{
uint pointCount; PointLight lights[];
}};
layout(binding = 1) uniform sampler2D table;
float window(float d, float r) {{
float q = d / r;
float s = max(1.0 - q * q * q * q, 0.0);
return s * s;
}}
float early(PointLight light, float d2) {{
if (d2 >= light.range * light.range) {{ return 0.0; }}
return window(sqrt(d2), light.range);
}}
void main() {{
vec3 sum = vec3(0.1);
float other = 1.0;
for (uint i = 0u; i < pointCount; i++) {{
    vec3 p = lights[i].position - FragPos;
    float d = length(p);
    float r = lights[i].range;
    vec3 c = lights[i].color;
    {body}
}}
FragColor = vec4(sum * other, 1.0);
}}
"
    );
    let source = Source::new("falloff.frag", text);
    let options = Options::default();
    let module = Module::new(&source, &options).unwrap_or_else(|found| panic!("{found:?}"));
    let blocks: Vec<_> = module.blocks.iter().map(|block| block.layout.clone()).collect();
    let lights = roles::lights_in_blocks(&blocks);
    assert_eq!(lights.len(), 1);
    let terms = terms(&source, &options, &lights, "FragPos");
    let terms = terms.unwrap_or_else(|found| panic!("{found:?}"));
    let of = |role| match role {
        Role::Range => Some([2.0; 2]),
        Role::Color | Role::Intensity => Some([0.5, 1.0]),
        _ => None,
    };
    let counts = ["pointCount".to_string(), "lights.length()".to_string()];
    let array = LightArray { index: 0, counts: &counts, lists: &[] };
    let mut terms = terms.of_array(array);
    let vanishes = terms.adds_zero(&FalloffNumbers { of: &of, distance: [distance, 1e19] });
    // A light is as it is whatever was asked before.
    let near = terms.adds_zero(&FalloffNumbers { of: &of, distance: [0.0, 1e19] });
    assert!(vanishes || !near);
    assert_eq!(terms.adds_zero(&FalloffNumbers { of: &of, distance: [distance, 1e19] }), vanishes);
    vanishes
}

#[test]
fn lights_that_end_are_told_from_lights_that_do_not() {
    for (body, past, within) in [
        ("sum += c * window(d, r);", true, false),
        ("sum += c * early(lights[i], dot(p, p)) / (1.0 + d);", true, false),
        ("sum += d < r ? c : vec3(0.0);", true, false),
        ("if (d > r) continue; sum += c * window(d, r);", true, false),
        ("sum += c * clamp(1.0 - d / r, 0.0, 1.0);", true, false),
        ("sum += c * (1.0 - smoothstep(r * 0.5, r * 0.9, d));", true, false),
        ("sum += c * window(d, r * 0.5);", true, true),
        ("if (c.x > 0.2) sum += c * window(d, r);", true, false),
        ("if (pointCount < 9u) sum += c * window(d, r);", false, false),
        ("if (i < 9u) sum += c * window(d, r);", false, false),
        (
            "float m = 1.0; for (int k = 0; k < 3; k++) m *= d; sum += c * m * window(d, r);",
            true,
            false,
        ),
        ("sum += c * window(d, r * 1.5);", false, false),
        ("sum += c * window(d, r) + 0.01;", false, false),
        ("sum += c * (1.0 - d / r);", false, false),
        ("sum += c / (1.0 + d * d);", false, false),
        ("sum += c * window(d, r); other = c.x;", false, false),
        ("sum += c * window(d, r); other *= 1.0 + window(d, r) + c.y;", false, false),
        ("sum += c * window(d, r); if (c.x > 0.7) break;", false, false),
        ("sum += c * window(d, r); if (d > r) { other = 0.5; continue; }", false, false),
        (
            "sum += c * window(d, r); switch (int(c.x)) { case 1: other = 2.0; break; default: other = 3.0; }",
            false,
            false,
        ),
        ("sum += c * window(d, r); if (c.x > 0.5) discard;", false, false),
        ("sum += c * window(d, r); if (pointCount > 5u) break;", false, false),
        ("sum += c * window(d, r) * float(i);", false, false),
        ("sum += c * window(d, r); other = float(pointCount);", false, false),
        ("sum += c * window(d, r); other += 0.01;", false, false),
        ("sum += c * window(d, r); for (int k = 0; k < 3; k++) other += 0.01;", false, false),
        ("sum = (sum + c * window(d, r)) * 0.99;", false, false),
        ("sum += c * window(d, r) * sum.x;", false, false),
        ("sum += c * window(d, r); other = texture(table, c.xy).x;", false, false),
        ("sum += c * window(length(p.xy), r);", false, false),
        ("sum += c * window(length(lights[i].position.xyz - FragPos), r);", true, false),
        ("sum += c * window(length(lights[i].position.zyx - FragPos), r);", false, false),
        ("sum += c * window(length(FragPos.yxz - lights[i].position), r);", false, false),
        ("sum += c * window(length(lights[i].position + FragPos), r);", false, false),
    ] {
        // Past the range by more than any rounding; and inside of it.
        assert_eq!(vanishes(body, 2.00001), past, "{body}");
        assert_eq!(vanishes(body, 1.5), within, "{body}");
    }
}
