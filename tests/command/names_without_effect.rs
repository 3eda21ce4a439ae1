//! Macros, constants, patterns and options that have no effect on anything are named; scenes of
//! which no pixel shows an object, too.

use crate::cli_check::place::CLEAN;
use crate::schema::{holds, validator};
use crate::support::command::{Place, Ran};
use snapbox::str;

const FUNCTION: &str = "#version 450
#ifndef LIGHTS
#define LIGHTS 4
#endif
layout(std140, binding = 0) uniform U { vec4 color[LIGHTS]; };
layout(location = 0) out vec4 o;
float f(float x) { return x * color[0].x; }
void main() { o = vec4(f(1.0)); }
";

/// A scene whose camera looks at the sky.
const SKY: &str = r#"{"size": [8, 8], "model": "multi", "camera": {"position": [0, 1, 0],
    "target": [0, 9, 0], "up": [1, 0, 0], "fov": 60}, "lights": {"point": [{"position": [0, 3, 3],
    "color": [9, 9, 9]}]}, "materials": [{"name": "grey", "diffuse": 0.8}],
    "objects": [{"mesh": "plane"}]}"#;

fn project(name: &str) -> Place {
    let place = Place::new(&format!("names-{name}"));
    place.write("a.frag", FUNCTION).write("b/b.frag", CLEAN).write("v.json", "{}");
    place
}

/// The warnings of a run that say that something has no effect.
fn unused(ran: &Ran) -> Vec<String> {
    assert!(ran.code < 2, "{}{}", ran.out, ran.err);
    let warnings = ran.err.lines().filter(|line| line.contains("has no effect"));
    warnings.map(|line| line.split_once(": ").expect("a code").1.to_string()).collect()
}

fn split(command: &str) -> Vec<&str> {
    command.split(' ').collect()
}

#[test]
fn a_macro_that_no_shader_contains_is_warned_of() {
    let place = project("macro");
    for (command, option) in [
        ("layout a.frag", "-D"),
        ("emit a.frag --lang c", "-D"),
        ("explain a.frag color", "-D"),
        ("encode a.frag v.json --hex", "-D"),
        ("verify a.frag --backend cpu", "-D"),
        ("lights a.frag", "-D"),
        ("run a.frag --fn f --args [1]", "-D"),
        ("lock a.frag", "-D"),
        ("check a.frag", "--define"),
        ("check . --cache-dir c", "--define"),
        // From the cache.
        ("check . --cache-dir c", "--define"),
    ] {
        let with = |text: &str| unused(&place.run(&[&*split(command), &[option, text]].concat()));
        let said = format!("`{option} LIGTHS` has no effect: no shader contains this name");
        assert_eq!(with("LIGTHS=128"), [said], "{command}");
        assert_eq!(with("LIGHTS=8"), [""; 0], "{command}");
    }
}

#[test]
fn names_of_the_configuration_that_no_shader_has_are_warned_of() {
    let place = project("configuration");
    let text = "define = [\"LIGTHS=2\", \"LIGHTS=2\"]\noverride = [\"nope=3\"]\n\
                exclude = [\"vendor\", \"b/nope*.frag\", \"kept\", \"b.frag\"]\n\
                permutations = [[\"LIGHTS=1\"], [\"FOGG\"]]\n";
    place.write("landfall.toml", text).write("kept/notes.txt", "no shader");
    let at = "of `landfall.toml` has no effect";
    let mut all = vec![
        format!("`vendor` in `exclude` {at}: no shader matches it"),
        format!("`b/nope*.frag` in `exclude` {at}: no shader matches it"),
        format!("`nope` in `override` {at}: no shader has this constant"),
        format!("`LIGTHS` in `define` {at}: no shader contains this name"),
        format!("`FOGG` in `permutations` {at}: no shader contains this name"),
    ];
    for command in ["check", "lock", "check --cache-dir c", "check --cache-dir c"] {
        assert_eq!(unused(&place.run(&split(command))), all, "{command}");
    }
    // Some of the shaders may lack what others have.
    for command in ["check a.frag", "lock a.frag"] {
        assert_eq!(unused(&place.run(&split(command))), [""; 0], "{command}");
    }
    let ran = place.run(&["check", "--exclude", "nosuch", "--exclude", "b"]);
    all.insert(2, "`--exclude nosuch` has no effect: no shader matches it".to_string());
    assert_eq!(unused(&ran), all);
    let ran = place.run(&["check", "a.frag", "--exclude", "nosuch"]);
    assert_eq!(unused(&ran), [all.swap_remove(2)]);
}

