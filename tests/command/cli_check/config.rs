//! The configuration: where it is found, what it says, and what is said about it.

use std::fs;

use crate::cli_check::place::{CLEAN, Place, Ran, idle};

#[test]
fn every_fault_of_a_configuration_is_told_with_its_place_and_a_remedy() {
    let place = Place::new("config-faults");
    place.write("a.frag", CLEAN);
    let table = |rest: &str| format!("[[table]]\nblock = \"Light\"\n{rest}\n");
    let group = |rest: &str| format!("[[mirror-group]]\nname = \"g\"\n{rest}\n");
    let cases = [
        ("lokcs = \"x\"", "1:1", "unknown-key", "did you mean `locks`?"),
        ("mirror_group = []", "1:1", "unknown-key", "did you mean `mirror-group`?"),
        ("colour = 1", "1:1", "unknown-key", "`permutations`"),
        ("paths = \"shaders\"", "1:9", "wrong-type", "write `paths = [\"shaders\"]`"),
        ("paths = [1]", "1:10", "wrong-type", "write `\"1\"`"),
        ("locks = 3", "1:9", "wrong-type", "write `locks = \"3\"`"),
        ("gather = \"yes\"", "1:10", "wrong-type", "write `gather = true`"),
        ("exclude = [\"a\", \"b[\"]", "1:17", "bad-glob", "escape"),
        ("define = [\"3D\"]", "1:11", "wrong-value", "a macro is NAME"),
        ("override = [\"N\"]", "1:13", "wrong-value", "NAME=VALUE"),
        ("rules = \"std14O\"", "1:9", "wrong-value", "did you mean `std140`?"),
        ("api = \"metal\"", "1:7", "wrong-value", "known are `opengl`, `vulkan`"),
        ("targets = [\"gl33\", \"webgl\"]", "1:20", "unknown-target", "did you mean `webgl2`?"),
        ("permutations = [\"A\"]", "1:16", "wrong-type", "[[\"SHADOWS=1\"]"),
        ("permutations = [[\"A=1\", \"=\"]]", "1:25", "wrong-value", "a macro is NAME"),
        (
            "[levels]\nstale-coment = \"warn\"",
            "2:1",
            "unknown-lint",
            "did you mean `stale-comment`?",
        ),
        ("[levels]\nstale-comment = \"denied\"", "2:17", "wrong-value", "`allow`, `warn`, `deny`"),
        ("[levels]\nstale-comment = 1", "2:17", "wrong-type", "`\"deny\"`"),
        ("levels = 1", "1:10", "wrong-type", "write `levels = {"),
        ("table = 1", "1:9", "wrong-type", "write it under `[[table]]`"),
        ("[[table]]\nsize = 1", "1:1", "missing-key", "add `block = "),
        (&table("size = \"48 * x\""), "3:14", "wrong-value", "write arithmetic"),
        (&table("size = \"4 - 8\""), "3:9", "wrong-value", "write arithmetic"),
        (&table("size = -1"), "3:8", "wrong-value", "from 0"),
        (&table("size = 1.5"), "3:8", "wrong-type", "48 * 128 + 4"),
        (&table("offsets = { \"data[0].pos\" = true }"), "3:29", "wrong-type", "a number"),
        (&table("file = \"{a\""), "3:8", "bad-glob", "escape"),
        (&table("sizes = 1"), "3:1", "unknown-key", "did you mean `size`?"),
        (&group("copies = [{ block = \"a\" }]"), "1:1", "missing-key", "add the other cop"),
        (&group("copies = [{ file = \"a\" }, { block = \"b\" }]"), "3:11", "missing-key", "`block"),
        (&group("copies = [\"a\", \"b\"]"), "3:10", "wrong-type", "[[copies]]"),
        ("[[rust-mirror]]\nfile = \"a.rs\"\nblock = \"A\"", "1:1", "missing-key", "structure"),
        ("paths = [", "1:10", "syntax", "error"),
        ("paths = []\npaths = []", "2:1", "syntax", "duplicate key"),
    ];
    for (text, at, code, remedy) in cases {
        let ran = place.write("landfall.toml", text).run(&["check"]);
        assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{text}\n{}", ran.err);
        for words in [&format!("--> landfall.toml:{at}\n"), &format!("error[{code}]"), remedy] {
            assert!(ran.err.contains(words), "{text}: no {words:?} in\n{}", ran.err);
        }
        assert_eq!(ran.err.matches("error[").count(), 1, "{text}\n{}", ran.err);
    }
}

