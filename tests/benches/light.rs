//! What lighting costs and what skipping saves: `cargo bench --features full --bench light`, which with
//! `--no-default-features` builds without drivers.
//!
//! Times are CPU time of this thread, each contest in turns A B, B A, the median of the rounds
//! with the 10th and 90th percentile. A time per light is a slope: what a further light adds.

use std::hint::black_box;

use glam::{DVec3, Vec3};
use landfall_layout::Buffer;
use landfall_light::culling;
use landfall_light::culling::{Options, Plan, UploadChoice};
use landfall_light::reference;
use landfall_light::sample::texels;
use landfall_light::scene::{Cone, Scene, SpotLight};
use landfall_light::shading_f32::{
    Form, Gates, Lights, Model, Shaded, Surface, Work, execute, shade_all, surfaces,
};
use landfall_light::{Frame, FrameOptions, Upload, scene};
use measure::{median, round};

mod measure;

const ROUNDS: usize = 15;
const SEED: Form = Form::Seed;
const ROBUST: Form = Form::Robust(Gates::ALL);

struct FragmentLights {
    upload: Upload,
    frame: Frame,
}

fn main() {
    println!("load {}", std::fs::read_to_string("/proc/loadavg").unwrap_or_default().trim());
    forms();
    few_lights();
    many_lights();
    far_lights();
    skipping();
    uploads();
}

/// The robust form against the published one on the six-light scene.
fn forms() {
    let lit = load("six_lights", None);
    let model = Model::default();
    println!("\nsix lights, {} fragments: ns a fragment", lit.frame.fragments.len());
    let exact = surfaces(&lit.frame, &lit.upload, &model, 0.0);
    let tiny = surfaces(&lit.frame, &lit.upload, &model, 2f64.powi(-24));
    let eye = lit.upload.camera.as_vec3();
    let six = Lights::new(&lit.upload, &model);
    let none = Lights::default();
    let points = Lights { directional: Vec::new(), spot: Vec::new(), ..six.clone() };
    let more = Lights { point: points.point.repeat(4), ..points.clone() };
    let shade = |surfaces: &[Surface], lights: &Lights, form: Form| {
        let shaded: Shaded<()> = shade_all(black_box(surfaces), eye, lights, &model, form);
        drop(black_box(shaded));
    };
    let variants: [(&str, &[Surface], Form); 4] = [
        ("seed", &exact, SEED),
        ("robust, no gate", &exact, Form::Robust(Gates::NONE)),
        ("robust, exact gates", &exact, ROBUST),
        ("robust, powers from 2^-24", &tiny, ROBUST),
    ];
    let fragments = exact.len() as f64;
    println!("{:28} {:>22} {:>22} {:>12}", "", "six lights", "a point light more", "max error");
    let mut seeds = [0.0; 2];
    for (name, surfaces, form) in variants {
        let [whole, slope] = {
            let contest = |a: &Lights, b: &Lights, per: f64| -> Spread {
                slopes(|| shade(surfaces, a, form), || shade(surfaces, b, form), per * fragments)
            };
            [contest(&none, &six, 1.0), contest(&points, &more, 12.0)]
        };
        let fixed = spread(|| shade(surfaces, &none, form), fragments);
        let total = fixed.median + whole.median;
        if form == SEED {
            seeds = [total, slope.median];
        }
        println!(
            "{name:28} {total:6.1}  {:>4} of seed    {slope} {:>4} of seed  {:8.1e} step",
            round(total / seeds[0]),
            round(slope.median / seeds[1]),
            error(&lit, surfaces, form)
        );
    }
    // The claim itself, in pairs.
    let pairs =
        measure::interleaved(ROUNDS, || shade(&tiny, &six, ROBUST), || shade(&exact, &six, SEED));
    println!("seed takes {pairs} times as long as robust, six lights");
    let pairs =
        measure::interleaved(ROUNDS, || shade(&tiny, &more, ROBUST), || shade(&exact, &more, SEED));
    println!("seed takes {pairs} times as long as robust, 16 point lights");
    for (name, surfaces, form) in variants {
        let Work { evaluations, attenuations, powers, .. } =
            shade_all::<Work>(surfaces, eye, &six, &model, form).tally;
        let per = |n: u64| n as f64 / fragments;
        println!(
            "{name:28} {:.2} evaluations, {:.2} attenuations, {:.2} powers a fragment",
            per(evaluations),
            per(attenuations),
            per(powers)
        );
    }
}

