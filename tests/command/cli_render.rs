//! `landfall render` from outside: files, reports, refusals.

use std::path::Path;

use landfall_layout::format::phrases;
use serde_json::Value;
use snapbox::str;

use crate::schema::{holds, validator};
use crate::support::command::{self, Place, Ran, golden};

pub const SCENE: &str = "shaders/scenes/six_lights.json";
pub const SHADER: &str = "shaders/six_lights/phong_330.frag";

fn render(more: &[&str]) -> Ran {
    let mut arguments = vec!["render", SCENE, "--shader", SHADER, "--size", "40x30"];
    arguments.extend(more);
    command::run(&arguments)
}

#[test]
fn pictures_and_their_differences_are_written_and_reported_by_the_schema() {
    let folder = Place::new("render-files");
    let out = folder.0.join("six.png");
    let out = out.display().to_string();
    let output = render(&["-o", &out, "--compare", "reference,gl", "--format", "json"]);
    assert_eq!(output.code, 0, "{}", output.err);
    let report = holds(&validator("render"), &output.out, "render");
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
    let folder = Place::new("render-floats");
    for name in ["six.exr", "six.pfm"] {
        let out = folder.0.join(name).display().to_string();
        let first = render(&["-o", &out]);
        assert_eq!(first.code, 0, "{}", first.err);
        let again = render(&["--compare", &out, "--max-step", "0"]);
        assert_eq!(again.code, 0, "{}{}", again.out, again.err);
        let psnr = again.out.lines().find(|line| line.trim_start().starts_with("psnr"));
        let same = str!["  psnr         infinite: all 8-bit values are equal"];
        golden().eq(psnr.unwrap_or(&again.out), same);
    }
    // Another light is another picture.
    let out = folder.path("six.exr");
    let bind = r#"{"dirLight.diffuse": [0, 0, 0]}"#;
    let other = render(&["--compare", &out, "--max-step", "0", "--bind", bind]);
    assert_eq!(other.code, 1, "{}", other.out);
}

