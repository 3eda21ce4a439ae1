//! Options and files that have no effect, or cannot be used, are named: adapters, locations,
//! include directories, ignore files that never end, files with the name of a product.

use std::fs;
use std::process::Command;

use snapbox::str;

use crate::cli_check::place::CLEAN;
use crate::support::command::Place;

/// A shader that tests `VULKAN` and names no API.
const BOTH: &str = "#version 450
#ifdef VULKAN
#define COUNT 3
#else
#define COUNT 4
#endif
struct PointLight { vec3 position; float range; vec3 color; float intensity; };
layout(std140, binding = 0) uniform U { PointLight lights[COUNT]; };
layout(location = 0) out vec4 o;
void main() { o = vec4(lights[0].color, 1.0); }
";

fn project(name: &str) -> Place {
    let place = Place::new(&format!("effect-{name}"));
    place.write("a.frag", CLEAN);
    place
}

#[test]
fn an_adapter_that_nothing_runs_on_is_warned_of() {
    let place = project("adapter");
    place.write("f.frag", "#version 450\nfloat f(float x) { return x * 2.0; }\nvoid main() {}\n");
    let commands: [&[&str]; 4] = [
        &["run", "f.frag", "--fn", "f", "--args", "[1]"],
        &["verify", "a.frag", "--backend", "cpu"],
        &["stress", "f.frag", "--fn", "f", "--samples", "10"],
        &["bench", "f.frag", "--fn", "f", "--backend", "cpu", "--rounds", "3"],
    ];
    for command in commands {
        let ran = place.run(&[command, &["--adapter", "nope"]].concat());
        let warning = "warning[unused-option]: `--adapter nope` has no effect without \
                       `--backend gpu`\n";
        assert!(ran.code < 2 && ran.err.contains(warning), "{command:?}: {}", ran.err);
        assert!(!place.run(command).err.contains("unused-option"), "{command:?}");
    }
}