#[test]
fn rows_of_the_configuration_for_files_that_are_not_there_are_warned_of() {
    let place = project("rows");
    let row = |key: &str, file: &str, more: &str| format!("[[{key}]]\nfile = \"{file}\"\n{more}\n");
    let (levels, policy) = ("levels = { all = \"allow\" }", "policy = \"bytes\"");
    let sets = "sets = [[\"LIGHTS=1\"], [\"LIGHTS=2\"]]";
    let rows = [
        row("path-levels", "old/**", levels),
        row("path-levels", "b/**", levels),
        // It has no shader, but a directory of that name is there.
        row("path-levels", "kept/**", levels),
        row("path-policy", "b/*.vert", policy),
        row("path-policy", "b/*", policy),
        row("variants", "renamed.frag", sets),
        row("variants", "a.frag", sets),
    ];
    place.write("landfall.toml", rows.concat()).write("kept/notes.txt", "no shader");
    let at = "of `landfall.toml` has no effect: no file that was read matches it";
    let said = [
        format!("`old/**` in `[[path-levels]]` {at}"),
        format!("`b/*.vert` in `[[path-policy]]` {at}"),
        format!("`renamed.frag` in `[[variants]]` {at}"),
    ];
    assert_eq!(unused(&place.run(&["check"])), said);
    // Other files may be those of the rows.
    for command in ["check a.frag", "check --exclude b"] {
        assert_eq!(unused(&place.run(&split(command))), [""; 0], "{command}");
    }
}

#[test]
fn the_summary_of_a_check_is_its_last_line() {
    let place = project("summary");
    let ran = place.run(&["check", "--define", "LIGTHS"]);
    assert_eq!(unused(&ran).len(), 1, "{}", ran.err);
    assert_eq!(ran.err.lines().last(), Some("checked 2 shaders: no findings"), "{}", ran.err);
}

#[test]
fn options_that_others_leave_without_effect_are_warned_of() {
    let place = project("options");
    place.write("scene.json", SKY);
    place.write(
        "es.frag",
        "#version 300 es\nprecision mediump float;\nout vec4 o;\n\
                            float f(float x) { return x * 3.0; }\nvoid main() { o = vec4(0); }\n",
    );
    let reference = "render scene.json --reference";
    for (command, said) in [
        ("verify a.frag --backend cpu --locks x", "`--locks` has no effect without `--record`"),
        (
            "layout a.frag --stdin-filename x.frag",
            "`--stdin-filename` has no effect without the input `-`",
        ),
        (
            "run a.frag --fn f --args [1] --mediump",
            "`--mediump` has no effect: the shader is not \
          of OpenGL ES, or declares nothing `mediump` or `lowp`",
        ),
        (
            "bench a.frag --fn f --variant h=:mediump --backend cpu --rounds 3 --samples 9",
            "`--variant h=:mediump` has no effect: the shader is not of OpenGL ES, or declares \
             nothing `mediump` or `lowp`",
        ),
        (
            &format!("{reference} --watch"),
            "`--watch` has no effect on the reference, which runs no shader",
        ),
        (
            &format!("{reference} --entry main"),
            "`--entry` has no effect on the reference, which runs no shader",
        ),
    ] {
        assert_eq!(unused(&place.run(&split(command))), [said], "{command}");
    }
    for command in ["run es.frag --fn f --args [1] --mediump", reference] {
        assert_eq!(unused(&place.run(&split(command))), [""; 0], "{command}");
    }
}

