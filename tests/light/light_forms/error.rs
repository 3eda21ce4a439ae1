//! How far `f32` is from `f64` in the functions of the six-light shaders, in seed form and in
//! robust form, on the same random ordinary inputs: by the evaluator and by a Vulkan driver.
//!
//! `cargo test --test light light_forms::error -- --nocapture` prints the table.

use std::sync::Arc;
use std::time::Duration;

use fastrand::Rng;
use landfall_exec::backend::wgpu::{AdapterChoice, Gpu};
use landfall_exec::backend::{Backend as _, Grid, Job, Resource, ResourceKind, StageCode};
use landfall_interp::{Call, Precision, Program, Settings, Words};
use landfall_ir::Module;
use landfall_layout::{Options, Source, Stage};

use crate::support::sample::everything;

/// Samples of a run, a multiple of the lanes of a workgroup.
fn sample_count() -> usize {
    if everything() { 100_032 } else { 10_048 }
}

/// Floats of one sample: the light's place, direction, colours, coefficients and cosines; the
/// normal, the fragment, the eye; a direction to the light, a power, a distance.
const INPUTS: usize = 34;
/// Attenuation, cone, highlight, and three colours.
const OUTPUTS: usize = 12;

/// By function: its first output, how many, and where its scalars are among the inputs.
struct Function {
    name: &'static str,
    at: usize,
    len: usize,
    arguments: &'static [&'static [usize]],
    /// Whether `Texels` come last.
    textured: bool,
}

const FUNCTIONS: [Function; 6] = [
    Function {
        name: "attenuation",
        at: 0,
        len: 1,
        arguments: &[&[15], &[16], &[17], &[33]],
        textured: false,
    },
    Function {
        name: "cone",
        at: 1,
        len: 1,
        arguments: &[&[29, 30, 31], &[3, 4, 5], &[18], &[19]],
        textured: false,
    },
    Function {
        name: "highlight",
        at: 2,
        len: 1,
        arguments: &[&[29, 30, 31], &[20, 21, 22], &[26, 27, 28], &[32]],
        textured: false,
    },
    Function {
        name: "calcDirLight",
        at: 3,
        len: 3,
        arguments: &[&[3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14], &[20, 21, 22], &[26, 27, 28]],
        textured: true,
    },
    Function {
        name: "calcPointLight",
        at: 6,
        len: 3,
        arguments: &[
            &[0, 1, 2, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17],
            &[20, 21, 22],
            &[23, 24, 25],
            &[26, 27, 28],
        ],
        textured: true,
    },
    Function {
        name: "calcSpotLight",
        at: 9,
        len: 3,
        arguments: &[
            &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 18, 19, 15, 16, 17],
            &[20, 21, 22],
            &[23, 24, 25],
            &[26, 27, 28],
        ],
        textured: true,
    },
];

const ENTRY: &str = "
@group(3) @binding(0) var<storage, read> given: array<f32>;
@group(3) @binding(1) var<storage, read_write> got: array<f32>;

fn given3(at: u32) -> vec3f {
    return vec3f(given[at], given[at + 1u], given[at + 2u]);
}

fn put3(at: u32, v: vec3f) {
    got[at] = v.x;
    got[at + 1u] = v.y;
    got[at + 2u] = v.z;
}

@compute @workgroup_size(64)
fn measure(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x * 34u;
    let o = id.x * 12u;
    let texels = Texels(vec3f(1.0), vec3f(1.0), vec3f(1.0));
    let normal = given3(i + 20u);
    let fragPos = given3(i + 23u);
    let viewDir = given3(i + 26u);
    let toLight = given3(i + 29u);
    got[o] = attenuation(given[i + 15u], given[i + 16u], given[i + 17u], given[i + 33u]);
    got[o + 1u] = cone(toLight, given3(i + 3u), given[i + 18u], given[i + 19u]);
    got[o + 2u] = highlight(toLight, normal, viewDir, given[i + 32u]);
    let sun = DirLight(given3(i + 3u), given3(i + 6u), given3(i + 9u), given3(i + 12u));
    put3(o + 3u, calcDirLight(sun, normal, viewDir, texels));
    let lamp = PointLight(given3(i), given3(i + 6u), given3(i + 9u), given3(i + 12u),
        given[i + 15u], given[i + 16u], given[i + 17u]);
    put3(o + 6u, calcPointLight(lamp, normal, fragPos, viewDir, texels));
    let torch = SpotLight(given3(i), given3(i + 3u), given3(i + 6u), given3(i + 9u), given3(i + 12u),
        given[i + 18u], given[i + 19u], given[i + 15u], given[i + 16u], given[i + 17u]);
    put3(o + 9u, calcSpotLight(torch, normal, fragPos, viewDir, texels));
}
";

type V = [f64; 3];

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(v: V) -> V {
    v.map(|x| x / dot(v, v).sqrt())
}

