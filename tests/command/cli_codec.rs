//! `landfall encode` and `landfall decode` as a user meets them: the bytes of a block to values
//! and back, what is said of input that is wrong, exit codes, files written.

mod corpus;
mod place;

use std::fs;
use std::process::Stdio;

use place::{LIGHTS, Place, Ran};
use serde_json::Value;

const TAIL: &str = "#version 430
layout(std430) buffer B { uint n; float x[]; };
";

#[test]
fn values_land_where_the_layout_says() {
    let place = Place::new("land");
    let json = r#"{"data[3].color":[1,2,3],"u_lights.data[3].pos.y":4,"actually_used_count":128}"#;
    let ran = place.run_with(&["encode", "a.frag"], json);
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
    assert_eq!((ran.code, ran.out(), ran.err.as_str()), (0, "", ""));
    assert!(place.read("o/v.bin") == wanted);
}

#[test]
fn a_table_has_a_row_for_each_element() {
    let place = Place::new("table");
    place.write("v.json", r#"{"data[3].color":[1,0.1,-3e30],"actually_used_count":-7}"#);
    place.run(&["encode", "a.frag", "v.json", "-o", "v.bin"]);
    let ran = place.run(&["decode", "a.frag", "v.bin"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let lines: Vec<&str> = ran.out().lines().collect();
    assert_eq!(lines.len(), 2 + 128 * 6 + 1);
    assert_eq!(lines[0], "uniform PointLightBlock u_lights · std140 · 6160 bytes");
    assert_eq!(lines[1], "  offset  type   path                 value");
    assert!(
        lines.contains(&"     160  vec3   data[3].color        1.0 0.1 -3e30"),
        "{}",
        ran.out()
    );
    assert_eq!(lines[770], "    6144  int    actually_used_count  -7");
    assert!(place.run(&["decode", "a.frag", "v.bin", "--color", "always"]).out().contains("\x1b["));
}

#[test]
fn only_keeps_what_a_path_names_and_what_is_odd_there() {
    let place = Place::new("only");
    let mut bytes = vec![0u8; 6160];
    bytes[13] = 1; // padding of data[0]
    bytes[3 * 48 + 44] = 2; // padding of data[3]
    bytes[4 * 48 + 28..][..4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    place.write("v.bin", &bytes);
    let only =
        |path, format| place.run(&["decode", "a.frag", "v.bin", "-f", format, "--only", path]);
    let ran = only("data[3]", "table");
    assert_eq!(ran.code, 1);
    assert_eq!(ran.out().lines().count(), 2 + 6 + 1);
    assert!(ran.out().ends_with("     188         -- padding         02  <- not zero\n"));
    assert_eq!(ran.err.matches("warning[").count(), 1, "{}", ran.err);
    assert_eq!(only("data[1]", "table").code, 0);
    assert_eq!(only("data[3].color.y", "table").out().lines().count(), 3);
    let json = only("data[4]", "json");
    assert_eq!(json.code, 1);
    let again = place.run_with(&["encode", "a.frag"], &json.bytes);
    assert_eq!(again.bytes[4 * 48..5 * 48], bytes[4 * 48..5 * 48]);
    only("data[128]", "table").refuses("index-out-of-range", "the length is 128");
    only("data[1].colr", "table").refuses("unknown-member", "did you mean `data[1].color`?");
    only("data[", "table").refuses("malformed-path", "expected");
}

#[test]
fn what_looks_wrong_is_flagged_in_its_row_and_on_stderr() {
    let place = Place::new("odd");
    let shader = "layout(std430) uniform B { vec3 a; mat2 m; bool b; float c; };\n";
    place.write("b.frag", format!("#version 450\n{shader}"));
    let mut bytes = vec![0u8; 48];
    bytes[4..8].copy_from_slice(&f32::NAN.to_le_bytes());
    bytes[8..12].copy_from_slice(&f32::NEG_INFINITY.to_le_bytes());
    bytes[15] = 0xee;
    bytes[32] = 2;
    bytes[40..48].fill(0xff);
    let arguments = ["decode", "b.frag", "-", "--rules", "std430"];
    let ran = place.run_with(&arguments, &bytes);
    assert_eq!(ran.code, 1);
    let rows: Vec<&str> = ran.out().lines().skip(2).collect();
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
    for words in [
        "warning[not-a-number]: `a.y` at byte 4 is not a number: nan\n --> <stdin>",
        "warning[infinite]: `a.z` at byte 8 is infinite: -inf\n",
        "warning[nonzero-padding]: padding at byte 15 is not zero: ee, between `a` and `m`\n",
        "warning[odd-bool]: `b` at byte 32 is a bool, but neither 0 nor 1: 2\n",
        "warning[nonzero-padding]: padding at byte 40 is not zero",
    ] {
        assert!(ran.err.contains(words), "{words}\n{}", ran.err);
    }
    let quiet = place.run_with(&["-q", "decode", "b.frag", "-"], &bytes);
    assert_eq!((quiet.code, quiet.err.as_str()), (1, ""));
    let json = place.run_with(&["decode", "b.frag", "-", "-f", "json"], &bytes);
    assert_eq!(json.code, 1);
    for line in json.err.lines() {
        let found: Value = serde_json::from_str(line).unwrap();
        assert_eq!((&found["severity"], &found["path"]), (&"warning".into(), &"<stdin>".into()));
    }
    assert_eq!(json.err.lines().count(), 5);
}

#[test]
fn findings_past_what_is_read_are_counted() {
    let place = Place::new("many");
    let ran = place.run_with(&["decode", "a.frag", "-"], [0xff; 6160]);
    assert_eq!(ran.code, 1);
    // 12 components and 2 gaps a light, and the block's tail.
    let all = 128 * 12 - 128 * 2 + 128 * 2 + 1;
    assert_eq!(ran.err.matches("warning[").count(), 100);
    let words = format!("warning[more-findings]: {} more findings in `<stdin>`", all - 99);
    assert!(ran.err.contains(&words), "{words}\n{}", &ran.err[ran.err.len() - 200..]);
    let json = place.run_with(&["decode", "a.frag", "-", "-f", "json"], [0xff; 6160]);
    assert_eq!(json.err.lines().count(), 1001);
}

#[test]
fn hex_names_every_word() {
    let place = Place::new("hex");
    let json = r#"{"data[0].pos":[1,2,3],"actually_used_count":2}"#;
    let ran = place.run_with(&["encode", "a.frag", "--hex"], json);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let lines: Vec<&str> = ran.out().lines().collect();
    assert_eq!(lines.len(), 1 + 6160 / 16);
    let wanted =
        "       0  00 00 80 3f  00 00 00 40  00 00 40 40  00 00 00 00  data[0].pos.x  .y  .z  --";
    assert_eq!(lines[1], wanted);
    assert!(lines[385].ends_with("  actually_used_count  --  --  --"), "{}", lines[385]);
    let to_file = place.run_with(&["encode", "a.frag", "--hex", "--out", "v.txt"], json);
    assert_eq!((to_file.code, to_file.out()), (0, ""));
    assert_eq!(place.read("v.txt"), ran.bytes);
}

#[test]
fn the_block_is_asked_for_when_there_are_several() {
    let place = Place::new("which");
    place.write("two.frag", format!("{LIGHTS}layout(std140) uniform View {{ vec4 eye; }};\n"));
    place.write("loose.frag", "#version 330\nuniform vec3 eye;\n");
    place.write("none.frag", "#version 330\nvoid main() {}\n");
    let same = "struct L { a: vec4<f32> }
@group(0) @binding(0) var<uniform> one: L;
@group(0) @binding(1) var<uniform> two: L;\n";
    place.write("same.wgsl", same);
    let run = |arguments: &[&str]| place.run_with(&[&["encode"], arguments, &["-"]].concat(), "{}");
    run(&["two.frag"])
        .refuses("which-block", "select one with `--block`: `PointLightBlock`, `View`");
    assert_eq!(run(&["two.frag", "-b", "View"]).bytes.len(), 16);
    run(&["two.frag", "-b", "Veiw"])
        .refuses("unknown-block", "available: `PointLightBlock`, `View`");
    run(&["loose.frag"]).refuses("no-bytes", "`--gather` lays them out");
    assert_eq!(run(&["loose.frag", "--gather"]).bytes.len(), 16);
    run(&["same.wgsl", "-b", "L"]).refuses("ambiguous-block", "by its instance: `one`, `two`");
    assert_eq!(run(&["same.wgsl", "-b", "two"]).bytes.len(), 16);
    let none = run(&["none.frag"]);
    assert_eq!((none.code, none.out()), (2, ""));
    assert!(none.err.contains("error[no-blocks]"), "{}", none.err);
}

#[test]
fn defines_overrides_and_rules_change_the_bytes() {
    let place = Place::new("options");
    place.write("d.frag", "#version 330\nlayout(std140) uniform B { float x[N]; };\n");
    let len = |arguments: &[&str]| {
        let ran = place.run_with(&[&["encode"], arguments].concat(), "{}");
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
    let place = Place::new("values");
    for (json, code, words) in [
        ("", "empty-input", "`<stdin>` is empty"),
        (" \n", "empty-input", "`{}` sets all of them to zero"),
        (
            "{\n  \"data\": [1,\n}",
            "json-syntax",
            "malformed JSON: expected value\n --> <stdin>:3:1\n",
        ),
        ("{\"data\": [", "json-syntax", " --> <stdin>:1:10\n"),
        ("{\"a\":1,\"a\":1}", "json-syntax", "`a` is given twice"),
        ("[]", "wrong-value", "the block: expected an object of members for `PointLightBlock`"),
        (r#"{"dta":[]}"#, "unknown-member", "help: did you mean `data`?"),
        (r#"{"data":[{"colour":1}]}"#, "unknown-member", "did you mean `data[0].color`?"),
        (r#"{"data[128].pos":1}"#, "index-out-of-range", "index 128 in `data[128].pos`"),
        (
            r#"{"data":[{"pos":[1,2]}]}"#,
            "wrong-count",
            "`data[0].pos`: `vec3` has 3 elements, not 2",
        ),
        (
            r#"{"actually_used_count":1.5}"#,
            "wrong-value",
            "expected an integer for `int`, found 1.5",
        ),
        (r#"{"actually_used_count":2147483648}"#, "value-out-of-range", "does not fit `int`"),
        (r#"{"data[0].pos":[1,2,3],"data":[{"pos.x":1}]}"#, "given-twice", "is given twice"),
    ] {
        let ran = place.run_with(&["encode", "a.frag", "--out", "v.bin"], json);
        ran.refuses(code, words);
        assert!(ran.err.contains("<stdin>"), "{}", ran.err);
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
        let ran = place.run_with(&["encode", "a.frag"], json);
        assert!(ran.err.contains(&format!(" --> <stdin>:{at}\n")), "{at} {}", ran.err);
    }
    let strict = ["encode", "a.frag", "--missing", "error"];
    place.run_with(&strict, "{}").refuses("missing-member", "`data[0].pos` is missing");
    place.run_with(&strict, "{}").refuses("missing-member", "with `--missing zero`");
    place.run_with(&["encode", "a.frag"], b"{\"\xff\"").refuses("unreadable-file", "is not UTF-8");
    assert_eq!(place.names(), ["a.frag"]);
}

#[test]
fn bytes_of_the_wrong_length_are_refused_with_both_numbers() {
    let place = Place::new("length");
    place.write("tail.comp", TAIL);
    let run = |bytes: &[u8], more: &[&str]| {
        place.run_with(&[&["decode", "a.frag", "-"], more].concat(), bytes)
    };
    let words = "`PointLightBlock` has 6160 bytes, but 160 bytes were given: they end before or in \
                 `data[3].color`";
    run(&[0; 160], &[]).refuses("wrong-length", words);
    run(&[], &[]).refuses("wrong-length", "has 6160 bytes, but 0 bytes were given");
    run(&[0; 6164], &[]).refuses("wrong-length", "has 6160 bytes, but 6164 bytes were given");
    run(&[0; 6164], &[]).refuses("wrong-length", "`--offset N` decodes the 6160 bytes from byte N");
    let mut dump = vec![0xffu8; 7000];
    dump[256..256 + 6160].fill(0);
    assert_eq!(run(&dump, &["--offset", "0x100"]).code, 0);
    assert_eq!(run(&dump, &["--offset", "257"]).code, 1);
    assert_eq!(run(&dump, &["--offset", "840"]).code, 1);
    run(&dump, &["--offset", "853"]).refuses("wrong-length", "6147 of them from byte 853 on");
    run(&dump, &["--offset", "7001"]).refuses("offset-out-of-range", "has 7000 bytes, none at");
    // All members, but not what a buffer must hold.
    let short = run(&[0; 6148], &[]);
    assert_eq!(short.code, 1);
    assert!(short.err.starts_with("warning[odd-length]: 6148 bytes hold every member"));
    let tail = place.run_with(&["decode", "tail.comp", "-"], [0; 20]);
    assert_eq!((tail.code, tail.err.as_str()), (0, ""));
    assert!(tail.out().ends_with("  20 bytes hold 4 of `x`\n"), "{}", tail.out());
    let odd = place.run_with(&["decode", "tail.comp", "-"], [0; 21]);
    assert!(odd.code == 1 && odd.err.contains("1 bytes follow the last whole element of `x`"));
}

#[test]
fn files_that_cannot_be_read_are_one_error() {
    let place = Place::new("unreadable");
    fs::create_dir(place.0.join("dir")).unwrap();
    for command in ["encode", "decode"] {
        let run = |shader, other| place.run(&[command, shader, other]);
        run("a.frag", "gone").refuses("unreadable-file", "`gone` cannot be read: no such file");
        run("a.frag", "dir").refuses("unreadable-file", "`dir` is a directory, not a file");
        run("gone.frag", "x").refuses("unreadable-file", "`gone.frag` cannot be read");
        run("-", "-").refuses("output", "`<stdin>` cannot be both the shader and the other input");
    }
    place.write("bad.frag", "#version 330\nuniform B { vec33 x; };\nuniform C { float y; };\n");
    let ran = place.run_with(&["encode", "bad.frag", "--out", "v.bin", "-b", "C"], "{}");
    assert!(ran.code == 2 && !place.0.join("v.bin").exists(), "{}", ran.err);
    let ran = place.run_with(&["decode", "bad.frag", "-", "-b", "C"], [0; 16]);
    assert!(ran.code == 2 && ran.out().contains("float  y     0.0"), "{}", ran.out());
}

#[test]
fn a_place_that_cannot_be_written_is_left_as_it_was() {
    let place = Place::new("out");
    place.write("file", "in the way");
    fs::create_dir(place.0.join("dir")).unwrap();
    for (out, words) in [
        ("file/v.bin", "`file` cannot be created as a directory"),
        ("file/deep/v.bin", "cannot be created as a directory"),
        ("dir", "`dir` cannot be written"),
    ] {
        let ran = place.run_with(&["encode", "a.frag", "--out", out], "{}");
        ran.refuses("output", words);
    }
    assert_eq!(place.read("file"), b"in the way");
    assert_eq!(place.names(), ["a.frag", "dir", "file"]);
    assert_eq!(fs::read_dir(place.0.join("dir")).unwrap().count(), 0);
}

#[test]
#[cfg(target_os = "linux")]
fn devices_and_links_stay_what_they_are() {
    let place = Place::new("links");
    place.write("v.bin", "old");
    std::os::unix::fs::symlink("v.bin", place.0.join("link")).unwrap();
    std::os::unix::fs::symlink("/dev/full", place.0.join("full")).unwrap();
    let to = |out| place.run_with(&["encode", "a.frag", "--out", out], "{}");
    assert_eq!(to("link").code, 0);
    assert!(place.0.join("link").is_symlink() && place.read("v.bin").len() == 6160);
    to("full").refuses("output", "`full` cannot be written: no space left on device");
    assert!(place.0.join("full").is_symlink());
    assert_eq!(place.names(), ["a.frag", "full", "link", "v.bin"]);
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_one_error_and_a_closed_pipe_is_none() {
    let place = Place::new("pipe");
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
        ran.refuses("output", "`<stdout>` cannot be written: no space left on device");
        let mut command = place.command(arguments);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let ran = Ran::of(child.wait_with_output().unwrap());
        assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{arguments:?}");
    }
}
