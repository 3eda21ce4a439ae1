//! Images and points: the pixel that each invocation writes.

use std::sync::Arc;
use std::time::Duration;

use super::memory::resource;
use super::support::{module, program, single};
use landfall_interp::backend::{
    Backend, Grid, Job, JobOutput, Resource, ResourceKind, StageCode, Texel,
};
use landfall_interp::internals::are_same;
use landfall_interp::{Cpu, Invocations, Port, Settings};
use landfall_ir::Module;
use landfall_layout::source::Stage;
use landfall_layout::{Options, Source};

fn run(stages: Vec<StageCode>, grid: Grid, resources: Vec<Resource>) -> JobOutput {
    let job = Job { stages, resources, grid, limit: Duration::from_secs(60) };
    let one = Cpu::new(single()).run(&job).unwrap_or_else(|failure| panic!("{failure:?}"));
    let two = Cpu::new(Settings { threads: 2, ..single() }).run(&job);
    assert_eq!(two.as_ref(), Ok(&one), "two threads");
    one
}

fn floats(pixel: [u32; 4]) -> [f32; 4] {
    pixel.map(f32::from_bits)
}

#[test]
fn a_fragment_is_at_the_middle_of_its_pixel() {
    let m = Arc::new(module(
        "@fragment fn main(@builtin(position) p: vec4<f32>) -> @location(0) vec4<f32> {
            if p.x > 20.0 && p.y < 3.0 { discard; }
            return vec4<f32>(p.xy, dpdx(p.x * p.x), dpdy(p.y * 3.0));
        }",
    ));
    let grid = Grid::Image { width: 21, height: 13, texel: Texel::Float };
    let answer =
        run(vec![StageCode::of_module(Stage::Fragment, "main", m.clone())], grid, Vec::new());
    assert_eq!(answer.pixels.len(), 21 * 13);
    for (i, pixel) in answer.pixels.iter().enumerate() {
        let (x, y) = (i % 21, i / 21);
        let left = (x - x % 2) as f32 + 0.5;
        let slope = (left + 1.0) * (left + 1.0) - left * left;
        let expected = match (x, y) {
            (20, 0..3) => [0.0; 4],
            _ => [x as f32 + 0.5, y as f32 + 0.5, slope, 3.0],
        };
        assert_eq!(floats(*pixel), expected, "{x}, {y}");
    }
}

#[test]
fn an_interpreter_need_not_compile_what_another_has_compiled() {
    let text = "@fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(3.0); }";
    let m = Arc::new(module(text));
    let stages = vec![StageCode::of_module(Stage::Fragment, "main", m.clone())];
    let grid = Grid::Image { width: 1, height: 1, texel: Texel::Float };
    let job = Job { stages, resources: Vec::new(), grid, limit: Duration::from_secs(60) };
    let mut first = Cpu::new(single());
    let pixels = first.run(&job).map(|output| output.pixels);
    let mut second = Cpu::with_programs(Settings { threads: 2, ..single() }, &first.programs());
    assert_eq!(second.run(&job).map(|output| output.pixels), pixels);
    assert_eq!(pixels, Ok(vec![[3f32.to_bits(); 4]]));
    // The other one's, not a copy.
    assert!(are_same(&first.programs(), &second.programs()));
}

#[test]
fn of_several_failures_the_first_is_reported_on_any_number_of_threads() {
    let m = Arc::new(module(
        "fn a(x: f32) -> f32 { var sum = x; loop { sum += 1.0; } return sum; }
        fn b(x: f32) -> f32 { var sum = x; loop { sum += 2.0; } return sum; }
        @fragment fn main(@builtin(position) p: vec4<f32>) -> @location(0) vec4<f32> {
            if p.y > 30.0 && p.y < 32.0 { return vec4<f32>(a(p.x)); }
            if p.y > 90.0 { return vec4<f32>(b(p.x)); }
            return p;
        }",
    ));
    let grid = Grid::Image { width: 64, height: 128, texel: Texel::Float };
    let stages = vec![StageCode::of_module(Stage::Fragment, "main", m.clone())];
    let job = Job { stages, resources: Vec::new(), grid, limit: Duration::from_secs(60) };
    for threads in 1..6 {
        let settings = Settings { threads, budget: 1000, ..single() };
        let failure = Cpu::new(settings).run(&job).unwrap_err();
        assert!(failure.message.contains("in `a`"), "{threads}: {}", failure.message);
    }
}

