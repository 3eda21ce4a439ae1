//! `landfall port` writes nothing that an installed compiler refuses.

use snapbox::str;

use crate::support::command::{Place, Ran, golden};

/// A conversion that no version has, on line 5.
const WRONG: &str = "#version 330\nuniform float a;\n// One too many.\nout vec4 c;\nvoid main() { c = vec4(a).xyz; }\n";

const RIGHT: &str = "#version 330\nuniform float a;\nout vec4 c;\nvoid main() { c = vec4(a); }\n";

#[test]
fn a_result_that_the_compiler_refuses_is_not_written() {
    let place = Place::new("port_refused");
    place.write("a.frag", WRONG);
    place.write("old.frag", "kept");
    for arguments in [["port", "a.frag", "--out", "old.frag"], ["port", "a.frag", "--to", "naga"]] {
        let ran = place.run(&arguments);
        ran.code(2).stdout_eq("");
        assert_eq!(place.read("old.frag"), "kept");
    }
    place.run(&["port", "a.frag"]).code(2).stderr_eq(str![[r#"
error[not-portable]: glslangValidator refuses the ported shader: 'assign' : cannot convert from ' temp 3-component vector of float' to 'layout( location=0) out highp 4-component vector of float'
 --> a.frag:5:1
  |
5 | void main() { c = vec4(a).xyz; }
  | ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
  |
  = help: mend the shader, or pass `--no-compiler` to write the result as it is


"#]]);
    let ran = place.run(&["port", "a.frag", "--no-compiler", "-q"]);
    ran.code(0)
        .stdout_eq(str![[r#"
#version 450
layout(set = 0, binding = 0, std140) uniform DefaultBlock {
    float a;
};
// One too many.
layout(location = 0) out vec4 c;
void main() { c = vec4(a).xyz; }

"#]])
        .stderr_eq("");
}

#[test]
fn a_missing_compiler_is_no_error() {
    let place = Place::new("port_no_compiler");
    place.write("a.frag", WRONG);
    let mut command = place.command(&["port", "a.frag", "-q"]);
    let output = command.env("PATH", &place.0).output().expect("it runs");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}

/// A compiler that breaks down says nothing about the shader.
#[cfg(unix)]
#[test]
fn a_broken_compiler_is_a_warning() {
    let place = Place::new("port_broken_compiler");
    place.write("a.frag", RIGHT);
    let ran = with_compiler(&place, "exit 1", &["port", "a.frag"]);
    assert_eq!(ran.code, 0);
    golden().eq(
        ran.err.as_str(),
        str![[r#"
warning[not-portable]: glslangValidator cannot tell whether the result compiles: exit status: 1
 --> a.frag:1:1
  |
1 | #version 330
  | ^

set 0 binding 0: DefaultBlock
location 0 out: c

"#]],
    );
}

#[test]
fn includes_and_macros_of_the_command_line_reach_the_compiler() {
    let place = Place::new("port_includes");
    place.write("lib/tone.glsl", "float tone(float x) { return x * SCALE; }\n");
    place.write("near.glsl", "const float NEAR = 0.5;\n");
    let text = "#version 330\n#include \"tone.glsl\"\n#include \"near.glsl\"\nuniform float a;\n\
                out vec4 c;\nvoid main() { c = vec4(tone(a) + NEAR); }\n";
    place.write("a.frag", text);
    let arguments = ["port", "a.frag", "-I", "lib", "-D", "SCALE=2.0", "-q"];
    place.run(&arguments).code(0).stderr_eq("");
    place.write("a.frag", text.replace("tone(a)", "tone(a, a)"));
    let ran = place.run(&arguments);
    ran.code(2).stdout_eq("").stderr_eq(str![[r#"
error[not-portable]: glslangValidator refuses the ported shader: [..]
 --> a.frag:6:1
  |
6 | void main() { c = vec4(tone(a, a) + NEAR); }
  | ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
  |
  = help: mend the shader, or pass `--no-compiler` to write the result as it is


"#]]);
}

#[test]
fn the_partner_keeps_its_stage_and_shares_its_uniforms() {
    let place = Place::new("port_partner");
    place.write("a.vs", "#version 330\nuniform vec4 a;\nvoid main() { gl_Position = a; }\n");
    place.write("a.fs", "#version 330\nuniform vec4 a;\nout vec4 c;\nvoid main() { c = a; }\n");
    let ran = place.run(&["port", "a.fs", "--stage", "fragment", "--partner", "a.vs"]);
    ran.code(0).stderr_eq(str![[r#"
shared with a.vs: DefaultBlock
set 0 binding 0: DefaultBlock
location 0 out: c

"#]]);
    // The name has an effect where the block is shared, and none where there is no loose uniform.
    let named = ["port", "a.fs", "--stage", "fragment", "--partner", "a.vs", "--block", "Uniforms"];
    place.run(&named).code(0).stderr_eq(str![[r#"
shared with a.vs: Uniforms
set 0 binding 0: Uniforms
location 0 out: c

"#]]);
    place.write("b.fs", "#version 330\nout vec4 c;\nvoid main() { c = vec4(1); }\n");
    let alone = ["port", "b.fs", "--stage", "fragment", "--block", "Uniforms"];
    place.run(&alone).code(0).stderr_eq(str![[r#"
location 0 out: c
warning[unused-option]: `--block Uniforms` has no effect: no uniform is outside blocks


"#]]);
}

/// Puts a script in the place of the compiler.
#[cfg(unix)]
fn with_compiler(place: &Place, script: &str, arguments: &[&str]) -> Ran {
    use std::os::unix::fs::PermissionsExt as _;
    place.write("bin/glslangValidator", format!("#!/bin/sh\n{script}\n"));
    let tool = place.0.join("bin/glslangValidator");
    std::fs::set_permissions(tool, std::fs::Permissions::from_mode(0o755)).expect("it is ours");
    let path = format!("{}:{}", place.path("bin"), std::env::var("PATH").unwrap_or_default());
    Ran::of(place.command(arguments).env("PATH", path).output().expect("it runs"))
}

/// Past its limit, the result is written with a warning; `--max-time` would end with 2.
#[cfg(target_os = "linux")]
#[test]
fn a_compiler_that_does_not_end_is_ended_at_its_limit() {
    let place = Place::new("port_endless_compiler");
    place.write("a.frag", RIGHT);
    let plain = place.run(&["port", "a.frag"]).out;
    // One computes; one waits, and has started another that holds its output.
    for (script, limit) in [("while :; do :; done", "1"), ("sleep 1000 & wait", "0.1")] {
        let arguments = ["port", "a.frag", "--limit", limit, "--max-time", "300"];
        let ran = with_compiler(&place, script, &arguments);
        assert_eq!((ran.code, &ran.out), (0, &plain), "{script}: {}", ran.err);
        let said = format!(
            "warning[not-portable]: glslangValidator cannot tell whether the result compiles: it \
             runs past its limit of {limit} s\n"
        );
        assert!(ran.err.starts_with(&said), "{script}: {}", ran.err);
        assert!(ran.err.contains("help: raise it with `--limit`, or pass `--no-compiler`"));
    }
}

/// What it says without end is not kept, and its address space is limited.
#[cfg(target_os = "linux")]
#[test]
fn the_output_and_the_memory_of_a_compiler_are_limited() {
    let place = Place::new("port_greedy_compiler");
    place.write("a.frag", RIGHT);
    let script = "head -c 400000000 /dev/zero; sleep 0.5; ulimit -v > limit";
    let ran = with_compiler(&place, script, &["port", "a.frag", "--max-memory", "300"]);
    assert!(ran.code == 0 && ran.out.contains("c = vec4(a)"), "{}", ran.err);
    // In KiB.
    assert_eq!(place.read("limit"), "4194304\n");
}
