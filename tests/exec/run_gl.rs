//! An OpenGL driver runs jobs: known words come back through each kind of grid and of
//! resource, and what it does not take is refused in words that help.
//!
//! Needs a driver (Debian packages `libegl1` and `libgl1-mesa-dri`); a missing one fails.

use crate::support::files;
use crate::support::jobs;

use files::shaders;
use jobs::{bound, bytes, counting, glsl, job, output, storage, uniform, words};
use landfall_exec::backend::gl::{ContextKind, Gl};
use landfall_exec::backend::reflection::{ReflectedBlock, ReflectedMember};
use landfall_exec::backend::{Backend as _, FailureKind, Grid, Job, ResourceKind, Texel};
use landfall_layout::{BlockLayout, Leaf, Options, Source, Stage, layout};

fn open() -> Gl {
    Gl::open().unwrap_or_else(|failure| panic!("{failure}"))
}

const COPY: &str = "#version 430
layout(local_size_x = 4) in;
layout(std140) uniform Input { uvec4 a; float b; uint c[2]; } i;
layout(std430) buffer Output { uint words[]; };
void main() {
  uint at = gl_GlobalInvocationID.x;
  uint got[8] = uint[](i.a.x, i.a.y, i.a.z, i.a.w, floatBitsToUint(i.b), i.c[0], i.c[1], 7u);
  words[at] += got[at];
}";

fn copy() -> Job {
    let resources = vec![uniform("Input", 0, &counting(16)), storage("Output", 1, &[5; 8])];
    job(vec![glsl(Stage::Compute, COPY)], resources, Grid::Groups([2, 1, 1]))
}

/// By the rules of std140: a at 0, b at 16, c at 32 with stride 16.
const COPIED: [u32; 8] = [1005, 1006, 1007, 1008, 1009, 1013, 1017, 12];

#[test]
fn words_of_a_uniform_block_come_back_through_a_storage_block() {
    let answer = open().run(&copy()).unwrap();
    assert_eq!(answer.buffers[0], None, "a uniform block does not come back");
    assert_eq!(words(answer.buffers[1].as_ref().unwrap()), COPIED);
    assert!(answer.pixels.is_empty());
}

#[test]
fn a_buffer_that_is_not_writable_does_not_come_back() {
    let mut copy = copy();
    copy.resources[1].kind = ResourceKind::Storage { bytes: bytes(&[5; 8]), writable: false };
    assert_eq!(open().run(&copy).unwrap().buffers, [None, None]);
}

#[test]
fn an_image_of_unsigned_integers_has_its_first_row_first() {
    let text = "#version 330
layout(std140) uniform B { uint base; } b;
out uvec4 color;
void main() { color = uvec4(gl_FragCoord.xy, b.base, 0xFFFFFFFFu); }";
    let grid = Grid::Image { width: 3, height: 2, texel: Texel::Uint };
    let resources = vec![uniform("B", 0, &[77, 0, 0, 0])];
    let answer = open().run(&job(vec![glsl(Stage::Fragment, text)], resources, grid)).unwrap();
    let expected: Vec<[u32; 4]> =
        (0..2).flat_map(|y| (0..3).map(move |x| [x, y, 77, u32::MAX])).collect();
    assert_eq!(answer.pixels, expected);
}

#[test]
fn an_image_of_floats_is_neither_clamped_nor_rounded() {
    let text = "#version 110
uniform sampler2D tex;
void main() { gl_FragColor = vec4(-2.5, 1e30, 0.1, 65537.0) + texture2D(tex, vec2(0.6, 0.1)); }";
    let texels = vec![[9.0; 4], [0.0, 0.0, 0.0, 1.0]];
    let texture = bound("tex", 0, ResourceKind::Texture { width: 2, height: 1, texels });
    let grid = Grid::Image { width: 1, height: 1, texel: Texel::Float };
    let answer = open().run(&job(vec![glsl(Stage::Fragment, text)], vec![texture], grid)).unwrap();
    assert_eq!(answer.pixels, [[-2.5f32, 1e30, 0.1, 65538.0].map(f32::to_bits)]);
}

