//! Landfall beside other tools in one table: `cargo bench --features full --bench all`, with `-- --markdown` as
//! the README has it.
//!
//! Every row is two things measured in turns in one run: their ratio, and where 8 of 10 pairs
//! lie. It is a bench and not part of the command, as half of what it compares with (encase, the
//! naga library as it is, mirrors compiled from `lights.rs`) is nothing the command contains.
//! Tools that are not on the path are left out and named. The other benches look closer.

mod measure;
mod naga_parse;
mod scene;
#[path = "../support/files.rs"]
mod support;
mod tree;

use std::collections::HashMap;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;

use encase::{ShaderType, UniformBuffer};
use landfall_accuracy::bench::clock::Start;
use landfall_exec::backend::wgpu::{AdapterChoice, Gpu};
use landfall_exec::backend::{Backend, Job};
use landfall_interp::{Cpu, Settings};
use landfall_layout::{Buffer, Language, Options, Source, layout};
use measure::{Contest, Ratios, contest, interleaved, round};
use naga_parse::parsed;

const LANDFALL: &str = env!("CARGO_BIN_EXE_landfall");

/// Pairs of what takes microseconds.
const SHORT: usize = 301;

/// Pairs of what takes a process.
const LONG: usize = 15;

/// Files that the tools which take one at a time are given.
const FILES: usize = 20;

/// What `landfall emit` makes of `lights.frag`; a test holds it to that.
mod gpu {
    include!("lights.rs");
}

fn main() {
    let markdown = std::env::args().any(|argument| argument == "--markdown");
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("ratios of pairs in turns: median (8 of 10 pairs); load {}\n", load.trim());
    let mut table = Table { markdown };
    table.heading();
    parsing(&mut table);
    commands(&mut table);
    names(&mut table);
    mirrors(&mut table);
    evaluator(&mut table);
    fragments(&mut table);
    skipping(&mut table);
}

struct Table {
    markdown: bool,
}

impl Table {
    fn heading(&self) {
        if self.markdown {
            println!("| what | ratio of their times |\n|---|---|");
        } else {
            println!("{:<70} ratio of their times", "");
        }
    }

    fn row(&mut self, slow: &str, fast: &str, ratios: &Ratios) {
        let what = format!("{slow} : {fast}");
        match self.markdown {
            true => println!("| {what} | {} |", ratios.to_string().trim()),
            false => println!("{what:<70} {ratios}"),
        }
    }

    fn missing(&mut self, what: &str) {
        match self.markdown {
            true => println!("| {what} | not here |"),
            false => println!("{what:<70} not here"),
        }
    }
}

/// Texts of this repository that naga takes, all of them in one go.
fn parsing(table: &mut Table) {
    for (name, language) in [("GLSL", Language::Glsl), ("WGSL", Language::Wgsl)] {
        let sources: Vec<Source> = support::shaders()
            .iter()
            .filter_map(|path| Source::read(path).ok())
            .filter(|source| source.language == language && parsed(source))
            .collect();
        let options = Options::default();
        let ours = || {
            for source in &sources {
                black_box(layout(black_box(source), &options));
            }
        };
        let naga = || {
            for source in &sources {
                black_box(parsed(black_box(source)));
            }
        };
        let Contest { first, ratios, .. } = contest(SHORT / 10, ours, naga);
        let bytes: usize = sources.iter().map(|source| source.text.len()).sum();
        let fast = format!(
            "landfall lays out {} {name} texts ({} MB/s)",
            sources.len(),
            round(bytes as f64 / first / 1e6)
        );
        table.row("naga's library parses", &fast, &ratios);
    }
}

/// Commands, each one process a file, and ours once for all files.
fn commands(table: &mut Table) {
    let all = support::shaders();
    let some = |wgsl: bool, vulkan: bool| -> Vec<PathBuf> {
        let fits = |path: &&PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy().to_string();
            let is_wgsl = name.ends_with(".wgsl");
            is_wgsl == wgsl && (!vulkan || name.contains("_450."))
        };
        all.iter().filter(fits).take(FILES).cloned().collect()
    };
    let tools: [(&str, &[&str], Vec<PathBuf>); 3] = [
        ("glslangValidator", &["-q", "-l", "-V"], some(false, true)),
        ("naga", &[], some(true, false)),
        // Its default is SPIR-V, which few builds of it write.
        ("tint", &["--format", "wgsl"], some(true, false)),
    ];
    for (tool, arguments, files) in tools {
        // What it refuses would be quick for the wrong reason.
        let files: Vec<&PathBuf> =
            files.iter().filter(|file| ran(Command::new(tool).args(arguments).arg(file))).collect();
        if files.is_empty() {
            table.missing(&format!("`{tool}`, one process a file"));
            continue;
        }
        let theirs = || {
            for file in &files {
                ran(Command::new(tool).args(arguments).arg(file));
            }
        };
        let each = || {
            for file in &files {
                ran(Command::new(LANDFALL).arg("layout").arg(file));
            }
        };
        let once = || {
            ran(Command::new(LANDFALL).arg("layout").args(&files));
        };
        let count = files.len();
        let ratios = interleaved(LONG, each, theirs);
        table.row(
            &format!("`{tool}` of {count} files, one process each"),
            "`landfall layout` so",
            &ratios,
        );
        let ratios = interleaved(LONG, once, theirs);
        table.row("the same", "`landfall layout` of them all", &ratios);
    }
    let dir = std::env::temp_dir().join(format!("landfall-bench-all-{}", std::process::id()));
    tree::write(&dir, 2000);
    let jobs = |n: &'static str, dir: &Path| {
        ran(Command::new(LANDFALL).args(["layout", "--format", "csv", "-j", n]).arg(dir));
    };
    let ratios = interleaved(LONG, || jobs("2", &dir), || jobs("1", &dir));
    table.row("`landfall layout -j 1` of 2,000 files", "`-j 2`", &ratios);
    std::fs::remove_dir_all(&dir).expect("the bench's own directory");
}

