//! Blocks read back through WebGL 2 and WebGPU of a browser: every leaf of every shader of the
//! repository and of random blocks, planted faults, and text that must stay text. A browser that is
//! missing fails the tests.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::support;

use landfall_exec::backend::web::{self, Apis, Launch};
use landfall_exec::backend::{Backend, FailureKind, Grid, Job, StageCode, Texel};
use landfall_exec::harness::verify::{
    BackendReport, BlockReport, Form, Outcome, ShaderReport, Subject, VerifyOptions, verify,
};
use landfall_layout::{BlockLayout, Leaf, Source, Stage};
use support::blocks::{Block, Rules as BlockRules, Space, print};
use support::generate::{Diet, random};
use support::known::UNREAD;
use support::sample::{everything, sample};

/// A browser keeps several processors busy: one at a time.
static ONLY: Mutex<()> = Mutex::new(());

struct Browser {
    /// WebGL, then WebGPU.
    apis: Vec<Box<dyn Backend>>,
    processes: Vec<Option<u32>>,
    scratch: PathBuf,
    _only: MutexGuard<'static, ()>,
}

impl Browser {
    fn start(name: &str, arguments: &[&str]) -> Browser {
        let _only = ONLY.lock().unwrap_or_else(PoisonError::into_inner);
        // Characters that a URL does not have.
        let scratch =
            std::env::temp_dir().join(format!("landfall web {name}#{}", std::process::id()));
        std::fs::create_dir_all(&scratch).expect("a directory for the profile");
        let mut launch = Launch::new("chromium", &scratch);
        launch.arguments = arguments.iter().map(OsString::from).collect();
        let Apis { webgl, webgpu } =
            web::open(launch).expect("a browser: apt-get install chromium");
        let apis = [webgl.expect("WebGL 2"), webgpu.expect("WebGPU")];
        let processes = apis.iter().map(web::Web::process).collect();
        let apis = apis.into_iter().map(|api| Box::new(api) as Box<dyn Backend>).collect();
        Browser { apis, processes, scratch, _only }
    }

    fn verified(&mut self, source: &Source, options: &VerifyOptions) -> ShaderReport {
        self.verified_by(0..self.apis.len(), source, options)
    }

    fn verified_by(
        &mut self,
        apis: Range<usize>,
        source: &Source,
        options: &VerifyOptions,
    ) -> ShaderReport {
        let subject = Subject::new(source, options)
            .unwrap_or_else(|(_, found)| panic!("{}: {found:?}\n{}", source.path, source.text));
        verify(&subject, options, &mut self.apis[apis])
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        self.apis.clear();
        let left = std::fs::read_dir(&self.scratch).map_or(0, Iterator::count);
        let _ = std::fs::remove_dir_all(&self.scratch);
        if !std::thread::panicking() {
            assert_eq!(left, 0, "the profile is removed");
        }
    }
}

fn options() -> VerifyOptions {
    VerifyOptions { limit: Duration::from_secs(120), ..VerifyOptions::default() }
}

/// Every report of a block by an API, with what it is about.
fn each(report: &ShaderReport) -> impl Iterator<Item = (&str, &BackendReport)> {
    let blocks = report.blocks.iter();
    blocks.flat_map(|block| block.backends.iter().map(|backend| (&*block.name, backend)))
}

