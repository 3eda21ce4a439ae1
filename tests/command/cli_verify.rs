//! `landfall verify` from outside: exit codes, locks, coverage, and what a backend may not touch.

use std::process::Command;

use serde_json::Value;
use snapbox::str;

use crate::schema::{holds, validator};
use crate::support::command::{Place, Ran};

const GOOD: &str = "#version 450
layout(std140, binding = 0) uniform B { float time; vec3 wind; float gains[4]; vec4 spare; } u;
layout(location = 0) out vec4 colour;
void main() { colour = vec4(u.time + u.gains[1] + u.gains[2]); }
";

/// The command where the loaders of drivers have nothing to load.
fn without_drivers(folder: &Place, arguments: &[&str]) -> Ran {
    let mut command = folder.command(arguments);
    for name in [
        "VK_DRIVER_FILES",
        "VK_ICD_FILENAMES",
        "__EGL_VENDOR_LIBRARY_FILENAMES",
        "LIBGL_DRIVERS_PATH",
    ] {
        command.env(name, "/nonexistent");
    }
    Ran::of(command.output().expect("the command of this package"))
}

#[test]
fn a_required_reader_that_is_missing_is_an_error() {
    let folder = Place::new("verify-require");
    folder.write("a.frag", GOOD);
    without_drivers(&folder, &["verify", "a.frag", "--require", "gpu"]).code(2).stderr_eq(str![[r#"
error[cannot-run]: `gpu` is required but did not run: no Vulkan adapter; the Debian packages `mesa-vulkan-drivers` and `libvulkan1` provide a software driver
  |
  = help: `landfall devices` lists the available backends


"#]]);
}

#[test]
fn shaders_verified_in_parallel_are_reported_in_order() {
    let folder = Place::new("verify-parallel");
    for at in 0..7 {
        let gains = format!("gains[{}]", 4 + at);
        folder.write(&format!("{at}.frag"), GOOD.replace("gains[4]", &gains));
    }
    folder.write("bad.frag", "#version 450\nuniform B { what x; } u;\nvoid main() {}\n");
    let run = |jobs: &str| {
        let backends = ["verify", ".", "--backend", "cpu,gl,gpu", "--format", "json"];
        folder.run(&[&backends[..], &["-j", jobs]].concat())
    };
    let (one, three) = (run("1"), run("3"));
    let report: Value = serde_json::from_str(&three.out).expect("JSON");
    assert_eq!(report["shaders"].as_array().map(Vec::len), Some(7));
    assert_eq!((one.code, &one.out, &one.err), (2, &three.out, &three.err));
}

#[test]
fn a_stale_lock_is_proven_wrong_and_the_leaf_named() {
    let folder = Place::new("verify-stale");
    folder.write("a.frag", GOOD);
    let output = folder.run(&["lock", "a.frag"]);
    assert_eq!(output.code, 0, "{}", output.err);
    let lock = "layouts/a.frag.json";
    let verify = ["verify", "a.frag", "--backend", "cpu", "--layout", lock];
    folder.run(&verify).code(0);
    // `wind` moves from 16 to 32; `time` stays, and what follows moves with it.
    let changed = GOOD.replace("vec3 wind;", "vec4 fog; vec3 wind;");
    folder.write("a.frag", changed);
    let output = folder.run(&verify);
    output.code(1).stdout_eq(str![[r#"
backends
  cpu  interpreter · landfall [VERSION]

a.frag
  B  std140  128 bytes     5 leaves  cpu ✗ 22 of 23 reads returned another byte
    gains[]
      cpu gains[0]  reads byte 48, expected 32  constant
      cpu gains[3]  reads byte 96, expected 80  constant
      cpu gains[1]  reads byte 64, expected 48  constant
      cpu gains[0]  reads byte 48, expected 32  dynamic
      … and 4 more
      it starts at 48 instead of 32
    spare
      cpu spare.x  reads byte 112, expected 96  constant
      cpu spare.y  reads byte 116, expected 100  constant
      cpu spare.z  reads byte 120, expected 104  constant
      cpu spare.w  reads byte 124, expected 108  constant
      … and 4 more
      it starts at 112 instead of 96
    wind
      cpu wind.x  reads byte 32, expected 16  constant
      cpu wind.y  reads byte 36, expected 20  constant
      cpu wind.z  reads byte 40, expected 24  constant
      cpu wind.x  reads byte 32, expected 16  dynamic
      … and 2 more
      this is its offset in std430; it starts at 32 instead of 16
    not probed: `fog`: the given layout has no member of this path

"#]]);
}

#[test]
fn json_with_coverage_holds_to_its_schema() {
    let folder = Place::new("verify-schema");
    folder.write("a.frag", GOOD);
    for more in [&[][..], &["--coverage"]] {
        let arguments = ["verify", "a.frag", "--backend", "cpu", "--format", "json"];
        let output = folder.run(&[&arguments[..], more].concat());
        let value = holds(&validator("verify"), &output.out, "verify");
        let block = &value["shaders"][0]["blocks"][0];
        assert_eq!(block.get("coverage").is_some(), !more.is_empty());
    }
}

#[test]
fn coverage_tells_what_is_never_read_from_what_was_not() {
    let folder = Place::new("verify-coverage");
    let text = "#version 450
layout(std140, binding = 0) uniform B {
    float time; vec3 wind; float gains[4]; int count; vec4 spare; float rare;
} u;
layout(location = 0) out vec4 colour;
float unused() { return u.spare.x; }
void main() {
    float sum = u.time + u.gains[1] + u.gains[2];
    if (u.count == 12345) sum += u.rare;
    colour = vec4(sum);
}
";
    folder.write("a.frag", text);
    let arguments = ["verify", "a.frag", "--backend", "cpu", "--coverage", "--format", "json"];
    let covered = |more: &[&str]| -> Value {
        let output = folder.run(&[&arguments[..], more].concat());
        assert_eq!(output.code, 0, "{}", output.err);
        let value = output.json();
        value["shaders"][0]["blocks"][0]["coverage"].clone()
    };
    let verdicts = |coverage: &Value| -> Vec<(String, String, u64, u64)> {
        let leaves = coverage["leaves"].as_array().unwrap().iter();
        leaves
            .map(|leaf| {
                let word = |key: &str| leaf[key].as_str().unwrap().to_string();
                let number = |key: &str| leaf[key].as_u64().unwrap();
                (word("path"), word("verdict"), number("read"), number("never"))
            })
            .collect()
    };
    let leaf = |path: &str, verdict: &str, read: u64, never: u64| {
        (path.to_string(), verdict.to_string(), read, never)
    };
    let coverage = covered(&[]);
    // By hand: gains[0] and [3] have no load; `spare` is loaded only by a function nobody calls.
    let expected = vec![
        leaf("time", "read", 4, 0),
        leaf("wind", "never", 0, 12),
        leaf("gains[]", "partly", 8, 8),
        leaf("count", "read", 4, 0),
        leaf("spare", "never", 0, 16),
        leaf("rare", "unread", 0, 0),
    ];
    assert_eq!(verdicts(&coverage), expected);
    assert_eq!(coverage["leaves"][2]["elements_read"], serde_json::json!([[1, 2]]));
    // std140: time 0, wind 16, gains 32 to 96, count 96, spare 112, rare 128, rounded to 144.
    assert_eq!((&coverage["bytes"], &coverage["read"]), (&144.into(), &16.into()));
    assert_eq!(coverage["never"], 36);
    // With the count that the branch asks for, `rare` is read.
    let coverage = covered(&["--data", r#"{"B": {"count": 12345}}"#]);
    assert_eq!(verdicts(&coverage)[5], leaf("rare", "read", 4, 0));
    let output = folder.run(&["verify", "a.frag", "--backend", "cpu", "--coverage"]);
    output.code(0).stdout_eq(str![[r#"
backends
  cpu  interpreter · landfall [VERSION]

a.frag
  B  std140  144 bytes     6 leaves  cpu ✓ 25 reads
    16 of 144 bytes read, 36 certainly never read
      time      4  read
      wind     12  never read (certain)
      gains[]  16  8 read, in [1..2] of 4 elements; 8 never read (certain)
      count     4  read
      spare    16  never read (certain)
      rare      4  not read in these runs

"#]]);
}

#[test]
fn a_member_that_one_block_of_an_array_is_read_for_is_read() {
    let folder = Place::new("verify-coverage-array");
    let text = "#version 450\nlayout(local_size_x = 1) in;\n\
                layout(std140, binding = 0) uniform In { vec3 a; float b; vec4 c; } ins[2];\n\
                layout(std430, binding = 4) buffer Out { float o[4]; };\n\
                void main() { o[0] = ins[0].b + ins[1].c.x; }\n";
    folder.write("a.comp", text);
    let ran = folder.run(&["verify", "a.comp", "--backend", "cpu", "--coverage", "--block", "In"]);
    ran.code(0).stdout_eq(str![[r#"
backends
  cpu  interpreter · landfall [VERSION]

a.comp
  In  std140  32 bytes     3 leaves  cpu ✓ 30 reads
    8 of 32 bytes read, 24 certainly never read
      a  12  never read (certain)
      b   4  read
      c  16  4 read; 12 never read (certain)

"#]]);
}

#[test]
fn a_broken_shader_leaves_the_others_alone() {
    let folder = Place::new("verify-broken");
    folder.write("a.frag", GOOD);
    folder.write("b.frag", "#version 450\nuniform B { vec33 x; };\n");
    folder.write("c.frag", GOOD);
    let arguments = ["verify", "a.frag", "b.frag", "gone.frag", "c.frag", "--backend", "cpu"];
    let output = folder.run(&arguments);
    output
        .code(2)
        .stdout_eq(str![[r#"
backends
  cpu  interpreter · landfall [VERSION]

a.frag
  B  std140  112 bytes     4 leaves  cpu ✓ 23 reads

c.frag
  B  std140  112 bytes     4 leaves  cpu ✓ 23 reads

"#]])
        .stderr_eq(str![[r#"
error[unknown-type]: unknown type `vec33`
 --> b.frag:2:13
  |
2 | uniform B { vec33 x; };
  |             ^^^^^
  |
  = help: did you mean `vec3`?

error[unreadable-file]: `gone.frag` cannot be read: no such file or directory

2 shaders, 2 blocks, 46 reads: every byte lands where the shader reads it

"#]]);
}

#[test]
fn record_notes_in_the_lock_who_confirmed_it() {
    let folder = Place::new("verify-record");
    folder.write("a.frag", GOOD);
    folder.run(&["lock", "a.frag"]).code(0);
    let output = folder.run(&["verify", "a.frag", "--backend", "gl", "--record"]);
    assert_eq!(output.code, 0, "{}", output.err);
    let lock = folder.read("layouts/a.frag.json");
    let lock: Value = serde_json::from_str(&lock).unwrap();
    assert_eq!(lock["verified"][0]["backend"], "gl", "{lock}");
    assert!(lock["verified"][0]["driver"].as_str().unwrap().starts_with("Mesa"), "{lock}");
    let output =
        folder.run(&["verify", "a.frag", "--backend", "cpu", "--layout", "layouts/a.frag.json"]);
    assert_eq!(output.code, 0, "the lock still reads");
}

#[test]
fn the_evaluator_needs_no_driver() {
    let folder = Place::new("verify-alone");
    folder.write("a.frag", GOOD);
    let verify = ["verify", "a.frag", "--backend", "cpu"];
    without_drivers(&folder, &verify)
        .code(0)
        .stdout_eq(str![[r#"
backends
  cpu  interpreter · landfall [VERSION]

a.frag
  B  std140  112 bytes     4 leaves  cpu ✓ 23 reads

"#]])
        .stderr_eq(str![[r#"
1 shader, 1 block, 23 reads: every byte lands where the shader reads it

"#]]);
    let covered = [&verify[..], &["--coverage"]].concat();
    without_drivers(&folder, &covered)
        .code(0)
        .stdout_eq(str![[r#"
backends
  cpu  interpreter · landfall [VERSION]

a.frag
  B  std140  112 bytes     4 leaves  cpu ✓ 23 reads
    12 of 112 bytes read, 36 certainly never read
      time      4  read
      wind     12  never read (certain)
      gains[]  16  8 read, in [1..2] of 4 elements; 8 never read (certain)
      spare    16  never read (certain)

"#]])
        .stderr_eq(str![[r#"
1 shader, 1 block, 23 reads: every byte lands where the shader reads it

"#]]);
}

#[test]
fn nothing_read_is_no_proof() {
    let folder = Place::new("verify-nothing");
    folder.write("a.wgsl", "@group(0) @binding(0) var<uniform> u: vec4f;\n");
    folder.run(&["verify", "a.wgsl", "--backend", "gl"]).code(2).stderr_eq(str![[r#"
1 shader, 1 block, 0 reads: nothing is verified
error[cannot-run]: `verify` read no member of any block
  |
  = help: the report names the reason by block; `--backend cpu` reads GLSL and WGSL


"#]]);
    folder.run(&["verify", "a.wgsl", "--backend", "cpu,gl", "--require", "gl"]).code(2).stderr_eq(
        str![[r#"
1 shader, 1 block, 8 reads: every byte lands where the shader reads it
error[cannot-run]: `gl` is required, but its probes read no member of any block
  |
  = help: the report names the reason by block; `--backend cpu` reads GLSL and WGSL


"#]],
    );
    folder.run(&["verify", "a.wgsl", "--backend", "cpu,gl", "--require", "cpu"]).code(0);
}

/// ES has storage buffers from 3.10, and takes their bindings from the text alone.
#[test]
fn es_shaders_are_read_on_the_driver() {
    let folder = Place::new("verify-es");
    let light = "struct L { vec3 p; float i; };\n";
    let fragment = |members: &str| {
        format!(
            "// 300 suns\n#version 300 es\nprecision highp float;\nuniform vec3 tint;\n{light}\
             layout(std140) uniform U {{ {members} }} u;\nout vec4 o;\n\
             void main() {{ o = vec4(u.l[1].p + u.m[0] * tint, u.w[2]); }}\n"
        )
    };
    folder.write("a.frag", fragment("L l[4]; mat3 m; float w[3];"));
    folder.write("swapped.frag", fragment("mat3 m; L l[4]; float w[3];"));
    folder.write(
        "b.vert",
        "#version 300 es\nlayout(std140) uniform Camera { mat4 view; vec3 eye; float near; };\n\
         in vec3 p;\nvoid main() { gl_Position = view * vec4(p - eye, near); }\n",
    );
    folder.write(
        "c.comp",
        "#version 310 es\nlayout(local_size_x = 8) in;\n\
         layout(std140, binding = 0) uniform U { vec3 a; float b[2]; } u;\n\
         layout(std430, binding = 0) buffer R { float r[]; };\n\
         void main() { r[gl_GlobalInvocationID.x] = u.a.x + u.b[1]; }\n",
    );
    let files = ["verify", "a.frag", "b.vert", "c.comp", "--backend", "gl", "--require", "gl"];
    folder.run(&files).code(0).stdout_eq(str![[r#"
backends
  gl   [DRIVER] · [DRIVER]

a.frag
  U             std140  160 bytes     4 leaves  gl ✓ 77 reads
  DefaultBlock  std140   16 bytes     1 leaf    gl ✓ 6 reads

b.vert
  Camera  std140  80 bytes     3 leaves  gl ✓ 42 reads

c.comp
  U  std140  48 bytes     2 leaves  gl ✓ 15 reads
  R  std430   4 bytes     1 leaf    gl ✓ 11 reads

"#]]);
    // The reads are the driver's: another layout is told apart.
    let swapped = folder.run(&["layout", "swapped.frag", "--format", "json"]).code(0).out.clone();
    folder.write("swapped.json", &swapped);
    folder.run(&["verify", "a.frag", "--backend", "gl", "--layout", "swapped.json"]).code(1);
}

/// SPIR-V of a text, made by glslang.
fn compiled(folder: &Place, name: &str, text: &str) -> String {
    folder.write(name, text);
    let output = format!("{name}.spv");
    let made = Command::new("glslangValidator")
        .current_dir(&folder.0)
        .args(["-V", name, "-o", &output])
        .output()
        .expect("glslangValidator: apt-get install glslang-tools");
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stdout));
    output
}

#[test]
fn decorations_of_a_compilers_module_are_held_against_the_layout() {
    let folder = Place::new("verify-spirv");
    let text = "#version 450
        struct Light { vec3 position; float power; mat3x2 frame; };
        layout(std140, binding = 0) uniform B {
            float time; Light lights[3]; float weights[2][3]; layout(row_major) mat4x3 bones;
        } u;
        layout(location = 0) out vec4 colour;
        void main() { colour = vec4(u.time); }
    ";
    let spirv = compiled(&folder, "a.frag", text);
    let verify = ["verify", "a.frag", "--backend", "cpu", "--spirv", &spirv, "--format", "json"];
    let outcomes = |output: &Ran| -> Value {
        let report = output.json();
        report["shaders"][0]["blocks"][0]["backends"][1].clone()
    };
    let same = folder.run(&verify);
    let backend = outcomes(&same);
    assert_eq!((&backend["backend"], &backend["outcome"]), (&"spirv".into(), &"confirmed".into()));
    assert!(backend["reads"].as_array().unwrap().len() > 12, "{backend}");
    assert_eq!(same.code, 0, "{}", same.err);
    // The shader has changed since it was compiled.
    let changed = text.replace("vec3 position; float power;", "vec3 position; vec2 power;");
    folder.write("a.frag", changed);
    let stale = folder.run(&verify);
    let backend = outcomes(&stale);
    assert_eq!(backend["outcome"], "disagrees");
    let reads = backend["reads"].as_array().unwrap();
    let power = reads.iter().find(|read| read["path"] == "lights[0].power").unwrap();
    // std140: a float follows a vec3 at 12, a vec2 is aligned to 8; the array starts at 16.
    assert_eq!((&power["byte_read"], &power["expected_byte"]), (&28.into(), &32.into()));
    assert_eq!(stale.code, 1);
    // What is no SPIR-V.
    folder.write("junk.spv", [7u8; 64]);
    let junk = folder.run(&["verify", "a.frag", "--backend", "cpu", "--spirv", "junk.spv"]);
    junk.code(2).stderr_eq(str![[r#"
error[cannot-run]: `junk.spv` is not SPIR-V: it begins with 0x07070707, not 0x07230203


"#]]);
}

#[test]
fn a_compilers_module_runs_beside_ours() {
    let folder = Place::new("verify-compiled");
    let text = "#version 450
        struct Light { vec3 position; float power; };
        layout(std140, binding = 0) uniform B { float time; Light lights[3]; int count; } u;
        layout(location = 0) in vec3 at;
        layout(location = 0) out vec4 colour;
        void main() {
            float sum = u.time;
            for (int i = 0; i < min(u.count, 3); ++i)
                sum += u.lights[i].power / (1.0 + dot(at, u.lights[i].position));
            colour = vec4(at * sum, 1.0);
        }
    ";
    let spirv = compiled(&folder, "a.frag", text);
    let verify = ["verify", "a.frag", "--backend", "gpu", "--spirv", &spirv, "--format", "json"];
    let run = |output: &Ran| -> Value {
        let report = output.json();
        report["shaders"][0]["compiled"].clone()
    };
    let same = folder.run(&verify);
    // Three fillings of the buffers, an image of 16 by 16, four words a pixel.
    let expected = serde_json::json!({
        "backend": "gpu", "outcome": "confirmed", "compared": 3 * 16 * 16 * 4, "differing": 0
    });
    assert_eq!(run(&same), expected);
    assert_eq!(same.code, 0, "{}", same.err);
    // The member the sum begins with has moved since.
    let changed =
        text.replace("float time; Light lights[3]", "vec4 wind; float time; Light lights[3]");
    folder.write("a.frag", changed);
    let stale = folder.run(&verify);
    assert_eq!(run(&stale)["outcome"], "disagrees");
    assert_eq!(stale.code, 1);
    let human = folder.run(&verify[..6]);
    human.code(1).stdout_eq(str![[r#"
backends
  gpu  [DRIVER] · [DRIVER]

a.frag
  B  std140  96 bytes     5 leaves
      gpu ✓ 50 reads  spirv ✗ 6 of 6 reads returned another byte
    count
      spirv count  reads byte 64, expected 80  reported
    lights[].position
      spirv lights[0].position  reads byte 16, expected 32  reported
      spirv lights[1].position  reads byte 32, expected 48  reported
    lights[].power
      spirv lights[0].power  reads byte 28, expected 44  reported
      spirv lights[1].power  reads byte 44, expected 60  reported
    time
      spirv time  reads byte 0, expected 16  reported
  spirv ✗ run on gpu: 1536 of 3,072 32-bit words differ from landfall's module

"#]]);
    // What wgpu cannot bind is said, and no failure.
    let textured = "#version 450
        layout(binding = 0) uniform sampler2D t;
        layout(std140, binding = 1) uniform B { vec4 tint; };
        layout(location = 0) out vec4 colour;
        void main() { colour = tint * texture(t, vec2(0.5)); }
    ";
    let spirv = compiled(&folder, "b.frag", textured);
    let verify = ["verify", "b.frag", "--backend", "gpu", "--spirv", &spirv];
    let refused = folder.run(&verify);
    refused.code(0).stdout_eq(str![[r#"
backends
  gpu  [DRIVER] · [DRIVER]

b.frag
  B  std140  16 bytes     1 leaf    gpu ✓ 8 reads  spirv ✓ 1 reads
  spirv not run on gpu: wgpu binds textures and samplers separately, but the SPIR-V has a combined one; declare `texture2D` and `sampler`

"#]]);
}
