//! A Vulkan driver runs jobs through wgpu: known words come back through each kind of grid
//! and of resource, from modules and from SPIR-V, and what it does not take is refused in
//! words that help.
//!
//! Needs a driver (Debian packages `mesa-vulkan-drivers` and `libvulkan1`) and
//! `glslangValidator` (`glslang-tools`); a missing one fails.

use crate::support::jobs;

use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

use jobs::{bound, bytes, counting, job, module, output, storage, uniform, words};
use landfall_exec::backend::wgpu::{AdapterChoice, Gpu};
use landfall_exec::backend::{
    Backend as _, FailureKind, Grid, Job, ResourceKind, StageCode, Texel,
};
use landfall_ir::Module;
use landfall_layout::{Options, Source, Stage};

fn open() -> Gpu {
    Gpu::open(&AdapterChoice::default()).unwrap_or_else(|failure| panic!("{failure}"))
}

fn wgsl(text: &str) -> Arc<Module> {
    let source = Source::new("test.wgsl", text);
    let module = Module::by_naga(&source, &Options::default());
    Arc::new(module.unwrap_or_else(|found| panic!("{found:?}")))
}

const COPY: &str = "
struct Input { a: vec4u, b: f32, @align(16) c: array<vec4u, 2> }
@group(0) @binding(0) var<uniform> i: Input;
@group(0) @binding(1) var<storage, read_write> words: array<u32>;
@compute @workgroup_size(4) fn copy(@builtin(global_invocation_id) id: vec3u) {
  var got = array<u32, 8>(i.a.x, i.a.y, i.a.z, i.a.w, bitcast<u32>(i.b), i.c[0].x, i.c[1].x, 7u);
  words[id.x] += got[id.x];
}";

fn copy() -> Job {
    let resources = vec![uniform("Input", 0, &counting(16)), storage("Output", 1, &[5; 8])];
    let stages = vec![module(Stage::Compute, "copy", &wgsl(COPY))];
    job(stages, resources, Grid::Groups([2, 1, 1]))
}

/// By the rules of WGSL: a at 0, b at 16, c at 32 with stride 16.
const COPIED: [u32; 8] = [1005, 1006, 1007, 1008, 1009, 1013, 1017, 12];

#[test]
fn words_of_a_uniform_block_come_back_through_a_storage_block() {
    let answer = open().run(&copy()).unwrap();
    assert_eq!(answer.buffers[0], None, "a uniform block does not come back");
    assert_eq!(words(answer.buffers[1].as_ref().unwrap()), COPIED);
    assert!(answer.pixels.is_empty());
}

/// What glslang makes of a text for Vulkan.
fn spirv(name: &str, text: &str) -> Arc<[u32]> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let (from, to) = (folder.join(name), folder.join(format!("{name}.spv")));
    std::fs::write(&from, text).unwrap();
    let run = Command::new("glslangValidator").arg("-V").arg("-o").arg(&to).arg(&from).output();
    let run = run.expect("`glslangValidator` is installed (Debian package `glslang-tools`)");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stdout));
    words(&std::fs::read(&to).unwrap()).into()
}

fn passed(stage: Stage, words: &Arc<[u32]>) -> StageCode {
    let spirv = Some(Arc::clone(words));
    StageCode { stage, entry: "main".to_string(), module: None, text: None, spirv }
}

#[test]
fn spirv_reaches_the_driver_as_it_is() {
    let text = "#version 450
layout(local_size_x = 4) in;
layout(std140, binding = 0) uniform Input { uvec4 a; float b; uint c[2]; } i;
layout(std430, set = 2, binding = 1) buffer Output { uint words[]; };
void main() {
  uint at = gl_GlobalInvocationID.x;
  uint got[8] = uint[](i.a.x, i.a.y, i.a.z, i.a.w, floatBitsToUint(i.b), i.c[0], i.c[1], 7u);
  words[at] += got[at];
}";
    let mut job = copy();
    job.stages = vec![passed(Stage::Compute, &spirv("passed.comp", text))];
    job.resources[1].group = 2;
    let answer = open().run(&job).unwrap();
    assert_eq!(words(answer.buffers[1].as_ref().unwrap()), COPIED);
}