#[test]
fn a_vertex_stage_may_come_with_the_fragment_stage() {
    let vertex = "#version 330
out vec2 place;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  place = corner * 8.0;
  gl_Position = vec4(corner * 4.0 - 1.0, 0.0, 1.0);
}";
    let fragment = "#version 330\nin vec2 place; out vec4 color;
void main() { color = vec4(place, 0.0, 1.0); }";
    let stages = vec![glsl(Stage::Vertex, vertex), glsl(Stage::Fragment, fragment)];
    let grid = Grid::Image { width: 4, height: 4, texel: Texel::Float };
    let answer = open().run(&job(stages, Vec::new(), grid)).unwrap();
    let place = |at: usize| [0, 1].map(|c| f32::from_bits(answer.pixels[at][c]));
    assert_eq!(place(0), [0.5, 0.5]);
    assert_eq!(place(7), [3.5, 1.5]);
}

#[test]
fn flat_values_are_those_of_the_last_vertex() {
    let vertex = "#version 330
flat out ivec2 carried;
void main() {
  carried = ivec2(gl_VertexID, 7);
  gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0);
}";
    let fragment = "#version 330\nflat in ivec2 carried; out uvec4 color;
void main() { color = uvec4(carried, 0u, 0u); }";
    let stages = vec![glsl(Stage::Vertex, vertex), glsl(Stage::Fragment, fragment)];
    let grid = Grid::Image { width: 2, height: 1, texel: Texel::Uint };
    let answer = open().run(&job(stages, Vec::new(), grid)).unwrap();
    assert_eq!(answer.pixels, [[2, 7, 0, 0]; 2]);
}

#[test]
fn point_i_lands_on_pixel_i() {
    for (line, precision) in [("#version 330", ""), ("#version 300 es", "precision highp float;")] {
        let vertex = format!(
            "{line}
layout(std140) uniform B {{ uint base; uint count; }};
flat out uvec2 carried;
void main() {{
  carried = uvec2(base, gl_VertexID);
  gl_Position = vec4((2.0 * float(gl_VertexID) + 1.0) / float(count) - 1.0, 0.0, 0.0, 1.0);
  gl_PointSize = 1.0;
}}"
        );
        let fragment = format!(
            "{line}\n{precision}\nflat in highp uvec2 carried; out highp uvec4 color;
void main() {{ color = uvec4(carried, 3u, 4u); }}"
        );
        let stages = vec![glsl(Stage::Vertex, &vertex), glsl(Stage::Fragment, &fragment)];
        let grid = Grid::Points { count: 101, texel: Texel::Uint };
        let resources = vec![uniform("B", 0, &[42, 101, 0, 0])];
        let answer = open().run(&job(stages, resources, grid)).unwrap();
        let expected: Vec<[u32; 4]> = (0..101).map(|i| [42, i, 3, 4]).collect();
        assert_eq!(answer.pixels, expected, "{line}");
    }
}

#[test]
fn es_runs_compute_shaders_too() {
    let text = COPY
        .replace("#version 430", "#version 310 es")
        .replace("layout(std430) buffer Output", "layout(std430, binding = 3) buffer Output");
    let job = Job { stages: vec![glsl(Stage::Compute, &text)], ..copy() };
    let answer = open().run(&job).unwrap();
    assert_eq!(words(answer.buffers[1].as_ref().unwrap()), COPIED);
}

#[test]
fn each_block_of_an_array_has_its_own_buffer() {
    let text = "#version 430
layout(local_size_x = 1) in;
layout(std140) uniform B { uint x; } b[2];
layout(std430) buffer Output { uint words[2]; };
void main() { words[0] = b[0].x; words[1] = b[1].x; }";
    let resources = vec![
        uniform("B[1]", 1, &[11, 0, 0, 0]),
        uniform("B[0]", 0, &[10, 0, 0, 0]),
        output("Output", 2, 2),
    ];
    let job = job(vec![glsl(Stage::Compute, text)], resources, Grid::Groups([1, 1, 1]));
    let answer = open().run(&job).unwrap();
    assert_eq!(words(answer.buffers[2].as_ref().unwrap()), [10, 11]);
}

