//! Outputs that the command refuses to write: over inputs, read-only files, a closed stdout.

pub mod campaign;
#[cfg(target_os = "linux")]
mod disk;
mod links;
mod other_files;

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};

use snapbox::str;

use crate::cli_check::place::CLEAN;
use crate::support::command::{Place, Ran, golden};

const LEGACY: &str = "#version 120
uniform vec3 tint;
void main() { gl_FragColor = vec4(tint, 1.0); }
";

const WITH: &str = "#version 450
#include \"light.inc\"
layout(std140, binding = 0) uniform B { Light light; } b;
layout(location = 0) out vec4 color;
float bend(float x) { return x * b.light.color.x; }
void main() { color = b.light.color; }
";

/// A project whose files are inputs of one command or another.
fn project(name: &str) -> Place {
    let place = Place::new(&format!("writers-{name}"));
    place.write("s/a.frag", WITH).write("s/light.inc", "struct Light { vec4 color; };\n");
    place.write("s/old.frag", LEGACY).write("v.json", "{}").write("d.svg", "{\"x\": [0, 1]}");
    place
}

/// A scene without a shader.
pub fn scene() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/scenes/six_lights.json");
    let mut scene: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    scene.as_object_mut().unwrap().retain(|key, _| key != "shader" && key != "$schema");
    scene.to_string()
}

/// Every file below a folder with its bytes, links as where they lead.
pub fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let shown = path.display().to_string();
        if path.is_symlink() {
            let leads = fs::read_link(&path).unwrap();
            found.push((shown, leads.display().to_string().into_bytes()));
        } else if path.is_dir() {
            found.extend(files(&path));
        } else if path.is_file() {
            found.push((shown, fs::read(&path).unwrap()));
        }
    }
    found.sort();
    found
}

