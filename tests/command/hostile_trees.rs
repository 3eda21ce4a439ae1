//! Hostile trees against every command that takes a path: links and loops, pipes and sockets in
//! the places of locks and outputs, names, files that are no text, files that change meanwhile.

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use snapbox::str;

use crate::cli_check::place::CLEAN;
use crate::support::command::Place;
use crate::writers::{campaign::rounds, files};

/// A command that takes longer than this hangs.
const LONGEST: Duration = Duration::from_secs(60);

const NAMES: [&str; 8] = [
    "a.frag",
    "-o.frag",
    "space and \u{202e}bidi.frag",
    "new\nline.vert",
    "::error::x.comp",
    "quote\"'`$(touch owned).wgsl",
    "*.frag",
    "\u{e4}\u{f6}\u{301}.glsl",
];

const TEXTS: [&[u8]; 8] = [
    CLEAN.as_bytes(),
    b"",
    b"\xff\xfe\x00#",
    b"#version 450\n#include \"a.frag\"\n#include \"..\"\n#include \"/\"\nvoid main() {}\n",
    b"layout(std140) uniform B { vec4 a[",
    b"#version 450\nlayout(std430, binding = 0) buffer B { uint n; float x[]; };\n",
    b"struct S { a: vec3<f32> }\n@group(0) @binding(0) var<uniform> s: S;\n",
    b"\0\0\0\0",
];

/// A tree of links, pipes and files, the same for a seed.
fn tree(seed: u64, outside: &Path) -> Place {
    let place = Place::new(&format!("tree-{seed}"));
    let mut random = fastrand::Rng::with_seed(seed);
    let folders = ["", "s/", "s/deep/", "layouts/", "layouts/s/", "o/"];
    folders.iter().for_each(|folder| fs::create_dir_all(place.0.join(folder)).unwrap());
    let outside = outside.display().to_string();
    for _ in 0..12 {
        let folder = random.choice(&folders).unwrap();
        let name = random.choice(&NAMES).unwrap();
        let is_lock = folder.starts_with("layouts") || folder.starts_with('o');
        let extension = if is_lock { random.choice([".json", ".txt"]).unwrap() } else { "" };
        let path = place.0.join(format!("{folder}{name}{extension}"));
        if path.symlink_metadata().is_ok() {
            continue;
        }
        match random.u32(0..9) {
            0 => symlink("nowhere", &path).unwrap(),
            1 => symlink(path.file_name().unwrap(), &path).unwrap(),
            2 => symlink(format!("{outside}/kept.frag"), &path).unwrap(),
            3 => symlink(&outside, &path).unwrap(),
            4 => fs::create_dir(&path).unwrap(),
            // Pipes and devices where something is written; where shaders are read is for the
            // tests of reading.
            5 if is_lock => {
                assert!(Command::new("mkfifo").arg("--").arg(&path).status().unwrap().success());
            }
            6 if is_lock => symlink("/dev/null", &path).unwrap(),
            _ => {
                fs::write(&path, random.choice(TEXTS).unwrap()).unwrap();
                let mode = random.choice([0o644, 0o444, 0o000, 0o755]).unwrap();
                fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
            }
        }
    }
    let mut name = || {
        let folder = random.choice(&folders).unwrap();
        let extension = random.choice(["", ".json", ".txt"]).unwrap();
        format!("{folder}{}{extension}", random.choice(&NAMES).unwrap())
    };
    let (texture, mesh) = (name(), name());
    let scene = serde_json::json!({
        "size": [4, 4], "model": "multi",
        "camera": {"position": [0, 1, 5], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 60},
        "lights": {"point": [{"position": [0, 3, 3], "color": [9, 9, 9]}]},
        "materials": [{"name": "m", "diffuse": {"png": texture}}],
        "objects": [{"mesh": {"obj": mesh}, "material": "m"}, {"mesh": "plane", "material": "m"}],
    });
    place.write("scene.json", scene.to_string());
    if random.bool() {
        let config = random.choice(["cache-dir = \"o\"\n", "locks = \"s\"\n", "\u{0}", "["]);
        place.write("landfall.toml", config.unwrap());
    }
    place
}

