//! What was asked for and did nothing is said: constants, folders, lints, shaders, configurations,
//! blocks, pictures and textures that are not there.

use std::os::unix::fs::symlink;

use snapbox::{IntoData, str};

use crate::cli_check::place::CLEAN;
use crate::support::command::{Place, Ran, golden};

const TEXTURED: &str = "#version 450
layout(constant_id = 3) const int COUNT = 4;
layout(std140, binding = 0) uniform L { vec4 color; bool on; };
layout(binding = 1) uniform sampler2D tex;
layout(location = 0) out vec4 c;
vec4 f(vec2 p) { return texture(tex, p) * color; }
void main() { c = f(vec2(0)) * float(COUNT); }
";

fn project(name: &str) -> Place {
    let place = Place::new(&format!("nothing-{name}"));
    place.write("a.frag", TEXTURED).write("b.frag", CLEAN);
    place
}

/// The diagnostics on standard error with this head, each from its line to an empty one.
#[track_caller]
fn diagnostics(ran: &Ran, head: &str) -> String {
    let mut inside = false;
    let lines = ran.err.split_inclusive('\n').filter(|line| {
        inside = line.starts_with(head) || inside && !line.trim().is_empty();
        inside
    });
    let found: String = lines.collect();
    assert!(!found.is_empty(), "no {head} in\n{}", ran.err);
    found
}

#[track_caller]
fn warns(ran: &Ran, code: &str, said: impl IntoData) {
    ran.code(0);
    golden().eq(diagnostics(ran, &format!("warning[{code}]")), said);
}

#[track_caller]
fn refuses(ran: &Ran, code: &str, said: impl IntoData) {
    ran.code(2);
    golden().eq(diagnostics(ran, &format!("error[{code}]")), said);
}

