//! `landfall encode` and `landfall decode` as a user meets them: the bytes of a block to values
//! and back, what is said of input that is wrong, exit codes, files written.

mod corpus;
mod place;

use std::fs;
use std::process::Stdio;

use place::{LIGHTS, place};
use serde_json::Value;
use snapbox::str;

use crate::support::command::{Place, Ran, golden};

const TAIL: &str = "#version 430
layout(std430) buffer B { uint n; float x[]; };
";

/// What lies in the folder, by name.
fn names(place: &Place) -> Vec<String> {
    let entries = fs::read_dir(&place.0).unwrap();
    let mut names: Vec<String> =
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn values_land_where_the_layout_says() {
    let place = place("land");
    let json = r#"{"data[3].color":[1,2,3],"u_lights.data[3].pos.y":4,"actually_used_count":128}"#;
    let ran = place.run_with_stdin(&["encode", "a.frag"], json);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let mut wanted = vec![0u8; 6160];
    for (at, value) in [(160, 1.0f32), (164, 2.0), (168, 3.0), (148, 4.0)] {
        wanted[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }
    wanted[6144] = 128;
    assert!(ran.bytes == wanted);
    // The same from a file with a byte-order mark, to a file.
    place.write("v.json", format!("\u{feff}{json}"));
    let ran = place.run(&["encode", "a.frag", "v.json", "-b", "u_lights", "--out", "o/v.bin"]);
    let said = "made the directory o\n";
    assert_eq!((ran.code, ran.out.as_str(), ran.err.as_str()), (0, "", said));
    assert!(place.bytes("o/v.bin") == wanted);
}

#[test]
fn a_table_has_a_row_for_each_element() {
    let place = place("table");
    place.write("v.json", r#"{"data[3].color":[1,0.1,-3e30],"actually_used_count":-7}"#);
    place.run(&["encode", "a.frag", "v.json", "-o", "v.bin"]);
    let ran = place.run(&["decode", "a.frag", "v.bin"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let lines: Vec<&str> = ran.out.lines().collect();
    assert_eq!(lines.len(), 2 + 128 * 6 + 1);
    // The heading, the light with a colour, and the last member.
    let shown = [&lines[..2], &lines[2 + 3 * 6..2 + 4 * 6], &lines[770..]].concat().join("\n");
    golden().eq(
        shown,
        str![[r#"
uniform PointLightBlock u_lights · std140 · 6,160 bytes
  offset  type   path                 value
     144  vec3   data[3].pos          0.0 0.0 0.0
     160  vec3   data[3].color        1.0 0.1 -3e30
     172  float  data[3].intensity    0.0
     176  float  data[3].constant     0.0
     180  float  data[3].linear       0.0
     184  float  data[3].quadratic    0.0
    6144  int    actually_used_count  -7
"#]],
    );
    assert!(place.run(&["decode", "a.frag", "v.bin", "--color", "always"]).out.contains("\x1b["));
}

#[test]
fn only_keeps_what_a_path_names_and_what_is_odd_there() {
    let place = place("only");
    let mut bytes = vec![0u8; 6160];
    bytes[13] = 1; // padding of data[0]
    bytes[3 * 48 + 44] = 2; // padding of data[3]
    bytes[4 * 48 + 28..][..4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    place.write("v.bin", &bytes);
    let only =
        |path, format| place.run(&["decode", "a.frag", "v.bin", "-f", format, "--only", path]);
    let ran = only("data[3]", "table");
    assert_eq!(ran.code, 1);
    assert_eq!(ran.out.lines().count(), 2 + 6 + 1);
    ran.stdout_eq(str![[r#"
uniform PointLightBlock u_lights · std140 · 6,160 bytes
  offset  type   path               value
     144  vec3   data[3].pos        0.0 0.0 0.0
     160  vec3   data[3].color      0.0 0.0 0.0
     172  float  data[3].intensity  0.0
     176  float  data[3].constant   0.0
     180  float  data[3].linear     0.0
     184  float  data[3].quadratic  0.0
     188         -- padding         02  <- not zero

"#]]);
    assert_eq!(ran.err.matches("warning[").count(), 1, "{}", ran.err);
    assert_eq!(only("data[1]", "table").code, 0);
    assert_eq!(only("data[3].color.y", "table").out.lines().count(), 3);
    let json = only("data[4]", "json");
    assert_eq!(json.code, 1);
    let again = place.run_with_stdin(&["encode", "a.frag"], &json.bytes);
    assert_eq!(again.bytes[4 * 48..5 * 48], bytes[4 * 48..5 * 48]);
    only("data[128]", "table").code(2).stdout_eq("").stderr_eq(str![[r#"
error[index-out-of-range]: index 128 in `data[128]` is out of range: the length is 128
 --> v.bin


"#]]);
    only("data[1].colr", "table").code(2).stdout_eq("").stderr_eq(str![[r#"
error[unknown-member]: no member `colr` in `data[1]` (path `data[1].colr`)
 --> v.bin
  |
  = help: did you mean `data[1].color`?


"#]]);
    only("data[", "table").code(2).stdout_eq("").stderr_eq(str![[r#"
error[malformed-path]: `data[` is not a path: expected a number at byte 5
 --> v.bin


"#]]);
}

#[test]
fn what_looks_wrong_is_flagged_in_its_row_and_on_stderr() {
    let place = place("odd");
    let shader = "layout(std430) uniform B { vec3 a; mat2 m; bool b; float c; };\n";
    let extension = "#extension GL_EXT_scalar_block_layout : require";
    place.write("b.frag", format!("#version 450\n{extension}\n{shader}"));
    let mut bytes = vec![0u8; 48];
    bytes[4..8].copy_from_slice(&f32::NAN.to_le_bytes());
    bytes[8..12].copy_from_slice(&f32::NEG_INFINITY.to_le_bytes());
    bytes[15] = 0xee;
    bytes[32] = 2;
    bytes[40..48].fill(0xff);
    let arguments = ["decode", "b.frag", "-", "--rules", "std430"];
    let ran = place.run_with_stdin(&arguments, &bytes);
    assert_eq!(ran.code, 1);
    let rows: Vec<&str> = ran.out.lines().skip(2).collect();
    assert_eq!(
        rows,
        [
            "       0  vec3   a           0.0 nan -inf  <- not a number, infinite",
            "      15         -- padding  ee  <- not zero",
            "      16  mat2   m           0.0 0.0 | 0.0 0.0",
            "      32  bool   b           2  <- neither 0 nor 1",
            "      36  float  c           0.0",
            "      40         -- padding  ff ff ff ff ff ff ff ff  <- not zero",
        ]
    );
    ran.stderr_eq(str![[r#"
warning[not-a-number]: `a.y` at byte 4 is not a number: nan
 --> <stdin>

warning[infinite]: `a.z` at byte 8 is infinite: -inf
 --> <stdin>

warning[nonzero-padding]: padding at byte 15 is not zero: ee, between `a` and `m`
 --> <stdin>

warning[odd-bool]: `b` at byte 32 is a bool, but neither 0 nor 1: 2
 --> <stdin>

warning[nonzero-padding]: padding at byte 40 is not zero: ff ff ff ff ff ff ff ff, after `c`
 --> <stdin>


"#]]);
    let quiet = place.run_with_stdin(&["-q", "decode", "b.frag", "-"], &bytes);
    assert_eq!((quiet.code, quiet.err.as_str()), (1, ""));
    let json = place.run_with_stdin(&["decode", "b.frag", "-", "-f", "json"], &bytes);
    assert_eq!(json.code, 1);
    for line in json.err.lines() {
        let found: Value = serde_json::from_str(line).unwrap();
        assert_eq!((&found["severity"], &found["path"]), (&"warning".into(), &"<stdin>".into()));
    }
    assert_eq!(json.err.lines().count(), 5);
}

#[test]
fn findings_past_what_is_read_are_counted() {
    let place = place("many");
    let ran = place.run_with_stdin(&["decode", "a.frag", "-"], [0xff; 6160]);
    assert_eq!(ran.code, 1);
    // 10 components and 2 gaps a light, and the block's tail: 128 × 12 + 1, less 99.
    assert_eq!(ran.err.matches("warning[").count(), 100);
    let words = "warning[more-findings]: 1,438 more findings in `<stdin>`";
    assert!(ran.err.contains(words), "{words}\n{}", &ran.err[ran.err.len() - 200..]);
    let json = place.run_with_stdin(&["decode", "a.frag", "-", "-f", "json"], [0xff; 6160]);
    assert_eq!(json.err.lines().count(), 1001);
}

#[test]
fn hex_names_every_word() {
    let place = place("hex");
    let json = r#"{"data[0].pos":[1,2,3],"actually_used_count":2}"#;
    let ran = place.run_with_stdin(&["encode", "a.frag", "--hex=16"], json);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let lines: Vec<&str> = ran.out.lines().collect();
    assert_eq!(lines.len(), 1 + 6160 / 16);
    let wanted =
        "       0  00 00 80 3f  00 00 00 40  00 00 40 40  00 00 00 00  data[0].pos.x  .y  .z  --";
    assert_eq!(lines[1], wanted);
    assert!(lines[385].ends_with("  actually_used_count  --  --  --"), "{}", lines[385]);
    let to_file = place.run_with_stdin(&["encode", "a.frag", "--hex=16", "--out", "v.txt"], json);
    assert_eq!((to_file.code, to_file.out.as_str()), (0, ""));
    assert_eq!(place.bytes("v.txt"), ran.bytes);
    // Without a number, as many bytes as leave room for the names.
    let ran = place.run_with_stdin(&["encode", "a.frag", "--hex"], json);
    let lines: Vec<&str> = ran.out.lines().collect();
    assert_eq!(lines.len(), 1 + 6160 / 8);
    assert_eq!(lines[1], "       0  00 00 80 3f  00 00 00 40  data[0].pos.x  .y");
    assert!(lines.iter().all(|line| line.len() <= 80));
}

#[test]
fn the_block_is_asked_for_when_there_are_several() {
    let place = place("which");
    place.write("two.frag", format!("{LIGHTS}layout(std140) uniform View {{ vec4 eye; }};\n"));
    place.write("loose.frag", "#version 330\nuniform vec3 eye;\n");
    place.write("none.frag", "#version 330\nvoid main() {}\n");
    let same = "struct L { a: vec4<f32> }
@group(0) @binding(0) var<uniform> one: L;
@group(0) @binding(1) var<uniform> two: L;\n";
    place.write("same.wgsl", same);
    let run =
        |arguments: &[&str]| place.run_with_stdin(&[&["encode"], arguments, &["-"]].concat(), "{}");
    run(&["two.frag"]).code(2).stdout_eq("").stderr_eq(str![[r#"
error[which-block]: `two.frag` has 2 blocks
  |
  = help: select one with `--block`: `PointLightBlock`, `View`


"#]]);
    assert_eq!(run(&["two.frag", "-b", "View"]).bytes.len(), 16);
    run(&["two.frag", "-b", "Veiw"]).code(2).stdout_eq("").stderr_eq(str![[r#"
error[unknown-block]: no block named `Veiw` in `two.frag`
  |
  = help: available: `PointLightBlock`, `View`


"#]]);
    run(&["loose.frag"]).code(2).stdout_eq("").stderr_eq(str![[r#"
error[no-bytes]: no block of `loose.frag` has any bytes
  |
  = help: loose uniforms are uploaded one by one; `--gather` lays them out as a block


"#]]);
    assert_eq!(run(&["loose.frag", "--gather"]).bytes.len(), 16);
    run(&["same.wgsl", "-b", "L"]).code(2).stdout_eq("").stderr_eq(str![[r#"
error[ambiguous-block]: 2 blocks of `same.wgsl` are named `L`
  |
  = help: name one by its instance: `one`, `two`


"#]]);
    assert_eq!(run(&["same.wgsl", "-b", "two"]).bytes.len(), 16);
    let none = run(&["none.frag"]);
    none.code(2).stdout_eq("").stderr_eq(str![[r#"
error[no-blocks]: no blocks and no loose uniforms in `none.frag`


"#]]);
}

#[test]
fn defines_overrides_and_rules_change_the_bytes() {
    let place = place("options");
    place.write("d.frag", "#version 330\nlayout(std140) uniform B { float x[N]; };\n");
    let len = |arguments: &[&str]| {
        let ran = place.run_with_stdin(&[&["encode"], arguments].concat(), "{}");
        assert_eq!(ran.code, 0, "{}", ran.err);
        ran.bytes.len()
    };
    assert_eq!(len(&["d.frag", "-D", "N=3"]), 48);
    assert_eq!(len(&["d.frag", "-D", "N=3", "--rules", "std430"]), 12);
    place.write(
        "o.wgsl",
        "override n: u32;\n@group(0) @binding(0) var<storage> b: array<f32, 4>;\n",
    );
    assert_eq!(len(&["o.wgsl", "-O", "n=2"]), 16);
}

#[test]
fn values_that_are_wrong_are_refused_with_their_place() {
    let place = place("values");
    for (json, said) in [
        (
            "",
            str![[r#"
error[empty-input]: `<stdin>` is empty
  |
  = help: write an object of the block's members; `{}` sets all of them to zero


"#]],
        ),
        (
            " \n",
            str![[r#"
error[empty-input]: `<stdin>` is empty
  |
  = help: write an object of the block's members; `{}` sets all of them to zero


"#]],
        ),
        (
            "{\n  \"data\": [1,\n}",
            str![[r#"
error[json-syntax]: malformed JSON: expected a value
 --> <stdin>:3:1
  |
3 | }
  | ^


"#]],
        ),
        (
            "{\"data\": [",
            str![[r#"
error[json-syntax]: malformed JSON: the text ends before the value is complete
 --> <stdin>:1:11
  |
1 | {"data": [
  |           ^


"#]],
        ),
        (
            "{\"a\":1,\"a\":1}",
            str![[r#"
error[json-syntax]: malformed JSON: `a` is given twice
 --> <stdin>:1:8
  |
1 | {"a":1,"a":1}
  |        ^


"#]],
        ),
        (
            "[]",
            str![[r#"
error[wrong-value]: the block: expected an object of members for `PointLightBlock`, found an array of 0 values
 --> <stdin>:1:1
  |
1 | []
  | ^^


"#]],
        ),
        (
            r#"{"dta":[]}"#,
            str![[r#"
error[unknown-member]: no member `dta` in the block (path `dta`)
 --> <stdin>:1:2
  |
1 | {"dta":[]}
  |  ^^^^^
  |
  = help: did you mean `data`?


"#]],
        ),
        (
            r#"{"data":[{"colour":1}]}"#,
            str![[r#"
error[unknown-member]: no member `colour` in `data[0]` (path `data[0].colour`)
 --> <stdin>:1:11
  |
1 | {"data":[{"colour":1}]}
  |           ^^^^^^^^
  |
  = help: did you mean `data[0].color`?


"#]],
        ),
        (
            r#"{"data[128].pos":1}"#,
            str![[r#"
error[index-out-of-range]: index 128 in `data[128].pos` is out of range: the length is 128
 --> <stdin>:1:2
  |
1 | {"data[128].pos":1}
  |  ^^^^^^^^^^^^^^^


"#]],
        ),
        (
            r#"{"data":[{"pos":[1,2]}]}"#,
            str![[r#"
error[wrong-count]: `data[0].pos`: `vec3` has 3 elements, not 2
 --> <stdin>:1:17
  |
1 | {"data":[{"pos":[1,2]}]}
  |                 ^^^^^


"#]],
        ),
        (
            r#"{"actually_used_count":1.5}"#,
            str![[r#"
error[wrong-value]: `actually_used_count`: expected an integer for `int`, found 1.5
 --> <stdin>:1:24
  |
1 | {"actually_used_count":1.5}
  |                        ^^^


"#]],
        ),
        (
            r#"{"actually_used_count":2147483648}"#,
            str![[r#"
error[value-out-of-range]: `actually_used_count`: 2147483648 does not fit `int`
 --> <stdin>:1:24
  |
1 | {"actually_used_count":2147483648}
  |                        ^^^^^^^^^^


"#]],
        ),
        (
            r#"{"data[0].pos":[1,2,3],"data":[{"pos.x":1}]}"#,
            str![[r#"
error[given-twice]: `data[0].pos[0]`: its value is given twice
 --> <stdin>:1:17
  |
1 | {"data[0].pos":[1,2,3],"data":[{"pos.x":1}]}
  |                 ^


"#]],
        ),
    ] {
        let ran = place.run_with_stdin(&["encode", "a.frag", "--out", "v.bin"], json);
        ran.code(2).stdout_eq("").stderr_eq(said);
    }
    let places = [
        ("{\n \"dta\": []}", "2:2"),
        ("{\"data\": [{},\n  {\"colour\": 1}]}", "2:4"),
        ("{\"data\": [\n{\"pos\": [1,\n  2]}]}", "2:9"),
        ("{\"data[3].pos\": [1, 2,\n    true]}", "2:5"),
        ("{\"ä\": 1}", "1:2"),
        ("{\"data\":[{},{\"data[3]\":\n0}]}", "1:14"),
        ("{\"data[200]\": 0}", "1:2"),
    ];
    for (json, at) in places {
        let ran = place.run_with_stdin(&["encode", "a.frag"], json);
        assert!(ran.err.contains(&format!(" --> <stdin>:{at}\n")), "{at} {}", ran.err);
    }
    let strict = ["encode", "a.frag", "--missing", "error"];
    place.run_with_stdin(&strict, "{}").code(2).stdout_eq("").stderr_eq(str![[r#"
error[missing-member]: `data[0].pos` is missing
 --> <stdin>
  |
  = help: add it, or set missing members to zero with `--missing zero`


"#]]);
    place.run_with_stdin(&["encode", "a.frag"], b"{\"\xff\"").code(2).stdout_eq("").stderr_eq(
        str![[r#"
error[unreadable-file]: `<stdin>` is not UTF-8: byte 0xff at line 1, column 3
  |
  = help: save the file as UTF-8


"#]],
    );
    assert_eq!(names(&place), ["a.frag", "landfall.toml"]);
}

#[test]
fn bytes_of_the_wrong_length_are_refused_with_both_numbers() {
    let place = place("length");
    place.write("tail.comp", TAIL);
    let run = |bytes: &[u8], more: &[&str]| {
        place.run_with_stdin(&[&["decode", "a.frag", "-"], more].concat(), bytes)
    };
    run(&[0; 160], &[]).code(2).stdout_eq("").stderr_eq(str![[r#"
error[wrong-length]: `PointLightBlock` has 6,160 bytes, but 160 bytes were given: they end before or in `data[3].color`
 --> <stdin>


"#]]);
    run(&[], &[]).code(2).stdout_eq("").stderr_eq(str![[r#"
error[wrong-length]: `PointLightBlock` has 6,160 bytes, but 0 bytes were given: they end before or in `data[0].pos`
 --> <stdin>


"#]]);
    run(&[0; 6164], &[]).code(2).stdout_eq("").stderr_eq(str![[r#"
error[wrong-length]: `PointLightBlock` has 6,160 bytes, but 6,164 bytes were given
 --> <stdin>
  |
  = help: `--offset N` decodes the 6,160 bytes from byte N of a longer dump


"#]]);
    let mut dump = vec![0xffu8; 7000];
    dump[256..256 + 6160].fill(0);
    assert_eq!(run(&dump, &["--offset", "0x100"]).code, 0);
    assert_eq!(run(&dump, &["--offset", "257"]).code, 1);
    assert_eq!(run(&dump, &["--offset", "840"]).code, 1);
    run(&dump, &["--offset", "853"]).code(2).stdout_eq("").stderr_eq(str![[r#"
error[wrong-length]: `PointLightBlock` has 6,160 bytes, but 6,147 bytes were given: they end before or in `actually_used_count`
 --> <stdin>
  |
  = note: `<stdin>` has 7,000 bytes, 6,147 of them from byte 853 on


"#]]);
    run(&dump, &["--offset", "7001"]).code(2).stdout_eq("").stderr_eq(str![[r#"
error[offset-out-of-range]: `<stdin>` has 7,000 bytes, none at offset 7001


"#]]);
    // All members, but not what a buffer must hold.
    let short = run(&[0; 6148], &[]);
    short.code(1).stderr_eq(str![[r#"
warning[odd-length]: 6,148 bytes hold every member of `PointLightBlock`, but a buffer for it must hold 6,160
 --> <stdin>


"#]]);
    let tail = place.run_with_stdin(&["decode", "tail.comp", "-"], [0; 20]);
    tail.code(0).stderr_eq("").stdout_eq(str![[r#"
storage B · std430 · 8 bytes
  offset  type   path  value
       0  uint   n     0
       4  float  x[0]  0.0
       8  float  x[1]  0.0
      12  float  x[2]  0.0
      16  float  x[3]  0.0
  20 bytes hold 4 of `x`

"#]]);
    let odd = place.run_with_stdin(&["decode", "tail.comp", "-"], [0; 21]);
    odd.code(1).stderr_eq(str![[r#"
warning[odd-length]: bytes past the last whole element of `x`: 1
 --> <stdin>


"#]]);
}

#[test]
fn files_that_cannot_be_read_are_one_error() {
    let place = place("unreadable");
    fs::create_dir(place.0.join("dir")).unwrap();
    for command in ["encode", "decode"] {
        let run = |shader, other| place.run(&[command, shader, other]);
        run("a.frag", "gone").code(2).stdout_eq("").stderr_eq(str![[r#"
error[unreadable-file]: `gone` cannot be read: no such file or directory


"#]]);
        run("a.frag", "dir").code(2).stdout_eq("").stderr_eq(str![[r#"
error[unreadable-file]: `dir` is a directory, not a file


"#]]);
        run("gone.frag", "x").code(2).stdout_eq("").stderr_eq(str![[r#"
error[unreadable-file]: `gone.frag` cannot be read: no such file or directory


"#]]);
        run("-", "-").code(2).stdout_eq("").stderr_eq(str![[r#"
error[cannot-run]: `<stdin>` cannot be both the shader and the other input
  |
  = help: name a file for one of them


"#]]);
    }
    place.write("bad.frag", "#version 330\nuniform B { vec33 x; };\nuniform C { float y; };\n");
    let ran = place.run_with_stdin(&["encode", "bad.frag", "--out", "v.bin", "-b", "C"], "{}");
    assert!(ran.code == 2 && !place.0.join("v.bin").exists(), "{}", ran.err);
    let ran = place.run_with_stdin(&["decode", "bad.frag", "-", "-b", "C"], [0; 16]);
    ran.code(2).stdout_eq(str![[r#"
uniform C · std140 · rules not declared: the driver's offsets may differ
    16 bytes
  offset  type   path  value
       0  float  y     0.0

"#]]);
}

#[test]
fn a_place_that_cannot_be_written_is_left_as_it_was() {
    let place = place("out");
    place.write("file", "in the way");
    fs::create_dir(place.0.join("dir")).unwrap();
    for (out, said) in [
        (
            "file/v.bin",
            str![[r#"
error[cannot-write]: `file` cannot be created as a directory: file exists


"#]],
        ),
        (
            "file/deep/v.bin",
            str![[r#"
error[cannot-write]: `file/deep` cannot be created as a directory: not a directory


"#]],
        ),
        (
            "dir",
            str![[r#"
error[cannot-write]: `dir` cannot be written: is a directory


"#]],
        ),
    ] {
        let ran = place.run_with_stdin(&["encode", "a.frag", "--out", out], "{}");
        ran.code(2).stdout_eq("").stderr_eq(said);
    }
    assert_eq!(place.bytes("file"), b"in the way");
    assert_eq!(names(&place), ["a.frag", "dir", "file", "landfall.toml"]);
    assert_eq!(fs::read_dir(place.0.join("dir")).unwrap().count(), 0);
}

#[test]
#[cfg(target_os = "linux")]
fn devices_and_links_stay_what_they_are() {
    let place = place("links");
    place.write("v.bin", "old");
    std::os::unix::fs::symlink("v.bin", place.0.join("link")).unwrap();
    std::os::unix::fs::symlink("/dev/full", place.0.join("full")).unwrap();
    let to = |out| place.run_with_stdin(&["encode", "a.frag", "--out", out], "{}");
    assert_eq!(to("link").code, 0);
    assert!(place.0.join("link").is_symlink() && place.bytes("v.bin").len() == 6160);
    to("full").code(2).stdout_eq("").stderr_eq(str![[r#"
error[cannot-write]: `full` cannot be written: no space left on device


"#]]);
    assert!(place.0.join("full").is_symlink());
    assert_eq!(names(&place), ["a.frag", "full", "landfall.toml", "link", "v.bin"]);
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_one_error_and_a_closed_pipe_is_none() {
    let place = place("pipe");
    place.write("v.json", "{}");
    place.write("v.bin", vec![0; 6160]);
    let encode: &[&str] = &["encode", "a.frag", "v.json"];
    let commands = [
        encode,
        &["encode", "a.frag", "v.json", "--hex"],
        &["decode", "a.frag", "v.bin"],
        &["decode", "a.frag", "v.bin", "-f", "json"],
    ];
    for arguments in commands {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let ran = Ran::of(place.command(arguments).stdout(full).output().unwrap());
        ran.code(2).stdout_eq("").stderr_eq(str![[r#"
error[cannot-write]: `<stdout>` cannot be written: no space left on device


"#]]);
        let mut command = place.command(arguments);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let ran = Ran::of(child.wait_with_output().unwrap());
        assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{arguments:?}");
    }
}