/// The largest difference from the reference in `f64`, in steps.
fn error(lit: &FragmentLights, surfaces: &[Surface], form: Form) -> f64 {
    let FragmentLights { upload, frame } = lit;
    let model = reference::Model::default();
    let lights = Lights::new(upload, &Model::default());
    let eye = upload.camera.as_vec3();
    let stride = 7;
    let some: Vec<Surface> = surfaces.iter().step_by(stride).copied().collect();
    let colors = shade_all::<()>(&some, eye, &lights, &Model::default(), form).colors;
    let mut most = 0f64;
    for (fragment, color) in frame.fragments.iter().step_by(stride).zip(colors) {
        let texels = texels(&upload.materials[fragment.material as usize], fragment.uv);
        if let Ok(truth) = reference::shade(&model, upload, fragment, &texels) {
            most = most.max((color.as_dvec3() - truth.total).abs().max_element() * 255.0);
        }
    }
    most
}

/// Lists cost more than they save where there are few lights.
fn few_lights() {
    let lit = load("six_lights", None);
    let model = Model::default();
    println!("\nsix lights: making a plan beside what it saves");
    row(&lit, &model, "used,tiles");
}

/// 1,024 lights that end.
fn many_lights() {
    let lit = load("lights_1024_windowed", None);
    let model = Model { windowed: true, ..Model::default() };
    println!("\n1,024 windowed lights, {} fragments", lit.frame.fragments.len());
    let exact = exact_in_range(&lit);
    println!("exactly in range: {exact:.1} lights a fragment");
    for text in ["used", "tiles=8", "tiles=16"] {
        row(&lit, &model, text);
    }
}

/// What skipping gains in time, the making of its plan included: ratios of pairs in turns.
fn skipping() {
    println!("\ntime of every light : of a plan, made and executed");
    let model = Model { windowed: true, ..Model::default() };
    let lit = load("lights_1024_windowed", None);
    for text in ["tiles=8", "tiles=16"] {
        gains("1,024 windowed point lights", &lit, &model, text);
    }
    let high: [(&str, &str); 2] = [("\"count\": 1024", "\"count\": 256"), ("[0.5, 4]", "[4, 12]")];
    let spots = spots(scene_of("lights_1024", &high));
    for text in ["tiles=8", "tiles=16"] {
        gains("256 spotlights of 20 degrees", &spots, &Model::default(), text);
    }
    let more = [
        ("\"count\": 1024", "\"count\": 16384"),
        ("[100, 100]", "[400, 400]"),
        ("\"count\": 200,", "\"count\": 3200,"),
    ];
    let more = FragmentLights::of(scene_of("lights_1024_windowed", &more));
    for text in ["tiles=8", "tiles=16"] {
        let options = culling::parse(text).expect("good options");
        let surfaces = [&lit, &more].map(|l| surfaces(&l.frame, &l.upload, &model, 0.0));
        let planned = |lit: &FragmentLights, surfaces: &[Surface]| {
            let plan = culling::plan_only(&lit.upload, &lit.frame, &model, &options);
            drop(black_box(execute::<()>(&plan, &lit.upload, surfaces, &model, ROBUST)));
        };
        let ratios = measure::interleaved(
            ROUNDS,
            || planned(&lit, &surfaces[0]),
            || planned(&more, &surfaces[1]),
        );
        println!("16,384 lights on 16 times the area : 1,024, {text:10} {ratios}");
    }
}

/// One row for each loop over every light.
fn gains(name: &str, lit: &FragmentLights, model: &Model, text: &str) {
    let FragmentLights { upload, frame } = lit;
    let surfaces = surfaces(frame, upload, model, 0.0);
    let (lights, eye) = (Lights::new(upload, model), upload.camera.as_vec3());
    let options = culling::parse(text).expect("good options");
    let whole = culling::plan_only(upload, frame, model, &Options::default());
    let planned = || {
        let plan = culling::plan_only(upload, frame, model, &options);
        drop(black_box(execute::<()>(&plan, upload, &surfaces, model, ROBUST)));
    };
    let gates = [("", Gates::NONE), (", what adds nothing skipped", Gates::ALL)];
    for (which, gates) in gates {
        let form = Form::Robust(gates);
        let single = || drop(black_box(shade_all::<()>(&surfaces, eye, &lights, model, form)));
        let lanes = || drop(black_box(execute::<()>(&whole, upload, &surfaces, model, form)));
        let rounds = if gates == Gates::ALL { ROUNDS } else { 5 };
        let ratios = measure::interleaved(rounds, planned, single);
        println!("{name}, {text}: one fragment at a time{which} {ratios}");
        let ratios = measure::interleaved(ROUNDS, planned, lanes);
        println!("{name}, {text}: fragments in lanes{which} {ratios}");
    }
}

