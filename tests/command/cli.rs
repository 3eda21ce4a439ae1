//! The command line as a user meets it: streams, exit codes, inputs, files written.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const LIGHTS: &str = "#version 330 core
struct PointLight { vec3 pos; vec3 color; float intensity, constant, linear, quadratic; };
layout(std140) uniform PointLightBlock {
    PointLight data[128];
    int actually_used_count;
} u_point_light_array;
layout(std140) uniform View { mat4 view; vec3 eye; };
";

/// A folder of its own for one test, and landfall run in it.
struct Place(PathBuf);

struct Ran {
    code: i32,
    out: String,
    err: String,
}

impl Place {
    fn new(name: &str) -> Place {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("cli-{name}"));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Place(path)
    }

    fn write(&self, path: &str, text: impl AsRef<[u8]>) -> &Place {
        let path = self.0.join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
        self
    }

    fn read(&self, path: &str) -> String {
        fs::read_to_string(self.0.join(path)).unwrap()
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_landfall"));
        command.args(arguments).current_dir(&self.0).env_remove("NO_COLOR").env("TERM", "xterm");
        command.env_remove("CLICOLOR_FORCE");
        command
    }

    fn run(&self, arguments: &[&str]) -> Ran {
        Ran::of(self.command(arguments).output().unwrap())
    }

    fn run_with_stdin(&self, arguments: &[&str], stdin: &[u8]) -> Ran {
        let mut child = self
            .command(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        child.stdin.take().unwrap().write_all(stdin).unwrap();
        Ran::of(child.wait_with_output().unwrap())
    }
}

