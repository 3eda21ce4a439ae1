//! The command line as a user meets it: streams, exit codes, inputs, files written.

use std::fs;
use std::process::Stdio;

use snapbox::str;

use crate::support::command::{Place, Ran};

const LIGHTS: &str = "#version 330 core
struct PointLight { vec3 pos; vec3 color; float intensity, constant, linear, quadratic; };
layout(std140) uniform PointLightBlock {
    PointLight data[128];
    int actually_used_count;
} u_point_light_array;
layout(std140) uniform View { mat4 view; vec3 eye; };
";

#[test]
fn colours_are_given_on_request_only() {
    let place = Place::new("cli-colour");
    place.write("a.frag", LIGHTS);
    assert!(place.run(&["layout", "a.frag", "--color", "always"]).out.contains('\x1b'));
    assert!(!place.run(&["--color", "never", "layout", "a.frag"]).out.contains('\x1b'));
    let json = place.run(&["layout", "a.frag", "--color", "always", "--format", "json"]).out;
    assert!(!json.contains('\x1b'));
}

#[test]
fn every_format_ends_in_a_newline_and_names_the_block() {
    let place = Place::new("cli-formats");
    place.write("a.frag", LIGHTS);
    for (format, text) in [
        (
            "table",
            str![[r#"
a.frag (fragment)

uniform PointLightBlock u_point_light_array · std140 · 6,160 bytes
  offset  size  align  stride  type        name
       0  6144     16      48  PointLight  data[128]
       0    12     16      48  vec3          pos
      12     4             48                -- hole
      16    12     16      48  vec3          color
      28     4      4      48  float         intensity
      32     4      4      48  float         constant
      36     4      4      48  float         linear
      40     4      4      48  float         quadratic
      44     4             48                -- tail padding of PointLight
    6144     4      4          int         actually_used_count
    6148    12                             -- tail padding
  6,160 bytes: 5,124 used, 1,036 padding (16.8 %)
  offsets are those of element 0; element i lies i × stride further

uniform View · std140 · 80 bytes
  offset  size  align  matrix  type  name
       0    64     16      16  mat4  view
      64    12     16          vec3  eye
      76     4                       -- tail padding
  80 bytes: 76 used, 4 padding (5.0 %)

"#]],
        ),
        (
            "listing",
            str![[r#"
// a.frag

/*            align(16) size(48) */ struct PointLight {
/* offset( 0) align(16) size(12) */     vec3 pos;
/* offset(12)           size( 4) */     // -- hole
/* offset(16) align(16) size(12) */     vec3 color;
/* offset(28) align( 4) size( 4) */     float intensity;
/* offset(32) align( 4) size( 4) */     float constant;
/* offset(36) align( 4) size( 4) */     float linear;
/* offset(40) align( 4) size( 4) */     float quadratic;
/* offset(44)           size( 4) */     // -- tail padding of PointLight
/*                               */ };

/*              align(16) size(6160)            */ layout(std140) uniform PointLightBlock {
/* offset(   0) align(16) size(6144) stride(48) */     PointLight data[128];
/* offset(6144) align( 4) size(   4)            */     int actually_used_count;
/* offset(6148)           size(  12)            */     // -- tail padding
/*                                              */ } u_point_light_array;
// 6,160 bytes: 5,124 used, 1,036 padding (16.8 %)

/*            align(16) size(80)             */ layout(std140) uniform View {
/* offset( 0) align(16) size(64) columns(16) */     mat4 view;
/* offset(64) align(16) size(12)             */     vec3 eye;
/* offset(76)           size( 4)             */     // -- tail padding
/*                                           */ };
// 80 bytes: 76 used, 4 padding (5.0 %)

"#]],
        ),
        (
            "csv",
            str![[r#"
shader,block,instance,address_space,rules,rules_declared,group,binding,block_size,path,type,offset,size,dims,strides,matrix_stride,row_major,naga_offset,assumed_target
a.frag,PointLightBlock,u_point_light_array,uniform,std140,true,,,6160,data[].pos,vec3,0,12,128,48,,,,
a.frag,PointLightBlock,u_point_light_array,uniform,std140,true,,,6160,data[].color,vec3,16,12,128,48,,,,
a.frag,PointLightBlock,u_point_light_array,uniform,std140,true,,,6160,data[].intensity,float,28,4,128,48,,,,
a.frag,PointLightBlock,u_point_light_array,uniform,std140,true,,,6160,data[].constant,float,32,4,128,48,,,,
a.frag,PointLightBlock,u_point_light_array,uniform,std140,true,,,6160,data[].linear,float,36,4,128,48,,,,
a.frag,PointLightBlock,u_point_light_array,uniform,std140,true,,,6160,data[].quadratic,float,40,4,128,48,,,,
a.frag,PointLightBlock,u_point_light_array,uniform,std140,true,,,6160,actually_used_count,int,6144,4,,,,,,
a.frag,View,,uniform,std140,true,,,80,view,mat4,0,64,,,16,false,,
a.frag,View,,uniform,std140,true,,,80,eye,vec3,64,12,,,,,,

"#]],
        ),
        (
            "md",
            str![[r#"
# `a.frag`

## `uniform PointLightBlock u_point_light_array`

std140

| offset | size | stride | type | path |
|--:|--:|--:|---|---|
| 0 | 12 | 48 | `vec3` | `data[128].pos` |
| 16 | 12 | 48 | `vec3` | `data[128].color` |
| 28 | 4 | 48 | `float` | `data[128].intensity` |
| 32 | 4 | 48 | `float` | `data[128].constant` |
| 36 | 4 | 48 | `float` | `data[128].linear` |
| 40 | 4 | 48 | `float` | `data[128].quadratic` |
| 6144 | 4 |  | `int` | `actually_used_count` |

6,160 bytes: 5,124 used, 1,036 padding (16.8 %)

## `uniform View`

std140

| offset | size | stride | type | path |
|--:|--:|--:|---|---|
| 0 | 64 | columns 16 | `mat4` | `view` |
| 64 | 12 |  | `vec3` | `eye` |

80 bytes: 76 used, 4 padding (5.0 %)

"#]],
        ),
    ] {
        let ran = place.run(&["layout", "a.frag", "--format", format]);
        ran.code(0).stderr_eq("").stdout_eq(text);
        assert!(ran.out.ends_with('\n'), "{format}");
    }
    let table = place.run(&["layout", "a.frag", "--format", "table"]).out;
    assert_eq!(place.run(&["layout", "a.frag"]).out, table);
    let ran = place.run(&["layout", "a.frag", "--format", "json"]);
    assert_eq!(ran.json()["shaders"][0]["blocks"][0]["name"], "PointLightBlock");
    assert!(ran.out.ends_with('\n'));
}

#[test]
fn directories_are_searched_in_order_and_each_file_once() {
    let place = Place::new("cli-directories");
    place.write("s/b.frag", LIGHTS).write("s/a.comp", "#version 430\nbuffer B { int x[]; };\n");
    place.write("s/deep/lights.glsl", LIGHTS).write("s/readme.txt", "no shader");
    let paths = |arguments: &[&str]| -> Vec<String> {
        let ran = place.run(arguments);
        let json: serde_json::Value = serde_json::from_str(&ran.out).expect(&ran.err);
        let shaders = json["shaders"].as_array().unwrap().iter();
        shaders.map(|s| s["path"].as_str().unwrap().to_string()).collect()
    };
    let all = ["s/a.comp", "s/b.frag", "s/deep/lights.glsl"];
    for jobs in ["1", "2", "7"] {
        assert_eq!(paths(&["layout", "s", "-f", "json", "-j", jobs]), all);
    }
    assert_eq!(paths(&["layout", "-f", "json"]), all, "no argument is the current directory");
    let twice = paths(&["layout", "s/b.frag", "s", "./s/b.frag", "-f", "json"]);
    assert_eq!(twice, ["s/b.frag", "s/a.comp", "s/deep/lights.glsl"]);
    assert_eq!(paths(&["layout", "s/*.frag", "-f", "json"]), ["s/b.frag"]);
    assert_eq!(paths(&["layout", "s/**/*.glsl", "-f", "json"]), ["s/deep/lights.glsl"]);
}

#[test]
fn what_is_not_there_is_said_and_the_rest_laid_out() {
    let place = Place::new("cli-missing");
    place.write("a.frag", LIGHTS).write("bin.frag", b"\xff\xfe\0x").write("empty/x.txt", "");
    let alone = place.run(&["layout", "a.frag"]).out;
    for (argument, said) in [
        (
            "gone.frag",
            str![[r#"
error[unreadable-file]: `gone.frag` cannot be read: no such file or directory


"#]],
        ),
        (
            "*.wgsl",
            str![[r#"
error[no-input]: `*.wgsl` matches no shader file


"#]],
        ),
        (
            "empty",
            str![[r#"
error[no-input]: `empty` contains no shader file
  |
  = help: shaders are recognised by their extension, such as .frag, .glsl or .wgsl; a file that is named itself is read with any extension


"#]],
        ),
        (
            "bin.frag",
            str![[r#"
error[unreadable-file]: `bin.frag` is UTF-16, but read as UTF-8
  |
  = help: save the file as UTF-8


"#]],
        ),
    ] {
        let ran = place.run(&["layout", argument, "a.frag"]);
        ran.code(2).stderr_eq(said);
        assert_eq!(ran.out, alone, "{argument}");
    }
}

#[test]
fn stdin_goes_by_the_name_it_is_given() {
    let place = Place::new("cli-stdin");
    let ran = place.run_with_stdin(&["layout", "-"], LIGHTS.as_bytes());
    ran.code(0).stdout_eq(str![[r#"
<stdin>

uniform PointLightBlock u_point_light_array · std140 · 6,160 bytes
...
"#]]);
    let named = ["layout", "-", "--stdin-filename", "x/y.frag", "-f", "json"];
    let ran = place.run_with_stdin(&named, LIGHTS.as_bytes());
    let shader = &ran.json()["shaders"][0];
    assert_eq!(shader["path"], "x/y.frag");
    assert_eq!((&shader["language"], &shader["stage"]), (&"glsl".into(), &"fragment".into()));
}

#[test]
fn an_unknown_extension_is_read_as_glsl_when_named() {
    let place = Place::new("cli-extension");
    let ran = place.write("lights.inc", LIGHTS).run(&["layout", "lights.inc", "--stage", "vert"]);
    ran.code(0).stdout_eq(str![[r#"
lights.inc (vertex)

uniform PointLightBlock u_point_light_array · std140 · 6,160 bytes
...
"#]]);
}

#[test]
fn block_keeps_one_block_by_its_name_or_its_instances() {
    let place = Place::new("cli-block");
    place.write("a.frag", LIGHTS).write("b.frag", "#version 330\nuniform float x;\n");
    for name in ["PointLightBlock", "u_point_light_array"] {
        let ran = place.run(&["layout", ".", "--block", name]);
        ran.code(0).stderr_eq("").stdout_eq(str![[r#"
a.frag (fragment)

uniform PointLightBlock u_point_light_array · std140 · 6,160 bytes
...
  offsets are those of element 0; element i lies i × stride further

"#]]);
    }
    let ran = place.run(&["layout", "a.frag", "--block", "Gone"]);
    ran.code(2).stderr_eq(str![[r#"
error[unknown-block]: no block named `Gone` in `a.frag`
  |
  = help: available: `PointLightBlock`, `View`


"#]]);
}

#[test]
fn rules_and_expand_change_the_numbers_and_the_rows() {
    let place = Place::new("cli-rules");
    place.write("a.frag", LIGHTS);
    let scalar = place.run(&["layout", "a.frag", "--rules", "scalar", "-b", "PointLightBlock"]);
    scalar.stdout_eq(str![[r#"
a.frag (fragment)

uniform PointLightBlock u_point_light_array · scalar · 5,124 bytes
  offset  size  align  stride  type        name
       0  5120      4      40  PointLight  data[128]
       0    12      4      40  vec3          pos
      12    12      4      40  vec3          color
      24     4      4      40  float         intensity
      28     4      4      40  float         constant
      32     4      4      40  float         linear
      36     4      4      40  float         quadratic
    5120     4      4          int         actually_used_count
  5,124 bytes: 5,124 used, 0 padding (0.0 %)
  offsets are those of element 0; element i lies i × stride further

"#]]);
    let expanded = place.run(&["layout", "a.frag", "--expand", "-f", "json"]).json();
    assert_eq!(
        expanded["shaders"][0]["blocks"][0]["offsets"]["data[3].color"], 160,
        "{expanded:#}"
    );
    let rows = place.run(&["layout", "a.frag", "--expand", "-f", "csv"]).out;
    assert_eq!(rows.lines().count(), 1 + 128 * 6 + 1 + 2);
}

#[test]
fn more_elements_than_a_bound_are_refused_by_number() {
    let place = Place::new("cli-many");
    place.write("a.comp", "#version 430\nlayout(std430) buffer B { float x[2000000]; };\n");
    let ran = place.run(&["layout", "a.comp", "--expand", "-f", "json"]);
    ran.code(2).stderr_eq(str![[r#"
{"severity":"error","code":"too-many-elements","message":"block `B` has 2,000,000 elements, `--expand` writes at most 1,000,000","path":"a.comp","line":2,"column":23,"end_line":2,"end_column":24,"labels":[{"path":"a.comp","line":2,"column":23,"end_line":2,"end_column":24,"text":""}],"notes":["the block is written as patterns: offset + index × stride"],"help":null}

"#]]);
    let block = &ran.json()["shaders"][0]["blocks"][0];
    assert_eq!((block.get("offsets"), &block["size"]), (None, &8_000_000.into()));
}

#[test]
fn out_writes_a_file_a_shader_only_when_changed() {
    let place = Place::new("cli-out");
    place
        .write("s/a.frag", LIGHTS)
        .write("s/deep/b.frag", LIGHTS)
        .write("s/bad.frag", "uniform B {");
    let ran = place.run(&["layout", "s", "--format", "json", "--out", "o"]);
    assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{}", ran.err);
    assert!(!place.0.join("o/bad.frag.json").exists());
    let json: serde_json::Value = serde_json::from_str(&place.read("o/a.frag.json")).unwrap();
    assert_eq!(json["shaders"][0]["blocks"][0]["size"], 6160);
    let stamp = |path: &str| fs::metadata(place.0.join(path)).unwrap().modified().unwrap();
    let before = stamp("o/deep/b.frag.json");
    place.run(&["layout", "s", "--format", "json", "--out", "o"]);
    assert_eq!(stamp("o/deep/b.frag.json"), before);
    let left: Vec<_> =
        fs::read_dir(place.0.join("o")).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 2, "{left:?}");
}

#[test]
fn two_shaders_for_one_file_and_unwritable_places_are_refused() {
    let place = Place::new("cli-out-refused");
    place.write("s/a.frag", LIGHTS).write("t/a.frag", LIGHTS).write("file", "in the way");
    let ran = place.run(&["layout", "s", "t", "-f", "json", "--out", "o"]);
    ran.code(2).stderr_eq(str![[r#"
error[cannot-write]: `o/a.frag.json` would be written twice: for `s/a.frag` and `t/a.frag`
  |
  = help: write the layouts of each directory to a directory of its own


"#]]);
    let ran = place.run(&["layout", "s", "-f", "json", "--out", "file"]);
    ran.code(2).stderr_eq(str![[r#"
error[cannot-write]: `file` cannot be created as a directory: file exists


"#]]);
    assert_eq!(place.read("file"), "in the way");
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_one_error_and_a_closed_pipe_is_none() {
    let place = Place::new("cli-full");
    place.write("a.frag", LIGHTS);
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let ran = Ran::of(place.command(&["layout", "a.frag"]).stdout(full).output().unwrap());
    ran.code(2).stderr_eq(str![[r#"
error[cannot-write]: `<stdout>` cannot be written: no space left on device


"#]]);
    let mut child = place
        .command(&["layout", "a.frag", "--expand"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let ran = Ran::of(child.wait_with_output().unwrap());
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
}

#[test]
fn errors_leave_the_other_blocks_and_files() {
    let place = Place::new("cli-errors");
    let bad = "uniform A { vec33 x; };\nuniform B { float y; };\nuniform C { float z[0]; };\n";
    place.write("bad.frag", bad).write("good.frag", LIGHTS);
    let ran = place.run(&["layout", "bad.frag", "good.frag"]);
    ran.code(2).stderr_eq(str![[r#"
error[unknown-type]: unknown type `vec33`
 --> bad.frag:1:13
  |
1 | uniform A { vec33 x; };
  |             ^^^^^
  |
  = help: did you mean `vec3`?

error[array-size]: array `z` has size 0, but an array has at least 1 element
 --> bad.frag:3:21
  |
3 | uniform C { float z[0]; };
  |                     ^


"#]]);
    ran.stdout_eq(str![[r#"
bad.frag (fragment)

uniform B · std140 · rules not declared: the driver's offsets may differ
    16 bytes
  offset  size  align  type   name
       0     4      4  float  y
       4    12                -- tail padding
  16 bytes: 4 used, 12 padding (75.0 %)

good.frag (fragment)

...
"#]]);
    place.write("broken.frag", "uniform B { float y; };\nuniform C { float\n");
    let ran = place.run(&["layout", "broken.frag"]);
    assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{}", ran.err);
}

#[test]
fn a_file_without_blocks_is_a_warning() {
    let place = Place::new("cli-no-blocks");
    place.write("a.vert", "#version 330\nvoid main() {}\n");
    let ran = place.run(&["layout", "a.vert"]);
    ran.code(0).stdout_eq("").stderr_eq(str![[r#"
warning[no-blocks]: no blocks and no loose uniforms in `a.vert`


"#]]);
    assert_eq!(place.run(&["layout", "-q", "a.vert"]).err, "");
}

#[test]
fn explain_leads_to_a_path_and_to_the_owner_of_a_byte() {
    let place = Place::new("cli-explain");
    place.write("a.frag", LIGHTS);
    let ran = place.run(&["explain", "a.frag", "data[3].color"]);
    ran.code(0).stderr_eq("").stdout_eq(str![[r#"
uniform PointLightBlock u_point_light_array · std140

  data  PointLight[128]
      std140 rule 10: an array of structures: each element is laid out in order
      alignment 16
      the first member: starts at 0
      0 + 0 = 0

  data[3]  PointLight
      std140 rule 10: an array of structures: each element is laid out in order
      stride 48: an element's 44 bytes, rounded up to 16
      3 × 48 = 144
      0 + 144 = 144

  data[3].color  vec3
      std140 rule 3: a vector of 3 components is aligned to 4 of them
      alignment 16
      `pos` ends at 12, rounded up to 16: 16
      144 + 16 = 160

  data[3].color: bytes 160 to 171, 12 bytes

"#]]);
    let ran = place.run(&["explain", "a.frag", "@172", "--block", "PointLightBlock"]);
    ran.stdout_eq(str![[r#"
uniform PointLightBlock u_point_light_array · std140

  byte 172 is byte 0 of 4 of data[3].intensity (float `data[3].intensity`,
    bytes 172 to 175)

"#]]);
    let ran = place.run(&["explain", "a.frag", "@0x2d", "-b", "PointLightBlock"]);
    ran.stdout_eq(str![[r#"
uniform PointLightBlock u_point_light_array · std140

  byte 45 is padding: tail padding of structure data[0], after `quadratic`
    (bytes 44 to 47)

"#]]);
    // Both blocks have a byte 12: both answer.
    assert_eq!(place.run(&["explain", "a.frag", "@12"]).out.matches("byte 12 is").count(), 2);
}

#[test]
fn explain_says_why_a_path_leads_nowhere() {
    let place = Place::new("cli-explain-nowhere");
    place.write("a.frag", LIGHTS).write("loose.frag", "#version 330\nuniform vec3 eye;\n");
    for (file, path, said) in [
        (
            "a.frag",
            "data[3].colour",
            str![[r#"
error[unknown-member]: `data[3]`, a `PointLight`, has no member `colour`
 --> a.frag
  |
  = help: there is a member `color`


"#]],
        ),
        (
            "a.frag",
            "data[128]",
            str![[r#"
error[index-out-of-range]: `data[128]` is out of range: `data` has 128 elements
 --> a.frag
  |
  = help: the last one is `data[127]`


"#]],
        ),
        (
            "a.frag",
            "eye[1].x",
            str![[r#"
error[not-a-structure]: `eye.y` has type `float`, which has no member or component `x`
 --> a.frag


"#]],
        ),
        (
            "a.frag",
            "data.color",
            str![[r#"
error[not-a-structure]: `data` has type `PointLight[128]`, which has no member or component `color`
 --> a.frag
  |
  = help: it is an array: write `data[0].color`


"#]],
        ),
        (
            "a.frag",
            "@6160",
            str![[r#"
error[byte-out-of-range]: byte 6160 lies in no block
 --> a.frag
  |
  = note: block `PointLightBlock` has 6,160 bytes
  = note: block `View` has 80 bytes


"#]],
        ),
        (
            "a.frag",
            "data[",
            str![[r#"
error[malformed-path]: `data[` is not a path: expected `]` at character 6
 --> a.frag
  |
  = help: a path is written as in the shader: `data[3].color`


"#]],
        ),
        (
            "loose.frag",
            "eye",
            str![[r#"
error[loose-uniform]: `eye` is a loose uniform, which is set on its own and has no offset
 --> loose.frag
  |
  = help: `--gather` lays out loose uniforms as a std140 block


"#]],
        ),
    ] {
        let ran = place.run(&["explain", file, path]);
        ran.code(2).stdout_eq("").stderr_eq(said);
    }
    let ran = place.run(&["explain", "loose.frag", "eye", "--gather"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
}

#[test]
fn wgsl_is_listed_and_explained_in_its_own_words() {
    let place = Place::new("cli-wgsl");
    let text = "struct Light { pos: vec3<f32>, @size(16) k: f32 }
struct Lights { n: u32, all: array<Light> }
@group(0) @binding(1) var<storage> lights: Lights;
@group(0) @binding(2) var<uniform> turn: mat3x3<f32>;
";
    place.write("a.wgsl", text);
    let listing = place.run(&["layout", "a.wgsl", "-f", "listing"]);
    listing.code(0).stderr_eq("").stdout_eq(str![[r#"
// a.wgsl

/*            align(16) size(32) */ struct Light {
/* offset( 0) align(16) size(12) */     pos : vec3<f32>,
/* offset(12) align( 4) size(16) */     k : f32,
/* offset(16)           size(12) */     // -- tail padding of k
/* offset(28)           size( 4) */     // -- tail padding of Light
/*                               */ }

/*            align(16) size(48)            */ struct Lights {
/* offset( 0) align( 4) size( 4)            */     n : u32,
/* offset( 4)           size(12)            */     // -- hole
/* offset(16) align(16)          stride(32) */     all : array<Light>,
/*                                          */ }
/*                                          */ @group(0) @binding(1) var<storage> lights : Lights;
// 48 bytes with one `all`, 32 for each more: 20 used, 28 padding (58.3 %)

/* offset(0) align(16) size(48) columns(16) */ @group(0) @binding(2) var<uniform> turn : mat3x3<f32>;
// 48 bytes: 36 used, 12 padding (25.0 %)

"#]]);
    let ran = place.run(&["explain", "a.wgsl", "lights.all[2].k"]);
    ran.stdout_eq(str![[r#"
storage Lights lights · wgsl

  all  array<Light>
      WGSL §14.4.3: an array of structures: each element is laid out in order
      alignment 16
      `n` ends at 4, rounded up to 16: 16
      0 + 16 = 16

  all[2]  Light
      WGSL §14.4.3: an array of structures: each element is laid out in order
      stride 32: an element's 28 bytes, rounded up to 16
      2 × 32 = 64
      16 + 64 = 80

  all[2].k  f32
      WGSL §14.4.1: a scalar is aligned to its size
      alignment 4
      `pos` ends at 12, a multiple of 4
      size 4, raised to 16 in the shader
      80 + 12 = 92

  all[2].k: bytes 92 to 107, 16 bytes

"#]]);
    let ran = place.run(&["explain", "a.wgsl", "@34", "-b", "lights"]);
    ran.stdout_eq(str![[r#"
storage Lights lights · wgsl

  byte 34 is padding: tail padding of member all[0].k (bytes 32 to 43)

"#]]);
}

#[test]
fn wrong_usage_is_2_and_help_is_0() {
    let place = Place::new("cli-usage");
    for arguments in [
        &["layout", "--format", "yaml"][..],
        &["layout", "--rules", "std150"],
        &["layout", "-D", "3=4"],
        &["layout", "--stage", "pixel"],
        &["sing"],
        &[],
    ] {
        assert_eq!(place.run(arguments).code, 2, "{arguments:?}");
    }
    for arguments in [&["--help"][..], &["layout", "--help"], &["explain", "-h"], &["--version"]] {
        let ran = place.run(arguments);
        assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{arguments:?}");
        assert!(ran.out.lines().all(|line| line.chars().count() <= 100), "{}", ran.out);
    }
}

/// naga recurses on such texts until the stack is gone; it is not asked about them.
#[test]
fn texts_that_exhaust_nagas_stack_are_laid_out_without_its_answer() {
    let block = "layout(std140, set = 0, binding = 0) uniform B { float a[4]; };\nvoid main() {}\n";
    let place = Place::new("cli-chain");
    for chain in ["1+".repeat(50_000), "true?1:".repeat(20_000), "- ".repeat(20_000)] {
        let text = format!("#version 450\nconst int N = {chain}1;\n{block}");
        let ran = place.write("a.frag", text).run(&["layout", "a.frag", "--format", "json"]);
        ran.code(0);
        assert_eq!(
            ran.json()["shaders"][0]["blocks"][0]["leaves"][0]["path"],
            "a[]",
            "{}",
            ran.out
        );
    }
}
