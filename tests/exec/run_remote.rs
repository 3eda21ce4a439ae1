//! Drivers that crash, hang or are not there do no harm: each runs in a process of its own,
//! and the next job works.
//!
//! Needs both drivers (Debian packages `libegl1`, `libgl1-mesa-dri`, `mesa-vulkan-drivers`
//! and `libvulkan1`); a missing one fails.
#![cfg(unix)]

use crate::support::command::golden;
use crate::support::jobs;
use snapbox::str;

use std::ffi::OsString;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use jobs::{bound, bytes, counting, glsl, job, module, output, storage, uniform, words};
use landfall_exec::backend::subprocess::{DriverKind, Launch, Subprocess, list};
use landfall_exec::backend::{
    Backend as _, Failure, FailureKind, Grid, Job, ResourceKind, StageCode, Texel,
};
use landfall_ir::Module;
use landfall_layout::{Options, Source, Stage};

fn launch(driver_kind: &DriverKind) -> Launch {
    Launch::new(env!("CARGO_BIN_EXE_landfall"), driver_kind)
}

fn open(driver_kind: &DriverKind) -> Subprocess {
    Subprocess::open(launch(driver_kind)).unwrap_or_else(|failure| panic!("{failure}"))
}

const BOTH: [DriverKind; 2] = [DriverKind::Gl, DriverKind::Gpu(None)];

fn wgsl(text: &str) -> Arc<Module> {
    let source = Source::new("test.wgsl", text);
    let module = Module::by_naga(&source, &Options::default());
    Arc::new(module.unwrap_or_else(|found| panic!("{found:?}")))
}

/// One stage in the two forms the drivers take.
fn both(stage: Stage, text: &str, code: &Arc<Module>) -> StageCode {
    StageCode { text: Some(text.to_string()), ..module(stage, "main", code) }
}

/// A job that either driver runs: the output is the input and 7 more.
fn adding() -> Job {
    let text = "#version 430
layout(local_size_x = 4) in;
layout(std140) uniform Input { uvec4 words; } i;
layout(std430) buffer Output { uint words[]; } o;
void main() { o.words[gl_LocalInvocationIndex] += i.words[gl_LocalInvocationIndex] + 7u; }";
    let code = wgsl(
        "@group(0) @binding(0) var<uniform> input: vec4u;
@group(0) @binding(1) var<storage, read_write> output: array<u32>;
@compute @workgroup_size(4) fn main(@builtin(local_invocation_index) at: u32) {
  output[at] += input[at] + 7u;
}",
    );
    let resources = vec![uniform("Input", 0, &counting(4)), storage("Output", 1, &[1, 0, 0, 0])];
    job(vec![both(Stage::Compute, text, &code)], resources, Grid::Groups([1, 1, 1]))
}

fn works(backend: &mut Subprocess) {
    let answer = backend.run(&adding()).unwrap_or_else(|failure| panic!("{failure}"));
    assert_eq!(words(answer.buffers[1].as_ref().unwrap()), [1008, 1008, 1009, 1010]);
    assert_eq!(answer.buffers[0], None);
}

/// A job that takes either driver hours. llvmpipe leaves a loop after 65535 iterations, so that
/// a loop without end is not enough there.
fn endless() -> Job {
    let text = "#version 430
layout(local_size_x = 64) in;
layout(std430) buffer Output { float x[64]; } o;
void main() {
  float x = o.x[gl_LocalInvocationIndex];
  for (;;) { x = sin(x) * 3.0 + cos(x); if (x > 9.0) break; }
  o.x[gl_LocalInvocationIndex] = x;
}";
    let code = wgsl(
        "@group(0) @binding(0) var<storage, read_write> o: array<f32, 64>;
@compute @workgroup_size(64) fn main(@builtin(local_invocation_index) at: u32) {
  var x = o[at];
  loop { x = sin(x) * 3.0 + cos(x); if x > 9.0 { break; } }
  o[at] = x;
}",
    );
    let stages = vec![both(Stage::Compute, text, &code)];
    job(stages, vec![output("Output", 0, 64)], Grid::Groups([65535, 64, 1]))
}

#[test]
fn jobs_run_in_the_other_process_as_in_this_one() {
    for driver_kind in &BOTH {
        let mut backend = open(driver_kind);
        assert_ne!(backend.process().unwrap(), std::process::id());
        let name = if *driver_kind == DriverKind::Gl { "gl" } else { "gpu" };
        assert_eq!(backend.device().backend.name(), name);
        works(&mut backend);
    }
}

