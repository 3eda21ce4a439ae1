//! What `landfall lights` says: bytes by hand from std140, the loop's bound, the smaller order.

use std::process::Command;

use serde_json::Value;

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

struct Ran {
    code: Option<i32>,
    out: String,
    err: String,
}

fn lights(name: &str, text: &str, more: &[&str]) -> Ran {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("lights");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(name), text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_landfall"));
    command.current_dir(&folder).arg("lights").arg(name).args(more);
    let output = command.output().expect("the binary was built for this test");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
    Ran { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
}

#[test]
fn a_light_of_four_members_takes_48_bytes_and_32_in_another_order() {
    let ran = lights("a.frag", TEXT, &[]);
    assert_eq!((ran.code, ran.err.as_str()), (Some(0), ""));
    // std140: intensity 0, pos 16..28, radius 28..32, color 32..44, rounded up to 48:
    // 32 bytes of scalars, 16 of padding. As vec3, float, vec3, float: 32.
    let expected = "\
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
  reordered as ";
    assert!(ran.out.starts_with(expected), "{}", ran.out);
    assert!(
        ran.out.contains(": 32 bytes instead of 48, 128 bytes saved in total\n"),
        "{}",
        ran.out
    );
    for part in [
        "warning[unclamped-count]: `count` is not clamped to the 8 slots of `data[]`",
        "--> a.frag:17:16",
        "= note: count-past-array, possible",
        "= note: light-at-fragment, possible",
        "= help: loop to `min(count, 8)`",
    ] {
        assert!(ran.out.contains(part), "{part}\n{}", ran.out);
    }
}

#[test]
fn json_keeps_to_its_schema_and_says_the_same() {
    let schema = Command::new(env!("CARGO_BIN_EXE_landfall")).args(["schema", "lights"]).output();
    let schema: Value = serde_json::from_slice(&schema.unwrap().stdout).expect("a schema is JSON");
    jsonschema::meta::validate(&schema).expect("a schema is a schema");
    let validator = jsonschema::validator_for(&schema).expect("a schema can be used");
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
        assert_eq!((ran.code, ran.err.as_str()), (Some(0), ""), "{name}");
        let value: Value =
            serde_json::from_str(&ran.out).unwrap_or_else(|e| panic!("{e}: {}", ran.out));
        let errors: Vec<String> =
            validator.iter_errors(&value).map(|e| format!("{}: {e}", e.instance_path())).collect();
        assert!(errors.is_empty(), "{name}: {errors:#?}\n{}", ran.out);
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
    assert_eq!(lights("f.frag", TEXT, &["--deny", "possible"]).code, Some(1));
    assert_eq!(lights("g.frag", TEXT, &["--deny", "certain"]).code, Some(0));
    let least = lights("h.frag", TEXT, &["--least", "certain"]);
    assert!(!least.out.contains("warning["), "{}", least.out);
    let broken = lights("i.frag", "uniform Lights {", &[]);
    assert_eq!(broken.code, Some(2));
    assert!(broken.err.contains("error["), "{}", broken.err);
    let dark = lights("j.frag", "#version 330\nvoid main() {}\n", &[]);
    assert_eq!(
        (dark.code, dark.out.as_str()),
        (Some(0), "j.frag\nno lights found in structures, blocks or members\n")
    );
}

#[test]
fn functions_that_cannot_be_followed_are_told_and_the_cost_all_the_same() {
    let text = TEXT.replace("void main() {", "void main() { gl_Nothing();");
    let ran = lights("k.frag", &text, &[]);
    assert_eq!(ran.code, Some(0));
    assert!(ran.out.contains("PointLight data[]"), "{}", ran.out);
    assert!(ran.out.contains("its functions could not be analysed"), "{}", ran.out);
    assert!(ran.out.contains("there is no function `gl_Nothing`"), "{}", ran.out);
}