#[test]
fn one_reader_runs_hundreds_of_jobs_and_each_sees_only_its_own_buffers() {
    let mut gl = open();
    let other = "#version 330
layout(std140) uniform Other { uvec4 z; };
out uvec4 color;
void main() { color = z; }";
    for round in 0..150u32 {
        let mut copy = copy();
        copy.resources[0] = uniform("Input", 0, &[round; 16]);
        let answer = gl.run(&copy).unwrap();
        let expected =
            [5 + round, 5 + round, 5 + round, 5 + round, 5 + round, 5 + round, 5 + round, 12];
        assert_eq!(words(answer.buffers[1].as_ref().unwrap()), expected);
        let resources = vec![uniform("Other", 0, &[round, 1, 2, 3])];
        let grid = Grid::Image { width: 1, height: 1, texel: Texel::Uint };
        let answer = gl.run(&job(vec![glsl(Stage::Fragment, other)], resources, grid)).unwrap();
        assert_eq!(answer.pixels, [[round, 1, 2, 3]]);
    }
}

fn refused(job: &Job) -> (String, String) {
    let mut gl = open();
    let failure = gl.run(job).unwrap_err();
    assert_eq!(failure.kind, FailureKind::Refused, "{failure}");
    let answer = gl.run(&copy()).expect("the next job is not affected");
    assert_eq!(words(answer.buffers[1].as_ref().unwrap()), COPIED);
    (failure.message, failure.log)
}

#[test]
fn a_syntax_error_comes_with_the_drivers_log() {
    let mut job = copy();
    job.stages = vec![glsl(Stage::Compute, &COPY.replace("words[at]", "wards[at]"))];
    let (message, log) = refused(&job);
    assert_eq!(message, "the compute shader does not compile");
    assert!(log.contains("wards"), "{log}");
}

#[test]
fn stages_that_do_not_meet_come_with_the_linkers_log() {
    let vertex = "#version 330\nout vec2 gone; void main() { gl_Position = gone.xyxy; }";
    let fragment = "#version 330\nin vec3 gone; out vec4 c; void main() { c = gone.xyzz; }";
    let stages = vec![glsl(Stage::Vertex, vertex), glsl(Stage::Fragment, fragment)];
    let grid = Grid::Image { width: 1, height: 1, texel: Texel::Float };
    let (message, log) = refused(&job(stages, Vec::new(), grid));
    assert_eq!(message, "the program does not link");
    assert!(log.contains("gone"), "{log}");
}

#[test]
fn a_block_over_the_limit_is_refused_with_both_numbers() {
    let limit = Gl::list().unwrap()[0].outcome.clone().unwrap().1.uniform_block_size.unwrap();
    let mut job = copy();
    let size = usize::try_from(limit).unwrap() + 16;
    job.resources[0].kind = ResourceKind::Uniform(vec![0; size]);
    let expected =
        format!("the uniform block `Input` has {size} bytes, but this device supports {limit}");
    assert_eq!(refused(&job).0, expected);
}

#[test]
fn too_many_workgroups_are_refused_with_both_numbers() {
    let limit = Gl::list().unwrap()[0].outcome.clone().unwrap().1.workgroups.unwrap();
    let groups = u32::try_from(limit + 1).unwrap();
    let job = Job { grid: Grid::Groups([1, groups, 1]), ..copy() };
    let expected = format!(
        "the dispatch has {groups} workgroups in one dimension, but this device supports {limit}"
    );
    assert_eq!(refused(&job).0, expected);
}

#[test]
fn what_is_bound_twice_or_not_at_all_or_too_short_is_named() {
    let mut job = copy();
    job.resources.push(uniform("Input", 5, &[0; 16]));
    assert_eq!(refused(&job).0, "`Input` is bound twice in one job");
    let mut job = copy();
    job.resources.remove(0);
    let message = "the shader reads the uniform block `Input`, but nothing is bound to it";
    assert_eq!(refused(&job).0, message);
    let mut job = copy();
    job.resources[0] = uniform("Input", 0, &[0; 12]);
    let message = "the driver requires 64 bytes in `Input`, but 48 bytes are bound";
    assert_eq!(refused(&job).0, message);
    let mut job = copy();
    job.resources.push(bound("push", 0, ResourceKind::PushConstant(vec![0; 4])));
    assert_eq!(
        refused(&job).0,
        "OpenGL has no push constants, but `push` is a push constant block"
    );
}