#[test]
fn images_textures_and_push_constants_travel_whole() {
    let texels = vec![[0.5, -1.0, 1e-40, 3e38], [0.0; 4]];
    let texture = ResourceKind::Texture { width: 2, height: 1, texels };
    let grid = Grid::Image { width: 1, height: 1, texel: Texel::Float };
    let text = "#version 330\nuniform sampler2D tex; out vec4 c;
void main() { c = texelFetch(tex, ivec2(0), 0); }";
    let stages = vec![glsl(Stage::Fragment, text)];
    let gl = job(stages, vec![bound("tex", 0, texture.clone())], grid);
    let code = wgsl(
        "var<immediate> add: f32;
@group(0) @binding(0) var tex: texture_2d<f32>;
@fragment fn main() -> @location(0) vec4f { return textureLoad(tex, vec2u(), 0) + add; }",
    );
    let push = ResourceKind::PushConstant(bytes(&[0f32.to_bits()]));
    let resources = vec![bound("tex", 0, texture), bound("add", 0, push)];
    let gpu = job(vec![module(Stage::Fragment, "main", &code)], resources, grid);
    for (driver_kind, job) in [(DriverKind::Gl, gl), (DriverKind::Gpu(None), gpu)] {
        let answer = open(&driver_kind).run(&job).unwrap_or_else(|failure| panic!("{failure}"));
        let [r, g, _, a] = answer.pixels[0].map(f32::from_bits);
        assert_eq!([r, g, a], [0.5, -1.0, 3e38], "{driver_kind:?}");
    }
}

#[test]
fn a_module_is_the_same_over_there_whatever_it_is_made_of() {
    // naga's front end calls itself for each level, deeper than a test's thread goes.
    let deep = thread::Builder::new().stack_size(64 << 20).spawn(nested_and_predeclared);
    deep.unwrap().join().unwrap();
}

fn nested_and_predeclared() {
    // `modf` has a result type that is keyed by no string; each `else if` is a level.
    let mut text = "@group(0) @binding(0) var<storage, read_write> o: array<f32, 4>;
@compute @workgroup_size(1) fn main() {
  let parts = modf(o[0]);
  o[1] = parts.fract; o[2] = 0.1; var at = 0u;
  if o[3] == -1.0 { at = 1u; }"
        .to_string();
    for level in 0..60 {
        write!(text, " else if o[3] == {level}.0 {{ at = {level}u + 100u; }}").unwrap();
    }
    text.push_str("\n  o[3] = f32(at);\n}");
    let stages = vec![module(Stage::Compute, "main", &wgsl(&text))];
    let words_in = [2.75f32, 0.0, 0.0, 58.0].map(f32::to_bits);
    let job = job(stages, vec![storage("o", 0, &words_in)], Grid::Groups([1, 1, 1]));
    let answer =
        open(&DriverKind::Gpu(None)).run(&job).unwrap_or_else(|failure| panic!("{failure}"));
    let out = words(answer.buffers[0].as_ref().unwrap());
    assert_eq!(out[1..].iter().map(|w| f32::from_bits(*w)).collect::<Vec<_>>(), [0.75, 0.1, 158.0]);
}

#[test]
fn one_process_runs_hundreds_of_jobs_and_many_modules() {
    let mut backend = open(&DriverKind::Gpu(None));
    let process = backend.process();
    for round in 0..150u32 {
        works(&mut backend);
        // More modules than are kept.
        let code = wgsl(&format!(
            "@group(0) @binding(0) var<storage, read_write> o: u32;
@compute @workgroup_size(1) fn main() {{ o += {round}u; }}"
        ));
        let stages = vec![module(Stage::Compute, "main", &code)];
        let job = job(stages, vec![storage("o", 0, &[5])], Grid::Groups([1, 1, 1]));
        let answer = backend.run(&job).unwrap();
        assert_eq!(words(answer.buffers[0].as_ref().unwrap()), [5 + round]);
    }
    assert_eq!(backend.process(), process);
}

#[test]
fn two_stages_of_one_job_are_known_together_after_any_number_of_modules() {
    let mut backend = open(&DriverKind::Gpu(None));
    let process = backend.process();
    for before in 0..140u32 {
        let grid = Grid::Image { width: 1, height: 1, texel: Texel::Float };
        let vertex = wgsl(
            "@vertex fn main(@builtin(vertex_index) at: u32) -> @builtin(position) vec4f {
  return vec4f(f32(at & 1) * 4 - 1, f32(at & 2) * 2 - 1, 0, 1);
}",
        );
        let fragment = wgsl(&format!(
            "@fragment fn main() -> @location(0) vec4f {{ return vec4f({before}); }}"
        ));
        let mut stages = vec![module(Stage::Fragment, "main", &fragment)];
        // One and two modules in turn, so that a limit falls between the two of a job.
        if before % 3 != 0 {
            stages.insert(0, module(Stage::Vertex, "main", &vertex));
        }
        let answer = backend.run(&job(stages, Vec::new(), grid));
        let answer = answer.unwrap_or_else(|failure| panic!("after {before}: {failure}"));
        assert_eq!(answer.pixels[0].map(f32::from_bits), [before as f32; 4]);
    }
    assert_eq!(backend.process(), process);
}