#[test]
fn all_faults_are_told_at_once_and_hostile_files_get_one_answer() {
    let place = Place::new("config-hostile");
    place.write("a.frag", CLEAN).write("landfall.toml", "a = 1\nb = 2\ngather = 3\n");
    assert_eq!(place.run(&["check"]).err.matches("error[").count(), 3);
    for text in ["[".repeat(100_000), format!("x = {}", "[".repeat(100_000)), "é\0".to_string()] {
        let ran = place.write("landfall.toml", &text).run(&["check"]);
        assert_eq!(ran.code, 2, "{}", ran.err);
    }
    let ran = place.write("landfall.toml", b"\xff\xfea").run(&["check"]);
    assert!(ran.code == 2 && ran.err.contains("is UTF-16"), "{}", ran.err);
}

#[test]
fn the_nearest_configuration_above_what_is_checked_holds() {
    let place = Place::new("config-found");
    place.write("landfall.toml", "[levels]\nunused-allow = \"deny\"\n");
    place.write("sub/a.frag", idle()).write("sub/deep/b.frag", idle());
    let code = |arguments: &[&str]| place.run(arguments).code;
    assert_eq!(code(&["check", "-A", "unused-allow"]), 0);
    assert_eq!(code(&["check", "sub/deep"]), 1);
    place.write("sub/.landfall.toml", "[levels]\nunused-allow = \"warn\"\n");
    assert_eq!(code(&["check", "sub/deep", "-A", "all", "-W", "unused-allow"]), 0);
    assert_eq!(code(&["check", "sub/deep/b.frag"]), 0);
    assert_eq!(code(&["check", "sub/**/*.frag"]), 0);
    assert_eq!(code(&["check"]), 1, "from here it is the upper one");
    assert_eq!(code(&["check", "--no-config"]), 0);
    assert_eq!(code(&["check", "--config", "sub/.landfall.toml"]), 0);
    let ran = place.write("sub/landfall.toml", "").run(&["check", "sub"]);
    assert_eq!(ran.code, 2);
    assert!(ran.err.contains("`sub/landfall.toml` conflicts with `.landfall.toml`"), "{}", ran.err);
    assert!(ran.err.contains("--config"), "{}", ran.err);
    let ran = place.run(&["check", "--config", "gone.toml"]);
    assert!(ran.code == 2 && ran.err.contains("`gone.toml` cannot be read"), "{}", ran.err);
}

#[test]
fn paths_are_relative_to_the_configuration_wherever_it_is_run() {
    let place = Place::new("config-relative");
    place.write("landfall.toml", "paths = [\"shaders\"]\nexclude = [\"vendor\", \"gen/*.frag\"]\n");
    place.write("shaders/a.frag", idle()).write("shaders/vendor/b.frag", idle());
    place.write("other/c.frag", idle()).write("work/d.frag", CLEAN).write("gen/e.frag", idle());
    assert_eq!(place.found(&[]), ["unused-allow shaders/a.frag:4"]);
    assert_eq!(place.found(&["."]).len(), 2, "what is named is checked, but for what is left out");
    assert_eq!(place.found(&["shaders/vendor/b.frag"]), [""; 0], "named or not");
    assert_eq!(place.found(&["--exclude", "a.*"]), [""; 0]);
    let mut below = place.command(&["check", "-f", "short"]);
    let ran = Ran::of(below.current_dir(place.0.join("work")).output().unwrap());
    assert!(ran.out.contains("../shaders/a.frag"), "{}\n{}", ran.out, ran.err);
    let spelled = place.0.join("work/../shaders/a.frag").display().to_string();
    assert_eq!(place.found(&[&spelled]), ["unused-allow shaders/a.frag:4"]);
    let ran = place.run(&["check", "--exclude", "a["]);
    assert!(ran.code == 2 && ran.err.contains("`a[` is not a glob"), "{}", ran.err);
}