/// The same lamps as spotlights that point down, up to 35 degrees aslant.
fn spots(mut scene: Scene) -> FragmentLights {
    let mut random = fastrand::Rng::with_seed(9);
    let cosine = |degrees: f64| degrees.to_radians().cos();
    let cone = Cone { inner_cos: cosine(16.0), outer_cos: cosine(20.0), degrees: None };
    let spot = |point| {
        let direction = DVec3::new(random.f64() - 0.5, -1.0, random.f64() - 0.5).normalize();
        SpotLight { point, direction, cone }
    };
    scene.lights.spot = scene.lights.point.drain(..).map(spot).collect();
    FragmentLights::of(scene)
}

/// 1,024 lights that do not end.
fn far_lights() {
    let model = Model::default();
    for seed in [42, 1, 7] {
        let lit = load("lights_1024", Some(seed));
        println!(
            "\n1,024 lights without end, seed {seed}, {} fragments",
            lit.frame.fragments.len()
        );
        for text in ["used", "budget=0.5"] {
            row(&lit, &model, text);
        }
    }
}

/// One plan: what it saves, what making and executing it takes.
fn row(lit: &FragmentLights, model: &Model, text: &str) {
    let FragmentLights { upload, frame } = lit;
    let options = culling::parse(text).expect("good options");
    let surfaces = surfaces(frame, upload, model, 0.0);
    let fragments = frame.fragments.len() as f64;
    let plan = culling::plan(upload, frame, model, &options);
    let run = |plan: &Plan| {
        drop(black_box(execute::<()>(plan, upload, &surfaces, model, ROBUST)));
    };
    let rounds = if plan.evaluations() > 20_000_000 { 2 } else { 9 };
    let made =
        cpu_median(rounds, || drop(black_box(culling::plan_only(upload, frame, model, &options))));
    let lit = cpu_median(rounds, || run(&plan));
    let per = plan.evaluations() as f64 / fragments;
    println!(
        "{text:20} {per:8.2} evaluations a fragment, {:6} times fewer; made in {:7.2} ms, lit in {:8.2} ms; {} draws",
        round(plan.savings.before as f64 / plan.evaluations().max(1) as f64),
        1e3 * made,
        1e3 * lit,
        plan.draws.len(),
    );
    for step in &plan.savings.steps {
        println!("    {}: {:?} ({})", step.option, step.error, step.did);
    }
}

fn exact_in_range(lit: &FragmentLights) -> f64 {
    let lights = &lit.upload.lights.point;
    let mut count = 0u64;
    for fragment in &lit.frame.fragments {
        let at = Vec3::from(fragment.position).as_dvec3();
        let inside = lights.iter().filter(|light| {
            let range = light.attenuation.range.unwrap_or(f64::INFINITY);
            (light.position - at).length_squared() < range * range
        });
        count += inside.count() as u64;
    }
    count as f64 / lit.frame.fragments.len() as f64
}