#[test]
fn a_stage_of_wgsl_and_the_gathering_of_no_uniforms_are_warned_of() {
    let place = project("stage");
    let wgsl = "@group(0) @binding(0) var<uniform> u: vec4f;\n";
    let loose =
        "#version 330\nuniform vec3 tint;\nout vec4 o;\nvoid main() { o = vec4(tint, 1); }\n";
    place.write("a.wgsl", wgsl).write("loose.frag", loose).write("w.txt", wgsl);
    let stage =
        "`--stage fragment` has no effect: WGSL and SPIR-V state the stages of their functions";
    let gather = "`--gather` has no effect: no shader has a uniform outside blocks";
    let block = "`--block Mine` has no effect: no uniform is outside blocks";
    for (command, said) in [
        ("layout a.wgsl --stage fragment", Some(stage)),
        ("layout w.txt --language wgsl --stage fragment", Some(stage)),
        ("check a.wgsl --stage fragment", Some(stage)),
        ("check a.wgsl --stage fragment --cache-dir c", Some(stage)),
        ("check a.wgsl --stage fragment --cache-dir c", Some(stage)),
        ("layout a.wgsl a.frag --stage fragment", None),
        ("check a.frag --stage fragment --cache-dir c", None),
        ("check a.frag --stage fragment --cache-dir c", None),
        ("layout a.frag --gather", Some(gather)),
        ("emit a.frag --lang c --gather", Some(gather)),
        ("lock a.frag --gather", Some(gather)),
        ("check a.frag --gather --cache-dir c", Some(gather)),
        ("check a.frag --gather --cache-dir c", Some(gather)),
        ("verify a.frag --backend cpu --gather", Some(gather)),
        ("layout a.frag loose.frag --gather", None),
        ("check loose.frag --gather --cache-dir c", None),
        ("check loose.frag --gather --cache-dir c", None),
        ("port a.frag --block Mine", Some(block)),
        ("port loose.frag --block Mine", None),
    ] {
        let said: Vec<&str> = said.into_iter().collect();
        assert_eq!(unused(&place.run(&split(command))), said, "{command}");
    }
}

/// Nothing is silent where an API was assumed: not where values are printed, nor where code runs.
#[test]
fn the_assumed_target_is_said_where_code_is_executed() {
    let place = Place::new("names-target");
    let text = "#version 330\n#ifdef VULKAN\n\
                layout(set = 0, binding = 0, std140) uniform U { vec4 a; } u;\n#else\n\
                layout(std140) uniform U { float scale; vec4 a; } u;\n#endif\nout vec4 o;\n\
                float f(float x) { return x * u.a.x; }\nvoid main() { o = u.a; }\n";
    place.write("b.frag", text);
    let said = "read for OpenGL: the shader tests `VULKAN` and is valid for both APIs";
    place.write("old.frag", text.replace("scale;", "scale, bias;"));
    place.write("lit.frag", LIT).write("scene.json", SCENE);
    let note = "read for OpenGL, as the shader names no API; its blocks differ for Vulkan";
    let key = "\"assumed_target\":\"opengl\"";
    let bench = "bench b.frag --fn f --samples 50 --rounds 3 --backend cpu";
    let stress = "stress b.frag --fn f --samples 50 --time 1";
    for (command, human, others) in [
        ("run b.frag --fn f --args [1]", note, &[("json", key)][..]),
        ("prove b.frag --fn f", note, &[("json", key)]),
        (stress, note, &[("json", key)]),
        (bench, note, &[("json", key), ("csv", ",opengl")]),
        ("bench scene.json --rounds 3 --variant v=lit.frag --backend cpu", note, &[("json", key)]),
        ("bench scene.json --rounds 3 --backend cpu", note, &[("json", key)]),
        ("render scene.json", note, &[("json", key)]),
        ("diff old.frag b.frag", note, &[("json", key), ("md", note)]),
        ("explain b.frag a", "", &[("json", key)]),
        ("port b.frag --no-compiler", "", &[]),
    ] {
        for (format, expected) in [("", human)].iter().chain(others) {
            let form = if format.is_empty() { String::new() } else { format!(" -f {format}") };
            let ran = place.run(&split(&format!("{command}{form}")));
            assert!(ran.code < 2 && ran.err.contains(said), "{command}{form}: {}", ran.err);
            // Tables are wrapped.
            let out = ran.out.replace('\n', " ");
            assert!(out.contains(expected), "{command}{form}: {out}");
            if *format == "json" {
                let of = command.split(' ').next().expect("a command");
                holds(&validator(of), &ran.out, of);
            }
            let ran = place.run(&split(&format!("{command}{form} --target opengl")));
            assert!(!ran.err.contains(said), "{command}{form}: {}", ran.err);
            assert!(expected.is_empty() || !ran.out.contains(expected), "{command}{form}");
        }
    }
}

