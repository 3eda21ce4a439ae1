//! `landfall verify` from outside: exit codes, locks, coverage, and what a backend may not touch.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

const GOOD: &str = "#version 450
layout(std140, binding = 0) uniform B { float time; vec3 wind; float gains[4]; vec4 spare; } u;
layout(location = 0) out vec4 colour;
void main() { colour = vec4(u.time + u.gains[1] + u.gains[2]); }
";

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli_verify").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    // A project of its own: locks lie below its configuration.
    std::fs::write(folder.join("landfall.toml"), "").unwrap();
    folder
}

fn landfall(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_landfall"));
    command.current_dir(folder).args(arguments).env("NO_COLOR", "1");
    command.output().expect("the binary was built for this test")
}

fn shown(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn a_required_reader_that_is_missing_is_an_error() {
    let folder = folder("require");
    std::fs::write(folder.join("a.frag"), GOOD).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_landfall"));
    command.current_dir(&folder).args(["verify", "a.frag", "--require", "gpu"]);
    command.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent");
    command.env("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent");
    let output = command.output().unwrap();
    let said = shown(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("`gpu` is required but did not run"), "{said}");
}

#[test]
fn a_stale_lock_is_proven_wrong_and_the_leaf_named() {
    let folder = folder("stale");
    std::fs::write(folder.join("a.frag"), GOOD).unwrap();
    let output = landfall(&folder, &["lock", "a.frag"]);
    assert_eq!(output.status.code(), Some(0), "{}", shown(&output.stderr));
    let lock = "layouts/a.frag.json";
    let verify = ["verify", "a.frag", "--backend", "cpu", "--layout", lock];
    assert_eq!(landfall(&folder, &verify).status.code(), Some(0));
    // `wind` moves from 16 to 32; `time` stays, and what follows moves with it.
    let changed = GOOD.replace("vec3 wind;", "vec4 fog; vec3 wind;");
    std::fs::write(folder.join("a.frag"), changed).unwrap();
    let output = landfall(&folder, &verify);
    let text = shown(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("reads byte 32, expected 16"), "{text}");
    let elsewhere: Vec<&str> = text.lines().map(str::trim).collect();
    assert!(elsewhere.contains(&"wind") && elsewhere.contains(&"gains[]"), "{text}");
    assert!(!elsewhere.contains(&"time"), "{text}");
}

#[test]
fn json_with_coverage_holds_to_its_schema() {
    let folder = folder("schema");
    std::fs::write(folder.join("a.frag"), GOOD).unwrap();
    let schema: Value =
        serde_json::from_slice(&landfall(&folder, &["schema", "verify"]).stdout).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    for more in [&[][..], &["--coverage"]] {
        let arguments = ["verify", "a.frag", "--backend", "cpu", "--format", "json"];
        let output = landfall(&folder, &[&arguments[..], more].concat());
        let value: Value = serde_json::from_slice(&output.stdout).unwrap();
        let errors: Vec<String> = validator.iter_errors(&value).map(|e| e.to_string()).collect();
        assert!(errors.is_empty(), "{}", errors.join("\n"));
        let block = &value["shaders"][0]["blocks"][0];
        assert_eq!(block.get("coverage").is_some(), !more.is_empty());
    }
}

#[test]
fn coverage_tells_what_is_never_read_from_what_was_not() {
    let folder = folder("coverage");
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
    std::fs::write(folder.join("a.frag"), text).unwrap();
    let arguments = ["verify", "a.frag", "--backend", "cpu", "--coverage", "--format", "json"];
    let covered = |more: &[&str]| -> Value {
        let output = landfall(&folder, &[&arguments[..], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", shown(&output.stderr));
        let value: Value = serde_json::from_slice(&output.stdout).unwrap();
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
    let output = landfall(&folder, &["verify", "a.frag", "--backend", "cpu", "--coverage"]);
    assert!(shown(&output.stdout).contains("16 of 144 bytes read"), "{}", shown(&output.stdout));
}

#[test]
fn a_broken_shader_leaves_the_others_alone() {
    let folder = folder("broken");
    std::fs::write(folder.join("a.frag"), GOOD).unwrap();
    std::fs::write(folder.join("b.frag"), "#version 450\nuniform B { vec33 x; };\n").unwrap();
    std::fs::write(folder.join("c.frag"), GOOD).unwrap();
    let arguments = ["verify", "a.frag", "b.frag", "gone.frag", "c.frag", "--backend", "cpu"];
    let output = landfall(&folder, &arguments);
    assert_eq!(output.status.code(), Some(2));
    let (text, said) = (shown(&output.stdout), shown(&output.stderr));
    assert!(text.contains("a.frag") && text.contains("c.frag"), "{text}");
    assert_eq!(text.matches('✓').count(), 2, "{text}");
    assert!(said.contains("vec33") && said.contains("gone.frag"), "{said}");
}

#[test]
fn record_notes_in_the_lock_who_confirmed_it() {
    let folder = folder("record");
    std::fs::write(folder.join("a.frag"), GOOD).unwrap();
    assert_eq!(landfall(&folder, &["lock", "a.frag"]).status.code(), Some(0));
    let output = landfall(&folder, &["verify", "a.frag", "--backend", "gl", "--record"]);
    assert_eq!(output.status.code(), Some(0), "{}", shown(&output.stderr));
    let lock = std::fs::read_to_string(folder.join("layouts/a.frag.json")).unwrap();
    let lock: Value = serde_json::from_str(&lock).unwrap();
    assert_eq!(lock["verified"][0]["reader"], "gl", "{lock}");
    assert!(lock["verified"][0]["driver"].as_str().unwrap().starts_with("Mesa"), "{lock}");
    let output = landfall(
        &folder,
        &["verify", "a.frag", "--backend", "cpu", "--layout", "layouts/a.frag.json"],
    );
    assert_eq!(output.status.code(), Some(0), "the lock still reads");
}

#[test]
fn the_evaluator_needs_no_driver() {
    let folder = folder("alone");
    std::fs::write(folder.join("a.frag"), GOOD).unwrap();
    for arguments in [
        &["verify", "a.frag", "--backend", "cpu"][..],
        &["verify", "a.frag", "--backend", "cpu", "--coverage"],
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_landfall"));
        command.current_dir(&folder).args(arguments);
        // A loader that is asked for any of these has nothing to load.
        command.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent");
        command.env("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent");
        command.env("LIBGL_DRIVERS_PATH", "/nonexistent");
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", shown(&output.stderr));
        assert!(shown(&output.stdout).contains("cpu ✓"));
    }
}

/// SPIR-V of a text, made by glslang.
fn compiled(folder: &Path, name: &str, text: &str) -> String {
    std::fs::write(folder.join(name), text).unwrap();
    let output = format!("{name}.spv");
    let made = Command::new("glslangValidator")
        .current_dir(folder)
        .args(["-V", name, "-o", &output])
        .output()
        .expect("glslangValidator: apt-get install glslang-tools");
    assert!(made.status.success(), "{}", shown(&made.stdout));
    output
}

#[test]
fn decorations_of_a_compilers_module_are_held_against_the_layout() {
    let folder = folder("spirv");
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
    let outcomes = |output: &Output| -> Value {
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        report["shaders"][0]["blocks"][0]["readers"][1].clone()
    };
    let same = landfall(&folder, &verify);
    let backend = outcomes(&same);
    assert_eq!((&backend["reader"], &backend["outcome"]), (&"spirv".into(), &"confirmed".into()));
    assert!(backend["reads"].as_array().unwrap().len() > 12, "{backend}");
    assert_eq!(same.status.code(), Some(0), "{}", shown(&same.stderr));
    // The shader has changed since it was compiled.
    let changed = text.replace("vec3 position; float power;", "vec3 position; vec2 power;");
    std::fs::write(folder.join("a.frag"), changed).unwrap();
    let stale = landfall(&folder, &verify);
    let backend = outcomes(&stale);
    assert_eq!(backend["outcome"], "disagrees");
    let reads = backend["reads"].as_array().unwrap();
    let power = reads.iter().find(|read| read["path"] == "lights[0].power").unwrap();
    // std140: a float follows a vec3 at 12, a vec2 is aligned to 8; the array starts at 16.
    assert_eq!((&power["byte_read"], &power["expected_byte"]), (&28.into(), &32.into()));
    assert_eq!(stale.status.code(), Some(1));
    // What is no SPIR-V.
    std::fs::write(folder.join("junk.spv"), [7u8; 64]).unwrap();
    let junk = landfall(&folder, &["verify", "a.frag", "--backend", "cpu", "--spirv", "junk.spv"]);
    assert_eq!(junk.status.code(), Some(2));
    assert!(shown(&junk.stderr).contains("not SPIR-V"), "{}", shown(&junk.stderr));
}

#[test]
fn a_compilers_module_runs_beside_ours() {
    let folder = folder("compiled");
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
    let run = |output: &Output| -> Value {
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        report["shaders"][0]["compiled"].clone()
    };
    let same = landfall(&folder, &verify);
    // Three fillings of the buffers, an image of 16 by 16, four words a pixel.
    let expected = serde_json::json!({
        "reader": "gpu", "outcome": "confirmed", "compared": 3 * 16 * 16 * 4, "differing": 0
    });
    assert_eq!(run(&same), expected);
    assert_eq!(same.status.code(), Some(0), "{}", shown(&same.stderr));
    // The member the sum begins with has moved since.
    let changed =
        text.replace("float time; Light lights[3]", "vec4 wind; float time; Light lights[3]");
    std::fs::write(folder.join("a.frag"), changed).unwrap();
    let stale = landfall(&folder, &verify);
    assert_eq!(run(&stale)["outcome"], "disagrees");
    assert_eq!(stale.status.code(), Some(1));
    let human = landfall(&folder, &verify[..6]);
    assert!(shown(&human.stdout).contains("words differ"), "{}", shown(&human.stdout));
    // What wgpu cannot bind is said, and no failure.
    let textured = "#version 450
        layout(binding = 0) uniform sampler2D t;
        layout(std140, binding = 1) uniform B { vec4 tint; };
        layout(location = 0) out vec4 colour;
        void main() { colour = tint * texture(t, vec2(0.5)); }
    ";
    let spirv = compiled(&folder, "b.frag", textured);
    let verify = ["verify", "b.frag", "--backend", "gpu", "--spirv", &spirv];
    let refused = landfall(&folder, &verify);
    assert_eq!(refused.status.code(), Some(0), "{}", shown(&refused.stderr));
    assert!(shown(&refused.stdout).contains("combined"), "{}", shown(&refused.stdout));
}