fn ran(command: &mut Command) -> bool {
    let quiet = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    quiet.status().is_ok_and(|status| status.success())
}

const BLOCK: &str = include_str!("lights.frag");

/// From a name to its offset, 128 different ones.
fn names(table: &mut Table) {
    let block = layout(&Source::new("lights.frag", BLOCK), &Options::default()).blocks.remove(0);
    let mut buffer = Buffer::new(&block).expect("the block has a fixed size");
    let handle = buffer.handle::<[f32; 3]>("data[].color").expect("a vec3");
    let paths: Vec<String> = (0..128).map(|i| format!("data[{}].color", i * 37 % 128)).collect();
    let rows: Vec<(String, usize)> =
        (0..128).map(|i| (format!("data[{i}].color"), 48 * i + 16)).collect();
    let map: HashMap<&str, usize> = rows.iter().map(|(name, at)| (name.as_str(), *at)).collect();
    let mut plain = vec![0u8; 6160];
    let value = [1f32, 0.5, 0.25];
    let store = |plain: &mut [u8], at: usize| {
        plain[at..at + 12].copy_from_slice(bytemuck::bytes_of(black_box(&value)));
    };
    let mut set = |path: &str| buffer.set(path, black_box(value)).expect("in range");
    let by_path = || paths.iter().for_each(|path| set(black_box(path)));
    let by_map = || {
        for path in &paths {
            let at = map[black_box(path.as_str())];
            store(black_box(&mut plain), at);
        }
    };
    let Contest { ratios, .. } = contest(SHORT, by_path, by_map);
    table.row("name to offset by a `HashMap`", "by `Buffer::set`", &ratios);
    let by_scan = || {
        for path in &paths {
            let found = rows.iter().find(|row| row.0 == black_box(path.as_str()));
            store(black_box(&mut plain), found.expect("a name").1);
        }
    };
    let by_path = || paths.iter().for_each(|path| set(black_box(path)));
    let Contest { ratios, .. } = contest(SHORT, by_path, by_scan);
    table.row("by scanning 128 names", "by `Buffer::set`", &ratios);
    let mut at = |i: usize| buffer.set_at(&handle, [i], black_box(value)).expect("in range");
    let by_handle = || (0..128).for_each(|i| at(black_box(i)));
    let constant = || (0..128).for_each(|i| store(black_box(&mut plain), 48 * black_box(i) + 16));
    let Contest { ratios, .. } = contest(SHORT, constant, by_handle);
    table.row("by handle and index", "a store at `48 i + 16`", &ratios);
}

/// As encase would have the same block.
#[derive(Clone, ShaderType)]
struct Lamp {
    pos: Three,
    color: Three,
    intensity: f32,
    constant: f32,
    linear: f32,
    // The mirror's stride is 48 as well: alignment of a vec3 sees to it.
    quadratic: f32,
}

#[derive(Clone, ShaderType)]
struct Lamps {
    data: [Lamp; 128],
    count: i32,
}

/// A vector for encase, which has none of its own.
#[derive(Clone, Copy)]
struct Three([f32; 3]);

impl AsRef<[f32; 3]> for Three {
    fn as_ref(&self) -> &[f32; 3] {
        &self.0
    }
}

impl AsMut<[f32; 3]> for Three {
    fn as_mut(&mut self) -> &mut [f32; 3] {
        &mut self.0
    }
}

impl From<[f32; 3]> for Three {
    fn from(parts: [f32; 3]) -> Three {
        Three(parts)
    }
}

encase::impl_vector!(3, Three, f32; using AsRef AsMut From);

