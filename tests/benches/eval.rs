//! How long the evaluator takes for a fragment lit by six lights, and for an operation:
//! `cargo bench --bench eval`.

use std::sync::Arc;
use std::time::Duration;

use landfall::buffer::Buffer;
use landfall::run::Module;
use landfall::run::eval::{Cpu, Precision, Settings};
use landfall::run::reader::{Answer, Grid, Job, Reader, Resource, ResourceKind, StageCode, Texel};
use landfall::source::{Source, Stage};
use landfall::{Options, layout};

mod measure;

const SIZE: u32 = 256;

fn main() {
    let source = Source::new("phong.wgsl", include_str!("phong.wgsl"));
    let module = Module::new(&source, &Options::default()).expect("the shader is in order");
    let job = Job {
        stages: vec![StageCode {
            stage: Stage::Fragment,
            entry: "main".into(),
            module: Some(Arc::new(module)),
            glsl: None,
            spirv: None,
        }],
        resources: vec![Resource {
            name: "scene".into(),
            group: 0,
            binding: 0,
            kind: ResourceKind::Uniform(scene(&source)),
        }],
        grid: Grid::Image { width: SIZE, height: SIZE, texel: Texel::Float },
        limit: Duration::from_secs(600),
    };
    let one = Settings { threads: 1, ..Settings::default() };
    report("f32, one thread", &job, one.clone());
    report("f32, all threads", &job, Settings::default());
    report("f64, one thread", &job, Settings { precision: Precision::Double, ..one.clone() });
    report("both, one thread", &job, Settings { precision: Precision::Both, ..one.clone() });
    report("f32 watched, one thread", &job, Settings { watch: true, ..one.clone() });
    report(
        "both watched, one thread",
        &job,
        Settings { watch: true, precision: Precision::Both, ..one },
    );
}

fn report(name: &str, job: &Job, settings: Settings) {
    let mut cpu = Cpu::new(settings);
    let run = |cpu: &mut Cpu| -> Answer { cpu.run(job).expect("the job runs") };
    let answer = run(&mut cpu);
    let times: Vec<f64> = (0..9).map(|_| measure::seconds(&mut || drop(run(&mut cpu)))).collect();
    let least = times.iter().copied().fold(f64::INFINITY, f64::min);
    let median = measure::median(times);
    let fragments = f64::from(SIZE * SIZE);
    let operations = cpu.notes.counts.operations() as f64;
    let sum: f64 = answer.pixels.iter().map(|p| f64::from(f32::from_bits(p[0]))).sum();
    println!(
        "{name:26} {:7.0} ns/fragment median, {:7.0} least; {:4.0} operations each, \
         {:5.0} million a second; mean red {:.6}",
        1e9 * median / fragments,
        1e9 * least / fragments,
        operations / fragments,
        1e-6 * operations / median,
        sum / fragments,
    );
}

/// A scene of the usual sort, placed by our own offsets.
fn scene(source: &Source) -> Vec<u8> {
    let shader = layout(source, &Options::default());
    let mut scene = Buffer::new(&shader.blocks[0]).expect("the block is laid out");
    let mut put = |path: &str, value: [f32; 3]| {
        scene.set(path, value).expect("the member is a vec3");
    };
    put("eye", [0.0, 0.0, 3.0]);
    put("sun.direction", [-0.2, -1.0, -0.3]);
    put("torch.position", [0.0, 0.0, 3.0]);
    put("torch.direction", [0.0, 0.0, -1.0]);
    let places = [[0.7, 0.2, 2.0], [2.3, -3.3, -4.0], [-4.0, 2.0, 12.0], [0.0, 0.0, 3.0]];
    let lamps: Vec<String> = (0..4).map(|i| format!("lamps[{i}]")).collect();
    for (lamp, place) in lamps.iter().zip(places) {
        put(&format!("{lamp}.position"), place);
    }
    let all = lamps.iter().map(String::as_str).chain(["sun", "torch"]);
    for light in all {
        put(&format!("{light}.ambient"), [0.05; 3]);
        put(&format!("{light}.diffuse"), [0.8; 3]);
        put(&format!("{light}.specular"), [1.0; 3]);
    }
    let mut put = |path: &str, value: f32| {
        scene.set(path, value).expect("the member is a float");
    };
    put("shininess", 32.0);
    put("torch.inner", 12.5f32.to_radians().cos());
    put("torch.outer", 15f32.to_radians().cos());
    for light in lamps.iter().map(String::as_str).chain(["torch"]) {
        put(&format!("{light}.constant"), 1.0);
        put(&format!("{light}.linear"), 0.09);
        put(&format!("{light}.quadratic"), 0.032);
    }
    scene.set("count", 4u32).expect("the member is a uint");
    scene.into_bytes()
}
