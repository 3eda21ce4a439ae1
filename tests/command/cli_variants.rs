//! Variants of shaders, which `permutations` configures, in locks and comparisons; and what a search
//! takes.

use snapbox::str;

use crate::support::command::Place;

const SHADER: &str = "#version 330 core
#ifdef SHADOWS
layout(std140) uniform Shadow { mat4 to_light; float bias; vec3 direction; };
#endif
#ifdef FOG
layout(std140) uniform Fog { vec3 color; };
#endif
layout(std140) uniform View { vec4 eye; };
out vec4 lit;
void main() { lit = eye; }
";

const LOCK: &str = "layouts/shaders/lit.frag.json";

fn project(name: &str) -> Place {
    let place = Place::new(&format!("variants-{name}"));
    let sets =
        "paths = [\"shaders\"]\npermutations = [[\"SHADOWS\"], [\"SHADOWS=2\"], [\"OTHER\"]]\n";
    place.write("landfall.toml", sets).write("shaders/lit.frag", SHADER);
    place.write("shaders/other.frag", "#version 330 core\n#ifdef OTHER\n#endif\nvoid main() {}\n");
    place
}

/// The offsets are those of std140 rules 1 to 5: after `mat4` 64, `vec3` at 64 and `float` at 76.
#[test]
fn a_member_that_moves_in_a_variant_is_found_by_every_command() {
    let place = project("moved");
    place.run(&["lock"]).code(0).stdout_eq("").stderr_eq(str![[r#"
warning[unreached-block]: no variant has block `Fog`: no lock guards it
 --> shaders/lit.frag:6:24
  |
6 | layout(std140) uniform Fog { vec3 color; };
  |                        ^^^
  |
  = note: it depends on the macro `FOG`
  = help: add a set of macros that gives it to `permutations` in landfall.toml

2 locks written, 0 unchanged

"#]]);
    place.commit();
    assert_eq!(place.read(LOCK).matches("\"name\": \"Shadow\"").count(), 1);
    for quiet in [&["check"][..], &["check", "--against", "HEAD"], &["lock", "--check"]] {
        assert_eq!(place.run(quiet).code, 0, "{quiet:?}");
    }
    place.run(&["diff", "--rev", "HEAD"]).code(0);
    place.run(&["diff", "layouts", "shaders"]).code(0);
    let moved = SHADER.replace("float bias; vec3 direction;", "vec3 direction; float bias;");
    place.write("shaders/lit.frag", moved);
    place.run(&["check", "--format", "short", "-A", "unreached-block"]).code(1).stdout_eq(str![[r#"
shaders/lit.frag:3:24: error[layout-drift] `Shadow` under `SHADOWS` differs from its lock: `bias` moved from 64 to 76; buffers filled for the lock's layout are misread

"#]]);
    place.run(&["check", "--against", "HEAD", "-A", "unreached-block"]).code(1).stdout_eq(str![[r#"
error[layout-drift]: `Shadow` under `SHADOWS` differs from `HEAD`: `bias` moved from 64 to 76; buffers filled for the old layout are misread
 --> shaders/lit.frag:3:24
  |
3 | layout(std140) uniform Shadow { mat4 to_light; vec3 direction; float bias; };
  |                        ^^^^^^ under `SHADOWS` differs from `HEAD`
  |
  = note: breaking: `direction` moved from 80 to 64
  = note: compatible: shrank from 96 to 80 bytes
  = note: the same under `SHADOWS=2`
  = note: declaration in `HEAD`: HEAD:shaders/lit.frag:3:24
  = note: the layout
             96  uniform Shadow std140      |    80  uniform Shadow std140
           0 64    mat4 to_light columns 16    0 64    mat4 to_light columns 16
          64  4    float bias               <
          68 12    -- hole                  <
          80 12    vec3 direction           | 64 12    vec3 direction
          92  4    -- tail padding          | 76  4    float bias
  = help: undo it, or change what uploads the block

"#]]);
    place.run(&["diff", "--rev", "HEAD"]).code(1).stdout_eq(str![[r#"
shaders/lit.frag: Shadow under `SHADOWS`: breaking
  breaking   `bias` moved from 64 to 76  [Shadow::bias]
  breaking   `direction` moved from 80 to 64  [Shadow::direction]
  compatible shrank from 96 to 80 bytes

     96  uniform Shadow std140      |    80  uniform Shadow std140
   0 64    mat4 to_light columns 16    0 64    mat4 to_light columns 16
  64  4    float bias               <
  68 12    -- hole                  <
  80 12    vec3 direction           | 64 12    vec3 direction
  92  4    -- tail padding          | 76  4    float bias

1 block changed: 1 breaking

"#]]);
    place.run(&["diff", "layouts", "shaders"]).code(1);
    place.run(&["lock", "--check"]).code(1);
    let forbidden = place.run(&["lock", "--policy", "superset"]);
    let said =
        "block `Shadow` under `SHADOWS` that policy `superset` forbids: `bias` moved from 64 to 76";
    assert!(forbidden.code == 1 && forbidden.err.contains(said), "{}", forbidden.err);
    let json = place.run(&["diff", "--rev", "HEAD", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&json.out).expect("JSON");
    assert_eq!(json["shaders"][0]["variant"], "SHADOWS");
    assert_eq!(place.run(&["check", "--accept"]).code, 0);
    assert_eq!(place.run(&["lock", "--check"]).code, 0);
}

#[test]
fn a_block_that_no_variant_has_is_named_once() {
    let place = project("unreached");
    let ran = place.run(&["check", "--format", "short"]);
    ran.code(0).stdout_eq(str![[r#"
shaders/lit.frag:6:24: warning[unreached-block] no variant has block `Fog`: no lock guards it

"#]]);
    assert_eq!(place.run(&["lock"]).err.matches("no variant has block `Fog`").count(), 1);
    let shader = place.read("shaders/lit.frag");
    let allowed = format!("// landfall: allow-file(unreached-block)\n{shader}");
    place.write("shaders/lit.frag", allowed);
    assert!(
        !place.run(&["lock"]).err.contains("no variant has"),
        "the comment holds for `lock`, too"
    );
    place.write("shaders/lit.frag", shader);
    place.write("landfall.toml", "permutations = [[\"SHADOWS\"], [\"FOG\"]]\n");
    assert!(!place.run(&["check"]).out.contains("no variant has"));
}

#[test]
fn a_variant_that_is_lost_is_said() {
    let place = project("lost");
    place.run(&["lock"]).code(0);
    place.write("landfall.toml", "paths = [\"shaders\"]\npermutations = [[\"OTHER\"]]\n");
    let ran = place.run(&["check", "--format", "short", "-A", "unreached-block"]);
    ran.code(1).stdout_eq(str![[r#"
shaders/lit.frag: error[layout-drift] `layouts/shaders/lit.frag.json` records the variant `SHADOWS`, which is not configured
shaders/lit.frag: error[layout-drift] `layouts/shaders/lit.frag.json` records the variant `SHADOWS=2`, which is not configured

"#]]);
    place.write("landfall.toml", "paths = [\"shaders\"]\npermutations = [[\"SHADOWS\"]]\n");
    place.write(
        "shaders/lit.frag",
        SHADER.replace("#ifdef SHADOWS\n", "#ifdef SHADOWS\n#error no\n"),
    );
    let ran = place.run(&["check", "--format", "short", "-A", "unreached-block"]);
    ran.code(1).stdout_eq(str![[r#"
shaders/lit.frag: error[layout-drift] `layouts/shaders/lit.frag.json` records the variant `SHADOWS`, which cannot be laid out
shaders/lit.frag: error[layout-drift] `layouts/shaders/lit.frag.json` records the variant `SHADOWS=2`, which is not configured
shaders/lit.frag:3:2: warning[define-changes-layout] under `SHADOWS` the shader cannot be laid out: `#error no`

"#]]);
    place.run(&["lock"]).code(0).stdout_eq("").stderr_eq(str![[r#"
warning[error-directive]: the lock lacks the variant `SHADOWS`, which cannot be laid out: `#error no`
 --> shaders/lit.frag:3:2
  |
3 | #error no
  |  ^^^^^
  |
  = help: define the required macro with `--define NAME` or `--define NAME=VALUE`

warning[unreached-block]: no variant has block `Fog`: no lock guards it
 --> shaders/lit.frag:7:24
  |
7 | layout(std140) uniform Fog { vec3 color; };
  |                        ^^^
  |
  = note: it depends on the macro `FOG`
  = help: add a set of macros that gives it to `permutations` in landfall.toml

1 lock written, 1 unchanged

"#]]);
}

#[test]
fn an_include_of_a_variant_alone_is_part_of_the_cached_result() {
    let place = project("include");
    let text = "#version 330 core\n#extension GL_GOOGLE_include_directive : enable\n#ifdef SHADOWS\n\
                #include \"shadow.glsl\"\n#endif\nvoid main() {}\n";
    place.write("shaders/lit.frag", text);
    place.write("shaders/shadow.glsl", "layout(std140) uniform Shadow { vec3 a; float b; };\n");
    place.run(&["lock"]).code(0);
    let check = ["check", "--cache-dir", "cache", "shaders/lit.frag"];
    assert_eq!(place.run(&check).code, 0);
    place.write("shaders/shadow.glsl", "layout(std140) uniform Shadow { float b; vec3 a; };\n");
    place.run(&check).code(1);
}

#[test]
fn a_search_passes_over_what_is_no_shader() {
    let place = Place::new("search-content");
    place.write("src/Program.cs", "using System;\nclass Program { static void Main() { } }\n");
    place.write("src/Lib.fs", "module Lib\nlet add a b = a + b\n");
    place.write("src/Toon.shader", "Shader \"Custom/Toon\" { Properties { } }\n");
    place.write("src/cube.mesh", b"BAKED\0\x01\xff".as_slice());
    place.write("src/text.mesh", "MESH v1\n3 4 5\n");
    let ran = place.run(&["check", "src"]);
    ran.code(2);
    let only = "`src` contains no GLSL or WGSL shader, only C#, F#, ShaderLab";
    assert!((ran.out.clone() + &ran.err).contains(only), "{} {}", ran.out, ran.err);
    place.write("game/a.frag", "#version 330 core\nlayout(std140) uniform U { vec3 a; };\n");
    let mirror = place.run(&["emit", "--lang", "csharp", "game/a.frag"]).out;
    place.write("game/Layouts.cs", mirror);
    for shader in ["game/b.fs", "game/c.mesh", "game/d.cs", "game/e.shader"] {
        place.write(shader, "#version 450\nlayout(std140) uniform U { vec3 a; };\n");
    }
    let ran = place.run(&["layout", ".", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&ran.code(0).out).expect("JSON");
    let paths = json["shaders"].as_array().expect("a list").iter();
    let paths: Vec<&str> = paths.map(|shader| shader["path"].as_str().expect("a text")).collect();
    assert_eq!(paths, ["game/a.frag", "game/b.fs", "game/c.mesh", "game/d.cs", "game/e.shader"]);
    place.run(&["check", "."]).code(0);
    assert_eq!(place.run(&["init", "--print"]).out.matches("paths = [\"game\"]").count(), 1);
    // A file that is named is read.
    assert_eq!(place.run(&["layout", "src/Lib.fs"]).code, 2);
    assert_eq!(place.run(&["layout", "src/*.fs"]).code, 2);
}

#[test]
fn excluded_files_are_left_out_of_every_search() {
    let place = Place::new("search-exclude");
    place.write("landfall.toml", "paths = [\".\"]\nexclude = [\"vendor\"]\n");
    let text = "#version 330 core\nlayout(std140) uniform Kept { vec3 a; };\nvoid main() {}\n";
    place.write("a.frag", text).write("vendor/b.frag", text.replace("Kept", "Left"));
    place.commit();
    place.write("vendor/b.frag", text.replace("vec3 a", "vec3 b; float c"));
    place.run(&["diff", "--rev", "HEAD"]).code(0).stdout_eq(str![[r#"
no layout changed

"#]]);
    let mirror = place.run(&["emit", "--lang", "rust", "."]).out;
    assert!(mirror.contains("struct Kept") && !mirror.contains("struct Left"), "{mirror}");
    assert!(place.run(&["emit", "--lang", "rust", "vendor/b.frag"]).out.contains("pub struct"));
}

#[test]
fn a_path_that_is_none_gets_what_may_be_meant() {
    let place = Place::new("explain-meant");
    let text = "#version 330 core\nstruct L { vec3 hue; float p; };\nlayout(std140) uniform B { L lamps[9]; };\n";
    place.write("a.frag", text);
    for (arguments, help) in [
        (&["a.frag", "172"][..], "a byte is written `@172`"),
        (&["a.frag", "hue"], "there is a path `lamps[0].hue`"),
        (&["a.frag", "B", "lamps[3].hue"], "write `B.lamps[3].hue`"),
        (&["B", "lamps[3].hue"], "`landfall explain SHADER 'B.lamps[3].hue'`"),
    ] {
        let ran = place.run(&[&["explain"][..], arguments].concat());
        assert!(ran.code == 2 && ran.err.contains(help), "{arguments:?}: {}", ran.err);
    }
    assert_eq!(place.run(&["explain", "a.frag", "B.lamps[3].hue"]).code, 0);
}

#[test]
fn what_emit_leaves_out_and_makes_is_said() {
    let place = Place::new("emit-said");
    place.write("loose.frag", "#version 330 core\nuniform vec3 tint;\nvoid main() {}\n");
    for language in ["rust", "c", "csharp", "zig", "python", "typescript"] {
        let ran = place.run(&["emit", "--lang", language, "loose.frag"]);
        let said =
            if language == "rust" { "no mirror is generated" } else { "no blocks to mirror" };
        assert!(ran.code == 0 && ran.err.contains(said), "{language} {}", ran.err);
    }
    let text = "struct S { c: vec3f, p: f32 }\n@group(0) @binding(0) var<uniform> s: S;\n";
    place.write("a.wgsl", text);
    let emit =
        ["emit", "--lang", "rust", "a.wgsl", "--type", "vec3f=crate::V", "--out", "new/deep/a.rs"];
    place.run(&emit).code(0).stderr_eq(str![[r#"
made the directory new/deep

"#]]);
    assert!(place.read("new/deep/a.rs").contains("pub c: crate::V"));
    place.run(&emit).code(0).stderr_eq("");
}

/// A server that is given a time has done its work after it.
#[test]
fn serve_ends_after_its_time() {
    let ran = Place::new("serve-time").run(&["serve", "--max-time", "0.3"]);
    assert!(ran.code == 0 && ran.out.starts_with("http://127.0.0.1:"), "{} {}", ran.code, ran.err);
}
