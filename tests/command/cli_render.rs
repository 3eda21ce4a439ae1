//! `landfall render` from outside: files, reports, refusals.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn landfall(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_landfall"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("the binary was built for this test")
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("it is text")
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("render-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder for this test");
    folder
}

const SCENE: &str = "shaders/scenes/six_lights.json";
const SHADER: &str = "shaders/six_lights/phong_330.frag";

fn render(more: &[&str]) -> Output {
    let mut arguments = vec!["render", SCENE, "--shader", SHADER, "--size", "40x30"];
    arguments.extend(more);
    landfall(&arguments)
}

#[test]
fn pictures_and_their_differences_are_written_and_reported_by_the_schema() {
    let folder = folder("files");
    let out = folder.join("six.png");
    let out = out.display().to_string();
    let output = render(&["-o", &out, "--compare", "reference,gl", "--format", "json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let schema = landfall(&["schema", "render"]);
    let schema: Value = serde_json::from_slice(&schema.stdout).expect("a schema is JSON");
    let validator = jsonschema::validator_for(&schema).expect("a schema can be used");
    let report: Value = serde_json::from_slice(&output.stdout).expect("a report is JSON");
    let errors: Vec<String> = validator.iter_errors(&report).map(|e| e.to_string()).collect();
    assert!(errors.is_empty(), "{errors:#?}");
    let names: Vec<&str> =
        report["written"].as_array().expect("files").iter().filter_map(Value::as_str).collect();
    assert_eq!(names.len(), 5, "{names:?}");
    for name in names {
        let bytes = std::fs::read(name).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(bytes[..4], *b"\x89PNG", "{name}");
    }
    assert_eq!(report["lights"]["point"], 4);
    assert_eq!(report["compared"][0]["with"], "reference");
    assert_eq!(report["evaluations"], 6 * report["fragments"].as_u64().expect("a count"));
    assert!(report["operations"]["calls"].to_string().contains("CalcPointLight"));
}

#[test]
fn a_picture_of_floats_is_the_same_when_it_is_read_again() {
    let folder = folder("floats");
    for name in ["six.exr", "six.pfm"] {
        let out = folder.join(name).display().to_string();
        let first = render(&["-o", &out]);
        assert_eq!(first.status.code(), Some(0), "{}", text(&first.stderr));
        let again = render(&["--compare", &out, "--max-step", "0"]);
        assert_eq!(again.status.code(), Some(0), "{}{}", text(&again.stdout), text(&again.stderr));
        assert!(text(&again.stdout).contains("infinite"), "{}", text(&again.stdout));
    }
    // Another light is another picture.
    let out = folder.join("six.exr").display().to_string();
    let bind = r#"{"dirLight.diffuse": [0, 0, 0]}"#;
    let other = render(&["--compare", &out, "--max-step", "0", "--bind", bind]);
    assert_eq!(other.status.code(), Some(1), "{}", text(&other.stdout));
}

#[test]
fn a_printed_binding_can_be_given_back() {
    let printed = render(&["--print-bind", "--format", "json"]);
    assert_eq!(printed.status.code(), Some(0), "{}", text(&printed.stderr));
    let again = render(&["--print-bind", "--format", "json", "--bind", text(&printed.stdout)]);
    assert_eq!(text(&again.stdout), text(&printed.stdout));
    let table = render(&["--print-bind"]);
    let table = text(&table.stdout);
    assert!(table.contains("pointLights[].linear") && table.contains("point[].linear"), "{table}");
}

#[test]
fn the_reference_needs_no_shader_but_a_model() {
    let folder = folder("reference");
    let out = folder.join("truth.exr").display().to_string();
    let scene = folder.join("scene.json").display().to_string();
    std::fs::write(&scene, unnamed()).expect("it is written");
    let arguments = ["render", &scene, "--size", "40x30", "--reference", "-o", &out];
    let without = landfall(&arguments);
    assert_eq!(without.status.code(), Some(2));
    assert!(text(&without.stderr).contains("--model multi"), "{}", text(&without.stderr));
    assert!(!Path::new(&out).exists());
    let facing = r#"{"family": "multi", "specular_gate": "facing"}"#;
    let with = landfall(&[&arguments[..], &["--model", facing]].concat());
    assert_eq!(with.status.code(), Some(0), "{}", text(&with.stderr));
    let near = render(&["--compare", &out, "--max-step", "1"]);
    assert_eq!(near.status.code(), Some(0), "{}", text(&near.stdout));
}

/// The scene without the shader and the model it names.
fn unnamed() -> String {
    let text = std::fs::read_to_string(SCENE).expect("it is there");
    let lines = text.lines().filter(|line| {
        !["shader", "model"].iter().any(|key| line.starts_with(&format!("  \"{key}\"")))
    });
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn a_scene_may_name_its_shader_beside_it() {
    let folder = folder("named");
    let scene = unnamed();
    std::fs::copy(SHADER, folder.join("lit.frag")).expect("it is copied");
    let file = folder.join("scene.json").display().to_string();
    for (shader, code, said) in [
        ("\"lit.frag\"", 0, "lit.frag"),
        (r#"{"path": "lit.frag", "normals": "unit", "define": {"X": 1}}"#, 0, "lit.frag"),
        (r#"{"path": "lit.frag", "normal": "unit"}"#, 2, "the unknown key `shader.normal`"),
        (r#"{"path": "lit.frag", "normals": "bent"}"#, 2, "`transformed`, `unit`"),
        ("\"gone.frag\"", 2, "gone.frag"),
    ] {
        let with = scene.replacen('{', &format!("{{\"shader\": {shader},"), 1);
        std::fs::write(&file, with).expect("it is written");
        let output = landfall(&["render", &file, "--size", "8x8"]);
        let all = format!("{}{}", text(&output.stdout), text(&output.stderr));
        assert_eq!(output.status.code(), Some(code), "{shader}\n{all}");
        assert!(all.contains(said), "{shader}\n{all}");
    }
}

#[test]
fn what_cannot_be_rendered_is_named() {
    let folder = folder("refused");
    let scene = std::fs::read_to_string(SCENE).expect("it is there");
    let bound = folder.join("bound.json");
    let with = scene.replacen('{', "{\n  \"bind\": {\"viewPoz\": \"camera.position\"},", 1);
    std::fs::write(&bound, with).expect("it is written");
    let bound = bound.display().to_string();
    let unlit = folder.join("unlit.frag").display().to_string();
    std::fs::write(&unlit, "#version 330\nout vec4 c;\nvoid main() { c = vec4(1.0); }\n")
        .expect("it is written");
    let nobody = folder.join("nobody.json").display().to_string();
    std::fs::write(&nobody, unnamed()).expect("it is written");
    let small = ["--size", "8x8"];
    for (arguments, messages) in [
        (vec![nobody.as_str()], &["names no shader", "--shader FILE"][..]),
        (vec![SCENE, "--shader", &unlit], &["no block or uniform of", "unlit.frag", "--bind"]),
        (
            vec![&bound, "--shader", SHADER],
            &["no member, texture or input `viewPoz`", "did you mean `viewPos`?", "bound.json:2"],
        ),
        (
            vec!["shaders/scenes/lights_1024.json", "--shader", SHADER],
            &["1024 point lights", "slots for 4", "--leave-out", "lights_1024.json:22:25"],
        ),
        (vec![SCENE, "--shader", SHADER, "--model", "phong"], &["`multi`, `array`"]),
        (vec![SCENE, "--shader", SHADER, "-o", "a.bmp"], &["a.bmp", "png"]),
        (vec![SCENE, "--shader", SHADER, "--compare", "gone.png"], &["gone.png"]),
        (
            vec![SCENE, "--shader", SHADER, "--bind", r#"{"viewPos": "camera"}"#],
            &["`viewPos` is bound to `camera`, which is not a quantity of a scene"],
        ),
        (
            vec![SCENE, "--shader", "shaders/six_lights/phong.wgsl", "--backend", "gl"],
            &["OpenGL does not accept WGSL"],
        ),
    ] {
        let arguments = [&["render"][..], &arguments, &small].concat();
        let output = landfall(&arguments);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}\n{said}");
        for message in messages {
            assert!(said.contains(message), "{arguments:?}: {message}\n{said}");
        }
    }
    assert!(!Path::new("a.bmp").exists());
    let left_out = landfall(&[
        "render",
        "shaders/scenes/lights_1024.json",
        "--shader",
        SHADER,
        "--size",
        "8x8",
        "--leave-out",
    ]);
    assert_eq!(left_out.status.code(), Some(0), "{}", text(&left_out.stderr));
    assert!(text(&left_out.stdout).contains("4 point"), "{}", text(&left_out.stdout));
}

#[test]
fn a_scene_is_refused_at_the_light_that_has_no_slot() {
    let folder = folder("slots");
    let scene = folder.join("five.json").display().to_string();
    let lamps: Vec<String> =
        (0..5).map(|x| format!("{{\"position\": [{x}, 2, 0], \"color\": 1}}")).collect();
    let written = |lamps: &[String]| {
        let text = format!(
            "{{\n\"size\": [8, 8],\n\
             \"camera\": {{\"position\": [0, 6, 0], \"front\": [0, -1, 0], \"up\": [0, 0, 1], \"fov\": 90}},\n\
             \"lights\": {{\"point\": [\n{}\n]}},\n\
             \"materials\": [{{\"name\": \"grey\", \"diffuse\": 0.8}}],\n\
             \"objects\": [{{\"mesh\": \"plane\", \"scale\": 9}}]\n}}\n",
            lamps.join(",\n")
        );
        std::fs::write(&scene, text).expect("it is written");
        landfall(&["render", &scene, "--shader", SHADER])
    };
    let refused = written(&lamps);
    let said = text(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    // The fifth lamp stands in line 9.
    for part in
        ["error[too-many-lights]", "5 point lights", "slots for 4", "five.json:9:1", "--leave-out"]
    {
        assert!(said.contains(part), "{part}\n{said}");
    }
    let taken = written(&lamps[..4]);
    assert_eq!(taken.status.code(), Some(0), "{}", text(&taken.stderr));
}