const COMMANDS: [&[&str]; 14] = [
    &["layout", "."],
    &["layout", "s", "-f", "json", "--out", "o"],
    &["layout", ".", "-f", "md", "--out", "o", "--force"],
    &["lock"],
    &["lock", "--prune", "--force"],
    &["check", "--cache-dir", "o"],
    &["check", "--accept", "-W", "all", "-f", "json=o/r.json"],
    &["check", "--fix", "-W", "all"],
    &["diff", "layouts", "s"],
    &["lights", "."],
    &["render", "scene.json", "--reference", "-o", "o/p.png"],
    &["bench", "scene.json", "--backend", "cpu", "--rounds", "3", "--plot", "o/p.svg"],
    &["verify", ".", "--backend", "cpu", "--record"],
    &["emit", "*.frag", "s", "--lang", "c", "-o", "o/h.h"],
];

/// The code of a command that ends, which it does without a signal.
fn code(place: &Place, command: &[&str]) -> i32 {
    let mut child =
        place.command(command).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let begun = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status.code().unwrap_or_else(|| panic!("{command:?} in {:?} died", place.0));
        }
        if begun.elapsed() > LONGEST {
            let _ = child.kill();
            panic!("{command:?} in {:?} hangs", place.0);
        }
        thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn every_command_ends_and_nothing_outside_changes() {
    let outside = Place::new("tree-outside");
    outside.write("kept.frag", CLEAN).write("kept.json", "{}");
    let before = files(&outside.0);
    for seed in 0..u64::from(rounds(6)) {
        let place = tree(seed, &outside.0);
        for command in COMMANDS {
            let code = code(&place, command);
            assert!((0..=2).contains(&code), "{command:?} of seed {seed}: {code}");
            assert!(files(&outside.0) == before, "{command:?} of seed {seed} wrote outside");
        }
        assert!(!place.has("owned") && !place.has("s/owned"), "a name was run");
        let _ = fs::remove_dir_all(&place.0);
    }
}

#[test]
fn a_file_that_changes_meanwhile_is_read_as_one_or_the_other() {
    let place = Place::new("tree-changes");
    let more = CLEAN.replace("vec4 color;\n}", "vec4 color;\n    vec4 more;\n}");
    place.write("a.frag", CLEAN);
    let sizes: Vec<String> = [CLEAN, &more]
        .iter()
        .map(|text| {
            place.write("a.frag", text);
            place.run(&["layout", "a.frag"]).out
        })
        .collect();
    let stop = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| {
            for text in [CLEAN, &more].into_iter().cycle() {
                if stop.load(Ordering::Relaxed) {
                    break;
                }
                // As editors do: written beside it, then renamed.
                place.write("a.new", text);
                fs::rename(place.0.join("a.new"), place.0.join("a.frag")).unwrap();
            }
        });
        for _ in 0..rounds(10) {
            let ran = place.run(&["layout", "a.frag"]);
            let known = sizes.contains(&ran.out);
            stop.fetch_or(!known, Ordering::Relaxed);
            assert!(known, "{}\n{}", ran.out, ran.err);
        }
        stop.store(true, Ordering::Relaxed);
    });
}