#[test]
fn a_job_without_text_or_the_stage_of_its_grid_is_refused() {
    let mut job = copy();
    job.stages[0].text = None;
    assert_eq!(refused(&job).0, "OpenGL needs GLSL, but the compute stage has none");
    let grid = Grid::Image { width: 1, height: 1, texel: Texel::Float };
    assert_eq!(refused(&Job { grid, ..copy() }).0, "the job has no fragment stage");
}

#[test]
fn every_kind_of_context_is_listed() {
    let found = Gl::list().unwrap();
    let kinds: Vec<&str> = found.iter().map(|f| f.kind.split(' ').next().unwrap()).collect();
    assert_eq!(kinds, ContextKind::ALL.map(ContextKind::name));
    for found in found {
        let (device, limits) = found.outcome.unwrap();
        assert_eq!((found.backend.name(), device.backend.name()), ("gl", "gl"));
        assert!(!device.adapter.is_empty() && !device.version.is_empty());
        // OpenGL 4.6 table 23.64 and ES 3.2 table 21.40 ask for no less.
        assert!(limits.uniform_block_size.unwrap() >= 16384);
    }
}

/// What OpenGL has no word for, or Mesa 22.3 no support.
const VULKAN: [&str; 5] = ["texture2D ", "push_constant", "constant_id", "#extension", "VULKAN"];

/// Mesa 22.3.6 takes the `readonly` of a member for that of the whole block.
const REFUSED: (&str, &str) = ("memory_qualifiers.comp", "read-only");

/// Texts that OpenGL takes once no descriptor set is named; nothing is put in for an
/// `#include`.
fn for_opengl() -> Vec<Source> {
    let all = shaders().into_iter().map(|path| {
        let mut source = Source::read(&path).unwrap();
        let text = (0..4)
            .fold(source.text.to_string(), |text, set| text.replace(&format!("set = {set}, "), ""));
        source.text = text.into();
        source
    });
    let ours = |source: &Source| {
        let text: &str = &source.text;
        source.stage.is_some()
            && !text.contains("#include")
            && !VULKAN.iter().any(|word| text.contains(word))
    };
    all.filter(ours).collect()
}

/// `data[1].w[0]` is `data[].w[]` at 1, and at nothing more if the array is listed whole.
fn pattern(member: &ReflectedMember) -> (String, Vec<u64>) {
    let (mut path, mut indices) = (String::new(), Vec::new());
    for (at, piece) in member.name.split('[').enumerate() {
        let (index, rest) = if at == 0 { ("", piece) } else { piece.split_once(']').unwrap() };
        if at > 0 {
            path.push_str("[]");
            indices.push(index.parse().unwrap());
        }
        path.push_str(rest);
    }
    (path, indices)
}

fn agree(file: &str, block: &BlockLayout, theirs: &ReflectedBlock) -> usize {
    let whole = format!("{file} {}", theirs.name);
    // Mesa rounds storage blocks up to 16 bytes too, and counts one element of a runtime tail.
    if block.space == landfall_layout::AddressSpace::Uniform {
        assert_eq!(block.size, Some(theirs.size), "{whole}");
    }
    for member in &theirs.members {
        let (path, indices) = pattern(member);
        let leaf: Option<&Leaf> = block.leaves.iter().find(|leaf| leaf.path == path);
        let leaf = leaf.unwrap_or_else(|| panic!("{whole}: no leaf {path}"));
        let steps: u64 = indices.iter().zip(&leaf.strides).map(|(i, stride)| i * stride).sum();
        assert_eq!(leaf.offset.map(|o| o + steps), Some(member.offset), "{whole} {}", member.name);
        if member.array_stride > 0 {
            assert_eq!(leaf.strides.last(), Some(&member.array_stride), "{whole} {}", member.name);
        }
        if let Some((_, stride)) = member.top_level {
            assert_eq!(leaf.strides.first(), Some(&stride), "{whole} {}", member.name);
        }
        assert_eq!(leaf.matrix_stride.unwrap_or(0), member.matrix_stride, "{whole} {path}");
        if leaf.matrix_stride.is_some() {
            assert_eq!(leaf.row_major, member.row_major, "{whole} {path}");
        }
    }
    for leaf in &block.leaves {
        let listed = theirs.members.iter().any(|member| pattern(member).0 == leaf.path);
        assert!(listed, "{whole}: the driver has no {}", leaf.path);
    }
    theirs.members.len()
}

