//! `[[assert]]`: files of assertions that `emit` writes and a check compares.

use snapbox::str;

use crate::support::command::Place;

const LIGHT: &str = "#version 450
struct PointLight { vec3 pos; vec3 color; float power; };
layout(std140, binding = 0) uniform Lights { PointLight data[4]; };
layout(location = 0) out vec4 color;
void main() { color = vec4(data[0].pos + data[0].color, data[0].power); }
";

const ROW: &str = "[[assert]]
out = \"src/light.hpp\"
lang = \"c\"
shaders = [\"s\"]
structures = { \"engine::PointLight\" = \"PointLight\" }
fields = { \"PointLight.pos\" = \"position\" }
include-header = [\"engine/light.h\"]
";

fn tree(name: &str, more: &str) -> Place {
    let place = Place::new(&format!("check-asserted-{name}"));
    place.write("s/a.frag", LIGHT).write("landfall.toml", format!("paths = [\"s\"]\n{ROW}{more}"));
    place
}

#[test]
fn emit_writes_the_files_and_check_tells_when_one_is_old() {
    let place = tree("stale", "");
    let missing = place.run(&["check"]);
    missing.code(1).stdout_eq(str![[r#"
error[stale-assertions]: `src/light.hpp` does not exist
 --> landfall.toml:2:1
  |
2 | [[assert]]
  | ^^^^^^^^^^
  |
  = help: `landfall emit` writes it

"#]]);
    place.run(&["emit"]).code(0).stderr_eq("1 file written, 0 unchanged\n");
    // The same as with the options, but for the command in its head.
    let named = place.run(&[
        "emit",
        "s",
        "--lang",
        "c",
        "--assert",
        "engine::PointLight=PointLight",
        "--field",
        "PointLight.pos=position",
        "--include-header",
        "engine/light.h",
        "--out",
        "other/light.hpp",
    ]);
    assert_eq!(named.code, 0, "{}", named.err);
    assert_eq!(place.read("src/light.hpp"), place.read("other/light.hpp"));
    assert!(place.read("src/light.hpp").contains("offsetof(engine::PointLight, position), 0u"));
    assert_eq!(place.run(&["check"]).code, 0);
    assert_eq!(place.run(&["emit"]).err, "0 files written, 1 unchanged\n");
    assert_eq!(place.run(&["emit", "--check"]).code, 0);
    // A member moves: the file is old, for a check of that shader alone, too.
    place.write("s/a.frag", LIGHT.replace("vec3 pos;", "vec3 pos; float range;"));
    for arguments in [&["check"][..], &["check", "s/a.frag"], &["check", "s/a.frag", "-f", "json"]]
    {
        let ran = place.run(arguments);
        assert!(ran.code == 1 && ran.out.contains("is out of date"), "{arguments:?}: {}", ran.out);
    }
    assert_eq!(place.run(&["emit", "--check"]).code, 1);
    assert_eq!(place.run(&["check", "-A", "stale-assertions"]).code, 0);
    place.write("t/b.frag", LIGHT);
    assert_eq!(place.run(&["check", "t/b.frag"]).code, 0);
    assert_eq!(place.run(&["emit"]).code, 0);
    assert_eq!(place.run(&["check"]).code, 0);
}

#[test]
fn a_check_says_what_to_do_about_assertions_that_cannot_be_written() {
    let place = tree("two", "");
    place.write(
        "s/b.frag",
        LIGHT.replace("vec3 pos;", "vec4 pos;").replace("data[0].pos", "data[0].pos.xyz"),
    );
    place.run(&["check"]).code(1).stdout_eq(str![[r#"
error[stale-assertions]: `src/light.hpp` cannot be written: `PointLight` is laid out in two ways: s/a.frag:2 (std140) and s/b.frag:2 (std140)
 --> landfall.toml:2:1
  |
2 | [[assert]]
  | ^^^^^^^^^^
  |
  = help: name the block that the structure is uploaded to: `Block.member`

"#]]);
}

#[test]
fn what_cannot_be_asserted_is_an_error_and_writes_nothing() {
    for (name, row, shader, said) in [
        ("member", "fields = { \"PointLight.nope\" = \"x\" }\n", LIGHT, "nope"),
        ("shader", "", "#version 450\nuniform Lights { vec3 a\n", "a.frag"),
    ] {
        let place = tree(name, "");
        let text = place
            .read("landfall.toml")
            .replace("fields = { \"PointLight.pos\" = \"position\" }\n", row);
        place.write("landfall.toml", text).write("s/a.frag", shader);
        let ran = place.run(&["emit"]);
        assert!(ran.code == 2 && ran.err.contains(said), "{name}: {}", ran.err);
        assert!(!place.has("src"), "{name}");
        let ran = place.run(&["check"]);
        assert!(
            ran.code > 0 && ran.out.contains("`src/light.hpp` cannot be written"),
            "{}",
            ran.out
        );
    }
}

#[test]
fn no_shader_include_or_configuration_is_overwritten() {
    for (name, out) in
        [("shader", "s/a.frag"), ("include", "s/light.glsl"), ("config", "landfall.toml")]
    {
        let place = tree(&format!("over-{name}"), "");
        let text = place.read("landfall.toml").replace("src/light.hpp", out);
        place.write("landfall.toml", &text);
        place.write("s/light.glsl", "struct PointLight { vec3 pos; vec3 color; float power; };\n");
        let shader = LIGHT.replace(
            "struct PointLight { vec3 pos; vec3 color; float power; };",
            "#extension GL_GOOGLE_include_directive : enable\n#include \"light.glsl\"",
        );
        place.write("s/a.frag", &shader);
        let before = place.read(out);
        let ran = place.run(&["emit"]);
        assert!(ran.code == 2 && ran.err.contains(out), "{name}: {}", ran.err);
        assert_eq!(place.read(out), before, "{name}");
    }
}

#[test]
fn a_row_that_asserts_nothing_is_refused() {
    for (name, text, said) in [
        ("out", ROW.replace("out = \"src/light.hpp\"\n", ""), "`[[assert]]` has no `out`"),
        ("language", ROW.replace("\"c\"", "\"cobol\""), "unknown language `cobol`"),
        ("shaders", ROW.replace("shaders = [\"s\"]\n", ""), "`[[assert]]` has no `shaders`"),
        (
            "structures",
            ROW.replace("{ \"engine::PointLight\" = \"PointLight\" }", "{}"),
            "`[[assert]]` has no `structures`",
        ),
    ] {
        let place = tree(&format!("row-{name}"), "");
        place.write("landfall.toml", text);
        let ran = place.run(&["check"]);
        assert!(ran.code == 2 && ran.err.contains(said), "{name}: {}", ran.err);
    }
    let place = tree("python", "");
    let text = place.read("landfall.toml").replace("lang = \"c\"", "lang = \"python\"");
    place.write("landfall.toml", text);
    place.run(&["emit"]).code(2).stderr_eq(str![[r#"
error[cannot-run]: structures of this language have no layout that is fixed
 --> landfall.toml:2:1
  |
2 | [[assert]]
  | ^^^^^^^^^^
  |
  = help: assertions are written in `rust`, `c`, `csharp` and `zig`

0 files written, 0 unchanged

"#]]);
    let place = tree("none", "");
    place.write("landfall.toml", "");
    place.run(&["emit"]).code(2).stderr_eq(str![[r#"
error[cannot-run]: `landfall emit` has nothing to write
  |
  = help: name shaders and a language, `landfall emit shaders/*.frag --lang rust`, or list files in `[[assert]]` of landfall.toml


"#]]);
}