impl Ran {
    fn of(output: Output) -> Ran {
        Ran {
            code: output.status.code().expect("not killed"),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

#[test]
fn a_layout_goes_to_stdout_and_nothing_to_stderr() {
    let place = Place::new("layout");
    let ran = place.write("a.frag", LIGHTS).run(&["layout", "a.frag"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    assert!(ran.out.contains("    6144     4      4          int         actually_used_count\n"));
    assert!(!ran.out.contains('\x1b'));
}

#[test]
fn colours_are_given_on_request_only() {
    let place = Place::new("colour");
    place.write("a.frag", LIGHTS);
    assert!(place.run(&["layout", "a.frag", "--color", "always"]).out.contains('\x1b'));
    assert!(!place.run(&["--color", "never", "layout", "a.frag"]).out.contains('\x1b'));
    let json = place.run(&["layout", "a.frag", "--color", "always", "--format", "json"]).out;
    assert!(!json.contains('\x1b'));
}

#[test]
fn every_format_ends_in_a_newline_and_names_the_block() {
    let place = Place::new("formats");
    place.write("a.frag", LIGHTS);
    for format in ["table", "listing", "json", "csv", "md"] {
        let ran = place.run(&["layout", "a.frag", "--format", format]);
        assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{format}");
        assert!(ran.out.contains("PointLightBlock") && ran.out.ends_with('\n'), "{format}");
    }
}

#[test]
fn directories_are_searched_in_order_and_each_file_once() {
    let place = Place::new("directories");
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
    let place = Place::new("missing");
    place.write("a.frag", LIGHTS).write("bin.frag", b"\xff\xfe\0x").write("empty/x.txt", "");
    for (argument, words) in [
        ("gone.frag", "`gone.frag` cannot be read: no such file or directory"),
        ("*.wgsl", "`*.wgsl` matches no shader file"),
        ("empty", "`empty` contains no shader file"),
        ("bin.frag", "`bin.frag` is UTF-16"),
    ] {
        let ran = place.run(&["layout", argument, "a.frag"]);
        assert_eq!(ran.code, 2, "{argument}");
        assert!(ran.err.contains(words), "{argument}: {}", ran.err);
        assert_eq!(ran.err.matches("error[").count(), 1, "{argument}");
        assert!(ran.out.contains("PointLightBlock"), "{argument}");
    }
}

#[test]
fn stdin_goes_by_the_name_it_is_given() {
    let place = Place::new("stdin");
    let ran = place.run_with_stdin(&["layout", "-"], LIGHTS.as_bytes());
    assert!(ran.code == 0 && ran.out.starts_with("<stdin>\n"), "{}", ran.err);
    let named = ["layout", "-", "--stdin-filename", "x/y.frag", "-f", "json"];
    let ran = place.run_with_stdin(&named, LIGHTS.as_bytes());
    assert!(ran.out.contains("\"path\":\"x/y.frag\",\"language\":\"glsl\",\"stage\":\"fragment\""));
}

#[test]
fn an_unknown_extension_is_read_as_glsl_when_named() {
    let place = Place::new("extension");
    let ran = place.write("lights.inc", LIGHTS).run(&["layout", "lights.inc", "--stage", "vert"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    assert!(ran.out.starts_with("lights.inc (vertex)\n"));
}

#[test]
fn block_keeps_one_block_by_its_name_or_its_instances() {
    let place = Place::new("block");
    place.write("a.frag", LIGHTS).write("b.frag", "#version 330\nuniform float x;\n");
    for name in ["PointLightBlock", "u_point_light_array"] {
        let ran = place.run(&["layout", ".", "--block", name]);
        assert_eq!((ran.code, ran.err.as_str()), (0, ""));
        assert!(ran.out.contains("PointLightBlock") && !ran.out.contains("View"));
        assert!(!ran.out.contains("b.frag"));
    }
    let ran = place.run(&["layout", "a.frag", "--block", "Gone"]);
    assert_eq!(ran.code, 2);
    assert!(ran.err.contains("no block named `Gone` in `a.frag`"), "{}", ran.err);
    assert!(ran.err.contains("`PointLightBlock`"), "{}", ran.err);
}

#[test]
fn rules_and_expand_change_the_numbers_and_the_rows() {
    let place = Place::new("rules");
    place.write("a.frag", LIGHTS);
    let scalar = place.run(&["layout", "a.frag", "--rules", "scalar", "-b", "PointLightBlock"]);
    assert!(scalar.out.contains("· scalar · 5124 bytes"), "{}", scalar.out);
    let expanded = place.run(&["layout", "a.frag", "--expand", "-f", "json"]).out;
    assert!(expanded.contains("\"data[3].color\":160,\n"), "{expanded}");
    let rows = place.run(&["layout", "a.frag", "--expand", "-f", "csv"]).out;
    assert_eq!(rows.lines().count(), 1 + 128 * 6 + 1 + 2);
}

#[test]
fn more_elements_than_a_bound_are_refused_by_number() {
    let place = Place::new("many");
    place.write("a.comp", "#version 430\nlayout(std430) buffer B { float x[2000000]; };\n");
    let ran = place.run(&["layout", "a.comp", "--expand", "-f", "json"]);
    assert_eq!(ran.code, 2);
    assert!(ran.err.contains("has 2000000 elements, `--expand` writes at most 1000000"));
    assert!(!ran.out.contains("\"offsets\""));
    assert!(ran.out.contains("\"size\":8000000"));
}

#[test]
fn out_writes_a_file_a_shader_only_when_changed() {
    let place = Place::new("out");
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
    let place = Place::new("out-refused");
    place.write("s/a.frag", LIGHTS).write("t/a.frag", LIGHTS).write("file", "in the way");
    let ran = place.run(&["layout", "s", "t", "-f", "json", "--out", "o"]);
    assert_eq!(ran.code, 2);
    assert!(
        ran.err.contains("would be written twice: for `s/a.frag` and `t/a.frag`"),
        "{}",
        ran.err
    );
    let ran = place.run(&["layout", "s", "-f", "json", "--out", "file"]);
    assert_eq!(ran.code, 2);
    assert!(ran.err.contains("`file` cannot be created as a directory"), "{}", ran.err);
    assert_eq!(place.read("file"), "in the way");
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_one_error_and_a_closed_pipe_is_none() {
    let place = Place::new("full");
    place.write("a.frag", LIGHTS);
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let ran = Ran::of(place.command(&["layout", "a.frag"]).stdout(full).output().unwrap());
    assert_eq!(ran.code, 2);
    assert!(
        ran.err.contains("`<stdout>` cannot be written: no space left on device"),
        "{}",
        ran.err
    );
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
    let place = Place::new("errors");
    let bad = "uniform A { vec33 x; };\nuniform B { float y; };\nuniform C { float z[0]; };\n";
    place.write("bad.frag", bad).write("good.frag", LIGHTS);
    let ran = place.run(&["layout", "bad.frag", "good.frag"]);
    assert_eq!(ran.code, 2);
    assert!(ran.err.contains(" --> bad.frag:1:13\n"), "{}", ran.err);
    assert_eq!(ran.err.matches("error[").count(), 2, "{}", ran.err);
    assert!(ran.out.contains("uniform B ·") && ran.out.contains("PointLightBlock"), "{}", ran.out);
    place.write("broken.frag", "uniform B { float y; };\nuniform C { float\n");
    let ran = place.run(&["layout", "broken.frag"]);
    assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{}", ran.err);
}

#[test]
fn a_file_without_blocks_is_a_warning() {
    let place = Place::new("no-blocks");
    place.write("a.vert", "#version 330\nvoid main() {}\n");
    let ran = place.run(&["layout", "a.vert"]);
    assert_eq!((ran.code, ran.out.as_str()), (0, ""));
    assert!(ran.err.starts_with("warning[no-blocks]: no blocks and no loose uniforms in `a.vert`"));
    assert_eq!(place.run(&["layout", "-q", "a.vert"]).err, "");
}

#[test]
fn explain_leads_to_a_path_and_to_the_owner_of_a_byte() {
    let place = Place::new("explain");
    place.write("a.frag", LIGHTS);
    let ran = place.run(&["explain", "a.frag", "data[3].color"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    for line in [
        "uniform PointLightBlock u_point_light_array · std140\n",
        "      stride 48: an element's 44 bytes, rounded up to 16\n      3 × 48 = 144\n",
        "      std140 rule 3: a vector of 3 components is aligned to 4 of them\n",
        "      `pos` ends at 12, rounded up to 16: 16\n      144 + 16 = 160\n",
        "  data[3].color: bytes 160 to 171, 12 bytes\n",
    ] {
        assert!(ran.out.contains(line), "{line}\n{}", ran.out);
    }
    let ran = place.run(&["explain", "a.frag", "@172", "--block", "PointLightBlock"]);
    assert!(ran.out.contains("byte 172 is byte 0 of 4 of data[3].intensity"), "{}", ran.out);
    let ran = place.run(&["explain", "a.frag", "@0x2d", "-b", "PointLightBlock"]);
    let words = "byte 45 is padding: tail padding of structure data[0], after `quadratic`";
    assert!(ran.out.contains(words), "{}", ran.out);
    // Both blocks have a byte 12: both answer.
    assert_eq!(place.run(&["explain", "a.frag", "@12"]).out.matches("byte 12 is").count(), 2);
}

#[test]
fn explain_says_why_a_path_leads_nowhere() {
    let place = Place::new("explain-nowhere");
    place.write("a.frag", LIGHTS).write("loose.frag", "#version 330\nuniform vec3 eye;\n");
    for (file, path, words) in [
        ("a.frag", "data[3].colour", "help: there is a member `color`"),
        ("a.frag", "data[128]", "`data[128]` is out of range: `data` has 128 elements"),
        ("a.frag", "eye[1].x", "`eye.y` has type `float`"),
        ("a.frag", "data.color", "help: it is an array: write `data[0].color`"),
        ("a.frag", "@6160", "byte 6160 lies in no block"),
        ("a.frag", "data[", "`data[` is not a path: expected `]` at character 6"),
        ("loose.frag", "eye", "help: `--gather` lays out loose uniforms"),
    ] {
        let ran = place.run(&["explain", file, path]);
        assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{path}");
        assert!(ran.err.contains(words), "{path}: {}", ran.err);
    }
    let ran = place.run(&["explain", "loose.frag", "eye", "--gather"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
}

#[test]
fn wgsl_is_listed_and_explained_in_its_own_words() {
    let place = Place::new("wgsl");
    let text = "struct Light { pos: vec3<f32>, @size(16) k: f32 }
struct Lights { n: u32, all: array<Light> }
@group(0) @binding(1) var<storage> lights: Lights;
@group(0) @binding(2) var<uniform> turn: mat3x3<f32>;
";
    place.write("a.wgsl", text);
    let listing = place.run(&["layout", "a.wgsl", "-f", "listing"]).out;
    for line in [
        "/* offset( 0) align(16) size(12) */     pos : vec3<f32>,\n",
        "/* offset(12) align( 4) size(16) */     k : f32,\n",
        "/* offset(16)           size(12) */     // -- tail padding of k\n",
        "@group(0) @binding(1) var<storage> lights : Lights;\n",
        "@group(0) @binding(2) var<uniform> turn : mat3x3<f32>;\n",
    ] {
        assert!(listing.contains(line), "{line}\n{listing}");
    }
    let ran = place.run(&["explain", "a.wgsl", "lights.all[2].k"]);
    assert!(ran.out.contains("WGSL §14.4.3: "), "{}", ran.out);
    assert!(ran.out.contains("size 4, raised to 16 in the shader"), "{}", ran.out);
    assert!(ran.out.contains("all[2].k: bytes 92 to 107, 16 bytes"), "{}", ran.out);
    let ran = place.run(&["explain", "a.wgsl", "@34", "-b", "lights"]);
    assert!(ran.out.contains("padding: tail padding of member all[0].k"), "{}", ran.out);
}

#[test]
fn wrong_usage_is_2_and_help_is_0() {
    let place = Place::new("usage");
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
    for chain in ["1+".repeat(50_000), "true?1:".repeat(20_000), "- ".repeat(20_000)] {
        let text = format!("#version 450\nconst int N = {chain}1;\n{block}");
        let path = std::env::temp_dir().join(format!("landfall-chain-{}.frag", std::process::id()));
        std::fs::write(&path, text).expect("a file for the test");
        let run = std::process::Command::new(env!("CARGO_BIN_EXE_landfall"))
            .args(["layout", "--format", "json"])
            .arg(&path)
            .output()
            .expect("the command runs");
        std::fs::remove_file(&path).expect("the test's own file");
        assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
        assert!(String::from_utf8_lossy(&run.stdout).contains("\"path\":\"a[]\""));
    }
}
