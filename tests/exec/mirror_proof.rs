//! A generated mirror, filled in Rust and uploaded, is what the shader reads: every member holds
//! the number its field was given, by every backend. A mirror that is older than the shader is
//! caught, and the members that moved are named.

use crate::support::rustc;

use std::fs;
use std::time::Duration;

use landfall_codegen::rust::{RustOptions, Vectors, rust};
use landfall_exec::backend::gl::Gl;
use landfall_exec::backend::wgpu::{AdapterChoice, Gpu};
use landfall_exec::backend::{Backend, Grid, Job, Resource, ResourceKind, StageCode};
use landfall_interp::Cpu;
use landfall_ir::Module;
use landfall_layout::{Options, Source, Stage, layout};
use rustc::{Math, crates, run, scratch};

/// The block as it was when the mirror was generated.
const BLOCK: &str = "struct Light { vec3 pos; float radius; mat3 turn; };
layout(std140, binding = 0) uniform Scene {
    float time;
    Light lights[3];
    vec2 wind;
    int count;
    float weights[2];
    mat2x3 frame;
    bool on;
} u;
";

/// What the shader reads, in words: each line a member, and the value that is put there below.
const READS: &[(&str, &str)] = &[
    ("time", "floatBitsToUint(u.time)"),
    ("lights[0].pos.y", "floatBitsToUint(u.lights[0].pos.y)"),
    ("lights[2].radius", "floatBitsToUint(u.lights[2].radius)"),
    ("lights[1].turn[2].x", "floatBitsToUint(u.lights[1].turn[2].x)"),
    ("wind.y", "floatBitsToUint(u.wind.y)"),
    ("count", "uint(u.count)"),
    ("weights[1]", "floatBitsToUint(u.weights[1])"),
    ("frame[1].z", "floatBitsToUint(u.frame[1].z)"),
    ("on", "u.on ? 1u : 0u"),
];

/// The numbers the program below writes, by hand, in the order of [`READS`].
fn written() -> Vec<u32> {
    let floats = |x: f32| x.to_bits();
    vec![
        floats(1.5),
        floats(2.5),
        floats(3.5),
        floats(4.5),
        floats(5.5),
        7,
        floats(6.5),
        floats(8.5),
        1,
    ]
}

/// A program that fills the mirror by its fields and writes its bytes.
const PROGRAM: &str = "mod mirrors { include!(\"mirrors.rs\"); }
use mirrors::{Light, Scene};
use std::io::Write;

fn main() {
    let mut scene: Scene = bytemuck::Zeroable::zeroed();
    let mut light: Light = bytemuck::Zeroable::zeroed();
    scene.time = 1.5;
    light.pos[1] = 2.5;
    scene.lights[0] = light;
    light = bytemuck::Zeroable::zeroed();
    light.turn = [[0.0; 3], [0.0; 3], [4.5, 0.0, 0.0]].into();
    scene.lights[1] = light;
    light = bytemuck::Zeroable::zeroed();
    light.radius = 3.5;
    scene.lights[2] = light;
    scene.wind[1] = 5.5;
    scene.count = 7;
    scene.weights[1] = 6.5_f32.into();
    scene.frame = [[0.0; 3], [0.0, 0.0, 8.5]].into();
    scene.on = true.into();
    std::io::stdout().write_all(bytemuck::bytes_of(&scene)).unwrap();
}
";

/// The bytes of the mirror of a block, filled in Rust.
fn uploaded(name: &str, block: &str) -> Vec<u8> {
    let text = format!("#version 450\n{block}void main() {{}}\n");
    let shader = layout(&Source::new("scene.frag", text.as_str()), &Options::default());
    let mut options = RustOptions::default();
    options.vectors = Vectors::Array;
    let mirrors = rust(&[&shader], &options);
    assert!(mirrors.diagnostics.is_empty(), "{:?}", mirrors.diagnostics);
    let folder = scratch(name);
    fs::write(folder.join("mirrors.rs"), &mirrors.text).unwrap();
    fs::write(folder.join("main.rs"), format!("#![allow(dead_code)]\n{PROGRAM}")).unwrap();
    run(crates(Math::Scalar), &folder.join("main.rs"), "2021")
}

