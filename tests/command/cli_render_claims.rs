//! `landfall render`: what it decides by running, what it refuses, and what it says beside the steps.

use snapbox::str;

use crate::cli_render::{SCENE, SHADER, unnamed};
use crate::support::command::{self, Place, golden};

/// A sun whose direction is negated after it was read, in files beside each other.
fn sun(folder: &Place, code: &str) -> (String, String) {
    let shader = folder.path("sun.frag");
    let text = format!(
        "#version 330 core
in vec3 FragPos; in vec3 Normal; in vec2 TexCoords; out vec4 FragColor;
uniform vec3 viewPos;
struct DirLight {{ vec3 direction; vec3 ambient; vec3 diffuse; vec3 specular; }};
uniform DirLight light;
uniform sampler2D crateDiffuse; uniform sampler2D crateSpecular; uniform float shininess;
void main() {{
    vec3 n = normalize(Normal), v = normalize(viewPos - FragPos);
    {code}
    float nl = max(dot(n, l), 0.0);
    float s = nl > 0.0 ? pow(max(dot(v, reflect(-l, n)), 0.0), shininess) : 0.0;
    FragColor = vec4(light.ambient * c + light.diffuse * nl * c + light.specular * s * g, 1.0);
}}
"
    );
    std::fs::write(&shader, text).expect("it is written");
    (shader, "shaders/scenes/caster_directional.json".to_string())
}

const TEXELS: &str = "vec3 c = texture(crateDiffuse, TexCoords).rgb;
    vec3 g = texture(crateSpecular, TexCoords).rgb;";