/// Blocks confirmed, their leaves and reads, and blocks skipped by reason.
#[derive(Default)]
struct Tally {
    confirmed: BTreeMap<&'static str, [usize; 3]>,
    skipped: BTreeMap<(&'static str, String), usize>,
}

impl Tally {
    fn add(&mut self, source: &Source, block: &BlockReport) {
        for seen in &block.backends {
            let api = seen.backend.name();
            let name = format!("{} {} {api}", source.path, block.name);
            match seen.outcome {
                Outcome::Confirmed => {
                    assert!(!seen.reads.is_empty(), "{name}");
                    let [blocks, leaves, reads] = self.confirmed.entry(api).or_default();
                    *blocks += 1;
                    *leaves += block.leaves;
                    *reads += seen.reads.len();
                }
                Outcome::Skipped => {
                    let reason = reason(seen);
                    assert!(is_known(api, &reason), "{name}: {reason}");
                    *self.skipped.entry((api, reason)).or_default() += 1;
                }
                Outcome::Disagrees | Outcome::Failed => {
                    panic!("{name}: {:?} {}\n{:#?}", seen.reason, seen.log, seen.causes)
                }
            }
        }
    }
}

fn reason(seen: &BackendReport) -> String {
    let reason = seen.reason.clone().unwrap_or_default();
    match &*seen.log {
        "" => reason,
        log => format!("{reason}: {}", log.lines().next().unwrap_or_default()),
    }
}

/// Through ANGLE's translation to the GLSL of Mesa's driver, and to SPIR-V for SwiftShader, whose
/// compiler takes ten times as long: there, and by WebGPU, every fifth shader is read. All are by
/// `landfall verify shaders --backend web`.
#[test]
fn every_leaf_of_our_shaders_is_read_where_it_is_laid_out() {
    for (name, arguments) in [("angle-gl", &["--use-angle=gl-egl"][..]), ("angle-vulkan", &[])] {
        let mut browser = Browser::start(name, arguments);
        let adapter = browser.apis[0].device().adapter.clone();
        let mut tally = Tally::default();
        let (step, apis) = if arguments.is_empty() { (30, 0..2) } else { (6, 0..1) };
        let paths = support::files::shaders();
        for number in sample(0..paths.len() as u64, step) {
            let path = &paths[number as usize];
            let source = Source::read(path).expect("a shader of ours is text");
            let report = browser.verified_by(apis.clone(), &source, &options());
            report.blocks.iter().for_each(|block| tally.add(&source, block));
        }
        println!("{adapter}: blocks, leaves, reads {:?}", tally.confirmed);
        for ((api, reason), count) in &tally.skipped {
            println!("{count:>4} {api}: {reason}");
        }
        let least = match arguments.is_empty() {
            true => vec![("webgl", [20, 120, 1_000]), ("webgpu", [35, 150, 1_500])],
            false => vec![("webgl", [130, 720, 32_000])],
        };
        for (api, least) in least.into_iter().filter(|_| everything()) {
            let found = tally.confirmed[api];
            assert!(found.iter().zip(least).all(|(found, least)| *found >= least), "{found:?}");
        }
    }
}

/// What an API does not take, and what no backend probes.
fn is_known(api: &str, reason: &str) -> bool {
    let of_api = UNREAD.iter().filter(|unread| unread.api == api).map(|unread| unread.reason);
    let known = of_api.chain(["it is a buffer reference", "it holds addresses"]);
    known.into_iter().any(|start| reason.starts_with(start))
}

/// An entry that an upgrade makes stale fails here.
#[test]
#[ignore = "runs for long in a browser: ./tests/run exec"]
fn what_an_api_does_not_read_is_said_with_its_reason() {
    let mut browser = Browser::start("unread", &[]);
    for unread in UNREAD {
        let (extension, declarations) = unread.example;
        let text = match extension {
            "wgsl" => declarations.to_string(),
            _ => format!("#version 460\n{declarations}\nvoid main() {{}}\n"),
        };
        let source = Source::new(format!("a.{extension}"), text.as_str());
        let report = browser.verified(&source, &options());
        let mut all = each(&report).filter(|(_, seen)| seen.backend.name() == unread.api);
        let seen = all.next().expect("the API").1;
        let (because, found) = (unread.because, reason(seen));
        assert_eq!(seen.outcome, Outcome::Skipped, "{because}: {found}");
        assert!(found.starts_with(unread.reason), "{because}: {found} for {}", unread.reason);
    }
}

/// What WebGL 2 has: std140 uniform blocks of 32-bit scalars.
const DIET: Diet = Diet {
    kinds: &[(Space::Uniform, BlockRules::Std140)],
    scalars: &[
        support::blocks::Scalar::Float,
        support::blocks::Scalar::Int,
        support::blocks::Scalar::Uint,
        support::blocks::Scalar::Bool,
    ],
    matrices: &[support::blocks::Scalar::Float],
    push_constant: false,
};

#[test]
fn random_blocks_are_read_where_they_are_laid_out() {
    let mut browser = Browser::start("random", &[]);
    let mut tally = Tally::default();
    for seed in sample(0..60, 6) {
        let (standing, made) = random(seed, 3, &DIET);
        let made: Vec<&Block> = made.iter().collect();
        let extension = ["vert", "frag"][seed as usize % 2];
        // Without what only a compute shader may have.
        let text = print(&standing, &made).replace("layout(local_size_x = 1) in;\n", "");
        let declared = text.split("shared float sink;").next().expect("there is a first part");
        let text = format!("{declared}void main() {{}}\n");
        let source = Source::new(format!("seed_{seed}.{extension}"), text.as_str());
        let report = browser.verified_by(0..1, &source, &options());
        report.blocks.iter().for_each(|block| tally.add(&source, block));
    }
    println!("{:?} {:?}", tally.confirmed, tally.skipped);
    let [blocks, _, reads] = tally.confirmed["webgl"];
    let share = if everything() { 1 } else { 12 };
    assert!(blocks >= 50 / share && reads >= 2_000 / share, "{blocks} blocks, {reads} reads");
}

/// The structures whose layout encase computes, too.
#[test]
fn wgsl_structures_are_read_and_written_where_they_are_laid_out() {
    let mut browser = Browser::start("wgsl", &[]);
    let source = Source::new("structures.wgsl", support::wgsl::text().as_str());
    let report = browser.verified(&source, &options());
    let (mut reads, mut writes) = (0, 0);
    for (block, seen) in each(&report).filter(|(_, seen)| seen.backend.name() == "webgpu") {
        assert_eq!(seen.outcome, Outcome::Confirmed, "{block}: {:?}\n{}", seen.reason, seen.log);
        let written = seen.reads.iter().filter(|read| read.way == "written").count();
        (reads, writes) = (reads + seen.reads.len() - written, writes + written);
    }
    println!("{} blocks, {reads} reads, {writes} writes", report.blocks.len());
    assert_eq!(report.blocks.len(), support::wgsl::cases().len());
    assert!(reads > 500 && writes > 200, "{reads} reads, {writes} writes");
}

const GLSL: &str = "#version 300 es
precision mediump float;
struct Light { vec3 position; float power; };
layout(std140) uniform Lights { float time; Light lights[4]; mat3 frame; float weights[3]; vec2 tail; } u;
out vec4 colour;
void main() { colour = vec4(u.lights[1].power); }
";

const WGSL: &str = "struct Light { position: vec3<f32>, power: f32 }
struct Lights { time: f32, lights: array<Light, 4>, frame: mat3x3<f32>, weights: array<vec4f, 3>, tail: vec2<f32> }
@group(0) @binding(1) var<uniform> u: Lights;
@fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(u.lights[1].power); }
";