/// All three; one that is missing fails the test.
fn every_reader() -> [Box<dyn Backend>; 3] {
    let gl = Gl::open().expect("an OpenGL driver: apt-get install libegl1 libgl1-mesa-dri");
    let gpu = Gpu::open(&AdapterChoice::default())
        .expect("a Vulkan driver: apt-get install libvulkan1 mesa-vulkan-drivers");
    [Box::new(Cpu::default()), Box::new(gl), Box::new(gpu)]
}

/// The members of which each backend sees another number than was written.
fn wrong(block: &str, bytes: &[u8]) -> Vec<(&'static str, Vec<&'static str>)> {
    let mut text = format!("#version 450\nlayout(local_size_x = 1) in;\n{block}");
    text.push_str("layout(std430, binding = 1) buffer Seen { uint seen[]; };\nvoid main() {\n");
    for (at, (_, read)) in READS.iter().enumerate() {
        text.push_str(&format!("    seen[{at}] = {read};\n"));
    }
    text.push_str("}\n");
    let source = Source::new("scene.comp", text.as_str());
    let module = Module::new(&source, &Options::default()).unwrap_or_else(|e| panic!("{e:?}"));
    let size = module.blocks()[0].layout.size.expect("it has a size") as usize;
    let mut bytes = bytes.to_vec();
    // A shader that has grown reads zeros past the end of an old upload.
    bytes.resize(bytes.len().max(size), 0);
    let seen = vec![0; READS.len() * 4];
    let bound = |name: &str, binding: u32, kind: ResourceKind| Resource {
        name: name.to_string(),
        group: 0,
        binding,
        kind,
    };
    let job = Job {
        stages: vec![StageCode {
            text: Some(text.clone()),
            ..StageCode::of_module(Stage::Compute, "main", module)
        }],
        resources: vec![
            bound("Scene", 0, ResourceKind::Uniform(bytes)),
            bound("Seen", 1, ResourceKind::Storage { bytes: seen, writable: true }),
        ],
        grid: Grid::Groups([1, 1, 1]),
        limit: Duration::from_secs(30),
    };
    let mut found = Vec::new();
    for mut backend in every_reader() {
        let answer = backend.run(&job).unwrap_or_else(|failure| panic!("{failure}"));
        let seen = answer.buffers[1].as_ref().expect("it is writable");
        let words = seen.chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().unwrap()));
        let members = words.zip(written()).zip(READS);
        let wrong = members.filter(|((seen, written), _)| seen != written);
        found.push((backend.device().backend.name(), wrong.map(|(_, (name, _))| *name).collect()));
    }
    found
}

#[test]
fn every_field_is_what_the_shader_reads_at_its_member() {
    let bytes = uploaded("proof", BLOCK);
    for (backend, wrong) in wrong(BLOCK, &bytes) {
        assert_eq!(wrong, [""; 0], "{backend}");
    }
}

#[test]
fn a_mirror_older_than_its_shader_is_caught_and_the_members_that_moved_are_named() {
    let bytes = uploaded("stale", BLOCK);
    // A vec4 before `wind` moves it and all that follows by 16; nothing before it moves.
    let changed = BLOCK.replace("    vec2 wind;", "    vec4 fog;\n    vec2 wind;");
    for (backend, wrong) in wrong(&changed, &bytes) {
        assert_eq!(wrong, ["wind.y", "count", "weights[1]", "frame[1].z", "on"], "{backend}");
    }
    // A float after a vec3 fills its gap: nothing moves, and nobody complains.
    let harmless = BLOCK.replace("bool on;", "bool on;\n    float more;");
    for (backend, wrong) in self::wrong(&harmless, &bytes) {
        assert_eq!(wrong, [""; 0], "{backend}");
    }
}
