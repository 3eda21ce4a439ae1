//! `landfall verify --backend web` from outside: a browser that is missing, what is printed, wrong
//! layouts, and that nothing of the browser stays.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use snapbox::str;

use crate::schema::{holds, validator};
use crate::support::command::{Place, Ran};

const GLSL: &str = "#version 330 core
layout(std140) uniform B { float time; vec3 wind; float gains[4]; } u;
uniform vec4 loose;
buffer S { vec4 stored; };
out vec4 colour;
void main() { colour = vec4(u.time + u.gains[1] + u.gains[2]) + loose + stored; }
";

const WGSL: &str = "struct B { time: f32, wind: vec3<f32> }
@group(0) @binding(0) var<uniform> u: B;
@group(1) @binding(3) var<storage, read_write> counts: array<atomic<u32>>;
@fragment fn main() -> @location(0) vec4f { return vec4f(u.wind, u.time); }
";

fn place(name: &str) -> Place {
    let place = Place::new(name);
    place.write("a.frag", GLSL).write("b.wgsl", WGSL);
    place
}

#[test]
fn a_missing_browser_is_named() {
    let folder = place("verify-web-missing");
    let without = |arguments: &[&str]| {
        let mut command = folder.command(arguments);
        // No program is in this directory.
        command.env("PATH", &folder.0);
        Ran::of(command.output().expect("the command of this package"))
    };
    without(&["verify", "a.frag", "--backend", "web"]).code(2).stdout_eq("").stderr_eq(str![[r#"
error[cannot-run]: `web` did not run: no browser is on the path: none of chromium, chromium-browser, google-chrome, google-chrome-stable, chrome
  |
  = help: install Chromium; `--backend cpu` needs no browser


"#]]);
    without(&["verify", "a.frag", "--require", "web"]).code(2).stdout_eq("").stderr_eq(str![[r#"
error[cannot-run]: `web` is required but did not run: no browser is on the path: none of chromium, chromium-browser, google-chrome, google-chrome-stable, chrome
  |
  = help: `landfall devices` lists the available backends


"#]]);
    without(&["verify", "a.frag", "--backend", "cpu", "--require", "web"])
        .code(2)
        .stdout_eq("")
        .stderr_eq(str![[r#"
error[cannot-run]: `web` is required, but `--backend` excludes it


"#]]);
    // Beside another backend it is no error.
    without(&["verify", "a.frag", "--backend", "cpu,web"]).code(0).stdout_eq(str![[r#"
backends
  cpu    interpreter · landfall [VERSION]
  webgl  did not run: no browser is on the path: none of chromium, chromium-browser, google-chrome, google-chrome-stable, chrome
  webgpu did not run: no browser is on the path: none of chromium, chromium-browser, google-chrome, google-chrome-stable, chrome

a.frag
  B             std140  96 bytes     3 leaves  cpu ✓ 15 reads
  S             std430  16 bytes     1 leaf    cpu ✓ 12 reads
  DefaultBlock  std140  16 bytes     1 leaf    cpu ✓ 8 reads

"#]]);
    let json = without(&["verify", "a.frag", "--backend", "cpu,web", "--format", "json"]).json();
    assert_eq!(json["backends"][1]["backend"], "webgl");
    let missing = json["backends"][1]["missing"].as_str().expect("a reason");
    assert!(missing.contains("on the path"), "{missing}");
}

#[test]
fn a_browser_that_does_not_start_says_why() {
    let folder = place("verify-web-broken");
    folder.write("chromium", "#!/bin/sh\necho 'error: no display' >&2\nexit 3\n");
    assert!(
        Command::new("chmod").arg("+x").arg(folder.path("chromium")).status().unwrap().success()
    );
    let mut command = folder.command(&["verify", "a.frag", "--backend", "web"]);
    command.env("PATH", &folder.0);
    let ran = Ran::of(command.output().expect("the command of this package"));
    ran.code(2).stdout_eq("").stderr_eq(str![[r#"
error[cannot-run]: `web` did not run: the browser does not start: the browser ended with exit code 3: error: no display
  |
  = help: install Chromium; `--backend cpu` needs no browser


"#]]);
}

#[test]
fn both_apis_read_the_blocks_and_say_what_they_lack() {
    let folder = place("verify-web");
    let verify = ["verify", "a.frag", "b.wgsl", "--backend", "web"];
    folder.run(&[&verify[..], &["--require", "web"]].concat()).code(0).stdout_eq(str![[r#"
backends
  webgl  [BROWSER] · [BROWSER]
  webgpu [BROWSER] · [BROWSER]

a.frag
  B             std140  96 bytes     3 leaves  webgl ✓ 19 reads  webgpu –
    webgpu: it cannot be ported to WGSL: `gains[]` is at offset 32, but WGSL puts it at 28
  S             std430  16 bytes     1 leaf    webgl –  webgpu ✓ 12 reads
    webgl: WebGL 2 has no storage buffers
  DefaultBlock  std140  16 bytes     1 leaf    webgl ✓ 8 reads  webgpu –
    webgpu: it cannot be ported to WGSL: `gains[]` is at offset 32, but WGSL puts it at 28

b.wgsl
  B       wgsl    32 bytes     2 leaves  webgl –  webgpu ✓ 7 reads
    webgl: WebGL does not accept WGSL
  counts  wgsl     4 bytes     1 leaf    webgl –  webgpu ✓ 6 reads
    webgl: WebGL does not accept WGSL

"#]]);
    let json = folder.run(&[&verify[..], &["--format", "json"]].concat()).out;
    let value = holds(&validator("verify"), &json, "verify");
    assert_eq!(value["shaders"][0]["blocks"][0]["backends"][0]["form"], "declared");
    assert_eq!(value["shaders"][1]["blocks"][0]["backends"][1]["form"], "original");
}

#[test]
fn a_wrong_layout_exits_with_1_and_the_leaf_is_named() {
    let folder = place("verify-web-stale");
    folder.run(&["lock", "a.frag"]).code(0);
    // `gains` moves from 32 to 48.
    folder.write("a.frag", GLSL.replace("float gains", "vec4 fog; float gains"));
    let lock = "layouts/a.frag.json";
    let verify = ["verify", "a.frag", "--backend", "web", "--block", "B", "--layout", lock];
    folder.run(&verify).code(1).stdout_eq(str![[r#"
backends
  webgl  [BROWSER] · [BROWSER]
  webgpu [BROWSER] · [BROWSER]

a.frag
  B  std140  112 bytes     4 leaves
      webgl ✗ 10 of 19 reads returned another byte  webgpu –
    gains[]
      webgl gains[0]  reads byte 48, expected 32  constant
      webgl gains[3]  reads byte 96, expected 80  constant
      webgl gains[1]  reads byte 64, expected 48  constant
      webgl gains[0]  reads byte 48, expected 32  dynamic
      … and 6 more
      it starts at 48 instead of 32
    webgpu: it cannot be ported to WGSL: the array stride of `gains[]` is 16 bytes, but 4 in WGSL
    not probed: `fog`: the given layout has no member of this path

"#]]);
}

/// The probes record in the lock which API confirmed it.
#[test]
fn the_lock_records_the_browser() {
    let folder = place("verify-web-record");
    folder.write("a.frag", GLSL.replace("buffer S { vec4 stored; };", "").replace(" + stored", ""));
    folder.run(&["lock", "a.frag"]).code(0);
    folder.run(&["verify", "a.frag", "--backend", "web", "--record"]).code(0);
    let lock = folder.read("layouts/a.frag.json");
    assert!(
        lock.contains("\"backend\": \"webgl\"") || lock.contains("\"backend\":\"webgl\""),
        "{lock}"
    );
    assert!(!lock.contains("webgpu"), "{lock}");
}

#[test]
fn devices_lists_both_apis() {
    let listed = crate::support::command::run(&["devices", "--format", "json"]).json();
    let kind = |backend: &str| {
        let devices = listed["devices"].as_array().expect("a list");
        let device = devices.iter().find(|device| device["backend"] == backend).expect(backend);
        assert_eq!(device["available"], true, "{device}");
        // WebGL 2 and WebGPU promise at least these.
        assert!(device["limits"]["uniform_block_size"].as_u64().expect("a size") >= 16384);
        device["kind"].as_str().expect("a kind").to_string()
    };
    assert_eq!((kind("webgl"), kind("webgpu")), ("webgl 2".to_string(), "webgpu".to_string()));
}

/// However the command ends, the browser ends, and its profile is removed.
#[cfg(target_os = "linux")]
#[test]
fn nothing_of_the_browser_stays() {
    for signal in ["-INT", "-TERM", "-KILL"] {
        let folder = place(&format!("verify-web-end{signal}"));
        let scratch = folder.0.join("scratch");
        std::fs::create_dir_all(&scratch).unwrap();
        for copy in 0..60 {
            folder.write(&format!("copy_{copy}.frag"), GLSL);
        }
        let mut command = folder.command(&["verify", ".", "--backend", "web"]);
        command.env("TMPDIR", &scratch).stdout(Stdio::null()).stderr(Stdio::null());
        let mut child = command.spawn().expect("the command of this package");
        let is_there = || std::fs::read_dir(&scratch).unwrap().count() > 0;
        wait("the browser starts", || is_there() && !browsers(&scratch).is_empty());
        end(&mut child, signal);
        wait("the browser ends", || browsers(&scratch).is_empty());
        wait("the profile is removed", || !is_there());
    }
}

#[cfg(target_os = "linux")]
fn end(child: &mut Child, signal: &str) {
    let kill = Command::new("kill").args([signal, &child.id().to_string()]).status();
    assert!(kill.expect("kill runs").success());
    assert!(!child.wait().expect("it ends").success());
}

#[cfg(target_os = "linux")]
fn wait(what: &str, holds: impl Fn() -> bool) {
    let begun = Instant::now();
    while !holds() {
        assert!(begun.elapsed() < Duration::from_secs(60), "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// The processes whose profile is in this directory.
#[cfg(target_os = "linux")]
fn browsers(scratch: &Path) -> Vec<String> {
    let scratch = scratch.display().to_string();
    std::fs::read_dir("/proc")
        .expect("Linux")
        .filter_map(|entry| std::fs::read_to_string(entry.ok()?.path().join("cmdline")).ok())
        .filter(|command| command.contains(&scratch))
        .collect()
}