#[test]
fn a_location_of_no_name_is_warned_of() {
    let place = project("location");
    let text = "#version 330\nin vec2 uv;\nout vec4 o;\nvoid main() { o = vec4(uv, 0.0, 1.0); }\n";
    place.write("a.frag", text);
    let ran = place.run(&["port", "a.frag", "--location", "nope=3", "-o", "b.frag"]);
    ran.code(0).stderr_eq(str![[r#"
location 0 in: uv
location 0 out: o
warning[unknown-name]: `--location nope` has no effect: nothing has this name
 --> a.frag
  |
  = help: name an input or output of the stage


"#]]);
    let ran = place.run(&["port", "a.frag", "--location", "uv=3", "-o", "b.frag"]);
    ran.code(0).stderr_eq(str![[r#"
location 3 in: uv
location 0 out: o

"#]]);
}

#[test]
fn an_include_directory_of_the_configuration_that_is_none_is_warned_of() {
    let place = project("include");
    place.write("landfall.toml", "include = [\"nope\", \"a.frag\"]\n");
    for command in [&["check"][..], &["lock"], &["verify", ".", "--backend", "cpu"]] {
        let ran = place.run(command);
        let warnings: Vec<&str> =
            ran.err.lines().filter(|line| line.contains("no-include-dir")).collect();
        assert_eq!(
            warnings,
            [
                "warning[no-include-dir]: `nope` does not exist; no include is searched there",
                "warning[no-include-dir]: `a.frag` is not a directory; no include is searched \
                 there"
            ],
            "{command:?}"
        );
    }
}

#[test]
fn an_ignore_file_that_never_ends_is_refused() {
    for file in [".gitignore", ".ignore", ".git/info/exclude"] {
        for folder in ["", "tree/", "tree/sub/"] {
            let place = project("ignore");
            place.write("tree/sub/b.frag", CLEAN);
            let path = place.0.join(folder).join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
            for command in [&["layout", "tree"][..], &["check"], &["lock", "tree"]] {
                let ran = place.run(&[command, &["--max-time", "20"]].concat());
                let said = ran.out.clone() + &ran.err;
                assert_eq!(ran.code, 2, "{command:?} with {folder}{file}: {said}");
                let error = format!("{folder}{file}` is not a regular file");
                assert!(said.contains(&error), "{command:?}: {said}");
            }
            // A file that is named itself needs no walk.
            place.run(&["layout", "tree/sub/b.frag", "--max-time", "20"]).code(0);
        }
    }
}

#[test]
fn a_file_with_the_name_of_a_cache_is_kept() {
    let place = project("cache");
    place.run(&["check", "--cache-dir", "c"]).code(0);
    let mut entries = fs::read_dir(place.0.join("c")).unwrap().flatten().map(|e| e.path());
    let cache = entries.find(|path| path.extension().is_some()).expect("a cache was written");
    fs::write(&cache, "mine").unwrap();
    let ran = place.run(&["check", "--cache-dir", "c"]);
    assert_eq!(fs::read_to_string(&cache).unwrap(), "mine");
    let note = ran.err.lines().find(|line| line.starts_with("the cache is not used"));
    let note =
        note.expect("it is said").replace(&*cache.file_name().unwrap().to_string_lossy(), "CACHE");
    assert_eq!(note, "the cache is not used: `c/CACHE` is not a cache of landfall");
    ran.code(0);
}

#[test]
fn a_picture_that_landfall_did_not_write_is_kept() {
    let place = project("picture");
    place.write(
        "scene.json",
        r#"{"size": [8, 8], "camera": {"position": [0, 0, 4], "target": [0, 0, 0],
            "up": [0, 1, 0], "fov": 60}, "lights": {"point": [{"position": [0, 3, 3],
            "color": [9, 9, 9]}]}, "materials": [{"name": "grey", "diffuse": 0.8}],
            "objects": [{"mesh": "plane"}]}"#,
    );
    let render = |more: &[&str]| {
        let first = ["render", "scene.json", "--reference", "--model", "multi"];
        place.run(&[&first[..], more].concat())
    };
    let all = ["-o", "p.png", "--compare", "reference"];
    render(&all).code(0);
    // Its own pictures are overwritten.
    render(&all).code(0);
    let derived = place.0.join("p.reference.flip.png");
    fs::write(&derived, "mine").unwrap();
    render(&all).code(2).stderr_eq(str![[r#"
error[cannot-write]: `p.reference.flip.png` exists and is not a picture of landfall
  |
  = help: move it, or choose another name for `--out`


"#]]);
    assert_eq!(fs::read_to_string(&derived).unwrap(), "mine");
    // Nothing is written where the picture itself is refused.
    fs::remove_file(&derived).unwrap();
    fs::remove_file(place.0.join("p.reference.difference.png")).unwrap();
    fs::copy(place.0.join("p.png"), place.0.join("q.png")).unwrap();
    fs::remove_file(place.0.join("p.png")).unwrap();
    fs::hard_link(place.0.join("q.png"), place.0.join("p.png")).unwrap();
    render(&["-o", "p.png", "--compare", "q.png"]).code(2);
    assert!(!place.0.join("p.q.flip.png").exists());
}

#[test]
fn a_directory_of_other_languages_names_them() {
    let place = project("languages");
    for name in ["a.slang", "b.hlsl", "c.metal"] {
        place.write(&format!("d/{name}"), "x");
    }
    place.run(&["layout", "d"]).code(2).stderr_eq(str![[r#"
error[no-input]: `d` contains no GLSL or WGSL shader, only HLSL, Metal, Slang
  |
  = help: landfall reads GLSL and WGSL; to read a file as one of them, name it and pass `--language`


"#]]);
}

#[test]
fn a_configuration_that_is_a_directory_and_a_shader_without_blocks_are_named() {
    let place = project("config");
    fs::remove_file(place.0.join("landfall.toml")).unwrap();
    fs::create_dir(place.0.join("landfall.toml")).unwrap();
    place.run(&["check"]).code(2).stderr_eq(str![[r#"
error[unreadable-file]: `landfall.toml` is the configuration but not a file
  |
  = help: remove it, or ignore it with `--no-config`


"#]]);
    place.write("e.frag", "#version 450\nvoid main() {}\n");
    place.run(&["emit", "e.frag", "--lang", "c", "--no-config"]).stderr_eq(str![[r#"
warning[no-blocks]: no blocks to mirror


"#]]);
}

#[test]
fn every_command_says_which_api_was_assumed() {
    let place = project("assumed");
    place.write("b.frag", BOTH).write("v.json", "{}");
    let long = "read for Vulkan, as the shader names no API; its blocks differ for OpenGL";
    let json = "\"assumed_target\":\"vulkan\"";
    let warning = "read for Vulkan: the shader tests `VULKAN` and is valid for both APIs";
    let commands: [(&str, &str); 12] = [
        ("layout b.frag", long),
        ("layout b.frag -f md", long),
        ("layout b.frag -f listing", long),
        ("layout b.frag -f json", json),
        ("layout b.frag -f csv", ",vulkan\n"),
        ("emit b.frag --lang c", long),
        ("emit b.frag --lang rust", long),
        ("lights b.frag", long),
        ("lights b.frag -f json", json),
        ("verify b.frag --backend cpu", long),
        ("verify b.frag --backend cpu -f json", json),
        ("explain b.frag lights[1].color", warning),
    ];
    for (command, said) in commands {
        let arguments: Vec<&str> = command.split(' ').collect();
        let ran = place.run(&arguments);
        assert!((ran.out.clone() + &ran.err).contains(said), "{command}: {}{}", ran.out, ran.err);
        let given = place.run(&[&arguments[..], &["--target", "vulkan"]].concat());
        assert!(!(given.out + &given.err).contains(said), "{command} --target vulkan");
    }
    for command in ["encode b.frag v.json -o bytes", "decode b.frag bytes"] {
        let ran = place.run(&command.split(' ').collect::<Vec<_>>());
        assert!(ran.err.contains(warning), "{command}: {}", ran.err);
    }
}

#[test]
fn options_of_emit_for_another_language_are_warned_of() {
    let place = project("emit");
    let said = |arguments: &[&str]| {
        let ran = place.run(&[&["emit", "a.frag", "--lang"][..], arguments].concat());
        assert_eq!(ran.code, 0, "{}", ran.err);
        ran.err.lines().filter(|line| line.contains("unused-option")).count()
    };
    assert_eq!(said(&["c", "--vectors", "array", "--no-tables", "--crate-visible"]), 2);
    assert_eq!(said(&["zig", "--vectors", "array", "--prefix", "a_"]), 1);
    assert_eq!(said(&["rust", "--prefix", "x_", "--namespace", "n", "--include-header", "h"]), 3);
    assert_eq!(said(&["rust", "--vectors", "array", "--no-tables"]), 0);
    assert_eq!(said(&["c", "--prefix", "x_"]), 0);
}

#[test]
fn a_table_without_figures_is_refused() {
    let place = project("table");
    place.write("landfall.toml", "[[table]]\nblock = \"Light\"\n");
    let ran = place.run(&["check"]);
    ran.code(2).stderr_eq(str![[r#"
error[missing-key]: a table without `size` and `offsets` checks nothing
 --> landfall.toml:1:1
  |
1 | [[table]]
  | ^^^^^^^^^
  |
  = help: add `size = …`, or a row to `offsets`


"#]]);
}

#[test]
fn an_override_of_another_type_is_refused() {
    let place = project("override");
    let text = "#version 450\nlayout(constant_id = 3) const int N = 2;\n\
                layout(std140, binding = 0) uniform U { vec4 a[N]; };\nvoid main() {}\n";
    place.write("b.frag", text);
    for (value, said) in [("2.5", 2), ("true", 2), ("5", 0)] {
        let ran = place.run(&["layout", "b.frag", "-O", &format!("3={value}")]);
        assert_eq!(ran.code, said, "{value}: {}", ran.err);
    }
}

/// glslangValidator searches the folders of all open files before those of `-I`.
#[test]
fn an_include_that_compilers_find_elsewhere_is_warned_of() {
    let place = project("include-elsewhere");
    place.write("sub/z.glsl", "#include \"x.glsl\"\n").write("x.glsl", "vec2 c;\n");
    let text = "#version 450\n#extension GL_GOOGLE_include_directive : enable\n\
                layout(std140, binding = 0) uniform U { float s;\n#include \"sub/z.glsl\"\n\
                vec4 h; } u;\nlayout(location = 0) out vec4 o;\nvoid main() { o = u.h; }\n";
    place.write("t.frag", text);
    let glslang = |folders: &[&str]| {
        let mut command = Command::new("glslangValidator");
        let command = command.args(["-V", "-q", "-l", "t.frag"]).args(folders);
        let output = command.current_dir(&place.0).output().expect("glslangValidator");
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    // `c` is at 8 and `h` at 16, also with another file in a folder of `-I`.
    let of_block = "U: offset -1, type ffffffff, size 32";
    assert!(glslang(&[]).contains(of_block), "{}", glslang(&[]));
    let ran = place.run(&["layout", "t.frag", "-f", "csv"]);
    assert_eq!((ran.code, &*ran.err), (0, ""));
    assert!(ran.out.contains(",c,vec2,8,"), "{}", ran.out);
    // The same file by another path.
    let ran = place.run(&["layout", "t.frag", "-f", "csv", "-I", "./sub/.."]);
    assert_eq!((ran.code, &*ran.err), (0, ""));
    place.write("inc/x.glsl", "vec3 b;\n");
    assert!(glslang(&["-Iinc"]).contains(of_block), "{}", glslang(&["-Iinc"]));
    let ran = place.run(&["layout", "t.frag", "-f", "csv", "-I", "inc"]);
    assert!(ran.out.contains(",b,vec3,16,"), "{}", ran.out);
    ran.stderr_eq(str![[r#"
warning[include]: `x.glsl` is read from `inc/x.glsl`
 --> sub/z.glsl:1:2
  |
1 | #include "x.glsl"
  |  ^^^^^^^^^^^^^^^^
  |
  = note: glslangValidator reads `x.glsl`
  = help: give one of them another name


"#]]);
}
