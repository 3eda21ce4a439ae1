//! The configuration: where it is found, what it says, and what is said about it.

use std::fs;

use snapbox::str;

use crate::cli_check::place::{CLEAN, idle};
use crate::support::command::{Place, Ran};

#[test]
fn every_fault_of_a_configuration_is_told_with_its_place_and_a_remedy() {
    let place = Place::new("check-config-faults");
    place.write("a.frag", CLEAN);
    let table = |rest: &str| format!("[[table]]\nblock = \"Light\"\n{rest}\n");
    let group = |rest: &str| format!("[[mirror-group]]\nname = \"g\"\n{rest}\n");
    let cases = [
        (
            "lokcs = \"x\"",
            str![[r#"
error[unknown-key]: the configuration has no key `lokcs`
 --> landfall.toml:1:1
  |
1 | lokcs = "x"
  | ^^^^^
  |
  = help: did you mean `locks`?


"#]],
        ),
        (
            "mirror_group = []",
            str![[r#"
error[unknown-key]: the configuration has no key `mirror_group`
 --> landfall.toml:1:1
  |
1 | mirror_group = []
  | ^^^^^^^^^^^^
  |
  = help: did you mean `mirror-group`?


"#]],
        ),
        (
            "colour = 1",
            str![[r#"
error[unknown-key]: the configuration has no key `colour`
 --> landfall.toml:1:1
  |
1 | colour = 1
  | ^^^^^^
  |
  = help: the configuration has `targets`, `api`, `rules`, `levels`, `path-levels`, `permutations`, `variants`, `mirror-group`, `table`, `rust-mirror`, `compiled`, `prove`, `paths`, `exclude`, `locks`, `cache-dir`, `baseline`, `define`, `features`, `prelude`, `include`, `override`, `gather`, `rename`, `types`, `c-types`, `derive`, `bindings`, `assert`, `policy`, `path-policy`


"#]],
        ),
        (
            "paths = \"shaders\"",
            str![[r#"
error[wrong-type]: `paths` is a string, not an array of strings
 --> landfall.toml:1:9
  |
1 | paths = "shaders"
  |         ^^^^^^^^^
  |
  = help: write `paths = ["shaders"]`


"#]],
        ),
        (
            "paths = [1]",
            str![[r#"
error[wrong-type]: `paths` contains an integer, but takes strings only
 --> landfall.toml:1:10
  |
1 | paths = [1]
  |          ^
  |
  = help: write `"1"`


"#]],
        ),
        (
            "locks = 3",
            str![[r#"
error[wrong-type]: `locks` is an integer, not a string
 --> landfall.toml:1:9
  |
1 | locks = 3
  |         ^
  |
  = help: write `locks = "3"`


"#]],
        ),
        (
            "gather = \"yes\"",
            str![[r#"
error[wrong-type]: `gather` is a string, not true or false
 --> landfall.toml:1:10
  |
1 | gather = "yes"
  |          ^^^^^
  |
  = help: write `gather = true`


"#]],
        ),
        (
            "exclude = [\"a\", \"b[\"]",
            str![[r#"
error[bad-glob]: `b[` is not a glob: a `[` is not closed by a `]`
 --> landfall.toml:1:17
  |
1 | exclude = ["a", "b["]
  |                 ^^^^
  |
  = help: escape literal `[`, `{`, `*` and `?` with `\`


"#]],
        ),
        (
            "define = [\"3D\"]",
            str![[r#"
error[wrong-value]: `3D` cannot be parsed
 --> landfall.toml:1:11
  |
1 | define = ["3D"]
  |           ^^^^
  |
  = help: a macro is NAME or NAME=TEXT; names consist of letters, digits and _


"#]],
        ),
        (
            "override = [\"N\"]",
            str![[r#"
error[wrong-value]: `N` cannot be parsed
 --> landfall.toml:1:13
  |
1 | override = ["N"]
  |             ^^^
  |
  = help: expected NAME=VALUE


"#]],
        ),
        (
            "rules = \"std14O\"",
            str![[r#"
error[wrong-value]: unknown rules `std14O`
 --> landfall.toml:1:9
  |
1 | rules = "std14O"
  |         ^^^^^^^^
  |
  = help: did you mean `std140`?


"#]],
        ),
        (
            "api = \"metal\"",
            str![[r#"
error[wrong-value]: unknown api `metal`
 --> landfall.toml:1:7
  |
1 | api = "metal"
  |       ^^^^^^^
  |
  = help: known are `opengl`, `vulkan`


"#]],
        ),
        (
            "targets = [\"gl33\", \"webgl\"]",
            str![[r#"
error[unknown-target]: unknown target `webgl`
 --> landfall.toml:1:20
  |
1 | targets = ["gl33", "webgl"]
  |                    ^^^^^^^
  |
  = help: did you mean `webgl2`?


"#]],
        ),
        (
            "permutations = [\"A\"]",
            str![[r#"
error[wrong-type]: `permutations` is an array, not an array of arrays of strings
 --> landfall.toml:1:16
  |
1 | permutations = ["A"]
  |                ^^^^^
  |
  = help: write `permutations = [["SHADOWS=1"], ["SHADOWS=2"]]`


"#]],
        ),
        (
            "permutations = [[\"A=1\", \"=\"]]",
            str![[r#"
error[wrong-value]: `=` cannot be parsed
 --> landfall.toml:1:25
  |
1 | permutations = [["A=1", "="]]
  |                         ^^^
  |
  = help: a macro is NAME or NAME=TEXT; names consist of letters, digits and _


"#]],
        ),
        (
            "[levels]\nstale-coment = \"warn\"",
            str![[r#"
error[unknown-lint]: there is no lint `stale-coment`
 --> landfall.toml:2:1
  |
2 | stale-coment = "warn"
  | ^^^^^^^^^^^^
  |
  = help: did you mean `stale-comment`?


"#]],
        ),
        (
            "[levels]\nstale-comment = \"denied\"",
            str![[r#"
error[wrong-value]: unknown level `denied`
 --> landfall.toml:2:17
  |
2 | stale-comment = "denied"
  |                 ^^^^^^^^
  |
  = help: known are `allow`, `warn`, `deny`


"#]],
        ),
        (
            "[levels]\nstale-comment = 1",
            str![[r#"
error[wrong-type]: the level of `stale-comment` is an integer, not a string
 --> landfall.toml:2:17
  |
2 | stale-comment = 1
  |                 ^
  |
  = help: write `"allow"`, `"warn"` or `"deny"`


"#]],
        ),
        (
            "levels = 1",
            str![[r#"
error[wrong-type]: `levels` is an integer, not a table
 --> landfall.toml:1:10
  |
1 | levels = 1
  |          ^
  |
  = help: write `levels = { layout-drift = "deny" }`


"#]],
        ),
        (
            "table = 1",
            str![[r#"
error[wrong-type]: `table` is an integer, not an array of tables
 --> landfall.toml:1:9
  |
1 | table = 1
  |         ^
  |
  = help: write it under `[[table]]`


"#]],
        ),
        (
            "[[table]]\nsize = 1",
            str![[r#"
error[missing-key]: `[[table]]` has no `block`
 --> landfall.toml:1:1
  |
1 | [[table]]
  | ^^^^^^^^^
  |
  = help: add `block = "…"`


"#]],
        ),
        (
            &table("size = \"48 * x\""),
            str![[r#"
error[wrong-value]: `size` is not a number of bytes: `x` is not a number
 --> landfall.toml:3:14
  |
3 | size = "48 * x"
  |              ^
  |
  = help: write arithmetic such as `48 * 128 + 4`, `+ - * ( )` and hex


"#]],
        ),
        (
            &table("size = \"4 - 8\""),
            str![[r#"
error[wrong-value]: `size` is not a number of bytes: `4 - 8` is negative
 --> landfall.toml:3:9
  |
3 | size = "4 - 8"
  |         ^^^^^
  |
  = help: write arithmetic such as `48 * 128 + 4`, `+ - * ( )` and hex


"#]],
        ),
        (
            &table("size = -1"),
            str![[r#"
error[wrong-value]: `size` is -1, which is not a number of bytes
 --> landfall.toml:3:8
  |
3 | size = -1
  |        ^^
  |
  = help: write a number from 0 to 2^63 - 1


"#]],
        ),
        (
            &table("size = 1.5"),
            str![[r#"
error[wrong-type]: `size` is a float, not a number of bytes
 --> landfall.toml:3:8
  |
3 | size = 1.5
  |        ^^^
  |
  = help: write a number, or arithmetic such as `"48 * 128 + 4"`


"#]],
        ),
        (
            &table("offsets = { \"data[0].pos\" = true }"),
            str![[r#"
error[wrong-type]: `data[0].pos` is a boolean, not a number of bytes
 --> landfall.toml:3:29
  |
3 | offsets = { "data[0].pos" = true }
  |                             ^^^^
  |
  = help: write a number, or arithmetic such as `"48 * 128 + 4"`


"#]],
        ),
        (
            &table("size = 1\nfile = \"{a\""),
            str![[r#"
error[bad-glob]: `{a` is not a glob: a `{` is not closed by a `}`
 --> landfall.toml:4:8
  |
4 | file = "{a"
  |        ^^^^
  |
  = help: escape literal `[`, `{`, `*` and `?` with `\`


"#]],
        ),
        (
            &table("size = 1\nsizes = 1"),
            str![[r#"
error[unknown-key]: `[[table]]` has no key `sizes`
 --> landfall.toml:4:1
  |
4 | sizes = 1
  | ^^^^^
  |
  = help: did you mean `size`?


"#]],
        ),
        (
            &group("copies = [{ block = \"a\" }]"),
            str![[r#"
error[missing-key]: a mirror group with fewer than two copies compares nothing
 --> landfall.toml:1:1
  |
1 | [[mirror-group]]
  | ^^^^^^^^^^^^^^^^
  |
  = help: add the other copies to `copies`


"#]],
        ),
        (
            &group("copies = [{ file = \"a\" }, { block = \"b\" }]"),
            str![[r#"
error[missing-key]: `copies` has no `block`
 --> landfall.toml:3:11
  |
3 | copies = [{ file = "a" }, { block = "b" }]
  |           ^^^^^^^^^^^^^^
  |
  = help: add `block = "…"`


"#]],
        ),
        (
            &group("copies = [\"a\", \"b\"]"),
            str![[r#"
error[wrong-type]: `copies` is an array, not an array of tables
 --> landfall.toml:3:10
  |
3 | copies = ["a", "b"]
  |          ^^^^^^^^^^
  |
  = help: write it under `[[copies]]`


"#]],
        ),
        (
            "[[rust-mirror]]\nfile = \"a.rs\"\nblock = \"A\"",
            str![[r#"
error[missing-key]: `[[rust-mirror]]` has no `structure`
 --> landfall.toml:1:1
  |
1 | [[rust-mirror]]
  | ^^^^^^^^^^^^^^^
  |
  = help: add `structure = "…"`


"#]],
        ),
        (
            "paths = [",
            str![[r#"
error[syntax]: unclosed array, expected `]`
 --> landfall.toml:1:10
  |
1 | paths = [
  |          ^


"#]],
        ),
        (
            "paths = []\npaths = []",
            str![[r#"
error[syntax]: duplicate key
 --> landfall.toml:2:1
  |
2 | paths = []
  | ^^^^^


"#]],
        ),
    ];
    for (text, said) in cases {
        place.write("landfall.toml", text).run(&["check"]).code(2).stdout_eq("").stderr_eq(said);
    }
}

#[test]
fn all_faults_are_told_at_once_and_hostile_files_get_one_answer() {
    let place = Place::new("check-config-hostile");
    place.write("a.frag", CLEAN).write("landfall.toml", "a = 1\nb = 2\ngather = 3\n");
    assert_eq!(place.run(&["check"]).err.matches("error[").count(), 3);
    for text in ["[".repeat(100_000), format!("x = {}", "[".repeat(100_000)), "é\0".to_string()] {
        let ran = place.write("landfall.toml", &text).run(&["check"]);
        assert_eq!(ran.code, 2, "{}", ran.err);
    }
    let ran = place.write("landfall.toml", b"\xff\xfea").run(&["check"]);
    ran.code(2).stderr_eq(str![[r#"
error[unreadable-file]: `landfall.toml` is UTF-16, but read as UTF-8
  |
  = help: save the file as UTF-8


"#]]);
}

#[test]
fn the_nearest_configuration_above_what_is_checked_holds() {
    let place = Place::new("check-config-found");
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
    ran.code(2).stderr_eq(str![[r#"
error[cannot-run]: `sub/landfall.toml` conflicts with `.landfall.toml`: only one may exist
  |
  = help: remove one, or select one with `--config`


"#]]);
    let ran = place.run(&["check", "--config", "gone.toml"]);
    ran.code(2).stderr_eq(str![[r#"
error[unreadable-file]: `gone.toml` cannot be read: no such file or directory


"#]]);
}

#[test]
fn paths_are_relative_to_the_configuration_wherever_it_is_run() {
    let place = Place::new("check-config-relative");
    place.write("landfall.toml", "paths = [\"shaders\"]\nexclude = [\"vendor\", \"gen/*.frag\"]\n");
    place.write("shaders/a.frag", idle()).write("shaders/vendor/b.frag", idle());
    place.write("other/c.frag", idle()).write("work/d.frag", CLEAN).write("gen/e.frag", idle());
    assert_eq!(place.found(&[]), ["unused-allow shaders/a.frag:4"]);
    assert_eq!(place.found(&["."]).len(), 2, "what is named is checked, but for what is left out");
    assert_eq!(place.found(&["shaders/vendor/b.frag"]), [""; 0], "named or not");
    assert_eq!(place.found(&["--exclude", "a.*"]), [""; 0]);
    let mut below = place.command(&["check", "-f", "short"]);
    let ran = Ran::of(below.current_dir(place.0.join("work")).output().unwrap());
    ran.stdout_eq(str![[r#"
../shaders/a.frag:4:36: warning[unused-allow] `allow(stale-comment)` suppresses nothing in line 4

"#]]);
    let spelled = place.0.join("work/../shaders/a.frag").display().to_string();
    assert_eq!(place.found(&[&spelled]), ["unused-allow shaders/a.frag:4"]);
    let ran = place.run(&["check", "--exclude", "a["]);
    ran.code(2).stderr_eq(str![[r#"
error[cannot-run]: `a[` is not a glob: a `[` is not closed by a `]`
  |
  = help: escape `[`, `{`, `*` and `?` with `\`


"#]]);
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
    let place = Place::new("check-config-read");
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
    let place = Place::new("check-config-target");
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
    let place = Place::new("check-config-crlf");
    let text = "\u{feff}# bom and carriage returns\r\n[levels]\r\nunused-allow = \"deny\"\r\n";
    place.write("landfall.toml", text).write("a.frag", idle());
    assert_eq!(place.run(&["check"]).code, 1);
    fs::remove_file(place.0.join("landfall.toml")).unwrap();
    assert_eq!(place.run(&["check", "--no-config"]).code, 0);
}

#[test]
fn the_example_has_every_key_and_is_taken() {
    let place = Place::new("check-config-example");
    let example = fs::read_to_string("crates/landfall-check/src/config/example.toml").unwrap();
    place.write("landfall.toml", &example).write("shaders/a.frag", CLEAN);
    place.write("src/lights.rs", "#[repr(C)] struct PointLight { pos: [f32; 4] }\n");
    place.write("landfall-baseline.json", "{\"schema_version\": 1, \"findings\": []}");
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

#[test]
fn the_name_of_a_folder_is_no_glob() {
    let place = Place::new("check-brackets");
    let levels = "[[path-levels]]\nfile = \"*.frag\"\nlevels = { mat3-padding = \"deny\" }\n";
    place.write("a[b{/landfall.toml", levels).write(
        "a[b{/x.frag",
        "#version 450\nlayout(binding = 0) uniform B { mat3 normal; };\nvoid main() {}\n",
    );
    let ran = place.run(&["check", "--config", "a[b{/landfall.toml", "a[b{", "-f", "short"]);
    assert!(ran.out.contains("error[mat3-padding]"), "{}{}", ran.out, ran.err);
    assert_eq!(ran.code, 1);
}