#[test]
fn standard_input_with_the_name_of_another_language_is_refused() {
    let place = project("stdin");
    let command = ["layout", "-", "--stdin-filename", "a.hlsl"];
    let ran = place.run_with_stdin(&command, CLEAN);
    assert_eq!(ran.code, 2);
    ran.stderr_eq(str![[r#"
error[unreadable-file]: `a.hlsl` is HLSL by its extension, which landfall does not read
  |
  = help: landfall reads GLSL and WGSL; if it is GLSL, pass `--language glsl`


"#]]);
    let command = [&command[..], &["--language", "glsl"]].concat();
    assert_eq!(place.run_with_stdin(&command, CLEAN).code, 0);
}

#[test]
fn a_scene_without_an_object_in_sight_is_not_measured() {
    let place = project("sky");
    place.write("scene.json", SKY);
    let ran = place.run(&["bench", "scene.json", "--rounds", "3", "--backend", "cpu"]);
    assert_eq!((ran.code, &*ran.out), (2, ""));
    ran.stderr_eq(str![[r#"
error[bad-request]: `scene.json` shows no object in any pixel: there is nothing to measure
  |
  = help: turn its camera, or enlarge it with `--size`


"#]]);
    let ran = place.run(&["render", "scene.json", "--reference"]);
    ran.code(0)
        .stdout_eq(str![[r#"
scene  the reference
  picture     8 by 8, 0 fragments
  lights      0 directional, 1 point, 0 spot
  time        [TIME]
  model       multi

"#]])
        .stderr_eq(str![[r#"
warning[bind]: no pixel shows an object: the picture is the background


"#]]);
}

/// A shader of one light, whose block depends on the API.
const LIT: &str = "#version 330
#ifdef VULKAN
layout(set = 0, binding = 0, std140) uniform L { vec4 light_color; vec3 light_position; } l;
#else
layout(std140) uniform L { float scale; vec4 light_color; vec3 light_position; } l;
#endif
in vec3 v_normal;
in vec3 v_position;
out vec4 o;
void main() {
    vec3 to = normalize(l.light_position - v_position);
    o = l.light_color * max(dot(normalize(v_normal), to), 0.0);
}
";

/// A scene for it.
const SCENE: &str = r#"{
  "size": [8, 8], "shader": "lit.frag",
  "camera": {"position": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 60},
  "lights": {"point": [{"position": [0, 3, 3], "color": [9, 9, 9]}]},
  "materials": [{"name": "grey", "diffuse": 0.8, "specular": 0.5, "shininess": 32}],
  "objects": [{"mesh": "sphere"}]
}"#;

/// 10-bit `lowp` is not modelled, which a user learns wherever floats are rounded.
#[test]
fn what_mediump_rounds_is_said_wherever_it_rounds() {
    let place = Place::new("names-rounded");
    let text = "#version 300 es\nprecision mediump float;\nout vec4 o;\n\
                lowp float f(lowp float x) { return x * 0.333; }\nvoid main() { o = vec4(f(1.0)); }\n";
    place.write("es.frag", text);
    let lit = LIT.replace("#version 330", "#version 300 es\nprecision mediump float;");
    place.write("lit.frag", lit).write("scene.json", SCENE);
    for command in [
        "run es.frag --fn f --args [1] --mediump",
        "run es.frag --fn f --args [1] --mediump -f json",
        "stress es.frag --fn f --mediump --samples 50 --details",
        "stress es.frag --fn f --mediump --samples 50 -f json",
        "bench es.frag --fn f --variant h=:mediump --samples 50 --backend cpu --rounds 3 --details",
        "bench scene.json --variant h=lit.frag:mediump --backend cpu --rounds 3",
    ] {
        let ran = place.run(&split(command));
        let said = (ran.out + &ran.err).replace("\n    ", " ");
        let note = "mediump and lowp are rounded to f16; a device may round lowp more coarsely, in \
                    fixed point between -2 and 2";
        assert!(ran.code < 2 && said.contains(note), "{command}: {said}");
        let plain = command.replace(" --mediump", "").replace(":mediump", "");
        let ran = place.run(&split(&plain));
        assert!(!(ran.out + &ran.err).contains("are rounded to f16"), "{plain}");
    }
}