#[test]
fn the_driver_puts_the_members_of_the_repositorys_shaders_where_landfall_does() {
    let mut gl = open();
    let (mut blocks, mut storage, mut members, mut texts) = (0, 0, 0, 0);
    for source in for_opengl() {
        let ours = layout(&source, &Options::default());
        let stage = source.stage.unwrap();
        let theirs = gl.reflect(&[(stage, &source.text)]);
        if source.path.ends_with(REFUSED.0) {
            assert!(theirs.is_err_and(|failure| failure.log.contains(REFUSED.1)));
            continue;
        }
        let theirs = theirs.unwrap_or_else(|e| panic!("{}: {e}", source.path));
        texts += 1;
        for block in ours.blocks.iter().filter(|block| block.rules_declared) {
            let all = theirs.uniform_blocks.iter().chain(&theirs.storage_blocks);
            // Those of an array may list their members with the first only.
            let here = |b: &&ReflectedBlock| {
                b.name.split('[').next() == Some(&*block.name) && !b.members.is_empty()
            };
            let Some(theirs) = all.clone().find(here) else {
                panic!("{}: the driver has no block {}", source.path, block.name)
            };
            members += agree(&source.path, block, theirs);
            blocks += 1;
            storage += usize::from(block.space == landfall_layout::AddressSpace::Storage);
        }
    }
    let counts = [texts, blocks, storage, members];
    assert!(
        counts.iter().zip([30, 20, 3, 2000]).all(|(count, least)| *count >= least),
        "{counts:?}"
    );
}

#[test]
fn loose_uniforms_are_listed_by_path_and_type() {
    let text = "#version 120
struct Light { vec3 pos; float k[2]; };
uniform Light lights[2]; uniform mat3 turn; uniform samplerCube sky;
void main() {
  gl_FragColor = vec4(turn * (lights[0].pos + lights[1].pos), lights[1].k[1])
    + textureCube(sky, lights[0].pos * lights[0].k[0]);
}";
    let reflection = open().reflect(&[(Stage::Fragment, text)]).unwrap();
    let mut found: Vec<(&str, &str, u64)> = reflection
        .uniforms
        .iter()
        .map(|u| (u.name.as_str(), u.ty.as_str(), u.array_size))
        .collect();
    found.sort_unstable();
    let expected = [
        ("lights[0].k[0]", "float", 2),
        ("lights[0].pos", "vec3", 1),
        ("lights[1].k[0]", "float", 2),
        ("lights[1].pos", "vec3", 1),
        ("sky", "samplerCube", 1),
        ("turn", "mat3", 1),
    ];
    assert_eq!(found, expected);
}

#[test]
fn a_lone_stage_with_inputs_is_reflected_in_every_version() {
    for (line, stage, text) in [
        (
            "#version 110",
            Stage::Fragment,
            "varying vec3 v; uniform float x; void main() { gl_FragColor = vec4(v, x); }",
        ),
        (
            "#version 100",
            Stage::Fragment,
            "precision mediump float; varying vec3 v; uniform float x; void main() { gl_FragColor = vec4(v, x); }",
        ),
        (
            "#version 330",
            Stage::Vertex,
            "in vec4 p; out vec4 v; uniform float x; void main() { v = p; gl_Position = p * x; }",
        ),
        (
            "#version 300 es",
            Stage::Vertex,
            "in vec4 p; out vec4 v; uniform float x; void main() { v = p; gl_Position = p * x; }",
        ),
        (
            "#version 430",
            Stage::Compute,
            "layout(local_size_x = 1) in; uniform float x; buffer O { float o; }; void main() { o = x; }",
        ),
    ] {
        let reflection = open().reflect(&[(stage, &format!("{line}\n{text}"))]);
        let reflection = reflection.unwrap_or_else(|e| panic!("{line}: {e}"));
        assert!(reflection.uniforms.iter().any(|uniform| uniform.name == "x"), "{line}");
    }
}