#[test]
fn a_shader_that_does_not_end_times_out_and_the_next_job_works() {
    for driver_kind in &BOTH {
        let mut backend = open(driver_kind);
        works(&mut backend);
        let limit = Duration::from_millis(700);
        let begun = Instant::now();
        let failure = backend.run(&Job { limit, ..endless() }).unwrap_err();
        assert_eq!(failure.kind, FailureKind::TimedOut, "{driver_kind:?}: {failure}");
        assert_eq!(failure.message, "timed out after 0.7 s");
        assert!(begun.elapsed() < Duration::from_secs(20), "nobody waits for the driver");
        assert_eq!(backend.process(), None, "the process is gone");
        works(&mut backend);
    }
}

#[test]
fn the_other_process_says_how_long_it_worked_and_the_device_if_it_is_asked() {
    for driver_kind in BOTH {
        let mut driver = open(&driver_kind);
        assert_eq!(driver.processor_time(), None, "no job has run");
        driver.run(&adding()).unwrap();
        assert!(driver.processor_time().is_some_and(|time| !time.is_zero()), "{driver_kind:?}");
        assert_eq!(driver.device_time(), None, "nobody asked for it");
        let mut timed = Subprocess::open(Launch { timed: true, ..launch(&driver_kind) }).unwrap();
        timed.run(&adding()).unwrap();
        // OpenGL's backend has no timestamps.
        assert_eq!(timed.device_time().is_some(), driver_kind != DriverKind::Gl);
        // A job that fails leaves none of the last one's.
        let nothing = Job { stages: Vec::new(), ..adding() };
        timed.run(&nothing).unwrap_err();
        assert_eq!((timed.device_time(), timed.processor_time()), (None, None));
    }
}

#[test]
fn a_driver_that_crashes_says_by_which_signal_and_the_next_job_works() {
    for driver_kind in &BOTH {
        let mut backend = open(driver_kind);
        let process = backend.process().unwrap().to_string();
        let crash = thread::spawn(move || {
            thread::sleep(Duration::from_millis(300));
            let kill = Command::new("kill").args(["-ABRT", &process]).status();
            assert!(kill.unwrap().success());
        });
        let failure = backend.run(&endless()).unwrap_err();
        crash.join().unwrap();
        assert_eq!(failure.kind, FailureKind::Died, "{driver_kind:?}: {failure}");
        let message = "the driver process was ended by signal 6 (SIGABRT)";
        assert_eq!(failure.message, message);
        works(&mut backend);
    }
}

#[test]
fn a_process_that_went_between_two_jobs_is_not_missed() {
    let mut backend = open(&DriverKind::Gl);
    works(&mut backend);
    let process = backend.process().unwrap();
    let kill = Command::new("kill").args(["-KILL", &process.to_string()]).status();
    assert!(kill.unwrap().success());
    works(&mut backend);
    assert_ne!(backend.process(), Some(process));
}

#[test]
fn a_refused_shader_comes_with_the_drivers_log_and_keeps_the_process() {
    let mut backend = open(&DriverKind::Gl);
    let process = backend.process();
    let mut job = adding();
    job.stages[0].text = Some("#version 430\nvoid main() { gone(); }".to_string());
    let failure = backend.run(&job).unwrap_err();
    assert_eq!(failure.kind, FailureKind::Refused);
    assert!(failure.log.contains("gone"), "{failure}");
    works(&mut backend);
    assert_eq!(backend.process(), process);
}

fn missing(driver_kind: &DriverKind, name: &str, value: impl Into<OsString>) -> Failure {
    let mut launch = launch(driver_kind);
    launch.environment.push((name.into(), value.into()));
    let failure = Subprocess::open(launch).err().expect("the driver was taken away");
    assert_eq!(failure.kind, FailureKind::Missing, "{failure}");
    failure
}