#[test]
fn a_fragment_shader_of_spirv_draws_too() {
    let text = "#version 450
layout(push_constant) uniform P { layout(offset = 4) uint base; } p;
layout(location = 0) out uvec4 color;
void main() { color = uvec4(gl_FragCoord.xy, p.base, 9u); }";
    let stages = vec![passed(Stage::Fragment, &spirv("passed.frag", text))];
    let push = bound("P", 0, ResourceKind::PushConstant(bytes(&[1, 77])));
    let grid = Grid::Image { width: 3, height: 2, texel: Texel::Uint };
    let answer = open().run(&job(stages, vec![push], grid)).unwrap();
    let expected: Vec<[u32; 4]> = (0..2).flat_map(|y| (0..3).map(move |x| [x, y, 77, 9])).collect();
    assert_eq!(answer.pixels, expected);
}

#[test]
fn an_image_of_unsigned_integers_has_its_first_row_first() {
    let text = "@group(1) @binding(3) var<uniform> base: vec4u;
@fragment fn main(@builtin(position) at: vec4f) -> @location(0) vec4u {
  return vec4u(vec2u(at.xy), base.x, 0xFFFFFFFFu);
}";
    let grid = Grid::Image { width: 3, height: 2, texel: Texel::Uint };
    let mut base = uniform("base", 3, &[77, 0, 0, 0]);
    base.group = 1;
    let stages = vec![module(Stage::Fragment, "main", &wgsl(text))];
    let answer = open().run(&job(stages, vec![base], grid)).unwrap();
    let expected: Vec<[u32; 4]> =
        (0..2).flat_map(|y| (0..3).map(move |x| [x, y, 77, u32::MAX])).collect();
    assert_eq!(answer.pixels, expected);
}

#[test]
fn an_image_of_floats_is_neither_clamped_nor_rounded() {
    let text = "@group(0) @binding(0) var tex: texture_2d<f32>;
@group(0) @binding(1) var near: sampler;
@fragment fn main() -> @location(0) vec4f {
  return vec4f(-2.5, 1e30, 0.1, 65537.0) + textureSample(tex, near, vec2f(1.6, 0.1));
}";
    let texels = vec![[9.0; 4], [0.0, 0.0, 0.0, 1.0]];
    let resources = vec![
        bound("tex", 0, ResourceKind::Texture { width: 2, height: 1, texels }),
        bound("near", 1, ResourceKind::Sampler),
    ];
    let grid = Grid::Image { width: 1, height: 1, texel: Texel::Float };
    let stages = vec![module(Stage::Fragment, "main", &wgsl(text))];
    let answer = open().run(&job(stages, resources, grid)).unwrap();
    assert_eq!(answer.pixels, [[-2.5f32, 1e30, 0.1, 65538.0].map(f32::to_bits)]);
}

const POINTS: &str = "struct B { base: u32, count: u32 }
@group(0) @binding(0) var<uniform> b: B;
struct Carried { @builtin(position) at: vec4f, @location(0) @interpolate(flat) words: vec2u }
@vertex fn place(@builtin(vertex_index) i: u32) -> Carried {
  let x = (2.0 * f32(i) + 1.0) / f32(b.count) - 1.0;
  return Carried(vec4f(x, 0.0, 0.0, 1.0), vec2u(b.base, i));
}
@fragment fn carry(c: Carried) -> @location(0) vec4u { return vec4u(c.words, 3u, 4u); }";

#[test]
fn point_i_lands_on_pixel_i() {
    let both = wgsl(POINTS);
    let stages =
        vec![module(Stage::Vertex, "place", &both), module(Stage::Fragment, "carry", &both)];
    let grid = Grid::Points { count: 101, texel: Texel::Uint };
    let resources = vec![uniform("B", 0, &[42, 101])];
    let answer = open().run(&job(stages, resources, grid)).unwrap();
    let expected: Vec<[u32; 4]> = (0..101).map(|i| [42, i, 3, 4]).collect();
    assert_eq!(answer.pixels, expected);
}

#[test]
fn push_constants_and_read_only_storage_are_read() {
    let text = "struct P { a: u32, b: vec2u }
var<immediate> p: P;
@group(0) @binding(0) var<storage> source: array<u32>;
@group(0) @binding(1) var<storage, read_write> to: array<u32>;
@compute @workgroup_size(1) fn main() {
  to[0] = p.a; to[1] = p.b.y; to[2] = source[2]; to[3] = arrayLength(&source);
}";
    let resources = vec![
        bound("P", 0, ResourceKind::PushConstant(bytes(&[1, 2, 3, 4]))),
        bound("source", 0, ResourceKind::Storage { bytes: bytes(&[7, 8, 9]), writable: false }),
        output("to", 1, 4),
    ];
    let stages = vec![module(Stage::Compute, "main", &wgsl(text))];
    let answer = open().run(&job(stages, resources, Grid::Groups([1, 1, 1]))).unwrap();
    assert_eq!(answer.buffers[..2], [None, None]);
    assert_eq!(words(answer.buffers[2].as_ref().unwrap()), [1, 4, 9, 3]);
}