#[test]
fn a_printed_binding_can_be_given_back() {
    let printed = render(&["--print-bind", "--format", "json"]);
    assert_eq!(printed.code, 0, "{}", printed.err);
    let again = render(&["--print-bind", "--format", "json", "--bind", &printed.out]);
    assert_eq!(again.out, printed.out);
    let table = render(&["--print-bind"]);
    let table = &table.out;
    golden().eq(
        table,
        str![[r#"
members
  viewPos                  camera.position
  material.shininess       material.shininess
  dirLight.direction       directional[0].direction
  dirLight.ambient         directional[0].ambient
  dirLight.diffuse         directional[0].diffuse
  dirLight.specular        directional[0].specular
  pointLights[].position   point[].position
  pointLights[].ambient    point[].ambient
  pointLights[].diffuse    point[].diffuse
  pointLights[].specular   point[].specular
  pointLights[].constant   point[].constant
  pointLights[].linear     point[].linear
  pointLights[].quadratic  point[].quadratic
  spotLight.position       spot[0].position
  spotLight.direction      spot[0].direction
  spotLight.ambient        spot[0].ambient
  spotLight.diffuse        spot[0].diffuse
  spotLight.specular       spot[0].specular
  spotLight.cutOff         spot[0].inner_cos
  spotLight.outerCutOff    spot[0].outer_cos
  spotLight.constant       spot[0].constant
  spotLight.linear         spot[0].linear
  spotLight.quadratic      spot[0].quadratic
textures
  material.diffuse         material.diffuse
  material.specular        material.specular
  material.flashlight      material.specular
inputs
  FragPos                  position
  Normal                   normal
  TexCoords                uv
decided by running the shader
  sign                       dirLight.direction: 1 of 2 interpretations matches the reference on 24 test fragments
  sign and unit              spotLight.direction, spotLight.cutOff, spotLight.outerCutOff: 1 of 12 interpretations matches the reference on 21 test fragments
  order of the coefficients  pointLights[].constant, pointLights[].linear, pointLights[].quadratic: 1 of 6 interpretations matches the reference on 8 test fragments
  order of the coefficients  spotLight.constant, spotLight.linear, spotLight.quadratic: 1 of 6 interpretations matches the reference on 8 test fragments

"#]],
    );
}

#[test]
fn the_reference_needs_no_shader_but_a_model() {
    let folder = Place::new("render-reference");
    let out = folder.path("truth.exr");
    let scene = folder.path("scene.json");
    std::fs::write(&scene, unnamed()).expect("it is written");
    let arguments = ["render", &scene, "--size", "40x30", "--reference", "-o", &out];
    let without = command::run(&arguments);
    without.code(2).stdout_eq("").stderr_eq(str![[r#"
error[cannot-run]: `--reference` needs a lighting model, but neither the scene nor the shader gives one
  |
  = help: add `--model multi`, `array`, `view_space` or `casters`


"#]]);
    assert!(!Path::new(&out).exists());
    let facing = r#"{"family": "multi", "specular_gate": "facing"}"#;
    let with = command::run(&[&arguments[..], &["--model", facing]].concat());
    assert_eq!(with.code, 0, "{}", with.err);
    let near = render(&["--compare", &out, "--max-step", "1"]);
    assert_eq!(near.code, 0, "{}", near.out);
}

/// The scene without the shader and the model it names.
pub fn unnamed() -> String {
    let text = std::fs::read_to_string(SCENE).expect("it is there");
    let lines = text.lines().filter(|line| {
        !["shader", "model"].iter().any(|key| line.starts_with(&format!("  \"{key}\"")))
    });
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn details_count_what_was_executed() {
    let brief = render(&["--backend", "cpu"]);
    let all = render(&["--backend", "cpu", "--details"]);
    assert_eq!((brief.code, all.code), (0, 0), "{}{}", brief.err, all.err);
    assert!(brief.out.lines().count() <= 10, "{}", brief.out);
    assert!(!brief.out.contains("called"), "{}", brief.out);
    let picture = brief.out.lines().find_map(|line| line.strip_prefix("  picture     40 by 30, "));
    let fragments = picture.unwrap().strip_suffix(" fragments").unwrap().replace(',', "");
    let fragments: u64 = fragments.parse().unwrap();
    // Each fragment has four point lights and a spotlight.
    for (function, lights) in [("main", 1), ("CalcPointLight", 4), ("CalcSpotLight", 1)] {
        let times = phrases::numbered(lights * fragments, "time");
        let line = format!("  called      `{function}` {times}\n");
        assert!(all.out.contains(&line), "{line}{}", all.out);
    }
}

#[test]
fn a_scene_may_name_its_shader_beside_it() {
    let folder = Place::new("render-named");
    let scene = unnamed();
    std::fs::copy(SHADER, folder.0.join("lit.frag")).expect("it is copied");
    let file = folder.path("scene.json");
    for (shader, code, said) in [
        (
            "\"lit.frag\"",
            0,
            str![[r#"
six lights  [TMP]/render-named/lit.frag
  cpu         interpreter · landfall [VERSION]
  picture     8 by 8, 42 fragments
  lights      1 directional, 4 point, 1 spot
  evaluated   252 light evaluations, 6.00 per fragment
  time        [TIME]

"#]],
        ),
        (
            r#"{"path": "lit.frag", "normals": "unit", "define": {"X": 1}}"#,
            0,
            str![[r#"
six lights  [TMP]/render-named/lit.frag
  cpu         interpreter · landfall [VERSION]
  picture     8 by 8, 42 fragments
  lights      1 directional, 4 point, 1 spot
  evaluated   252 light evaluations, 6.00 per fragment
  time        [TIME]

"#]],
        ),
        (
            r#"{"path": "lit.frag", "normal": "unit"}"#,
            2,
            str![[r#"
error[cannot-run]: `[TMP]/render-named/scene.json` has the unknown key `shader.normal`; the keys are `path`, `entry`, `define`, `normals`


"#]],
        ),
        (
            r#"{"path": "lit.frag", "normals": "bent"}"#,
            2,
            str![[r#"
error[cannot-run]: `[TMP]/render-named/scene.json` has the unknown `shader.normals` of `bent`; the values are `transformed` (of any length), `unit` (normalised) and `unit_of_four` (normalised as a `vec4`, a mistake found in published shaders)


"#]],
        ),
        (
            "\"gone.frag\"",
            2,
            str![[r#"
error[unreadable-file]: `[TMP]/render-named/gone.frag` cannot be read: no such file or directory


"#]],
        ),
    ] {
        let with = scene.replacen('{', &format!("{{\"shader\": {shader},"), 1);
        std::fs::write(&file, with).expect("it is written");
        let output = command::run(&["render", &file, "--size", "8x8"]);
        output.code(code);
        golden().eq(format!("{}{}", output.out, output.err), said);
    }
}

#[test]
fn what_cannot_be_rendered_is_named() {
    let folder = Place::new("render-refused");
    let scene = std::fs::read_to_string(SCENE).expect("it is there");
    let bound = folder.0.join("bound.json");
    let with = scene.replacen('{', "{\n  \"bind\": {\"viewPoz\": \"camera.position\"},", 1);
    std::fs::write(&bound, with).expect("it is written");
    let bound = bound.display().to_string();
    let unlit = folder.path("unlit.frag");
    std::fs::write(&unlit, "#version 330\nout vec4 c;\nvoid main() { c = vec4(1.0); }\n")
        .expect("it is written");
    let nobody = folder.path("nobody.json");
    std::fs::write(&nobody, unnamed()).expect("it is written");
    let small = ["--size", "8x8"];
    for (arguments, said) in [
        (
            vec![nobody.as_str()],
            str![[r#"
error[cannot-run]: `[TMP]/render-refused/nobody.json` names no shader
  |
  = help: add `--shader FILE`, or `--reference` to render the model alone


"#]],
        ),
        (
            vec![SCENE, "--shader", &unlit],
            str![[r#"
error[no-lights]: no block or uniform of `[TMP]/render-refused/unlit.frag` holds a light
 --> shaders/scenes/six_lights.json
  |
  = help: bind the members with `--bind`: {"Block.place": "point[0].position"}


"#]],
        ),
        (
            vec![&bound, "--shader", SHADER],
            str![[r#"
error[unknown-member]: the shader has no member, texture or input `viewPoz`
 --> [TMP]/render-refused/bound.json:2:23
  |
2 |   "bind": {"viewPoz": "camera.position"},
  |                       ^^^^^^^^^^^^^^^^^
  |
  = help: did you mean `viewPos`?


"#]],
        ),
        (
            vec!["shaders/scenes/lights_1024.json", "--shader", SHADER],
            str![[r#"
error[too-many-lights]: the scene has 1024 point lights, but `pointLights[].position` has slots for 4
  --> shaders/scenes/lights_1024.json:22:25
   |
22 |     "lights": {"count": 1024, "height": [0.5, 4], "distances": [7, 13, 20, 32], "gain": 0.6},
   |                         ^^^^
   |
   = help: leave out the lights without a slot with `--leave-out`


"#]],
        ),
        (
            vec![SCENE, "--shader", SHADER, "--model", "phong"],
            str![[r#"
error[cannot-run]: `--model` names an unknown lighting model: unknown variant `phong`, expected one of `multi`, `array`, `view_space`, `casters`
  |
  = help: the models are `multi`, `array`, `view_space` and `casters`


"#]],
        ),
        (
            vec![SCENE, "--shader", SHADER, "-o", "a.bmp"],
            str![[r#"
error[cannot-run]: `a.bmp` has no known extension; use `.png`, `.exr` or `.pfm`


"#]],
        ),
        (
            vec![SCENE, "--shader", SHADER, "--compare", "gone.png"],
            str![[r#"
error[unreadable-file]: `gone.png` cannot be read: no such file or directory


"#]],
        ),
        (
            vec![SCENE, "--shader", SHADER, "--bind", r#"{"viewPos": "camera"}"#],
            str![[r#"
error[unknown-quantity]: `viewPos` is bound to `camera`, which is not a property of a scene
 --> shaders/scenes/six_lights.json
  |
  = help: write the name of a property, such as `camera.position`, `ambient.color`, `point.count`, `point[].color`, `spot[0].outer_cos` or `material.shininess`; of a fragment `position`, `normal`, `uv` or `pixel`


"#]],
        ),
        (
            vec![SCENE, "--shader", "shaders/six_lights/phong.wgsl", "--backend", "gl"],
            str![[r#"
error[backend]: OpenGL does not accept WGSL
 --> shaders/six_lights/phong.wgsl


"#]],
        ),
    ] {
        let arguments = [&["render"][..], &arguments, &small].concat();
        let output = command::run(&arguments);
        output.code(2).stdout_eq("").stderr_eq(said);
    }
    assert!(!Path::new("a.bmp").exists());
    let left_out = command::run(&[
        "render",
        "shaders/scenes/lights_1024.json",
        "--shader",
        SHADER,
        "--size",
        "8x8",
        "--leave-out",
    ]);
    left_out.code(0).stdout_eq(str![[r#"
1,024 lights  shaders/six_lights/phong_330.frag
  cpu         interpreter · landfall [VERSION]
  picture     8 by 8, 40 fragments
  lights      0 directional, 4 point, 0 spot
  evaluated   240 light evaluations, 6.00 per fragment
  idle        2 slots without a light are evaluated as zeros
  time        [TIME]

"#]]);
}

#[test]
fn a_scene_is_refused_at_the_light_that_has_no_slot() {
    let folder = Place::new("render-slots");
    let scene = folder.path("five.json");
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
        command::run(&["render", &scene, "--shader", SHADER])
    };
    let refused = written(&lamps);
    // The fifth lamp stands in line 9.
    refused.code(2).stdout_eq("").stderr_eq(str![[r#"
error[too-many-lights]: the scene has 5 point lights, but `pointLights[].position` has slots for 4
 --> [TMP]/render-slots/five.json:9:1
  |
9 | {"position": [4, 2, 0], "color": 1}
  | ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
  |
  = help: leave out the lights without a slot with `--leave-out`


"#]]);
    let taken = written(&lamps[..4]);
    assert_eq!(taken.code, 0, "{}", taken.err);
}