#[test]
fn a_value_for_a_constant_that_no_shader_has_is_warned_of() {
    let place = project("override");
    place.write("v.json", "{}");
    let commands: [&[&str]; 8] = [
        &["layout", "."],
        &["lock"],
        &["check"],
        &["explain", "a.frag", "color"],
        &["emit", ".", "--lang", "c"],
        &["encode", "a.frag", "v.json", "--hex"],
        &["verify", ".", "--backend", "cpu"],
        &["run", "a.frag", "--fn", "f", "--args", "[[0, 0]]"],
    ];
    for command in commands {
        let with = |value: &str| place.run(&[command, &["-O", value]].concat());
        warns(
            &with("nope=3"),
            "unknown-override",
            str![[r#"
warning[unknown-override]: `-O nope` has no effect: no shader has this constant
  |
  = help: constants are those of `layout(constant_id = N)` in GLSL and `override` in WGSL, by name or number

"#]],
        );
        warns(
            &with("33=3"),
            "unknown-override",
            str![[r#"
warning[unknown-override]: `-O 33` has no effect: no shader has this constant
  |
  = help: constants are those of `layout(constant_id = N)` in GLSL and `override` in WGSL, by name or number

"#]],
        );
        for value in ["COUNT=3", "3=3"] {
            assert!(!with(value).err.contains("unknown-override"), "{command:?} {value}");
        }
    }
    // What is remembered is as good as what is read.
    let cached = ["check", "--cache-dir", "c", "-O", "COUNT=3"];
    for _ in 0..2 {
        assert!(!place.run(&cached).err.contains("unknown-override"));
    }
    let cached = ["check", "--cache-dir", "c", "-O", "nope=3"];
    for _ in 0..2 {
        warns(
            &place.run(&cached),
            "unknown-override",
            str![[r#"
warning[unknown-override]: `-O nope` has no effect: no shader has this constant
  |
  = help: constants are those of `layout(constant_id = N)` in GLSL and `override` in WGSL, by name or number

"#]],
        );
    }
}

#[test]
fn a_folder_of_includes_that_is_none_is_warned_of() {
    let place = project("include");
    for command in ["layout", "check", "lock", "verify"] {
        let backend = if command == "verify" { &["--backend", "cpu"][..] } else { &[] };
        let with = |folder: &str| place.run(&[&[command, "-I", folder], backend].concat());
        warns(
            &with("nodir"),
            "no-include-dir",
            str![[r#"
warning[no-include-dir]: `nodir` does not exist; no include is searched there
  |
  = help: `-I DIR` names a directory

"#]],
        );
        warns(
            &with("a.frag"),
            "no-include-dir",
            str![[r#"
warning[no-include-dir]: `a.frag` is not a directory; no include is searched there
  |
  = help: `-I DIR` names a directory

"#]],
        );
        assert!(!with(".").err.contains("no-include-dir"));
    }
}

#[test]
fn a_lint_level_is_no_macro_and_a_macro_no_lint_level() {
    let place = project("lint");
    let ran = place.run(&["check", "-D", "vec3array"]);
    refuses(
        &ran,
        "unknown-lint",
        str![[r#"
error[unknown-lint]: there is no lint `vec3array`
  |
  = note: macros are defined with `--define NAME[=TEXT]`
  = help: did you mean `vec3-array`?

"#]],
    );
    assert_eq!(ran.out, "");
    refuses(
        &place.run(&["check", "-D", "LIGHTS"]),
        "unknown-lint",
        str![[r#"
error[unknown-lint]: there is no lint `LIGHTS`
  |
  = note: macros are defined with `--define NAME[=TEXT]`
  = help: `landfall rule` lists the lints

"#]],
    );
    place.write("c.frag", format!("{CLEAN}#ifndef LIGHTS\n#error none\n#endif\n"));
    assert_eq!(place.run(&["check", "c.frag"]).code, 2);
    for define in [&["--define", "LIGHTS"][..], &["--define=LIGHTS=1"]] {
        assert_eq!(place.run(&[&["check", "c.frag"], define].concat()).code, 0, "{define:?}");
    }
    for level in [&["-D", "LIGHTS=1"][..], &["-DLIGHTS=1"], &["--deny", "LIGHTS=1"]] {
        let ran = place.run(&[&["check", "c.frag"], level].concat());
        refuses(
            &ran,
            "unknown-lint",
            str![[r#"
error[unknown-lint]: there is no lint `LIGHTS=1`
  |
  = help: define a macro with `--define LIGHTS=1`

"#]],
        );
    }
}

#[test]
fn a_run_that_leaves_every_shader_out_is_an_error() {
    let place = project("exclude");
    refuses(
        &place.run(&["check", "--exclude", "*"]),
        "no-input",
        str![[r#"
error[no-input]: all 2 shaders are excluded: nothing to do
  |
  = help: excluded by `--exclude *`

"#]],
    );
    refuses(
        &place.run(&["check", "a.frag", "--exclude", "a.*"]),
        "no-input",
        str![[r#"
error[no-input]: the only shader is excluded: nothing to do
  |
  = help: excluded by `--exclude a.*`

"#]],
    );
    place.write("landfall.toml", "exclude = [\"*.frag\"]\n");
    refuses(
        &place.run(&["check"]),
        "no-input",
        str![[r#"
error[no-input]: all 2 shaders are excluded: nothing to do
  |
  = help: excluded by `exclude` of the configuration

"#]],
    );
    refuses(
        &place.run(&["lock"]),
        "no-input",
        str![[r#"
error[no-input]: all 2 shaders are excluded: nothing to do
  |
  = help: excluded by `exclude` of the configuration

"#]],
    );
    // A hook names what changed, and that may be what the configuration leaves out.
    warns(
        &place.run(&["check", "a.frag"]),
        "no-input",
        str![[r#"
warning[no-input]: the only shader is excluded: nothing to do
  |
  = help: excluded by `exclude` of the configuration

"#]],
    );
    warns(
        &place.run(&["lock", "a.frag"]),
        "no-input",
        str![[r#"
warning[no-input]: the only shader is excluded: nothing to do
  |
  = help: excluded by `exclude` of the configuration

"#]],
    );
}

#[test]
fn a_configuration_that_cannot_be_read_is_not_the_same_as_none() {
    let place = project("config");
    let file = place.0.join("landfall.toml");
    let commands: [&[&str]; 4] = [
        &["check"],
        &["lock"],
        &["diff", "a.frag", "b.frag"],
        &["verify", ".", "--backend", "cpu"],
    ];
    std::fs::remove_file(&file).unwrap();
    symlink("nowhere.toml", &file).unwrap();
    for command in commands {
        refuses(
            &place.run(command),
            "unreadable-file",
            str![[r#"
error[unreadable-file]: `landfall.toml` is the configuration but a broken link
  |
  = help: remove it, or ignore it with `--no-config`

"#]],
        );
        let without = [command, &["--no-config"]].concat();
        assert!(place.run(&without).code < 2, "{without:?}");
    }
    std::fs::remove_file(&file).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(&file).status().unwrap().success());
    for command in commands {
        refuses(
            &place.run(command),
            "unreadable-file",
            str![[r#"
error[unreadable-file]: `landfall.toml` is the configuration but not a file
  |
  = help: remove it, or ignore it with `--no-config`

"#]],
        );
    }
}

#[test]
fn nothing_to_verify_is_no_proof() {
    let place = project("verify");
    place.write("e/empty.frag", "#version 450\nvoid main() {}\n");
    let ran = place.run(&["verify", "e", "--backend", "cpu"]);
    warns(
        &ran,
        "no-blocks",
        str![[r#"
warning[no-blocks]: no blocks to verify in 1 shader

"#]],
    );
    ran.stderr_eq(str![[r#"
warning[no-blocks]: no blocks to verify in 1 shader


"#]]);
    let ran = place.run(&["verify", "a.frag", "--backend", "cpu", "--block", "nope"]);
    refuses(
        &ran,
        "unknown-block",
        str![[r#"
error[unknown-block]: no block named `nope` in 1 shader

"#]],
    );
    let ran = place.run(&["verify", "e", "a.frag", "--backend", "cpu"]);
    ran.stderr_eq(str![[r#"
2 shaders, 1 block, 9 reads: every byte lands where the shader reads it

"#]]);
}

#[test]
fn a_plot_has_a_format_that_it_can_have() {
    let place = project("plot");
    for (file, said) in [
        (
            "p.png",
            str![[r#"
error: invalid value 'p.png' for '--plot <FILE.svg>': a plot is an .svg file

For more information, try '--help'.

"#]],
        ),
        (
            "p",
            str![[r#"
error: invalid value 'p' for '--plot <FILE.svg>': a plot is an .svg file

For more information, try '--help'.

"#]],
        ),
        (
            "p.html",
            str![[r#"
error: invalid value 'p.html' for '--plot <FILE.svg>': a plot is an .svg file

For more information, try '--help'.

"#]],
        ),
    ] {
        let ran = place.run(&["bench", "a.frag", "--fn", "f", "--plot", file]);
        ran.code(2).stdout_eq("").stderr_eq(said);
        assert!(!place.has(file));
    }
}

#[test]
fn a_colour_for_a_texture_that_is_not_there_is_refused() {
    let place = project("texture");
    let run = ["run", "a.frag", "--fn", "f", "--args", "[[0, 0]]"];
    let stress = ["stress", "a.frag", "--fn", "f", "--samples", "50"];
    let bench =
        ["bench", "a.frag", "--fn", "f", "--backend", "cpu", "--rounds", "3", "--samples", "16"];
    for command in [&run[..], &stress, &bench] {
        let with = |texture: &str| place.run(&[command, &["--texture", texture]].concat());
        let ran = with("text=[1, 0, 0, 1]");
        refuses(
            &ran,
            "unknown-texture",
            str![[r#"
error[unknown-texture]: the shader has no texture `text`
 --> --texture
  |
  = help: did you mean `tex`?

"#]],
        );
        assert!(with("tex=[1, 0, 0, 1]").code < 2, "{command:?}");
    }
}

#[test]
fn a_bool_that_is_neither_0_nor_1_is_warned_of() {
    let place = project("bool");
    let with = |values: &str| {
        place.write("v.json", values);
        place.run(&["encode", "a.frag", "v.json", "-o", "v.bin"])
    };
    warns(
        &with("{\"on\": 2}"),
        "odd-bool",
        str![[r#"
warning[odd-bool]: `on` at byte 16 is a bool, but neither 0 nor 1: 2
 --> v.json

"#]],
    );
    assert_eq!(std::fs::read(place.0.join("v.bin")).unwrap()[16], 2, "it is written all the same");
    for values in ["{\"on\": 1}", "{\"on\": true}", "{}"] {
        assert_eq!(with(values).err, "");
    }
}

/// A shader that no lint could follow has no finding, but that says nothing of it.
#[test]
fn functions_that_are_too_large_to_analyse_are_reported() {
    let place = Place::new("nothing-analysed");
    let statements = "    x = x + 1.0;\n".repeat(60_000);
    let wgsl = format!(
        "@group(0) @binding(0) var<uniform> u: vec4f;\n\
         @fragment fn main() -> @location(0) vec4f {{\n    var x = u.x;\n{statements}\
         return vec4f(x);\n}}\n"
    );
    let glsl = format!(
        "#version 450\nlayout(std140, binding = 0) uniform U {{ vec4 a; }} u;\n\
         layout(location = 0) out vec4 o;\nvoid main() {{\n    float x = u.a.x;\n{statements}\
         o = vec4(x);\n}}\n"
    );
    place.write("a.wgsl", wgsl).write("a.frag", glsl);
    place.run(&["check", "a.wgsl"]).code(0).stdout_eq(str![[r#"
warning[not-analysed]: functions are not analysed: the shader has 60004 statements, members and bodies, more than the 4000 that naga is given
 --> a.wgsl
  |
  = note: lints that follow code cannot find anything in this shader

"#]]);
    assert_eq!(place.run(&["check", "a.wgsl", "-D", "warnings"]).code, 1);
    // The front end of Landfall itself has no such limit.
    let ran = place.run(&["check", "a.frag"]);
    assert!(ran.code == 0 && !ran.out.contains("not-analysed"), "{}", ran.out);
}