/// Ranges against the whole block: what a call costs in bytes.
fn uploads() {
    const LIGHTS: &str = "
        struct PointLight { vec3 pos; vec3 color; float intensity; float constant; float linear; float quadratic; };
        layout(std140) uniform PointLightBlock { PointLight data[128]; int actually_used_count; } lights;
    ";
    let source = landfall_layout::Source::new("lights.frag", LIGHTS);
    let block =
        landfall_layout::layout(&source, &landfall_layout::Options::default()).blocks.remove(0);
    let mut buffer = Buffer::new(&block).expect("a fixed size");
    let mut staging = vec![0u8; buffer.bytes().len()];
    println!("\nuploads of a block of {} bytes, staged by copying", staging.len());
    let position = buffer.handle::<[f32; 3]>("data[].pos").expect("a vec3");
    for moved in [1, 2, 8, 32, 128] {
        buffer.clear_dirty();
        for light in 0..moved {
            buffer.set_at(&position, [light * 128 / moved], [1.0; 3]).expect("in range");
        }
        let parts = culling::CALL;
        let (choice, upload) = culling::choose(&buffer, parts);
        let many = 2000;
        let ranges = cpu_median(9, || {
            for _ in 0..many {
                for range in black_box(&buffer).dirty(0) {
                    staging[range.clone()].copy_from_slice(&buffer.bytes()[range]);
                }
                black_box(&mut staging);
            }
        });
        let whole = cpu_median(9, || {
            for _ in 0..many {
                staging.copy_from_slice(black_box(&buffer).bytes());
                black_box(&mut staging);
            }
        });
        let chosen = match choice {
            UploadChoice::Nothing => "nothing".to_string(),
            UploadChoice::Ranges(ranges) => format!("{} ranges", ranges.len()),
            UploadChoice::Whole => "the whole block".to_string(),
        };
        println!(
            "{moved:4} positions moved: {:5.0} ns in ranges, {:5.0} ns whole; at {parts} bytes a call: {chosen}, {} bytes dirty",
            1e9 * ranges / f64::from(many),
            1e9 * whole / f64::from(many),
            upload.bytes
        );
    }
}

fn load(name: &str, seed: Option<u64>) -> FragmentLights {
    let seed = seed.map(|seed| format!("\"seed\": {seed}"));
    let other: Vec<(&str, &str)> = seed.iter().map(|s| ("\"seed\": 42", s.as_str())).collect();
    FragmentLights::of(scene_of(name, &other))
}

/// Reads a scene, with other numbers in its text.
fn scene_of(name: &str, others: &[(&str, &str)]) -> Scene {
    let path = format!("{}/shaders/scenes/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let mut text = std::fs::read_to_string(&path).expect("a scene of ours");
    for (from, to) in others {
        assert!(text.contains(from), "{name}: {from}");
        text = text.replace(from, to);
    }
    let folder = format!("{}/shaders/scenes/", env!("CARGO_MANIFEST_DIR"));
    let open = |name: &str| {
        std::fs::read(format!("{folder}{name}"))
            .map_err(|e| landfall_layout::Error::new(name, e.to_string()))
    };
    let reading = scene::read(&path, &text, &open);
    reading.scene.unwrap_or_else(|| panic!("{:?}", reading.diagnostics))
}

impl FragmentLights {
    fn of(scene: Scene) -> FragmentLights {
        let frame = Frame::new(&scene, &FrameOptions::default());
        FragmentLights { upload: Upload::new(&scene), frame }
    }
}

struct Spread {
    median: f64,
    low: f64,
    high: f64,
}

impl std::fmt::Display for Spread {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:5.1} ({:.1} to {:.1})", self.median, self.low, self.high)
    }
}

/// What `more` takes beyond `less`, in ns for each of `per`.
fn slopes(mut less: impl FnMut(), mut more: impl FnMut(), per: f64) -> Spread {
    let mut found: Vec<f64> = Vec::new();
    for round in 0..=ROUNDS {
        let (a, b) = if round % 2 == 0 {
            let a = cpu(&mut less);
            (a, cpu(&mut more))
        } else {
            let b = cpu(&mut more);
            (cpu(&mut less), b)
        };
        // The first round warms up.
        if round > 0 {
            found.push(1e9 * (b - a) / per);
        }
    }
    of(found)
}

fn spread(mut work: impl FnMut(), per: f64) -> Spread {
    work();
    of((0..ROUNDS).map(|_| 1e9 * cpu(&mut work) / per).collect())
}

fn of(mut found: Vec<f64>) -> Spread {
    found.sort_by(f64::total_cmp);
    let at = |part: f64| found[(part * (found.len() - 1) as f64).round() as usize];
    Spread { median: at(0.5), low: at(0.1), high: at(0.9) }
}

fn cpu_median(rounds: usize, mut work: impl FnMut()) -> f64 {
    work();
    median((0..rounds).map(|_| cpu(&mut work)).collect())
}

/// Seconds this thread computes for one call.
fn cpu(work: &mut impl FnMut()) -> f64 {
    let before = on_cpu();
    work();
    on_cpu() - before
}

/// Seconds this thread has computed so far.
fn on_cpu() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}