/// A shader that only some settings can read.
const ASKS: &str = "#version 330
#if !defined(LIGHTS) || LIGHTS != 3
#error LIGHTS is not 3
#endif
#include \"lights.glsl\"
layout(std140) uniform B { Light lights[LIGHTS]; };
void main() {}
";

#[test]
fn shaders_are_read_as_the_configuration_says_and_flags_hold_over_it() {
    let place = Place::new("config-read");
    place.write("a.frag", ASKS).write("lib/lights.glsl", "struct Light { vec4 a; };\n");
    assert_eq!(place.run(&["check", "a.frag"]).code, 2);
    place.write("landfall.toml", "include = [\"lib\"]\ndefine = [\"LIGHTS=3\"]\n");
    let code = |arguments: &[&str]| {
        let ran = place.run(&[&["check", "a.frag", "-A", "all"], arguments].concat());
        assert!(ran.code != 1, "{}\n{}", ran.out, ran.err);
        ran.code
    };
    assert_eq!(code(&[]), 0);
    assert_eq!(code(&["--define=LIGHTS=4"]), 2);
    place.write("landfall.toml", "include = [\"lib\"]\ndefine = [\"LIGHTS=4\"]\n");
    assert_eq!(code(&["--define", "LIGHTS=3"]), 0);
    place.write("landfall.toml", "");
    assert_eq!(code(&["--define", "LIGHTS=3", "-I", "lib"]), 0);
}

#[test]
fn a_target_says_what_glsl_is_read_as() {
    let place = Place::new("config-target");
    let text = "#version 450\n#ifndef VULKAN\n#error not for OpenGL\n#endif\nvoid main() {}\n";
    place.write("a.frag", text);
    let code = |arguments: &[&str]| {
        place.run(&[&["check", "a.frag", "-A", "all"], arguments].concat()).code
    };
    assert_eq!(code(&["--target", "gl33"]), 2);
    assert_eq!(code(&["--target", "vulkan"]), 0);
    assert_eq!(code(&["--target", "vulkan", "--target", "webgpu"]), 0);
    place.write("landfall.toml", "api = \"vulkan\"\ntargets = [\"gles30\"]\n");
    assert_eq!(code(&[]), 0, "`api` says it before `targets` do");
    assert_eq!(code(&["--target", "opengl"]), 2);
    assert_eq!(code(&["--target", "metal"]), 2);
}

#[test]
fn a_byte_order_mark_and_carriage_returns_do_not_matter() {
    let place = Place::new("config-crlf");
    let text = "\u{feff}# bom and carriage returns\r\n[levels]\r\nunused-allow = \"deny\"\r\n";
    place.write("landfall.toml", text).write("a.frag", idle());
    assert_eq!(place.run(&["check"]).code, 1);
    fs::remove_file(place.0.join("landfall.toml")).unwrap();
    assert_eq!(place.run(&["check", "--no-config"]).code, 0);
}

#[test]
fn the_example_has_every_key_and_is_taken() {
    let place = Place::new("config-example");
    let example = fs::read_to_string("src/bin/landfall/config/example.toml").unwrap();
    place.write("landfall.toml", &example).write("shaders/a.frag", CLEAN);
    place.write("src/lights.rs", "#[repr(C)] struct PointLight { pos: [f32; 4] }\n");
    let ran = place.run(&["check", "-A", "all"]);
    assert_eq!(ran.code, 0, "{}\n{}", ran.out, ran.err);
    // An unknown key is answered with the known ones, as long as none is near.
    let ran = place.write("landfall.toml", "xyzxyz = 1").run(&["check"]);
    let known = ran.err.lines().find_map(|line| line.split_once(" has `")).unwrap().1;
    for key in known.trim_end_matches('`').split("`, `") {
        assert!(
            example.contains(&format!("\n{key} = ")) || example.contains(&format!("[{key}]")),
            "{key}"
        );
    }
}