/// The leaves that an API sees elsewhere, with the causes.
fn caught(browser: &mut Browser, fault: impl Fn(&mut BlockLayout)) -> Vec<(String, String)> {
    let mut all = Vec::new();
    for (name, text, api) in [("a.frag", GLSL, "webgl"), ("a.wgsl", WGSL, "webgpu")] {
        let source = Source::new(name, text);
        let mut given = landfall_layout::layout(&source, &Default::default()).blocks;
        fault(&mut given[0]);
        let report = browser.verified(&source, &VerifyOptions { given: Some(given), ..options() });
        let seen = each(&report).find(|(_, seen)| seen.backend.name() == api).expect("it ran").1;
        let elsewhere = seen.reads.iter().filter(|read| read.byte_read != Some(read.expected_byte));
        let mut leaves: Vec<(String, String)> = elsewhere
            .map(|read| {
                let cause = seen.causes.iter().find(|cause| cause.leaf == read.leaf);
                (read.leaf.clone(), cause.map_or(String::new(), |cause| cause.cause.clone()))
            })
            .collect();
        // One that a probe reads and WebGL reports elsewhere is one.
        leaves.sort();
        leaves.dedup();
        assert_eq!(seen.outcome == Outcome::Disagrees, !leaves.is_empty(), "{:?}", seen.reason);
        all.push(leaves);
    }
    let paths = |leaves: &[(String, String)]| -> Vec<String> {
        leaves.iter().map(|(path, _)| path.clone()).collect()
    };
    assert_eq!(paths(&all[0]), paths(&all[1]), "WebGL against WebGPU");
    for ((path, of_webgl), (_, of_webgpu)) in all[0].iter().zip(&all[1]) {
        // By chance, the offset may be that of other rules, too.
        let last = |cause: &str| cause.rsplit("; ").next().map(str::to_string);
        assert_eq!(last(of_webgl), last(of_webgpu), "{path}");
    }
    all.swap_remove(0)
}

