//! Every JSON output keeps to its published schema.

use std::path::Path;

use landfall::report;
use landfall_layout::format;
use serde_json::Value;
use snapbox::Data;

use crate::support::command::{self, Place, Ran};
use crate::support::schema;
pub use crate::support::schema::holds;

pub fn validator(of: &str) -> jsonschema::Validator {
    let schema = command::run(&["schema", of]);
    assert!(schema.code == 0);
    schema::validator(&schema.out)
}

/// The files are written again by `SNAPSHOTS=overwrite`.
#[test]
fn the_files_are_what_the_types_give() {
    let files = snapbox::Assert::new().action_env("SNAPSHOTS");
    for (file, schema) in [
        ("crates/landfall-layout/schema/diagnostic.json", format::diagnostics::schema()),
        ("crates/landfall-layout/schema/diff.json", format::diff::schema()),
        ("crates/landfall-layout/schema/explain.json", format::explain::schema()),
        ("crates/landfall-layout/schema/layout.json", format::json::schema()),
        ("crates/landfall-layout/schema/lock.json", landfall_layout::lock::schema()),
        ("crates/landfall-lint/schema/check.json", landfall_lint::render::schema()),
        ("src/report/schema/baseline.json", landfall_check::baseline::schema()),
        ("src/report/schema/bench.json", report::bench::schema()),
        ("src/report/schema/config.json", landfall_check::config::schema()),
        ("src/report/schema/devices.json", report::devices::schema()),
        ("src/report/schema/lights.json", report::lights::schema()),
        ("src/report/schema/plan.json", report::plan::schema()),
        ("src/report/schema/prove.json", report::prove::schema()),
        ("src/report/schema/render.json", report::render::schema()),
        ("src/report/schema/run.json", landfall_exec::report::run::schema()),
        ("src/report/schema/scene.json", landfall_light::scene::schema()),
        ("src/report/schema/stress.json", report::stress::schema()),
        ("src/report/schema/verify.json", report::verify::schema()),
    ] {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
        files.eq(Data::text(schema).raw(), Data::read_from(&file, None).raw());
    }
}

/// Shaders written for these tests: one text with everything a schema has a word for.
const EVERYTHING: &str = "#version 460
#extension GL_EXT_scalar_block_layout : require
layout(constant_id = 7) const int COUNT = 4;
struct Light { vec3 pos; float radius; mat3 turn; };
layout(std140, set = 1, binding = 2) uniform Lights { Light lights[2][3]; layout(row_major) mat4x2 m; } u;
layout(std430, binding = 0) buffer Particles { uint n; Light all[]; };
layout(scalar, binding = 4) buffer Tight { vec3 a[COUNT]; double d; };
layout(push_constant) uniform Push { vec4 colour; } push;
uniform Undeclared { float x; } arrays[4];
uniform sampler2D picture;
void main() {}
";

const EVERYTHING_IN_WGSL: &str = "override count: u32 = 3;
struct Inner { @align(16) a: u32 }
struct Light { pos: vec3<f32>, @size(32) tint: vec3<f32>, turn: mat3x3<f32>, in: Inner }
struct Lights { n: atomic<u32>, all: array<Light> }
@group(0) @binding(1) var<storage, read_write> lights: Lights;
@group(0) @binding(2) var<storage> raw: array<vec3<f32>>;
struct View { view: mat4x4<f32>, eye: vec3<f32> }
@group(0) @binding(0) var<uniform> view: View;
";