fn about(rng: &mut Rng, v: V, spread: f64) -> V {
    let mut gauss = || (0..6).map(|_| rng.f64() - 0.5).sum::<f64>();
    unit(v.map(|x| x + spread * gauss()))
}

/// The rows of the table of attenuations, nearest to farthest.
const ROWS: [[f32; 3]; 12] = [
    [1.0, 0.7, 1.8],
    [1.0, 0.35, 0.44],
    [1.0, 0.22, 0.20],
    [1.0, 0.14, 0.07],
    [1.0, 0.09, 0.032],
    [1.0, 0.07, 0.017],
    [1.0, 0.045, 0.0075],
    [1.0, 0.027, 0.0028],
    [1.0, 0.022, 0.0019],
    [1.0, 0.014, 0.0007],
    [1.0, 0.007, 0.0002],
    [1.0, 0.0014, 0.000007],
];

/// One sample: a light in front of the surface, every other time near the mirrored eye and in the
/// ramp of its cone.
fn sample(rng: &mut Rng, power: f32) -> [f32; INPUTS] {
    let normal = about(rng, [0.0; 3], 1.0);
    let eye = loop {
        let eye = about(rng, [0.0; 3], 1.0);
        if dot(eye, normal) > 0.05 {
            break eye;
        }
    };
    let mirrored: V = std::array::from_fn(|i| 2.0 * dot(normal, eye) * normal[i] - eye[i]);
    let spread = 2.0 / f64::from(power).sqrt();
    let to_light = loop {
        let near = rng.bool();
        let to = if near { about(rng, mirrored, spread) } else { about(rng, [0.0; 3], 1.0) };
        if dot(to, normal) > 0.01 {
            break to;
        }
    };
    let inner = 2.0 * 10f64.powf(rng.f64());
    let outer = inner * (1.1 + rng.f64());
    let off = (outer * 1.2 * rng.f64()).to_radians();
    // The lamp points past the fragment by that angle.
    let across = {
        let any = about(rng, [0.0; 3], 1.0);
        unit(std::array::from_fn(|i| any[i] - dot(any, to_light) * to_light[i]))
    };
    let axis: V = std::array::from_fn(|i| -(off.cos() * to_light[i] + off.sin() * across[i]));
    let distance = 10f64.powf(-1.0 + 3.0 * rng.f64());
    let fragment: V = [0.0; 3].map(|_: f64| 20.0 * rng.f64() - 10.0);
    let row = ROWS[rng.usize(..ROWS.len())];
    let mut all = [0f32; INPUTS];
    let mut put = |at: usize, v: V| (0..3).for_each(|i| all[at + i] = v[i] as f32);
    put(0, std::array::from_fn(|i| fragment[i] + distance * to_light[i]));
    put(3, axis);
    put(6, [0.05; 3]);
    put(9, [0.8; 3]);
    put(12, [1.0; 3]);
    put(15, row.map(f64::from));
    put(20, normal);
    put(23, fragment);
    put(26, eye);
    put(29, to_light);
    all[18] = inner.to_radians().cos() as f32;
    all[19] = outer.to_radians().cos() as f32;
    all[32] = power;
    all[33] = distance as f32;
    all
}

fn samples(seed: u64, power: f32) -> Vec<[f32; INPUTS]> {
    let mut rng = Rng::with_seed(seed);
    (0..sample_count()).map(|_| sample(&mut rng, power)).collect()
}

struct Form {
    name: &'static str,
    module: Arc<Module>,
}

fn form(name: &'static str, path: &str, squarings: i32) -> Form {
    let source = Source::read(path).expect("the shader is there");
    let known = format!("override SQUARINGS: i32 = {squarings};");
    let text = source.text.replace("override SQUARINGS: i32 = -1;", &known);
    let text = format!("{text}{ENTRY}");
    let source = Source::new(path, text.as_str());
    let module = Module::new(&source, &Options::default()).unwrap_or_else(|f| panic!("{f:?}"));
    Form { name, module: Arc::new(module) }
}

fn material(module: &Module, power: f32) -> Resource {
    let block = module.blocks().iter().find(|b| &*b.layout.name == "MaterialBlock");
    let block = block.expect("there is a material");
    let mut bytes = power.to_le_bytes().to_vec();
    bytes.resize(16, 0);
    let kind = ResourceKind::Uniform(bytes);
    Resource { name: "MaterialBlock".to_string(), group: block.group, binding: block.binding, kind }
}

