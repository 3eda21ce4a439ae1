//! `landfall stress` from outside: what it exits with, that its findings repeat, and that it
//! stops when it is told to.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// A function that is exact, one that breaks at zero, and one that is inaccurate near 1.
const SHADER: &str = "#version 450
layout(location = 0) out vec4 color;
float halved(float x) { return x * 0.5; }
vec3 direction(vec3 v) {
    return normalize(v);
}
float nearly(float x) { return 1000.0 * (x * x - 1.0); }
void main() { color = vec4(direction(vec3(1)), halved(nearly(1.0))); }
";

fn shader(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli_stress");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    std::fs::write(&path, SHADER).unwrap();
    path
}

fn stress(path: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_landfall"));
    command.arg("stress").arg(path).args(arguments).env("NO_COLOR", "1");
    command.output().expect("the binary was built for this test")
}

#[test]
fn it_exits_with_1_past_a_limit_and_on_what_is_not_finite() {
    let path = shader("exits.frag");
    let few = ["--samples", "4000", "--time", "3"];
    for (function, more, code) in [
        ("halved", &["--max-ulp", "0", "--domain", r#"{"x": [1, 2]}"#][..], 0),
        ("direction", &[], 1),
        ("nearly", &["--domain", r#"{"x": [0.9, 1.1]}"#], 0),
        ("nearly", &["--max-step", "0.001", "--domain", r#"{"x": [0.9, 1.1]}"#], 1),
        ("halve", &[], 2),
        ("halved", &["--domain", r#"{"y": [0, 1]}"#], 2),
        ("halved", &["--domain", r#"{"x": [1, 0]}"#], 2),
    ] {
        let output = stress(&path, &[&["--fn", function][..], &few, more].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{function} {more:?}: {said}");
        assert_eq!(output.stdout.is_empty(), code == 2, "{function} {more:?}");
        assert_eq!(said.contains("error"), code == 2, "{function} {more:?}: {said}");
    }
    let output = stress(&path, &["--fn", "halve"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("`halved`"), "the nearest name");
}

#[test]
fn what_is_found_is_repeated_by_the_command_beside_it() {
    let path = shader("repeats.frag");
    let few = ["--fn", "direction", "--samples", "4000", "--time", "3", "--format", "json"];
    let output = stress(&path, &few);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let found = report["findings"].as_array().unwrap();
    let zero = found.iter().find(|found| found["code"] == "zero-vector");
    let zero = zero.unwrap_or_else(|| panic!("{found:#?}"));
    assert_eq!(zero["line"], 5, "the line of `normalize`");
    let line = zero["case"]["command"].as_str().unwrap();
    let binary = Path::new(env!("CARGO_BIN_EXE_landfall")).parent().unwrap();
    let paths = format!("{}:{}", binary.display(), std::env::var("PATH").unwrap());
    let again = Command::new("sh").args(["-c", line]).env("PATH", paths).output().unwrap();
    let (text, said) = (String::from_utf8(again.stdout), String::from_utf8(again.stderr));
    let (text, said) = (text.unwrap(), said.unwrap());
    assert!(text.contains("result.x  nan  nan"), "{line}:\n{text}");
    assert!(said.contains("normalised zero vector") && said.contains(".frag:5:"), "{said}");
}

#[test]
fn an_error_map_is_a_drawing_of_the_two_inputs() {
    let path = shader("map.frag");
    let map = path.with_extension("svg");
    let arguments = ["--map", map.to_str().unwrap(), "--map-x", "v.x", "--map-y", "v.y"];
    let few = ["--fn", "direction", "--samples", "2000", "--time", "3"];
    assert_eq!(stress(&path, &[&few[..], &arguments].concat()).status.code(), Some(1));
    let drawing = std::fs::read_to_string(&map).unwrap();
    let document = roxmltree::Document::parse(&drawing).expect("SVG is XML");
    let texts: Vec<&str> = document.descendants().filter_map(|node| node.text()).collect();
    for axis in ["v.x", "v.y"] {
        assert!(texts.iter().any(|text| text.contains(axis)), "{axis} in {texts:?}");
    }
}

/// Where signals can be looked at.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_ends_it_with_what_it_has() {
    use std::io::Read as _;
    use std::process::Stdio;
    use std::time::{Duration, Instant};

    let path = shader("interrupt.frag");
    let mut child = Command::new(env!("CARGO_BIN_EXE_landfall"))
        .arg("stress")
        .arg(&path)
        .args(["--fn", "direction", "--time", "3000", "--samples", "1000000000000"])
        .args(["--format", "json"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let began = Instant::now();
    let status = format!("/proc/{}/status", child.id());
    let listens = || {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let caught = text.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        let caught = caught.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
        caught.is_some_and(|mask| mask & 0b10 != 0)
    };
    while !listens() {
        assert!(began.elapsed() < Duration::from_secs(60), "it does not listen to SIGINT");
        std::thread::sleep(Duration::from_millis(20));
    }
    // Time for some samples.
    std::thread::sleep(Duration::from_secs(2));
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let mut text = String::new();
    child.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    // Not the 3000 seconds, nor half as long again for what was found.
    assert!(began.elapsed() < Duration::from_secs(120), "{:?}", began.elapsed());
    let report: Value = serde_json::from_str(&text).expect("the whole report is there");
    assert_eq!(report["stopped"], true);
    assert!(report["total"]["samples"].as_u64().unwrap() > 0);
    let found = report["findings"].as_array().unwrap();
    assert!(found.iter().any(|found| found["code"] == "zero-vector"), "{text}");
}