#[test]
fn layouts_keep_to_their_schema() {
    let folder = Place::new("schema-layout");
    let file = folder.0.join("everything.frag");
    std::fs::write(&file, EVERYTHING).unwrap();
    folder.write("loose.frag", "uniform vec3 a[2]; uniform sampler2D s;");
    folder.write("nothing.vert", "#version 330\nvoid main() {}\n");
    folder.write("everything.wgsl", EVERYTHING_IN_WGSL);
    let validator = validator("layout");
    let folder = folder.0.display().to_string();
    for more in
        [&[][..], &["--expand"], &["--gather"], &["--rules", "scalar"], &["--block", "Lights"]]
    {
        let mut arguments = vec!["layout", &folder, "--format", "json"];
        arguments.extend(more);
        let output = command::run(&arguments);
        let text = &output.out;
        let value = holds(&validator, text, &arguments.join(" "));
        assert!(output.code == 0, "{}", output.err);
        assert!(!value["shaders"].as_array().unwrap().is_empty());
        assert!(text.ends_with('\n'));
    }
}

#[test]
fn the_shaders_of_the_repository_keep_to_it_too() {
    let shaders = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders").display().to_string();
    let output = command::run(&["layout", &shaders, "--format", "json", "--expand"]);
    assert!(output.code == 0, "{}", output.err);
    let text = &output.out;
    holds(&validator("layout"), text, "shaders");
}

#[test]
fn explanations_keep_to_their_schema() {
    let folder = Place::new("schema-explain");
    let file = folder.0.join("everything.frag");
    std::fs::write(&file, EVERYTHING).unwrap();
    let validator = validator("explain");
    for place in ["lights[1][2].turn[1].y", "m[3]", "all", "all[].pos", "@0", "@12", "@60", "@76"] {
        let arguments = ["explain", &file.display().to_string(), place, "--format", "json"];
        let output = command::run(&arguments);
        assert!(output.code == 0, "{}", output.err);
        let value = holds(&validator, &output.out, place);
        assert!(!value["answers"].as_array().unwrap().is_empty(), "{place}");
    }
}

#[test]
fn devices_keep_to_their_schema_whether_they_are_there_or_not() {
    let validator = validator("devices");
    for drivers in [None, Some("/nonexistent")] {
        let mut command = command::landfall(&["devices", "--format", "json"]);
        if let Some(drivers) = drivers {
            command.env("VK_DRIVER_FILES", drivers).env("__EGL_VENDOR_LIBRARY_FILENAMES", drivers);
        }
        let output = Ran::of(command.output().expect("the command of this package"));
        assert!(output.code == 0 && output.err.is_empty());
        let text = &output.out;
        let value = holds(&validator, text, "devices");
        let backends: Vec<&str> = value["devices"]
            .as_array()
            .unwrap()
            .iter()
            .filter_map(|d| d["backend"].as_str())
            .collect();
        assert!(backends.contains(&"cpu") && backends.contains(&"gl") && backends.contains(&"gpu"));
        let vulkan = value["devices"].as_array().unwrap().iter().find(|d| d["kind"] == "vulkan");
        if cfg!(feature = "gpu") {
            assert_eq!(vulkan.unwrap()["available"], drivers.is_none());
        }
    }
}

#[test]
fn findings_keep_to_their_schema() {
    let folder = Place::new("schema-diagnostic");
    let file = folder.0.join("bad.frag");
    std::fs::write(&file, "#include \"gone.glsl\"\nuniform B { vec33 x; float y[0]; };\n").unwrap();
    let validator = validator("diagnostic");
    let file = file.display().to_string();
    for arguments in [
        &["layout", &file, "--format", "json"][..],
        &["layout", "no/such/file.frag", "--format", "json"],
        &["layout", &file, "--format", "json", "--block", "Gone"],
        &["explain", &file, "x", "--format", "json"],
    ] {
        let output = command::run(arguments);
        assert_eq!(output.code, 2, "{arguments:?}");
        let text = &output.err;
        assert!(!text.is_empty(), "{arguments:?}");
        text.lines().for_each(|line| drop(holds(&validator, line, "a finding")));
    }
}

#[test]
fn the_schema_of_reports_takes_an_empty_one_and_no_other_version() {
    let validator = validator("check");
    let report = "{\"schema_version\":1,\"tool\":{\"name\":\"landfall\",\"version\":\"0.1.0\"},\
                  \"shaders\":0,\"findings\":[],\"blocks\":[]}";
    let mut value = holds(&validator, report, "a report");
    value["schema_version"] = 2.into();
    assert!(!validator.is_valid(&value));
}