/// A function's results by the evaluator, by scalar and sample.
fn evaluated(
    form: &Form,
    function: &Function,
    given: &[[f32; INPUTS]],
    power: f32,
    precision: Precision,
) -> Vec<Vec<f64>> {
    let column = |at: &usize| given.iter().map(|s| u64::from(s[*at].to_bits())).collect();
    let mut arguments: Vec<Words> =
        function.arguments.iter().map(|places| places.iter().map(column).collect()).collect();
    if function.textured {
        arguments.push(vec![vec![u64::from(1f32.to_bits()); given.len()]; 9]);
    }
    let resources = [material(&form.module, power)];
    let call =
        Call { function: function.name, lanes: given.len(), arguments, resources: &resources };
    let settings = Settings { precision, ..Settings::default() };
    let called = Program::new(&form.module, &[]).call(&call, &settings);
    called.unwrap_or_else(|f| panic!("{}: {f:?}", function.name)).result.doubles
}

/// All functions' results by the driver: `OUTPUTS` a sample.
fn driven(gpu: &mut Gpu, form: &Form, given: &[[f32; INPUTS]], power: f32) -> Vec<f32> {
    let bytes = given.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let own = |name: &str, binding: u32, bytes: Vec<u8>, writable: bool| Resource {
        name: name.to_string(),
        group: 3,
        binding,
        kind: ResourceKind::Storage { bytes, writable },
    };
    let job = Job {
        stages: vec![StageCode::of_module(Stage::Compute, "measure", form.module.clone())],
        resources: vec![
            material(&form.module, power),
            own("given", 0, bytes, false),
            own("got", 1, vec![0; given.len() * OUTPUTS * 4], true),
        ],
        grid: Grid::Groups([(given.len() / 64) as u32, 1, 1]),
        limit: Duration::from_secs(120),
    };
    let answer = gpu.run(&job).unwrap_or_else(|failure| panic!("{failure}"));
    let bytes = answer.buffers[2].as_ref().expect("the results come back");
    let four = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    bytes.chunks_exact(4).map(four).collect()
}

/// The largest error and that of 99.9 %, in steps of 1/255, and the largest in units of the last
/// place of numbers above 2^-10.
#[derive(Clone, Copy, Debug)]
struct Error {
    most: f64,
    nearly: f64,
    ulps: f64,
}

fn error(pairs: impl Iterator<Item = (f64, f64)>) -> Error {
    let mut steps = Vec::new();
    let mut ulps = 0f64;
    for (got, truth) in pairs {
        assert!(got.is_finite() && truth.is_finite(), "{got}, {truth}");
        let off = (got - truth).abs();
        steps.push(255.0 * off);
        let floor = truth.abs().max(2f64.powi(-10));
        ulps = ulps.max(off / 2f64.powi(floor.log2().floor() as i32 - 23));
    }
    steps.sort_by(f64::total_cmp);
    let nearly = steps[steps.len() * 999 / 1000];
    Error { most: steps[steps.len() - 1], nearly, ulps }
}

#[test]
fn the_robust_form_is_no_less_accurate() {
    let mut gpu =
        Gpu::open(&AdapterChoice::default()).unwrap_or_else(|failure| panic!("{failure}"));
    println!("steps of 1/255: most, 99.9 %; last places of numbers above 2^-10: most");
    for squarings in [5, 8, 10] {
        let forms = [
            form("seed", "shaders/seed/six_lights.wgsl", -1),
            form("robust", "shaders/six_lights/phong.wgsl", -1),
            form("squared", "shaders/six_lights/phong.wgsl", squarings),
        ];
        let power = f32::from(1u16 << squarings);
        let given = samples(6, power);
        let driven = forms.each_ref().map(|form| driven(&mut gpu, form, &given, power));
        for function in &FUNCTIONS {
            let mut rows = Vec::new();
            for (form, driven) in forms.iter().zip(&driven) {
                let run = |precision| evaluated(form, function, &given, power, precision);
                let (single, double) = (run(Precision::Single), run(Precision::Double));
                let cpu =
                    error(single.iter().flatten().copied().zip(double.iter().flatten().copied()));
                let gpu = error(double.iter().enumerate().flat_map(|(scalar, column)| {
                    let at = function.at + scalar;
                    assert!(scalar < function.len);
                    let got = move |i: usize| f64::from(driven[i * OUTPUTS + at]);
                    column.iter().enumerate().map(move |(i, truth)| (got(i), *truth))
                }));
                for (backend, e) in [("evaluator", cpu), ("driver", gpu)] {
                    println!(
                        "n {power:<5} {:15} {:7} {backend:10} {:.2e} {:.2e} {:8.1}",
                        function.name, form.name, e.most, e.nearly, e.ulps
                    );
                }
                rows.push([cpu, gpu]);
            }
            for (backend, at) in [("evaluator", 0), ("driver", 1)] {
                for robust in [rows[1][at], rows[2][at]] {
                    let seed = rows[0][at];
                    assert!(
                        robust.most <= seed.most && robust.nearly <= seed.nearly,
                        "{}, n {power}, {backend}: {robust:?} for {seed:?}",
                        function.name
                    );
                }
            }
        }
    }
}