#[test]
fn doubles_and_64_bit_integers_are_to_be_had() {
    let text = "@group(0) @binding(0) var<storage, read_write> to: array<u64, 2>;
@group(0) @binding(1) var<storage> d: f64;
@compute @workgroup_size(1) fn main() {
  to[0] = to[1] * 3lu; to[1] = u64(d * 2.0lf);
}";
    let stages = vec![module(Stage::Compute, "main", &wgsl(text))];
    let one_and_a_half = 1.5f64.to_bits();
    let halves = [one_and_a_half as u32, (one_and_a_half >> 32) as u32];
    let resources = vec![
        storage("to", 0, &[0, 0, 0, 1]),
        bound("d", 1, ResourceKind::Storage { bytes: bytes(&halves), writable: false }),
    ];
    let answer = open().run(&job(stages, resources, Grid::Groups([1, 1, 1]))).unwrap();
    assert_eq!(words(answer.buffers[0].as_ref().unwrap()), [0, 3, 3, 0]);
}

#[test]
fn one_reader_runs_hundreds_of_jobs() {
    let mut gpu = open();
    let mut copy = copy();
    for round in 0..200u32 {
        copy.resources[0] = uniform("Input", 0, &[round; 16]);
        let answer = gpu.run(&copy).unwrap();
        let [same, last] = [5 + round, 12];
        let expected = [same, same, same, same, same, same, same, last];
        assert_eq!(words(answer.buffers[1].as_ref().unwrap()), expected);
    }
}

fn refused(job: &Job) -> (String, String) {
    let mut gpu = open();
    let failure = gpu.run(job).unwrap_err();
    assert_eq!(failure.kind, FailureKind::Refused, "{failure}");
    let answer = gpu.run(&copy()).expect("the next job is not affected");
    assert_eq!(words(answer.buffers[1].as_ref().unwrap()), COPIED);
    (failure.message, failure.log)
}

#[test]
fn a_uniform_block_shorter_than_the_shader_wants_is_refused_with_both_numbers() {
    let mut job = copy();
    job.resources[0] = uniform("Input", 0, &[0; 12]);
    let (message, log) = refused(&job);
    assert!(message.contains("48") && message.contains("64"), "{message}\n{log}");
}

#[test]
fn an_entry_point_that_is_not_there_is_refused() {
    let mut job = copy();
    job.stages[0].entry = "gone".to_string();
    let (message, log) = refused(&job);
    assert!(message.contains("gone") || log.contains("gone"), "{message}\n{log}");
}

#[test]
fn a_writable_block_bound_read_only_is_refused() {
    let mut job = copy();
    job.resources[1].kind = ResourceKind::Storage { bytes: bytes(&[5; 8]), writable: false };
    let (message, log) = refused(&job);
    assert!(log.contains("read-only") || log.contains("LOAD"), "{message}\n{log}");
}

#[test]
fn what_is_over_a_limit_is_refused_with_both_numbers() {
    let found = Gpu::list().into_iter().find_map(|found| found.outcome.ok()).unwrap().1;
    let mut job = copy();
    let limit = found.uniform_block_size.unwrap();
    let size = usize::try_from(limit).unwrap() + 16;
    job.resources[0].kind = ResourceKind::Uniform(vec![0; size]);
    let expected =
        format!("the uniform block `Input` has {size} bytes, but this device supports {limit}");
    assert_eq!(refused(&job).0, expected);
    let limit = found.workgroups.unwrap();
    let groups = u32::try_from(limit + 1).unwrap();
    let expected = format!(
        "the dispatch has {groups} workgroups in one dimension, but this device supports {limit}"
    );
    assert_eq!(refused(&Job { grid: Grid::Groups([1, groups, 1]), ..copy() }).0, expected);
    let limit = found.push_constant_size.unwrap();
    let size = usize::try_from(limit).unwrap() + 4;
    let mut job = copy();
    job.resources.push(bound("P", 0, ResourceKind::PushConstant(vec![0; size])));
    let expected =
        format!("the push constant block `P` has {size} bytes, but this device supports {limit}");
    assert_eq!(refused(&job).0, expected);
}