#[test]
#[ignore = "runs for long in a browser: ./tests/run exec"]
fn planted_faults_are_caught_by_both_apis() {
    let mut browser = Browser::start("faults", &[]);
    let leaf = |block: &mut BlockLayout, path: &str, change: &dyn Fn(&mut Leaf)| {
        change(block.leaves.iter_mut().find(|leaf| leaf.path == path).expect("such a leaf"));
    };
    assert_eq!(caught(&mut browser, |_| {}), []);
    // By hand: lights at 16 to 80, frame to 128, weights to 176, then tail.
    let found = caught(&mut browser, |block| {
        leaf(block, "tail", &|leaf| leaf.offset = leaf.offset.map(|offset| offset + 8));
    });
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].0, "tail");
    assert!(found[0].1.ends_with("it starts at 176 instead of 184"), "{found:?}");
    let found = caught(&mut browser, |block| {
        leaf(block, "lights[].power", &|leaf| leaf.strides[0] = 32);
    });
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].0, "lights[].power");
    assert!(found[0].1.ends_with("the array stride is 16 instead of 32"), "{found:?}");
    let found = caught(&mut browser, |block| {
        leaf(block, "frame", &|leaf| leaf.row_major = true);
    });
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].1.ends_with("rows and columns are swapped"), "{found:?}");
    // A layout under the wrong rules: std430 has `weights` at stride 4 and `tail` after them.
    let text = GLSL.replace("std140) uniform", "std430) buffer").replace("300 es", "430");
    let wrong = landfall_layout::layout(&Source::new("a.frag", text.as_str()), &Default::default());
    let wrong: Vec<Leaf> = wrong.blocks[0].leaves.clone();
    let found = caught(&mut browser, |block| block.leaves.clone_from(&wrong));
    let paths: Vec<&str> = found.iter().map(|(path, _)| &**path).collect();
    assert_eq!(paths, ["tail", "weights[]"], "{found:?}");
}

/// GLSL ES 3.00 is reflected as it is, its `main` included.
#[test]
#[ignore = "runs for long in a browser: ./tests/run exec"]
fn webgl_reports_offsets_of_the_unchanged_text() {
    let mut browser = Browser::start("reflected", &[]);
    let report = browser.verified(&Source::new("a.frag", GLSL), &options());
    let (_, seen) = each(&report).next().expect("WebGL");
    assert_eq!((seen.form, seen.outcome), (Form::Declared, Outcome::Confirmed));
    let reported: Vec<(&str, Option<u64>)> = seen
        .reads
        .iter()
        .filter(|read| read.way == "reported")
        .map(|read| (&*read.path, read.byte_read))
        .collect();
    // OpenGL ES 3.0 §2.12.6.4, by hand.
    for expected in
        [("time", 0), ("lights[3].power", 16 + 48 + 12), ("frame", 80), ("weights[1]", 144)]
    {
        assert!(reported.contains(&(expected.0, Some(expected.1))), "{expected:?} in {reported:?}");
    }
}

