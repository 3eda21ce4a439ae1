//! The image that the benches of the evaluator and of the backends compute: a plane lit by a
//! sun, four lamps and a torch.

use std::sync::Arc;
use std::time::Duration;

use landfall_exec::backend::{Grid, Job, Resource, ResourceKind, StageCode, Texel};
use landfall_ir::Module;
use landfall_layout::buffer::Buffer;
use landfall_layout::source::{Source, Stage};
use landfall_layout::{Options, layout};

fn source() -> Source {
    Source::new("phong.wgsl", include_str!("phong.wgsl"))
}

pub fn module() -> Module {
    Module::new(&source(), &Options::default()).expect("the shader is in order")
}

/// A square image of so many pixels a side.
pub fn job(module: &Arc<Module>, size: u32) -> Job {
    Job {
        stages: vec![StageCode::of_module(Stage::Fragment, "main", Arc::clone(module))],
        resources: vec![Resource {
            name: "scene".into(),
            group: 0,
            binding: 0,
            kind: ResourceKind::Uniform(scene(&source())),
        }],
        grid: Grid::Image { width: size, height: size, texel: Texel::Float },
        limit: Duration::from_secs(600),
    }
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
