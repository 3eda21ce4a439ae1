//! Names of files, includes, macros and lints that are misspelt, and what is said of them.

use snapbox::str;

use crate::cli_check::place::CLEAN;
use crate::support::command::Place;

const LIGHTS: &str = "#version 450
#include \"light.glsl\"
layout(std140, binding = 0) uniform Lights { Light lights[MAX_LIGHTS]; };
layout(location = 0) out vec4 o;
void main() { o = vec4(lights[0].range); }
";

fn project(name: &str) -> Place {
    let place = Place::new(&format!("wrong-names-{name}"));
    place.write("shaders/lights.frag", LIGHTS);
    place.write("shaders/inc/light.glsl", "#define MAX_LIGHTS 8\nstruct Light { float range; };\n");
    place.write("a.frag", CLEAN);
    place
}

#[test]
fn a_file_that_is_missing_is_told_with_the_nearest() {
    let place = project("files");
    for (named, near) in [
        ("shaders/lihgts.frag", Some("shaders/lights.frag")),
        ("shaders/lights.fragg", Some("shaders/lights.frag")),
        ("shadres", Some("shaders")),
        ("Shaders/lights.frag", None),
        // Alike in its ending alone.
        ("b.frag", None),
    ] {
        for command in ["layout", "check"] {
            let ran = place.run(&[command, named]);
            let said = near.map(|near| format!("did you mean `{near}`?"));
            let all = format!("{}{}", ran.out, ran.err);
            assert!(ran.code == 2 && all.contains("no such file or directory"), "{all}");
            assert_eq!(
                all.lines().find_map(|line| line.split_once("help: ")).map(|(_, help)| help),
                said.as_deref(),
                "{command} {named}"
            );
        }
    }
}

#[test]
fn a_misspelt_include_is_told_with_the_nearest_and_takes_the_blame_for_types() {
    let place = project("include");
    place.write("shaders/lights.frag", LIGHTS.replace("light.glsl", "lihgt.glsl"));
    place.run(&["layout", "shaders/lights.frag", "-I", "shaders/inc"]).code(2).stderr_eq(str![[
        r#"
error[missing-include]: `lihgt.glsl` not found
 --> shaders/lights.frag:2:2
  |
2 | #include "lihgt.glsl"
  |  ^^^^^^^^^^^^^^^^^^^^
  |
  = note: looked for `shaders/lihgt.glsl`
  = note: looked for `shaders/inc/lihgt.glsl`
  = help: did you mean `light.glsl`?

error[unknown-type]: unknown type `Light`
 --> shaders/lights.frag:3:46
  |
3 | layout(std140, binding = 0) uniform Lights { Light lights[MAX_LIGHTS]; };
  |                                              ^^^^^
  |
  = help: an include that is not found may declare it


"#
    ]]);
    // Without a file of a similar name.
    place.write("shaders/lights.frag", LIGHTS.replace("light.glsl", "nowhere.glsl"));
    let ran = place.run(&["layout", "shaders/lights.frag"]);
    assert!(ran.err.contains("help: pass its directory with `-I DIR`"), "{}", ran.err);
}

#[test]
fn a_misspelt_length_is_told_with_the_nearest_macro_or_how_to_define_it() {
    let place = project("length");
    let said = |length: &str| {
        let text = LIGHTS.replace("MAX_LIGHTS", length).replace("light.glsl", "inc/light.glsl");
        place
            .write("shaders/lights.frag", text.replace("layout(l", "uniform int count;\nlayout(l"));
        let ran = place.run(&["layout", "shaders/lights.frag"]);
        assert!(
            ran.code == 2 && ran.err.contains("is not a constant of this shader"),
            "{}",
            ran.err
        );
        ran.err.lines().find_map(|line| Some(line.split_once("help: ")?.1.to_string()))
    };
    assert_eq!(said("MAX_LIGHT").as_deref(), Some("did you mean `MAX_LIGHTS`?"));
    assert_eq!(said("COUNT").as_deref(), Some("define it with `--define COUNT=N`"));
    assert_eq!(said("count"), None, "a variable is no macro");
}

#[test]
fn values_in_the_place_of_their_file_are_told_apart() {
    let place = project("values");
    let ran = place.run(&["encode", "a.frag", "{\"color\": 1}", "--hex"]);
    assert!(
        ran.err.contains("help: write the values to a file, or to standard input"),
        "{}",
        ran.err
    );
}

#[test]
fn only_deny_is_taken_for_the_option_of_macros() {
    let place = project("levels");
    for (option, notes) in [("-D", 1), ("-W", 0), ("-A", 0)] {
        let ran = place.run(&["check", "a.frag", option, "LIGHTS"]);
        let said = ran.err.matches("macros are defined with").count();
        assert_eq!((ran.code, said), (2, notes), "{option}: {}", ran.err);
    }
}

#[test]
fn a_path_in_the_place_of_a_command_is_not_told_with_a_hidden_one() {
    let place = project("command");
    for wrong in ["shaders", "shader", "leader"] {
        let ran = place.run(&[wrong]);
        assert!(ran.code == 2 && ran.err.contains("unrecognized subcommand"), "{}", ran.err);
        assert!(!ran.err.contains("__reader"), "{}", ran.err);
    }
}

#[test]
fn a_member_that_is_in_another_block_is_missing_in_all() {
    let place = project("blocks");
    let text = "#version 450\nstruct Light { float constant; };\n\
        layout(std140, binding = 0) uniform View { vec3 eye; };\n\
        layout(std140, binding = 1) uniform Lights { Light lights[4]; };\nvoid main() {}\n";
    place.write("two.frag", text);
    place.run(&["explain", "two.frag", "constant"]).code(2).stderr_eq(str![[r#"
error[unknown-member]: no block has a member `constant`
 --> two.frag
  |
  = help: there is a path `lights[0].constant`


"#]]);
}