/// 128 lights into the bytes of their block.
fn mirrors(table: &mut Table) {
    let light = gpu::PointLight::new(gpu::PointLightInit {
        pos: [1.0, 2.0, 3.0],
        color: [0.5; 3],
        intensity: 1.0,
        constant: 1.0,
        linear: 0.09,
        quadratic: 0.032,
    });
    let lit = gpu::PointLightBlockInit { data: [light; 128], actually_used_count: 2 };
    let mut block = gpu::PointLightBlock::new(lit);
    let lamp = Lamp {
        pos: Three([1.0, 2.0, 3.0]),
        color: Three([0.5; 3]),
        intensity: 1.0,
        constant: 1.0,
        linear: 0.09,
        quadratic: 0.032,
    };
    let lamps = Lamps { data: std::array::from_fn(|_| lamp.clone()), count: 2 };
    let mut ours = vec![0u8; size_of::<gpu::PointLightBlock>()];
    let mut theirs = UniformBuffer::new(Vec::<u8>::new());
    let mut copy = || {
        black_box(&mut ours).copy_from_slice(bytemuck::bytes_of(black_box(&block)));
    };
    let mut encase = || black_box(&mut theirs).write(black_box(&lamps)).expect("it fits");
    copy();
    encase();
    let Contest { ratios, .. } = contest(SHORT, &mut copy, &mut encase);
    table.row("encase writes a block of 128 lights", "a mirror is copied", &ratios);
    // What matters is what is written: the same bytes.
    assert_eq!(ours, *theirs.as_ref(), "both write the same block");
    let lights = [light; 128];
    // Aligned as the block is, or one of the two copies is of lines that are split.
    let mut to = gpu::PointLightBlock::new(lit);
    let memcpy = || {
        let bytes = &mut bytemuck::bytes_of_mut(black_box(&mut to))[..6144];
        bytes.copy_from_slice(bytemuck::cast_slice(black_box(&lights)));
    };
    let mirror = || black_box(&mut block).data.copy_from_slice(black_box(&lights));
    let Contest { ratios, .. } = contest(SHORT, memcpy, mirror);
    table.row("128 lights into a mirror", "`memcpy` of as many bytes", &ratios);
}

/// A job of six lights as a program waits for it, in processor time of all threads: a driver also
/// binds resources and reads back.
fn evaluator(table: &mut Table) {
    let Ok(mut gpu) = Gpu::open(&AdapterChoice::default()) else {
        return table.missing("the interpreter beside a Vulkan driver");
    };
    if !gpu.device().software {
        return table.missing("the interpreter beside a Vulkan driver on the processor");
    }
    let job = scene::job(&Arc::new(scene::module()), 256);
    let mut cpu = Cpu::new(Settings::default());
    let spent = |backend: &mut dyn Backend, job: &Job| {
        let start = Start::now();
        for _ in 0..4 {
            backend.run(job).expect("the job runs");
        }
        start.elapsed().time.as_secs_f64()
    };
    let mut pairs = Vec::new();
    for pair in 0..=LONG {
        let (a, b) = if pair % 2 == 0 {
            let a = spent(&mut cpu, &job);
            (a, spent(&mut gpu, &job))
        } else {
            let b = spent(&mut gpu, &job);
            (spent(&mut cpu, &job), b)
        };
        // The first compiles.
        if pair > 0 {
            pairs.push(a / b);
        }
    }
    let driver = gpu.device().adapter.split(' ').next().unwrap_or_default().to_string();
    let jobs = "a job of 256 x 256 fragments with transfers: the evaluator";
    table.row(jobs, &driver, &Ratios::new(pairs));
}

/// A fragment of the six-light picture by `landfall bench`: the shader alone, without transfers.
fn fragments(table: &mut Table) {
    let rounds = LONG.to_string();
    let output = Command::new(LANDFALL)
        .args(["bench", "shaders/scenes/six_lights.json", "--format", "json"])
        .args(["--backend", "cpu,gl", "--rounds", &rounds])
        .args(["--model", r#"{"family":"multi","specular_gate":"none"}"#])
        .args(["--variant", "seed=shaders/seed/six_lights_450.frag"])
        .output();
    let bench = output.ok().and_then(|output| serde_json::from_slice(&output.stdout).ok());
    let bench: serde_json::Value = bench.unwrap_or_default();
    let rounds = |backend: &str| -> Vec<f64> {
        let rows = bench["rows"].as_array().map_or(&[][..], |rows| rows);
        let found = rows.iter().find(|row| row["runner"]["backend"] == backend);
        let all = found.and_then(|row| row["ns_per_fragment_rounds"].as_array());
        all.into_iter().flatten().filter_map(serde_json::Value::as_f64).collect()
    };
    let pairs: Vec<f64> = rounds("cpu").iter().zip(rounds("gl")).map(|(a, b)| a / b).collect();
    if pairs.is_empty() {
        return table.missing("`landfall bench` of the six-light picture: cpu beside gl");
    }
    let what = "`landfall bench` of the six-light picture, a fragment: cpu";
    table.row(what, "gl", &Ratios::new(pairs));
}

/// Scenes with `--skip`, from start to end.
fn skipping(table: &mut Table) {
    let scenes = [
        ("lights_1024_windowed", "1,024 lights with windows"),
        ("lights_1024", "1,024 lights without"),
        ("six_lights", "six lights"),
    ];
    for (scene, what) in scenes {
        let path = format!("shaders/scenes/{scene}.json");
        let render = |arguments: &[&str]| {
            let size = ["render", &path, "--size", "320x180"];
            assert!(ran(Command::new(LANDFALL).args(size).args(arguments)), "{scene}");
        };
        let ratios = interleaved(LONG, || render(&["--skip"]), || render(&[]));
        table.row(&format!("`landfall render` of {what}"), "`--skip`", &ratios);
    }
}
