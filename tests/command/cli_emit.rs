//! `landfall emit` and `landfall port` as people run them.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

fn landfall(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_landfall")).args(args).output().expect("the command runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A directory of this test's own, removed at the end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Scratch {
        let dir = std::env::temp_dir().join(format!("landfall-{name}-{}", std::process::id()));
        fs::create_dir_all(&dir).expect("a directory for the test");
        Scratch(dir)
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }

    fn write(&self, name: &str, text: &str) -> String {
        fs::write(self.0.join(name), text).expect("a file for the test");
        self.path(name)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

const BLOCK: &str =
    "#version 450\nlayout(std140) uniform Light { vec3 pos; float power; vec2 size; };\n";

#[test]
fn mirrors_go_to_stdout_or_whole_into_a_file() {
    let dir = Scratch::new("emit");
    let shader = dir.write("light.frag", BLOCK);
    let printed = landfall(&["emit", &shader, "--lang", "rust"]);
    assert!(printed.status.success(), "{}", text(&printed.stderr));
    let mirrors = text(&printed.stdout);
    assert!(mirrors.contains("pub struct Light {"), "{mirrors}");
    // vec3 to 12, float to 16, vec2 to 24, rounded up to 32.
    assert!(mirrors.contains("_pad_24: [u8; 8]"), "{mirrors}");

    let out = dir.path("light.rs");
    let written = landfall(&["emit", &shader, "--lang", "rust", "--out", &out]);
    assert!(written.status.success() && written.stdout.is_empty());
    assert_eq!(fs::read_to_string(&out).expect("the mirrors"), mirrors);
}

#[test]
fn the_mirrors_of_the_bench_are_not_stale() {
    let run = landfall(&[
        "emit",
        "tests/benches/lights.frag",
        "--lang",
        "rust",
        "--vectors",
        "array",
        "--no-tables",
        "--out",
        "tests/benches/lights.rs",
        "--check",
    ]);
    assert_eq!(run.status.code(), Some(0), "{}", text(&run.stderr));
}

#[test]
fn a_stale_file_is_found_and_left_alone() {
    let dir = Scratch::new("stale");
    let shader = dir.write("light.frag", BLOCK);
    let out = dir.path("light.rs");
    let check = |wanted| {
        let run = landfall(&["emit", &shader, "--lang", "rust", "--out", &out, "--check"]);
        assert_eq!(run.status.code(), Some(wanted), "{}", text(&run.stderr));
        text(&run.stderr)
    };
    assert!(check(1).contains("does not exist"));
    assert!(landfall(&["emit", &shader, "--lang", "rust", "--out", &out]).status.success());
    check(0);
    let before = fs::read(&out).expect("the mirrors");
    dir.write("light.frag", &BLOCK.replace("vec2 size", "vec4 size"));
    assert!(check(1).contains("is out of date"));
    assert_eq!(fs::read(&out).expect("the mirrors"), before);
}

#[test]
fn a_broken_shader_leaves_the_previous_output() {
    let dir = Scratch::new("kept");
    let shader = dir.write("light.frag", BLOCK);
    for (lang, file) in [("rust", "light.rs"), ("c", "light.h")] {
        let out = dir.path(file);
        assert!(landfall(&["emit", &shader, "--lang", lang, "--out", &out]).status.success());
        let before = fs::read(&out).expect("the output");
        let broken = dir.write("broken.frag", "uniform B { float a[0]; };");
        let run = landfall(&["emit", &shader, &broken, "--lang", lang, "--out", &out]);
        assert_eq!(run.status.code(), Some(2));
        assert!(text(&run.stderr).contains("array-size"));
        assert_eq!(fs::read(&out).expect("the output"), before);
    }
}

#[test]
fn a_place_that_cannot_be_written_is_one_clear_error() {
    let dir = Scratch::new("unwritable");
    let shader = dir.write("light.frag", BLOCK);
    let file = dir.write("file", "not a directory");
    let out = format!("{file}/light.rs");
    let run = landfall(&["emit", &shader, "--lang", "rust", "--out", &out]);
    assert_eq!(run.status.code(), Some(2));
    assert_eq!(text(&run.stderr).matches("error").count(), 1, "{}", text(&run.stderr));
    assert_eq!(fs::read_to_string(&file).expect("the file"), "not a directory");
}

#[test]
fn a_block_that_cannot_be_mirrored_is_named_and_the_rest_is_written() {
    let dir = Scratch::new("rest");
    let shader = dir.write(
        "sizes.wgsl",
        "override N: u32;
         struct Open { n: u32, data: array<vec4<f32>, N> }
         struct Fixed { a: vec4<f32> }
         @group(0) @binding(0) var<storage> open: Open;
         @group(0) @binding(1) var<uniform> fixed: Fixed;",
    );
    let run = landfall(&["emit", &shader, "--lang", "rust"]);
    assert_eq!(run.status.code(), Some(2));
    let (mirrors, told) = (text(&run.stdout), text(&run.stderr));
    assert!(mirrors.contains("pub struct Fixed {") && !mirrors.contains("pub struct Open"));
    assert!(told.contains("block `Open` has no mirror"), "{told}");
}

#[test]
fn a_header_is_named_after_its_file() {
    let dir = Scratch::new("header");
    let shader = dir.write("light.frag", BLOCK);
    let out = dir.path("my_lights.h");
    let run = landfall(&["emit", &shader, "--lang", "c", "--prefix", "eng_", "--out", &out]);
    assert!(run.status.success(), "{}", text(&run.stderr));
    let header = fs::read_to_string(&out).expect("the header");
    assert!(header.contains("MY_LIGHTS_H") && header.contains("eng_Light"), "{header}");
}

#[test]
fn loose_uniforms_become_one_block() {
    let dir = Scratch::new("port");
    let shader = dir.write(
        "old.frag",
        "#version 330 core\nuniform vec3 eye; // where from\nuniform float gain = 2.0;\nuniform sampler2D albedo;\n\
         in vec2 uv;\nout vec4 color;\nvoid main() { color = texture(albedo, uv) * gain + eye.x; }\n",
    );
    let run = landfall(&["port", &shader]);
    assert!(run.status.success(), "{}", text(&run.stderr));
    let (ported, told) = (text(&run.stdout), text(&run.stderr));
    assert!(ported.starts_with("#version 450"), "{ported}");
    assert!(ported.contains("// where from"), "{ported}");
    assert!(ported.contains("void main() { color = texture(albedo, uv) * gain + eye.x; }"));
    assert!(told.contains("upload: gain = 2.0"), "{told}");
    // The block is where the gathered one is: eye at 0, gain behind it.
    let new = dir.write("new.frag", &ported);
    let layout = landfall(&["layout", &new, "--format", "csv"]);
    let gathered = landfall(&["layout", &shader, "--gather", "--format", "csv"]);
    let offsets = |output: &Output| {
        let csv = text(&output.stdout);
        let mut rows = csv.lines().map(|line| line.split(',').map(str::to_string));
        let head: Vec<String> = rows.next().expect("a head").collect();
        let column = |name: &str| head.iter().position(|h| h == name).expect("the column");
        let (path, offset) = (column("path"), column("offset"));
        rows.map(|row| row.collect::<Vec<_>>())
            .map(|row| format!("{} {}", row[path], row[offset]))
            .collect::<Vec<_>>()
    };
    assert_eq!(offsets(&layout), ["eye 0", "gain 12"]);
    assert_eq!(offsets(&gathered), ["eye 0", "gain 12"]);
}

#[test]
fn what_cannot_be_ported_says_why() {
    let dir = Scratch::new("unportable");
    let shader = dir.write(
        "old.frag",
        "#version 120\nvoid main() { gl_FragColor = gl_LightSource[0].diffuse; }\n",
    );
    let run = landfall(&["port", &shader]);
    assert_eq!(run.status.code(), Some(2));
    assert!(run.stdout.is_empty());
    let told = text(&run.stderr);
    assert!(told.contains("gl_LightSource") && told.contains("old.frag:2:30"), "{told}");
    assert_eq!(landfall(&["port", &dir.path("nowhere.frag")]).status.code(), Some(2));
}