/// A pipe that nobody reads would hold a writer for good.
#[test]
fn a_pipe_without_a_reader_is_an_error() {
    let place = Place::new("trees-pipe");
    place.write("a.frag", CLEAN);
    let made = Command::new("mkfifo").arg(place.path("pipe")).status();
    assert!(made.is_ok_and(|made| made.success()));
    let emit = ["emit", "--lang", "c", "a.frag", "-o", "pipe"];
    place.run(&emit).code(2).stdout_eq("").stderr_eq(str![[r#"
error[cannot-write]: `pipe` is a pipe that no process reads
  |
  = help: start its reader first, or name a file


"#]]);
    place.run(&["check", "-f", "json=pipe"]).code(2).stdout_eq("").stderr_eq(str![[r#"
error[cannot-write]: `pipe` is a pipe that no process reads
  |
  = help: start its reader first, or name a file


"#]]);
    let reader = Command::new("cat").arg(place.path("pipe")).stdout(Stdio::piped()).spawn();
    let reader = reader.expect("cat");
    // Until it has opened the pipe.
    let ran = (0..100).map(|_| {
        thread::sleep(Duration::from_millis(20));
        place.run(&emit)
    });
    assert!(ran.into_iter().any(|ran| ran.code == 0));
    let read = reader.wait_with_output().expect("cat ends");
    assert!(String::from_utf8_lossy(&read.stdout).contains("struct"));
}

#[test]
fn files_that_exclude_shaders_are_inputs() {
    let place = Place::new("trees-ignore");
    place.write("a.frag", CLEAN).write("b.frag", CLEAN);
    for name in [".ignore", ".gitignore"] {
        place.write(name, "b.frag\n");
        let ran = place.run(&["check", ".", "-f", &format!("json={name}")]);
        assert_eq!(ran.code, 2, "{}", ran.err);
        assert_eq!(place.read(name), "b.frag\n");
        let ran = place.run(&["emit", "--lang", "c", "a.frag", "-o", name]);
        assert_eq!(ran.code, 2, "{}", ran.err);
        assert_eq!(place.read(name), "b.frag\n");
    }
}

#[test]
fn many_long_patterns_are_no_trap() {
    let place = Place::new("trees-globs");
    place.write("a.frag", CLEAN);
    let pattern = "a*".repeat(1500);
    let flags: Vec<&str> = (0..30).flat_map(|_| ["--exclude", &pattern]).collect();
    let ran = place.run(&[&["check"][..], &flags].concat());
    assert_eq!(ran.code, 0);
    assert_eq!(ran.err.matches("warning[unused-option]").count(), 30);
    let mut list: Vec<String> = (0..6000).map(|i| format!("\"a*b*c*{i}\"")).collect();
    list.push("\"*.frag\"".to_string());
    place.write("landfall.toml", format!("exclude = [{}]\n", list.join(", ")));
    let ran = place.run(&["check"]);
    assert!(ran.err.contains("the only shader is excluded"), "{}", ran.err);
    let list: Vec<String> = (0..300).map(|i| format!("\"{i}{}\"", "a".repeat(4000))).collect();
    place.write("landfall.toml", format!("exclude = [{}]\n", list.join(", ")));
    let ran = place.run(&["check"]);
    assert_eq!(ran.code, 2);
    assert!(ran.err.contains("is not a glob: with those before it, it is too large"));
}

/// naga 30.0.1 panics on constants of arrays in GLSL.
#[test]
fn a_panic_of_naga_prints_nothing() {
    let place = Place::new("trees-naga");
    let text = "#version 450\nconst int N[] = int[](4, 5, 6);\n\
                layout(std140, binding = 0) uniform U { float a[N[1]]; vec4 h; } u;\n\
                layout(location = 0) out vec4 o;\nvoid main() { o = vec4(1.0); }\n";
    place.write("a.frag", text);
    for command in [
        &["layout", "--naga", "a.frag"][..],
        &["check", "-W", "all"],
        &["port", "--to", "wgsl", "a.frag"],
    ] {
        let ran = place.run(command);
        assert!(!ran.err.contains("panicked at"), "{command:?}: {}", ran.err);
    }
}

#[test]
fn includes_are_bounded_in_depth_and_number() {
    let place = Place::new("trees-includes");
    for nth in 0..600 {
        place.write(&format!("deep/{nth}.glsl"), format!("#include \"{}.glsl\"\n", nth + 1));
        let twice = format!("#include \"{}.glsl\"\n", nth + 1).repeat(2);
        place.write(&format!("twice/{nth}.glsl"), if nth < 40 { &twice } else { "" });
    }
    place.write("deep/600.glsl", "");
    for (folder, said) in
        [("deep", "includes are nested more than 512 deep"), ("twice", "more than 16384 includes")]
    {
        place.write(
            "a.frag",
            format!("#version 450\n#include \"{folder}/0.glsl\"\n{}", &CLEAN[12..]),
        );
        let ran = place.run(&["layout", "a.frag"]);
        assert_eq!(ran.code, 2, "{folder}");
        assert!(ran.err.contains(said), "{folder}: {}", ran.err);
    }
}
