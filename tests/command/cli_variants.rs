//! Variants of shaders, which `permutations` configures, in locks and comparisons; and what a search
//! takes.

use std::process::Command;

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

fn git(place: &Place, arguments: &[&str]) {
    let names = ["-c", "user.name=A", "-c", "user.email=a@example.org"];
    let mut git = Command::new("git");
    let done = git.current_dir(&place.0).args(names).args(arguments).output();
    assert!(done.expect("git").status.success(), "{arguments:?}");
}

/// The offsets are those of std140 rules 1 to 5: after `mat4` 64, `vec3` at 64 and `float` at 76.
#[test]
fn a_member_that_moves_in_a_variant_is_found_by_every_command() {
    let place = project("moved");
    git(&place, &["init", "-q"]);
    place.run(&["lock"]).code(0).stdout_eq("").stderr_eq(str![]);
    git(&place, &["add", "."]);
    git(&place, &["commit", "-q", "-m", "lock"]);
    assert_eq!(place.read(LOCK).matches("\"name\": \"Shadow\"").count(), 1);
    for quiet in [&["check"][..], &["check", "--against", "HEAD"], &["lock", "--check"]] {
        assert_eq!(place.run(quiet).code, 0, "{quiet:?}");
    }
    place.run(&["diff", "--rev", "HEAD"]).code(0);
    place.run(&["diff", "layouts", "shaders"]).code(0);
    let moved = SHADER.replace("float bias; vec3 direction;", "vec3 direction; float bias;");
    place.write("shaders/lit.frag", moved);
    place.run(&["check", "--format", "short", "-A", "unreached-block"]).code(1).stdout_eq(str![]);
    place.run(&["check", "--against", "HEAD", "-A", "unreached-block"]).code(1).stdout_eq(str![]);
    place.run(&["diff", "--rev", "HEAD"]).code(1).stdout_eq(str![]);
    place.run(&["diff", "layouts", "shaders"]).code(1);
    place.run(&["lock", "--check"]).code(1);
    place.run(&["lock", "--policy", "superset"]).code(1);
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
    ran.code(0).stdout_eq(str![]);
    assert_eq!(place.run(&["lock"]).err.matches("no variant has block `Fog`").count(), 1);
    place.write("landfall.toml", "permutations = [[\"SHADOWS\"], [\"FOG\"]]\n");
    assert!(!place.run(&["check"]).out.contains("no variant has"));
}

#[test]
fn a_variant_that_is_lost_is_said() {
    let place = project("lost");
    place.run(&["lock"]).code(0);
    place.write("landfall.toml", "paths = [\"shaders\"]\npermutations = [[\"OTHER\"]]\n");
    let ran = place.run(&["check", "--format", "short", "-A", "unreached-block"]);
    ran.code(1).stdout_eq(str![]);
    place.write("landfall.toml", "paths = [\"shaders\"]\npermutations = [[\"SHADOWS\"]]\n");
    place.write(
        "shaders/lit.frag",
        SHADER.replace("#ifdef SHADOWS\n", "#ifdef SHADOWS\n#error no\n"),
    );
    let ran = place.run(&["check", "--format", "short", "-A", "unreached-block"]);
    ran.code(1).stdout_eq(str![]);
    place.run(&["lock"]).code(0).stdout_eq("").stderr_eq(str![]);
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
    place.run(&["check", "src"]).code(2).stdout_eq("").stderr_eq(str![]);
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
    git(&place, &["init", "-q"]);
    git(&place, &["add", "."]);
    git(&place, &["commit", "-q", "-m", "first"]);
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
    for language in ["rust", "c", "csharp", "zig", "odin", "python", "typescript"] {
        let ran = place.run(&["emit", "--lang", language, "loose.frag"]);
        assert!(ran.code == 0 && ran.err.contains("no blocks to mirror"), "{language} {}", ran.err);
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