#[test]
fn what_runs_concurrently_runs_once_also_where_the_job_is_refused() {
    let m = Arc::new(module(
        "@group(0) @binding(0) var<uniform> u: vec4<f32>;
        @fragment fn main() -> @location(0) vec4<f32> { return u; }",
    ));
    let grid = Grid::Image { width: 500, height: 3, texel: Texel::Float };
    let bound = resource(0, ResourceKind::Uniform(vec![0; 16]));
    for (resources, works) in [(vec![bound], true), (Vec::new(), false)] {
        let stages = vec![StageCode::of_module(Stage::Fragment, "main", m.clone())];
        let job = Job { stages, resources, grid, limit: Duration::from_secs(60) };
        for threads in [1, 2, 3] {
            let mut cpu = Cpu::new(Settings { threads, ..single() });
            let mut count = 0;
            let answer = cpu.run_concurrently(&job, &mut || count += 1);
            assert_eq!((count, answer.is_ok()), (1, works), "{threads} threads");
            assert!(answer.is_err() || answer == cpu.run(&job));
        }
    }
}

#[test]
fn a_triangle_interpolates_in_perspective_and_carries_flat_values() {
    let m = Arc::new(module(
        "struct V { @builtin(position) p: vec4<f32>, @location(0) uv: vec2<f32>, @location(1) @interpolate(flat) n: u32 }
        @vertex fn vs(@builtin(vertex_index) i: u32) -> V {
            let x = f32(i / 2u) * 4.0 - 1.0;
            let y = f32(i % 2u) * 4.0 - 1.0;
            // The same place on the screen, twice as far at the second vertex.
            let w = select(1.0, 2.0, i == 1u);
            return V(vec4<f32>(x * w, y * w, 0.25 * w, w), vec2<f32>(f32(i == 1u), f32(i == 2u)), 7u + i);
        }
        @fragment fn fs(v: V) -> @location(0) vec4<f32> { return vec4<f32>(v.uv, f32(v.n), v.p.z); }",
    ));
    let stages = vec![
        StageCode::of_module(Stage::Vertex, "vs", m.clone()),
        StageCode::of_module(Stage::Fragment, "fs", m.clone()),
    ];
    let grid = Grid::Image { width: 8, height: 4, texel: Texel::Float };
    let answer = run(stages, grid, Vec::new());
    for (i, pixel) in answer.pixels.iter().enumerate() {
        // Shares of the corners on the screen; row 0 is the top, y = 1.
        let (x, y) = ((i % 8) as f64 / 8.0 + 1.0 / 16.0, 1.0 - ((i / 8) as f64 / 4.0 + 0.125));
        let screen = [1.0 - x / 2.0 - y / 2.0, y / 2.0, x / 2.0];
        let far = [screen[0], screen[1] / 2.0, screen[2]];
        let sum: f64 = far.iter().sum();
        let [u, v, n, z] = floats(*pixel).map(f64::from);
        assert!((u - far[1] / sum).abs() < 1e-6, "{i}: {u}");
        assert!((v - far[2] / sum).abs() < 1e-6, "{i}: {v}");
        assert_eq!((n, z), (7.0, 0.25));
    }
}

/// The values of the last vertex, as OpenGL has them; `tests/exec` asks its driver.
#[test]
fn a_triangle_of_glsl_carries_the_flat_values_of_its_last_vertex() {
    let stage = |stage: Stage, path: &str, text: &str| {
        let module = Module::new(&Source::new(path, text), &Options::default());
        let module = module.unwrap_or_else(|found| panic!("{found:?}"));
        StageCode::of_module(stage, "main", Arc::new(module))
    };
    let vertex = "#version 410
layout(location = 0) flat out vec2 a; layout(location = 1) flat out ivec2 b;
void main() {
  a = vec2(gl_VertexID, 7); b = ivec2(gl_VertexID, 8);
  gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0);
}";
    let fragment = "#version 410