#[test]
fn no_output_is_written_over_an_input() {
    let place = project("inputs");
    assert_eq!(place.run(&["lock", "s"]).code, 0);
    let run = ["--samples", "50", "--time", "1"];
    let map = ["--map-x", "x", "--map-y", "b.light.color.x"];
    let cases: [(&str, Vec<&str>); 14] = [
        ("s/a.frag", vec!["emit", "s/a.frag", "--lang", "rust", "-o"]),
        ("s/light.inc", vec!["emit", "s/a.frag", "--lang", "c", "-o"]),
        ("s/a.frag", vec!["encode", "s/a.frag", "v.json", "-o"]),
        ("v.json", vec!["encode", "s/a.frag", "v.json", "-o"]),
        ("v.json", vec!["encode", "s/a.frag", "v.json", "--hex", "-o"]),
        ("s/light.inc", vec!["encode", "s/a.frag", "v.json", "-o"]),
        ("s/old.frag", vec!["port", "s/old.frag", "-o"]),
        ("s/a.frag", vec!["port", "s/old.frag", "--partner", "s/a.frag", "-o"]),
        ("s/a.frag", vec!["check", "s", "-f", "json="]),
        ("s/light.inc", vec!["check", "s", "-f", "sarif="]),
        ("landfall.toml", vec!["check", "s", "-f", "human="]),
        ("layouts/s/a.frag.json", vec!["check", "s", "-f", "junit="]),
        (
            "d.svg",
            [
                &["stress", "s/a.frag", "--fn", "bend", "--domain", "d.svg"],
                &run[..],
                &map,
                &["--map"],
            ]
            .concat(),
        ),
        (
            "d.svg",
            vec![
                "bench",
                "s/a.frag",
                "--fn",
                "bend",
                "--domain",
                "d.svg",
                "--backend",
                "cpu",
                "--rounds",
                "3",
                "--samples",
                "16",
                "--plot",
            ],
        ),
    ];
    // What each command said, with its target as `FILE`.
    let mut said = BTreeSet::new();
    for (target, command) in cases {
        let kind = Path::new(target).extension().unwrap().to_str().unwrap();
        let (link, hard) = (format!("link.{kind}"), format!("hard.{kind}"));
        symlink(target, place.0.join(&link)).unwrap();
        fs::hard_link(place.0.join(target), place.0.join(&hard)).unwrap();
        let before = files(&place.0);
        let behind = format!("/proc/self/cwd/{target}");
        for target in [target, &link, &hard, &behind] {
            let mut all = command.clone();
            let joined = format!("{}{target}", all.last().unwrap());
            match all.last().unwrap().ends_with('=') {
                true => *all.last_mut().unwrap() = &joined,
                false => all.push(target),
            }
            let ran = place.run(&all);
            assert_eq!(ran.code, 2, "{all:?}: {}\n{}", ran.out, ran.err);
            said.insert(ran.err.replace(&format!("`{target}`"), "`FILE`"));
            assert!(files(&place.0) == before, "{all:?} changed a file");
        }
        fs::remove_file(place.0.join(link)).unwrap();
        fs::remove_file(place.0.join(hard)).unwrap();
    }
    golden().eq(
        said.into_iter().collect::<String>(),
        str![[r#"
error[cannot-write]: `FILE` is an input of this command, and would be overwritten
  |
  = help: name another file for the output


"#]],
    );
}

#[test]
fn a_picture_is_not_written_over_the_one_it_is_compared_with_nor_over_the_scene() {
    let place = project("picture");
    place.write("scene.pfm", scene());
    let render = ["render", "scene.pfm", "--reference", "--model", "multi", "--size", "8x8", "-o"];
    let ran = place.run(&[&render[..], &["a.png"]].concat());
    assert_eq!(ran.code, 0, "{}", ran.err);
    let before = files(&place.0);
    let over = [&render[..], &["scene.pfm"]].concat();
    place.run(&over).code(2).stderr_eq(str![[r#"
error[cannot-write]: `scene.pfm` is an input of this command, and would be overwritten
  |
  = help: name another file for the output


"#]]);
    let compared = [&render[..], &["a.png", "--compare", "a.png"]].concat();
    place.run(&compared).code(2).stderr_eq(str![[r#"
error[cannot-write]: `a.png` is an input of this command, and would be overwritten
  |
  = help: name another file for the output


"#]]);
    let unchanged = |path: &str| {
        let at = place.0.join(path).display().to_string();
        before.iter().find(|(name, _)| *name == at).unwrap().1 == fs::read(at).unwrap()
    };
    assert!(unchanged("scene.pfm") && unchanged("a.png"));
}

/// Meshes and textures that a scene names, and the scene, by their names and through links.
#[test]
fn nothing_is_drawn_over_the_files_of_a_scene() {
    let place = project("scene");
    for (kind, command) in [
        ("png", "render scene.png --reference -o"),
        ("svg", "bench scene.svg --backend cpu --rounds 3 --plot"),
    ] {
        let name = |name: &str| format!("{name}.{kind}");
        let mut scene: serde_json::Value = serde_json::from_str(&scene()).unwrap();
        scene["size"] = serde_json::json!([4, 4]);
        scene["model"] = "multi".into();
        place.write("plain.json", scene.to_string());
        let drawn = ["render", "plain.json", "--reference", "-o", "t.png"];
        assert_eq!(place.run(&drawn).code, 0);
        fs::copy(place.0.join("t.png"), place.0.join(name("texture"))).unwrap();
        place.write(&name("mesh"), "v 0 0 0\nv 2 0 0\nv 0 2 0\nvn 0 0 1\nf 1//1 2//1 3//1\n");
        let material = serde_json::json!({"name": "m", "diffuse": {"png": name("texture")}});
        scene["materials"] = serde_json::json!([material]);
        let object = serde_json::json!({"mesh": {"obj": name("mesh")}});
        scene["objects"].as_array_mut().unwrap().push(object);
        place.write(&name("scene"), scene.to_string());
        for input in ["scene", "mesh", "texture"].map(name) {
            let link = name("link");
            symlink(&input, place.0.join(&link)).unwrap();
            let before = files(&place.0);
            for target in [&input, &link, &format!("/proc/self/cwd/{input}")] {
                let command: Vec<&str> = command.split(' ').chain([target.as_str()]).collect();
                let ran = place.run(&command);
                let said = format!("`{target}` is an input of this command");
                assert!(ran.code == 2 && ran.err.contains(&said), "{command:?}: {}", ran.err);
                assert!(files(&place.0) == before, "{command:?} changed a file");
            }
            fs::remove_file(place.0.join(link)).unwrap();
        }
    }
}

#[test]
fn two_reports_of_one_file_by_two_names_are_refused() {
    let place = Place::new("writers-twice");
    place.write("a.frag", CLEAN).write("r.json", "");
    symlink("r.json", place.0.join("link.json")).unwrap();
    let command = ["check", "a.frag", "-f", "json=r.json", "-f", "sarif=link.json"];
    place.run(&command).code(2).stderr_eq(str![[r#"
error[cannot-write]: `link.json` is an input of this command, and would be overwritten
  |
  = help: name another file for the output


"#]]);
    assert!(place.read("r.json").contains("\"findings\""));
}

#[test]
fn a_read_only_file_stays() {
    let place = project("readonly");
    place.write("m.rs", "mine");
    let mut permissions = fs::metadata(place.0.join("m.rs")).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(place.0.join("m.rs"), permissions).unwrap();
    let command = ["emit", "s/a.frag", "--lang", "rust", "-o", "m.rs"];
    place.run(&command).code(2).stderr_eq(str![[r#"
error[cannot-write]: `m.rs` cannot be written: it is read-only
  |
  = help: make it writable, or name another file


"#]]);
    assert_eq!(place.read("m.rs"), "mine");
}

#[test]
#[cfg(target_os = "linux")]
fn a_closed_stdout_is_an_error_where_a_product_would_be_lost() {
    let place = project("closed");
    let hole = "#version 450\nlayout(std140) uniform U { float a; vec4 b; };\nvoid main() {}\n";
    place.write("s/hole.frag", hole);
    let closed = |arguments: &str| {
        let script = format!("exec {} {arguments} >&-", env!("CARGO_BIN_EXE_landfall"));
        let mut command = Command::new("sh");
        command.args(["-c", &script]).current_dir(&place.0).stdin(Stdio::null());
        Ran::of(command.output().unwrap())
    };
    for command in [
        "layout s/a.frag",
        "layout s/a.frag -f json",
        "explain s/a.frag b.light.color",
        "emit s/a.frag --lang c",
        "port s/old.frag",
        "encode s/a.frag v.json",
        "encode s/a.frag v.json --hex",
        "verify s/a.frag --backend cpu",
        "lights s/a.frag",
        "check s -W implicit-padding",
        "check s -f sarif",
        "rule",
        "schema lock",
        "devices -f json",
    ] {
        let ran = closed(command);
        ran.code(2).stderr_eq(str![[r#"
error[cannot-write]: `<stdout>` is closed: the output would be lost
  |
  = help: redirect it to a file, or to /dev/null to discard it


"#]]);
    }
    for command in ["--help", "--version", "check --help"] {
        let ran = closed(command);
        ran.code(2).stderr_eq("error: standard output cannot be written: it is closed\n");
    }
    for command in ["lock s", "emit s/a.frag --lang c -o h.h", "check s -f json=r.json -f short=r"]
    {
        let ran = closed(command);
        assert_eq!(ran.code, 0, "{command} prints no product: {}", ran.err);
    }
    let null = place.command(&["layout", "s/a.frag"]).stdout(Stdio::null()).output().unwrap();
    assert_eq!(null.status.code(), Some(0), "/dev/null is where somebody sent it");
}