#[test]
fn what_is_bound_twice_or_not_at_all_is_named() {
    let mut job = copy();
    job.resources.push(uniform("Other", 0, &[0; 16]));
    let expected = "group 0, binding 0 (`Input`, `Other`) is bound twice in one job";
    assert_eq!(refused(&job).0, expected);
    let mut job = copy();
    job.resources.remove(0);
    let (message, log) = refused(&job);
    let expected = "the shader reads `i` (group 0, binding 0), but nothing is bound to it";
    assert_eq!(message, expected, "{log}");
}

#[test]
fn what_is_no_spirv_does_not_get_to_the_driver() {
    let mut job = copy();
    job.stages = vec![passed(Stage::Compute, &Arc::from([1, 2, 3, 4, 5, 6]))];
    let expected = "wgpu rejects the compute shader: the SPIR-V has an invalid header";
    assert!(expected.ends_with(&refused(&job).0));
}

#[test]
fn an_adapter_that_is_not_there_is_missing_and_those_there_are_named() {
    let choice = AdapterChoice { adapter: Some("voodoo".to_string()) };
    let failure = Gpu::open(&choice).err().unwrap();
    assert_eq!(failure.kind, FailureKind::Missing);
    let start = "no GPU adapter matches `voodoo`; there are ";
    assert!(failure.message.starts_with(start) && failure.message.contains("vulkan"), "{failure}");
    let choice = AdapterChoice { adapter: Some("VULKAN".to_string()) };
    assert!(Gpu::open(&choice).is_ok());
}

#[test]
fn llvmpipe_takes_65535_turns_an_invocation_whatever_the_loops_say() {
    let text = "@group(0) @binding(0) var<storage, read_write> o: array<u32, 3>;
@compute @workgroup_size(1) fn main() {
  var x = o[2];
  var turns = vec2u();
  for (var i = 0u; i < 100000u; i++) { turns.x++; x = x * 5u + 1u; if x == 77u { break; } }
  for (var i = 0u; i < 50000u; i++) { turns.y++; x = x * 5u + 1u; if x == 77u { break; } }
  o[0] = turns.x; o[1] = turns.y; o[2] = x;
}";
    let stages = vec![module(Stage::Compute, "main", &wgsl(text))];
    let mut gpu = open();
    let job = job(stages, vec![output("o", 0, 3)], Grid::Groups([1, 1, 1]));
    let answer = gpu.run(&job).unwrap();
    let turns = &words(answer.buffers[0].as_ref().unwrap())[..2];
    // Mesa 22.3.6; the second loop is left at its first turn.
    let expected = match gpu.device().adapter.contains("llvmpipe") {
        true => [65535, 1],
        false => [100_000, 50_000],
    };
    assert_eq!(turns, expected);
}

#[test]
fn a_job_that_takes_too_long_times_out() {
    // 12800 invocations of 60000 iterations each: llvmpipe ends loops beyond 65535 iterations itself.
    let text = "@group(0) @binding(0) var<storage, read_write> to: array<f32>;
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
  var x = f32(id.x);
  for (var i = 0u; i < 60000u; i++) { x = sin(x) * 3.0 + cos(x); }
  to[id.x % 64u] = x;
}";
    let stages = vec![module(Stage::Compute, "main", &wgsl(text))];
    let limit = Duration::from_millis(300);
    let resources = vec![output("to", 0, 64)];
    let job = Job { limit, ..job(stages, resources, Grid::Groups([200, 1, 1])) };
    let mut gpu = open();
    let failure = gpu.run(&job).unwrap_err();
    assert_eq!(failure.kind, FailureKind::TimedOut, "{failure}");
    assert_eq!(failure.message, "timed out after 0.3 s");
    assert_eq!(gpu.run(&copy()).unwrap_err().kind, FailureKind::Died);
}

#[test]
fn a_device_with_timestamps_times_the_pass_where_asked() {
    let mut untimed = open();
    untimed.run(&copy()).unwrap();
    assert_eq!(untimed.device_time(), None);
    let mut timed = open().timed();
    assert_eq!(timed.device_time(), None, "no job has run");
    for _ in 0..3 {
        let begun = std::time::Instant::now();
        let answer = timed.run(&copy()).unwrap();
        let whole = begun.elapsed();
        assert_eq!(words(answer.buffers[1].as_ref().unwrap()), COPIED);
        // lavapipe has timestamps; the pass is a part of the job.
        let pass = timed.device_time().expect("a driver with timestamps");
        assert!(pass > Duration::ZERO && pass < whole, "{pass:?} of {whole:?}");
    }
}