#[test]
fn locks_keep_to_their_schema() {
    let folder = Place::new("schema-lock");
    let shaders = folder.0.join("shaders");
    std::fs::create_dir_all(&shaders).unwrap();
    std::fs::write(shaders.join("everything.frag"), EVERYTHING).unwrap();
    std::fs::write(shaders.join("loose.frag"), "uniform vec3 a[2]; uniform sampler2D s;").unwrap();
    std::fs::write(shaders.join("nothing.vert"), "#version 330\nvoid main() {}\n").unwrap();
    std::fs::write(shaders.join("everything.wgsl"), EVERYTHING_IN_WGSL).unwrap();
    let locks = folder.0.join("layouts");
    let config = folder.0.join("landfall.toml");
    std::fs::write(&config, "").unwrap();
    let output = command::run(&[
        "lock",
        "--config",
        &config.display().to_string(),
        &shaders.display().to_string(),
        "--locks",
        &locks.display().to_string(),
    ]);
    assert!(output.code == 0, "{}", output.err);
    let validator = validator("lock");
    let mut seen = 0;
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("layouts");
    let mut folders = vec![locks.clone(), repository];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            holds(&validator, &text, &path.display().to_string());
            assert!(text.ends_with("\n"));
            seen += 1;
        }
    }
    assert!(seen > 60, "{seen}");
    // With what `verify --record` is to write.
    let text = std::fs::read_to_string(locks.join("shaders/nothing.vert.json")).unwrap();
    let verified = r#""blocks": [], "verified": [{"backend": "gl", "adapter": "llvmpipe",
        "driver": "Mesa 22.3.6", "version": "0.1.0"}]"#;
    holds(&validator, &text.replace("\"blocks\": []", verified), "verified");
}

#[test]
fn differences_keep_to_their_schema() {
    let folder = Place::new("schema-diff");
    let old = folder.0.join("old.frag");
    let new = folder.0.join("new.frag");
    std::fs::write(&old, EVERYTHING).unwrap();
    let changed = EVERYTHING
        .replace("float radius", "uint radius, more")
        .replace("Particles", "Dust")
        .replace("uniform Undeclared { float x; } arrays[4];", "uniform float loose;");
    std::fs::write(&new, changed).unwrap();
    let validator = validator("diff");
    let (old, new) = (old.display().to_string(), new.display().to_string());
    for sides in [[&old, &new], [&new, &old], [&old, &old]] {
        let output = command::run(&["diff", "--no-config", sides[0], sides[1], "--format", "json"]);
        let text = &output.out;
        let value = holds(&validator, text, "diff");
        assert_eq!(value["shaders"].as_array().unwrap().is_empty(), sides[0] == sides[1]);
        assert_eq!(output.code, i32::from(sides[0] != sides[1]));
    }
}

#[test]
fn scenes_keep_to_their_schema_and_wrong_ones_do_not() {
    let validator = validator("scene");
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/scenes");
    let mut seen = 0;
    for entry in std::fs::read_dir(scenes).unwrap() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        let mut value = holds(&validator, &text, &path.display().to_string());
        assert!(text.ends_with('\n'));
        // Editors find the schema by it.
        assert_eq!(value["$schema"], "../../src/report/schema/scene.json");
        value["camera"]["fow"] = 45.into();
        assert!(!validator.is_valid(&value));
        seen += 1;
    }
    assert!(seen >= 9, "{seen}");
}

#[test]
fn benches_keep_to_their_schema() {
    let scene = "shaders/scenes/six_lights.json";
    let arguments = [
        "bench",
        scene,
        "--size",
        "40x30",
        "--rounds",
        "3",
        "--backend",
        "cpu",
        "--format",
        "json",
    ];
    let output = command::run(&arguments);
    let text = &output.out;
    let value = holds(&validator("bench"), text, "bench");
    // What is compiled in, and the scene's own shader.
    let rows = value["rows"].as_array().unwrap();
    assert!(rows.iter().any(|row| row["runner"]["backend"] == "rust"), "{text}");
    assert!(rows.iter().any(|row| row["runner"]["backend"] == "cpu"), "{text}");
}