layout(location = 0) flat in vec2 a; layout(location = 1) flat in ivec2 b;
layout(location = 0) out vec4 color;
void main() { color = vec4(a, b); }";
    let stages =
        vec![stage(Stage::Vertex, "a.vert", vertex), stage(Stage::Fragment, "a.frag", fragment)];
    let grid = Grid::Image { width: 2, height: 2, texel: Texel::Float };
    for pixel in run(stages, grid, Vec::new()).pixels {
        assert_eq!(floats(pixel), [2.0, 7.0, 2.0, 8.0]);
    }
}

#[test]
fn a_point_carries_its_vertex_to_its_pixel() {
    let m = Arc::new(module(
        "struct V { @builtin(position) p: vec4<f32>, @location(0) @interpolate(flat) n: vec4<u32> }
        @vertex fn vs(@builtin(vertex_index) i: u32) -> V {
            return V(vec4<f32>(0.0, 0.0, 0.0, 1.0), vec4<u32>(i, i * i, 3u, ~i));
        }
        @fragment fn fs(v: V) -> @location(0) vec4<u32> { return v.n; }",
    ));
    let stages = vec![
        StageCode::of_module(Stage::Vertex, "vs", m.clone()),
        StageCode::of_module(Stage::Fragment, "fs", m.clone()),
    ];
    let answer = run(stages, Grid::Points { count: 70, texel: Texel::Uint }, Vec::new());
    let expected: Vec<[u32; 4]> = (0..70).map(|i| [i, i * i, 3, !i]).collect();
    assert_eq!(answer.pixels, expected);
}

#[test]
fn a_texture_repeats_and_is_read_at_the_nearest_texel() {
    let m = Arc::new(module(
        "@group(0) @binding(0) var t: texture_2d<f32>;
        @group(0) @binding(1) var s: sampler;
        fn look(t: texture_2d<f32>, uv: vec2<f32>) -> f32 { return textureSample(t, s, uv).x; }
        @fragment fn main(@builtin(position) p: vec4<f32>) -> @location(0) vec4<f32> {
            let size = vec2<f32>(textureDimensions(t));
            let exact = textureLoad(t, vec2<i32>(p.xy) % vec2<i32>(size), 0);
            return vec4<f32>(look(t, p.xy / size - 2.0), exact.x, size);
        }",
    ));
    let texels: Vec<[f32; 4]> = (0..6u8).map(|i| [f32::from(i), 0.0, 0.0, 1.0]).collect();
    let resources = vec![
        resource(0, ResourceKind::Texture { width: 3, height: 2, texels }),
        resource(1, ResourceKind::Sampler),
    ];
    let grid = Grid::Image { width: 7, height: 5, texel: Texel::Float };
    let answer =
        run(vec![StageCode::of_module(Stage::Fragment, "main", m.clone())], grid, resources);
    for (i, pixel) in answer.pixels.iter().enumerate() {
        let texel = (i / 7 % 2 * 3 + i % 7 % 3) as f32;
        assert_eq!(floats(*pixel), [texel, texel, 3.0, 2.0], "{i}");
    }
}

#[test]
fn an_entry_point_takes_inputs_by_location() {
    let p = program(
        "@fragment fn main(@location(2) a: vec2<f32>, @location(5) @interpolate(flat) k: u32)
            -> @location(1) vec2<f32> {
            if k == 3u { discard; }
            return a * f32(k);
        }",
    );
    let number =
        |f: fn(u16) -> f32| -> Vec<u64> { (0..100).map(|i| u64::from(f(i).to_bits())).collect() };
    let inputs = vec![
        (Port::Location(2), vec![number(f32::from), number(|i| f32::from(i) + 0.5)]),
        (Port::Location(5), vec![(0..100).map(|i| i % 5).collect()]),
    ];
    let invocations = Invocations { count: 100, inputs };
    let outputs = p.run_entry("main", &invocations, &[], &single()).expect("it runs");
    let (port, numbers) = &outputs.ports[0];
    assert_eq!(*port, Port::Location(1));
    for i in 0..100 {
        assert_eq!(outputs.discarded[i], i % 5 == 3);
        if i % 5 != 3 {
            assert_eq!(numbers.doubles[1][i], (i as f64 + 0.5) * (i % 5) as f64);
        }
    }
}