#[test]
fn the_sign_of_a_sun_is_decided_by_running_and_printed() {
    let folder = Place::new("render-sign");
    let later = format!("{TEXELS} vec3 d = normalize(light.direction); vec3 l = -d;");
    let (shader, scene) = sun(&folder, &later);
    let printed = command::run(&["render", &scene, "--shader", &shader, "--print-bind"]);
    printed.code(0).stdout_eq(str![[r#"
members
  viewPos          camera.position
  light.direction  directional[0].direction
  light.ambient    directional[0].ambient
  light.diffuse    directional[0].diffuse
  light.specular   directional[0].specular
  shininess        material.shininess
textures
  crateDiffuse     material.diffuse
  crateSpecular    material.specular
inputs
  FragPos          position
  Normal           normal
  TexCoords        uv
decided by running the shader
  sign  light.direction: 1 of 2 interpretations matches the reference on 24 test fragments

"#]]);
    // The same after `port`, whose code goes through variables of its own.
    let ported = folder.path("sun.wgsl");
    command::run(&["port", &shader, "--to", "wgsl", "-o", &ported]).code(0);
    for shader in [&shader, &ported] {
        let arguments = ["render", &scene, "--shader", shader, "--size", "80x60"];
        let more = ["--compare", "reference", "--max-step", "1"];
        let same = command::run(&[&arguments[..], &more].concat());
        same.code(0);
    }
}

#[test]
fn a_sign_that_running_does_not_tell_is_refused_with_what_to_write() {
    let folder = Place::new("render-sign-refused");
    let place = format!("{TEXELS} vec3 l = normalize(light.direction * 3.0 - FragPos);");
    let (shader, scene) = sun(&folder, &place);
    let arguments = ["render", &scene, "--shader", &shader, "--size", "8x8"];
    command::run(&arguments).code(2).stdout_eq("").stderr_eq(str![[r#"
error[bind]: the sign of `light.direction` cannot be inferred: of 2 interpretations, none matches the reference on 24 test fragments
 --> shaders/scenes/caster_directional.json
  |
  = help: say what they hold, with `--bind '{"light.direction": "-directional[0].direction"}'` or `--bind '{"light.direction": "directional[0].direction"}'`


"#]]);
    let bind = r#"{"light.direction": "-directional[0].direction"}"#;
    command::run(&[&arguments[..], &["--bind", bind]].concat()).code(0);
}

#[test]
fn a_texture_that_the_shader_ignores_is_named_beside_the_steps() {
    let folder = Place::new("render-ignored");
    let white = "vec3 c = vec3(0.5), g = vec3(0.5) * texture(crateSpecular, TexCoords).r;
    vec3 l = normalize(-light.direction);";
    let (shader, scene) = sun(&folder, white);
    let arguments = ["render", &scene, "--shader", &shader, "--size", "40x30"];
    let compared = command::run(&[&arguments[..], &["--compare", "reference"]].concat());
    compared.code(0);
    let out = compared.out.replace(&format!("\n{:15}", ""), " ");
    let notes: Vec<&str> = out.lines().filter(|line| line.starts_with("  note")).collect();
    golden().eq(notes.join("\n"), str!["  note         the shader ignores the diffuse texture of `crate`, which the reference applies"]);
}

#[test]
fn a_reference_alone_takes_the_model_of_the_scenes_shader() {
    let folder = Place::new("render-own-model");
    let scene = folder.path("scene.json");
    std::fs::copy(SHADER, folder.0.join("lit.frag")).expect("it is copied");
    let named = unnamed().replacen('{', "{\"shader\": \"lit.frag\",", 1);
    std::fs::write(&scene, named).expect("it is written");
    let reference = ["render", &scene, "--size", "40x30", "--reference"];
    let alone = command::run(&reference);
    let model = |text: &str| {
        let line = text.lines().find(|line| line.trim_start().starts_with("model"));
        line.unwrap_or_default().to_string()
    };
    alone.code(0);
    let compared = command::run(&["render", &scene, "--size", "40x30", "--compare", "reference"]);
    golden().eq(
        model(&alone.out),
        str!["  model       multi, specular_gate facing; the best match for the shader"],
    );
    assert_eq!(model(&alone.out), model(&compared.out));
}

#[test]
fn a_size_obeys_the_limit_of_scenes() {
    let large = command::run(&["render", SCENE, "--size", "32768x32768"]);
    large.code(2).stdout_eq("").stderr_eq(str![[r#"
error[cannot-run]: `--size` is 1073741824 pixels, but a picture has at most 16777216


"#]]);
}

#[test]
fn lights_past_the_turns_of_a_driver_are_refused_on_it() {
    let folder = Place::new("render-turns");
    let scene = folder.path("many.json");
    let text = std::fs::read_to_string("shaders/scenes/lights_1024.json").expect("it is there");
    let text = text.replace("\"count\": 1024", "\"count\": 65536");
    let shaders = std::fs::canonicalize("shaders").expect("it is there").display().to_string();
    std::fs::write(&scene, text.replace("../", &format!("{shaders}/"))).expect("it is written");
    let shader = "shaders/many_lights/plain_450.frag";
    let arguments = ["render", &scene, "--shader", shader, "--size", "2x2", "--backend", "gpu"];
    let refused = command::run(&arguments);
    refused.code(2).stdout_eq("").stderr_eq(str![[r#"
error[backend]: the shader loops over 65536 lights, but [DRIVER]
 --> shaders/many_lights/plain_450.frag


"#]]);
    // It ends the line, after the name of the driver.
    assert!(refused.err.contains("ends all loops after 65535 iterations"), "{}", refused.err);
    let cpu = command::run(&[&arguments[..6], &["--backend", "cpu"]].concat());
    cpu.code(0);
}

#[test]
fn a_shader_that_reads_lists_is_written_and_nothing_else_is_overwritten() {
    let folder = Place::new("render-emit-shader");
    let scene = "shaders/scenes/lights_1024_windowed.json";
    let out = folder.path("listed.frag");
    let render = |more: &[&str]| {
        let mut all = vec!["render", scene, "--size", "48x27"];
        all.extend(more);
        command::run(&all)
    };
    let ran = render(&["--skip", "tiles=8", "--emit-shader", &out]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let blocks = command::run(&["layout", &out, "--format", "json"]);
    assert!(blocks.out.contains("LandfallTileBlock"), "{}", blocks.out);
    // What was written already reads lists.
    let again = folder.path("again.frag");
    let refused = render(&["--shader", &out, "--skip", "tiles", "--emit-shader", &again]);
    refused.code(2);
    assert!(refused.err.contains("names of Landfall's lists already"), "{}", refused.err);
    let copy = folder.path("own.frag");
    std::fs::copy("shaders/many_lights/windowed_330.frag", &copy).expect("it is there");
    let before = folder.read("own.frag");
    let png = folder.path("a.png");
    for (more, why) in [
        (vec!["--shader", &copy, "--skip", "tiles", "--emit-shader", &copy], "input"),
        (vec!["--skip", "tiles", "--emit-shader", &png, "--out", &png], "picture too"),
        (vec!["--skip", "tiles", "--emit-shader", "a.wgsl"], "another language"),
    ] {
        let ran = render(&more);
        ran.code(2);
        assert!(ran.err.contains(why), "{more:?}: {}", ran.err);
    }
    assert_eq!(folder.read("own.frag"), before);
    assert!(!folder.has("again.frag") && !folder.has("a.png"));
}