/// Every part of a text that reaches the browser: comments, names of files, names of blocks.
#[test]
#[ignore = "runs for long in a browser: ./tests/run exec"]
fn hostile_text_stays_text() {
    let mut browser = Browser::start("hostile", &[]);
    let acts = [
        "</script><script>document.title='acted'</script>",
        "`${document.title='acted'}`",
        "'); document.title='acted'; ('",
        "\"}); document.title=\"acted\"; ({\"",
        "\\u0027); document.title='acted'; //",
        "<img src=x onerror=document.title='acted'>",
        "\u{2028}document.title='acted'\u{2029}",
        "\u{0000}\u{FEFF}\u{202E}",
    ];
    for act in acts {
        let comment = act.replace('\n', " ").replace('\0', "");
        let glsl = format!(
            "#version 300 es\nprecision highp float;\n// {comment}\n\
             layout(std140) uniform B {{ float a; }};\nvoid main() {{ gl_Position = vec4(a); }}\n"
        );
        let wgsl = format!(
            "/* {} */\n@group(0) @binding(0) var<uniform> B: vec4f;\n",
            comment.replace("*/", "")
        );
        for (name, text, api) in [("a.vert", glsl, 0), ("a.wgsl", wgsl, 1)] {
            let source =
                Source { path: format!("{act}{name}"), ..Source::new(name, text.as_str()) };
            let report = browser.verified(&source, &options());
            let seen = &report.blocks[0].backends[api];
            let title = run(&mut browser, SEVEN, None).map(|pixel| pixel[0]);
            assert_eq!(title, Ok(7.0f32.to_bits()), "{act}");
            assert_eq!(seen.outcome, Outcome::Confirmed, "{act}: {:?}\n{}", seen.reason, seen.log);
        }
    }
}

/// A statement that sets the result of [`run`].
const SEVEN: &str = "float a = 7.0;";

/// Runs a fragment shader of one pixel on WebGL that returns `a`.
fn run(browser: &mut Browser, a: &str, limit: Option<Duration>) -> Result<[u32; 4], FailureKind> {
    let code = StageCode::of_text;
    let vertex = "#version 300 es\nvoid main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, \
                  gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }\n";
    let fragment = format!(
        "#version 300 es\nprecision highp float;\nout vec4 o;\nvoid main() {{ {a} o = vec4(a); }}\n"
    );
    let job = Job {
        stages: vec![code(Stage::Vertex, vertex), code(Stage::Fragment, &fragment)],
        resources: Vec::new(),
        grid: Grid::Image { width: 1, height: 1, texel: Texel::Float },
        limit: limit.unwrap_or(Duration::from_secs(60)),
    };
    browser.apis[0].run(&job).map(|output| output.pixels[0]).map_err(|failure| failure.kind)
}

/// A refused shader, a limit that is exceeded, and a browser that was killed: the next job runs.
#[test]
fn a_browser_that_fails_is_started_again() {
    let mut browser = Browser::start("again", &[]);
    let seven = Ok([7.0f32.to_bits(); 4]);
    assert_eq!(run(&mut browser, SEVEN, None), seven);
    assert_eq!(run(&mut browser, "nothing a = 7.0;", None), Err(FailureKind::Refused));
    assert_eq!(run(&mut browser, SEVEN, None), seven);
    let endless = "float a = 7.0; while (a > 0.0) a += gl_FragCoord.x;";
    let second = Some(Duration::from_secs(1));
    assert_eq!(run(&mut browser, endless, second), Err(FailureKind::TimedOut));
    assert_eq!(run(&mut browser, SEVEN, None), seven);
    let supervisor = browser.processes[0].expect("it ran");
    assert!(!std::path::Path::new(&format!("/proc/{supervisor}")).exists(), "it was ended");
    let running = children(std::process::id());
    let [supervisor] = &running[..] else { panic!("{running:?}") };
    for process in children(*supervisor) {
        let killed = std::process::Command::new("kill").args(["-9", &process.to_string()]).status();
        assert!(killed.expect("kill").success());
    }
    let begun = Instant::now();
    assert_eq!(run(&mut browser, SEVEN, None), Err(FailureKind::Died));
    assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", begun.elapsed());
    assert_eq!(run(&mut browser, SEVEN, None), seven);
}

/// The children of a process that run `sh` or a browser.
fn children(process: u32) -> Vec<u32> {
    let tasks = std::fs::read_dir(format!("/proc/{process}/task")).into_iter().flatten().flatten();
    let all = tasks.filter_map(|task| std::fs::read_to_string(task.path().join("children")).ok());
    let all: Vec<u32> = all
        .flat_map(|all| all.split_whitespace().filter_map(|id| id.parse().ok()).collect::<Vec<_>>())
        .collect();
    let is_browser = |id: &u32| {
        let command = std::fs::read_to_string(format!("/proc/{id}/cmdline")).unwrap_or_default();
        command.contains("--user-data-dir=")
    };
    all.into_iter().filter(is_browser).collect()
}