#[test]
fn stressed_functions_keep_to_their_schema() {
    let validator = validator("stress");
    let shaders = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/seed");
    let lights = shaders.join("six_lights_330.frag").display().to_string();
    let robust = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("shaders/six_lights/phong_330.frag#attenuation")
        .display()
        .to_string();
    let domain = r#"{"d": [0, 10], "constant": [1, 2]}"#;
    for more in [
        &["--against", robust.as_str()][..],
        &["--half"],
        &["--domain", domain, "--backend", "cpu"],
        &["--max-ulp", "1", "--seed", "7"],
    ] {
        let mut arguments = vec!["stress", &lights, "--fn", "attenuation", "--format", "json"];
        arguments.extend(["--samples", "3000", "--time", "3"]);
        arguments.extend(more);
        let output = command::run(&arguments);
        assert!(matches!(output.code, 0 | 1), "{more:?}: {}", output.err);
        let value = holds(&validator, &output.out, "stress");
        assert!(value["total"]["samples"].as_u64().unwrap() >= 3000, "{more:?}");
    }
}

#[test]
fn proofs_keep_to_their_schema() {
    let validator = validator("prove");
    let shaders = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/seed");
    let lights = shaders.join("six_lights_330.frag").display().to_string();
    let domain = r#"{"d": [0, 10], "constant": [0, 2]}"#;
    for more in [
        &["--no-nan", "--no-inf"][..],
        &["--domain", domain],
        &["--domain", domain, "--max-ulp", "1000", "--f64"],
    ] {
        let mut arguments = vec!["prove", &lights, "--fn", "attenuation", "--format", "json"];
        arguments.extend(["--time", "1"]);
        arguments.extend(more);
        let output = command::run(&arguments);
        assert!(matches!(output.code, 0 | 1), "{more:?}: {}", output.err);
        let value = holds(&validator, &output.out, "prove");
        assert!(!value["operations"].as_array().unwrap().is_empty(), "{more:?}");
    }
}

/// The same block in both languages, whose types have other names.
#[test]
fn leaves_are_described_in_the_same_words_in_both_languages() {
    let place = Place::new("schema-leaves");
    place.write(
        "a.comp",
        "#version 450\nlayout(local_size_x = 1) in;\nlayout(std430, binding = 0) buffer B {\n\
         mat4x3 m; vec3 v; ivec2 i; uint u; float f[2];\n};\nvoid main() {}\n",
    );
    place.write(
        "a.wgsl",
        "struct B { m: mat4x3f, v: vec3<f32>, i: vec2i, u: u32, f: array<f32, 2> }\n\
         @group(0) @binding(0) var<storage> b: B;\n",
    );
    let leaves = |path: &str| {
        let ran = place.run(&["layout", path, "--format", "json"]);
        let json: Value = serde_json::from_str(&ran.out).unwrap();
        let leaves = json["shaders"][0]["blocks"][0]["leaves"].as_array().unwrap().clone();
        let words =
            |leaf: &Value| ["kind", "width", "columns", "rows"].map(|key| leaf[key].clone());
        leaves.iter().map(words).collect::<Vec<_>>()
    };
    let expected = [
        ("float", 4, 4, 3),
        ("float", 4, 1, 3),
        ("sint", 4, 1, 2),
        ("uint", 4, 1, 1),
        ("float", 4, 1, 1),
    ];
    let expected = expected.map(|(kind, width, columns, rows)| {
        [kind.into(), width.into(), columns.into(), rows.into()] as [Value; 4]
    });
    assert_eq!(leaves("a.comp"), expected);
    assert_eq!(leaves("a.wgsl"), expected);
}