#[test]
fn a_machine_without_vulkan_says_what_to_install() {
    let failure = missing(&DriverKind::Gpu(None), "VK_DRIVER_FILES", "/nonexistent");
    let expected = "no Vulkan adapter; the Debian packages `mesa-vulkan-drivers` and \
        `libvulkan1` provide a software driver";
    assert_eq!(failure.message, expected);
}

/// A folder with a libEGL that cannot be loaded, to be found before the real one.
fn no_egl() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("no-egl");
    std::fs::create_dir_all(&folder).unwrap();
    for name in ["libEGL.so.1", "libEGL.so"] {
        std::fs::write(folder.join(name), "").unwrap();
    }
    folder
}

#[test]
fn a_machine_without_egl_says_what_to_install() {
    let failure = missing(&DriverKind::Gl, "LD_LIBRARY_PATH", no_egl());
    let expected = "no OpenGL driver: libEGL 1.5 cannot be loaded; the Debian packages \
        `libegl1` and `libgl1-mesa-dri` provide a software driver";
    assert_eq!(failure.message, expected);
    assert!(failure.log.contains("libEGL"), "{failure}");
}

#[test]
fn the_process_ends_when_nobody_asks_any_more() {
    let mut process = Command::new(env!("CARGO_BIN_EXE_landfall"))
        .args(["__reader", "gl"])
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    thread::sleep(Duration::from_millis(50));
    assert!(process.try_wait().unwrap().is_none(), "it waits for questions");
    drop(process.stdin.take());
    let begun = Instant::now();
    while process.try_wait().unwrap().is_none() && begun.elapsed() < Duration::from_secs(20) {
        thread::sleep(Duration::from_millis(5));
    }
    assert!(process.wait().unwrap().success());
}

fn script(text: &str) -> Launch {
    Launch {
        program: "sh".into(),
        arguments: vec!["-c".into(), text.into()],
        environment: Vec::new(),
        opening: Duration::from_secs(20),
        timed: false,
    }
}

#[test]
fn a_process_that_ends_at_once_leaves_its_last_words() {
    let failure =
        Subprocess::open(script("echo noise; echo 'driver: no' >&2; exit 3")).err().unwrap();
    assert_eq!(failure.kind, FailureKind::Died);
    assert_eq!(failure.message, "the driver process ended with exit code 3");
    assert_eq!(failure.log, "driver: no");
}

#[test]
fn a_driver_that_hangs_when_it_is_opened_is_not_waited_for() {
    let opening = Duration::from_millis(200);
    let launch = Launch { opening, ..script("exec sleep 600") };
    let failure = Subprocess::open(launch).err().unwrap();
    assert_eq!(failure.kind, FailureKind::TimedOut, "{failure}");
}

#[test]
fn a_program_that_is_not_there_is_named() {
    let launch = Launch { program: "/nonexistent/landfall".into(), ..script("") };
    let failure = Subprocess::open(launch).err().unwrap();
    assert_eq!(failure.kind, FailureKind::Missing);
    golden().eq(failure.message, str!["the driver process does not start: /nonexistent/landfall"]);
}

#[test]
fn what_there_is_is_listed_from_there() {
    for (driver_kind, backend, kinds) in [
        (DriverKind::Gl, "gl", &["core", "compat", "es"][..]),
        (DriverKind::Gpu(None), "gpu", &["vulkan"]),
    ] {
        let found = list(&launch(&driver_kind)).unwrap();
        for kind in kinds {
            let found = found.iter().find(|f| f.kind.starts_with(kind)).unwrap();
            let (device, limits) = found.outcome.as_ref().unwrap();
            assert_eq!((found.backend.name(), device.backend.name()), (backend, backend));
            assert!(limits.uniform_block_size.unwrap() >= 16384);
        }
    }
}

#[test]
fn opengl_says_from_there_where_members_are() {
    let mut backend = open(&DriverKind::Gl);
    let text = "#version 330\nlayout(std140) uniform B { float a; vec3 b; } i; out vec4 c;
void main() { c = vec4(i.b, i.a); }";
    let limit = Duration::from_secs(30);
    let reflection = backend.reflect(&[(Stage::Fragment, text)], limit).unwrap();
    let block = &reflection.uniform_blocks[0];
    assert_eq!((block.name.as_str(), block.size), ("B", 32));
    let members: Vec<(&str, u64)> =
        block.members.iter().map(|m| (m.name.as_str(), m.offset)).collect();
    assert_eq!(members, [("a", 0), ("b", 16)]);
    let failure = backend.reflect(&[(Stage::Fragment, "#version 330\nx")], limit).unwrap_err();
    assert_eq!(failure.kind, FailureKind::Refused);
}
