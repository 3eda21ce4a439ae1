//! What `landfall lights` says: bytes by hand from std140, the loop's bound, the smaller order.

use snapbox::str;

use crate::support::command::{self, Place, Ran};
use crate::support::schema;

const TEXT: &str = "\
#version 330 core
struct PointLight {
    float intensity;
    vec3 pos;
    float radius;
    vec3 color;
};
layout(std140) uniform Lights {
    PointLight data[8];
    int count;
} lights;
in vec3 at;
out vec4 color;
void main() {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < lights.count; i++) {
        sum += lights.data[i].color * normalize(lights.data[i].pos - at).z;
    }
    color = vec4(sum, 1.0);
}
";

fn lights(name: &str, text: &str, more: &[&str]) -> Ran {
    let place = Place::new(&format!("lights-{name}"));
    place.write(name, text).run(&[&["lights", name], more].concat())
}

#[test]
fn a_light_of_four_members_takes_48_bytes_and_32_in_another_order() {
    let ran = lights("a.frag", TEXT, &[]);
    // std140: intensity 0, pos 16..28, radius 28..32, color 32..44, rounded up to 48:
    // 32 bytes of scalars, 16 of padding. As vec3, float, vec3, float: 32. The block: 8 × 48,
    // the count at 384, rounded up to 400.
    ran.code(0).stderr_eq("").stdout_eq(str![[r#"
a.frag
kind   bytes  padding  slots  array  block  light
point     48       16      8    384    400  PointLight data[]

PointLight data[] in uniform Lights (std140)
  intensity  intensity  float   0
  position   pos        vec3   16
  range      radius     float  28
  color      color      vec3   32
  count: count of Lights at byte 384
  index: loop to the count, not clamped to the array
  reordered as pos, intensity, color, radius: 32 bytes instead of 48, 128
    bytes saved in total

warning[unclamped-count]: `count` is not clamped to the 8 slots of `data[]`
  --> a.frag:17:16
   |
17 |         sum += lights.data[i].color * normalize(lights.data[i].pos - at).z;
   |                ^^^^^^^^^^^^^^ this index may be past the end of the array
   |
   = note: hazard `count-past-array`, possible
   = help: loop to `min(count, 8)`

warning[unguarded-normalize]: a zero vector is normalised where the light's `data[].pos` is at the surface
  --> a.frag:17:39
   |
17 |         sum += lights.data[i].color * normalize(lights.data[i].pos - at).z;
   |                                       ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ 0 / 0
   |
   = note: hazard `light-at-fragment`, possible
   = help: write `v * inversesqrt(max(dot(v, v), 1.0e-30))`, which keeps a zero vector zero


"#]]);
}

#[test]
fn json_keeps_to_its_schema_and_says_the_same() {
    let validator = schema::validator(&command::run(&["schema", "lights"]).out);
    let loose = TEXT
        .replace(
            "layout(std140) uniform Lights {\n    PointLight data[8];",
            "uniform PointLight data[8];\nlayout(std140) uniform Lights {\n",
        )
        .replace("lights.data", "data");
    let wgsl = "struct Sun { direction: vec3f, color: vec3f }\n@group(0) @binding(0) var<uniform> sun: Sun;\n";
    for (name, text) in
        [("b.frag", TEXT), ("c.frag", &loose), ("d.wgsl", wgsl), ("e.frag", "void main() {}")]
    {
        let ran = lights(name, text, &["--format", "json"]);
        assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{name}");
        let value = schema::holds(&validator, &ran.out, name);
        if name == "b.frag" {
            let light = &value["shaders"][0]["lights"][0];
            assert_eq!(
                (&light["bytes"], &light["padding"], &light["slots"]),
                (&48.into(), &16.into(), &8.into())
            );
            assert_eq!(light["bounds"][0]["kind"], "count");
            assert_eq!(light["reorder"]["bytes"], 32);
            assert_eq!(light["count"]["offset"], 384);
        }
    }
}

#[test]
fn exit_codes_say_findings_and_could_not() {
    lights("f.frag", TEXT, &["--deny", "possible"]).code(1);
    lights("g.frag", TEXT, &["--deny", "certain"]).code(0);
    let least = lights("h.frag", TEXT, &["--least", "certain"]);
    assert!(!least.code(0).out.contains("warning["), "{}", least.out);
    let broken = lights("i.frag", "uniform Lights {", &[]);
    broken.code(2).stderr_eq(str![[r#"
error[unclosed-brace]: `{` is never closed
 --> i.frag:1:16
  |
1 | uniform Lights {
  |                ^


"#]]);
    let dark = lights("j.frag", "#version 330\nvoid main() {}\n", &[]);
    dark.code(0).stdout_eq(str![[r#"
j.frag
no lights found in structures, blocks or members

"#]]);
}

#[test]
fn functions_that_cannot_be_followed_are_told_and_the_cost_all_the_same() {
    let text = TEXT.replace("void main() {", "void main() { gl_Nothing();");
    let ran = lights("k.frag", &text, &[]);
    ran.code(0).stdout_eq(str![[r#"
k.frag
kind   bytes  padding  slots  array  block  light
point     48       16      8    384    400  PointLight data[]

PointLight data[] in uniform Lights (std140)
  intensity  intensity  float   0
  position   pos        vec3   16
  range      radius     float  28
  color      color      vec3   32
  count: count of Lights at byte 384
  reordered as pos, intensity, color, radius: 32 bytes instead of 48, 128
    bytes saved in total

its functions could not be analysed, so loop bounds and hazards are unknown:
error[unknown-name]: there is no function `gl_Nothing`
  --> k.frag:14:15
   |
14 | void main() { gl_Nothing();
   |               ^^^^^^^^^^


"#]]);
}

/// Functions with a fault, each beside one that is mended.
const FAULTS: [[&str; 2]; 9] = [
    ["return acos(dot(a, b));", "return acos(clamp(dot(a, b), -1.0, 1.0));"],
    [
        "vec3 d = a - b; return 1.0 / dot(d, d);",
        "vec3 d = a - b; return 1.0 / max(dot(d, d), 1.0e-4);",
    ],
    [
        "vec3 d = a - b; return 3.0 / (12.56 * dot(d, d));",
        "vec3 d = a - b; return 3.0 / (12.56 * dot(d, d) + 0.01);",
    ],
    [
        "vec3 d = a - b; float d2 = dot(d, d); return (d / sqrt(d2)).x;",
        "vec3 d = a - b; float d2 = dot(d, d); return (d / sqrt(max(d2, 1.0e-30))).x;",
    ],
    [
        "return normalize(a + b).x;",
        "vec3 h = a + b; return dot(h, h) > 1.0e-30 ? normalize(h).x : 0.0;",
    ],
    ["return normalize(a - b).x;", "if (a == b) { return 0.0; } return normalize(a - b).x;"],
    [
        "float c = dot(a, b); return sqrt(1.0 - c * c);",
        "float c = dot(a, b); return sqrt(max(1.0 - c * c, 0.0));",
    ],
    ["return smoothstep(1.0, 0.0, dot(a, b));", "return 1.0 - smoothstep(0.0, 1.0, dot(a, b));"],
    ["return pow(dot(a, b), 8.0);", "return pow(max(dot(a, b), 0.0), 8.0);"],
];

/// `stress` runs the function with unit vectors, `lights` reads it: without an entry point, and
/// without a light.
#[test]
fn lights_finds_what_stress_finds_and_nothing_in_the_mended_twin() {
    let place = Place::new("lights-stress");
    let domain = r#"{"a": "unit", "b": "unit"}"#;
    for pair in FAULTS {
        for (body, code) in pair.into_iter().zip([1, 0]) {
            let function = format!("float f(vec3 a, vec3 b) {{ {body} }}\n");
            place.write("f.frag", format!("#version 330 core\n{function}"));
            let lights = place.run(&["lights", "f.frag", "--deny", "possible"]);
            assert_eq!(lights.code, code, "{body}\n{}{}", lights.out, lights.err);
            let stress = ["stress", "f.frag", "--fn", "f", "--domain", domain, "--max-step", "1"];
            let stress = place.run(&[&stress[..], &["--samples", "20000"]].concat());
            assert_eq!(stress.code, code, "{body}\n{}{}", stress.out, stress.err);
        }
    }
}
