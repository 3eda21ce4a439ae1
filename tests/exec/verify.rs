//! Proof of blocks: every backend sees every leaf where it is laid out, and faults that are
//! planted are caught and located by every backend that can see them.

use std::collections::BTreeSet;

use snapbox::str;

use crate::support;
use crate::support::backends;
use crate::support::command::golden;

use backends::with_readers;
use landfall_exec::harness::verify::{
    BackendReport, Outcome, ShaderReport, Subject, VerifyOptions, verify,
};
use landfall_layout::{BlockLayout, Rules, Source, Stage};
use support::blocks::{Block, Rules as BlockRules, Space, print};
use support::generate::{Diet, random};
use support::known::{Subject as Asked, within_the_driver};
use support::sample::{everything, sample};

/// What the backends here all take: no 8, 16 and 64-bit integers.
const DIET: Diet = Diet {
    kinds: &[
        (Space::Uniform, BlockRules::Std140),
        (Space::Buffer, BlockRules::Std140),
        (Space::Buffer, BlockRules::Std430),
    ],
    scalars: &[
        support::blocks::Scalar::Float,
        support::blocks::Scalar::Float,
        support::blocks::Scalar::Float,
        support::blocks::Scalar::Int,
        support::blocks::Scalar::Uint,
        support::blocks::Scalar::Bool,
        support::blocks::Scalar::Double,
    ],
    // Drivers take seconds to compile shaders that are mostly double matrices.
    matrices: &[
        support::blocks::Scalar::Float,
        support::blocks::Scalar::Float,
        support::blocks::Scalar::Float,
        support::blocks::Scalar::Float,
        support::blocks::Scalar::Float,
        support::blocks::Scalar::Double,
    ],
    push_constant: false,
};

fn verified(source: &Source, options: &VerifyOptions) -> ShaderReport {
    verified_by(usize::MAX, source, options)
}

/// Verifies by so many of the backends, the interpreter first.
fn verified_by(most: usize, source: &Source, options: &VerifyOptions) -> ShaderReport {
    let subject = Subject::new(source, options)
        .unwrap_or_else(|(_, found)| panic!("{}: {found:?}\n{}", source.path, source.text));
    with_readers(|backends| {
        let most = most.min(backends.len());
        assert_eq!(backends[0].device().backend.name(), "cpu");
        verify(&subject, options, &mut backends[..most])
    })
}

/// Every report of a block by a backend, with what it is about.
fn each(report: &ShaderReport) -> impl Iterator<Item = (&str, &BackendReport)> {
    let blocks = report.blocks.iter();
    blocks.flat_map(|block| block.backends.iter().map(|backend| (&*block.name, backend)))
}

/// Two halves, for two threads and two sets of backends: 300 blocks together.
#[test]
fn random_blocks_are_read_where_they_are_laid_out() {
    random_blocks_are_confirmed(0..56);
}

#[test]
fn more_random_blocks_are_read_where_they_are_laid_out() {
    random_blocks_are_confirmed(56..112);
}

fn random_blocks_are_confirmed(seeds: std::ops::Range<u64>) {
    let (mut blocks, mut reads) = (0, 0);
    for seed in sample(seeds, 8) {
        let (standing, made) = random(seed, 3, &DIET);
        let stage = [Stage::Vertex, Stage::Fragment, Stage::Compute][seed as usize % 3];
        let extension = ["vert", "frag", "comp"][seed as usize % 3];
        let made: Vec<&Block> = made
            .iter()
            .filter(|block| within_the_driver(Asked { block, standing: &standing }))
            .collect();
        let text = declarations(&print(&standing, &made));
        let source = Source::new(format!("seed_{seed}.{extension}"), text.as_str());
        // Drivers compile some of these for half a minute on a slow machine.
        let options =
            VerifyOptions { limit: std::time::Duration::from_secs(180), ..Default::default() };
        let report = verified(&source, &options);
        for (block, backend) in each(&report) {
            assert_eq!(
                (backend.outcome, backend.stage),
                (Outcome::Confirmed, stage.name()),
                "seed {seed}, {block}, {}: {:?}\n{}\n{:#?}\n{text}",
                backend.backend.name(),
                backend.reason,
                backend.log,
                backend
                    .reads
                    .iter()
                    .filter(|r| r.byte_read != Some(r.expected_byte))
                    .take(5)
                    .collect::<Vec<_>>(),
            );
            reads += backend.reads.len();
        }
        blocks += report.blocks.len();
    }
    println!("{blocks} blocks, {reads} reads");
    let share = if everything() { 1 } else { 20 };
    assert!(blocks >= 150 / share, "{blocks} blocks");
    assert!(reads > 20_000 / share, "{reads} reads");
}

/// A compute shader's text without what only a compute shader may have.
fn declarations(text: &str) -> String {
    let declared = text.split("shared float sink;").next().expect("there is a first part");
    format!("{}void main() {{}}\n", declared.replace("layout(local_size_x = 1) in;\n", ""))
}

/// A shader whose block has a bit of everything a fault could hit.
const LIGHTS: &str = "#version 450
struct Attenuation { float constant; float linear; };
struct Light { vec3 position; Attenuation att; float power; };
layout(std140, binding = 0) uniform LightBlock {
    float time;
    Light lights[4];
    float weights[3][2];
    layout(row_major) mat3x4 frame;
    bool on;
    vec2 tail;
} u;
void main() {}
";

/// The layout of [`LIGHTS`] with a fault in it.
fn with_fault(fault: impl Fn(&mut BlockLayout)) -> ShaderReport {
    let source = Source::new("lights.frag", LIGHTS);
    let layout = landfall_layout::layout(&source, &landfall_layout::Options::default());
    let mut given = layout.blocks.clone();
    fault(&mut given[0]);
    verified(&source, &VerifyOptions { given: Some(given), ..VerifyOptions::default() })
}

/// The leaves each backend sees elsewhere, which must be the same for all; with the causes.
fn caught(report: &ShaderReport) -> Vec<(String, String)> {
    let mut all: Vec<(&str, Vec<(String, String)>)> = Vec::new();
    for (_, backend) in each(report) {
        let elsewhere = backend.reads.iter().filter(|r| r.byte_read != Some(r.expected_byte));
        let mut leaves: Vec<(String, String)> = elsewhere
            .map(|read| {
                let cause = backend.causes.iter().find(|cause| cause.leaf == read.leaf);
                (read.leaf.clone(), cause.map_or(String::new(), |cause| cause.cause.clone()))
            })
            .collect();
        leaves.sort();
        leaves.dedup();
        assert_eq!(backend.outcome == Outcome::Disagrees, !leaves.is_empty());
        all.push((backend.backend.name(), leaves));
    }
    assert_eq!(all.len(), 3, "every backend ran");
    for (backend, leaves) in &all {
        assert_eq!(leaves, &all[0].1, "{backend} against {}", all[0].0);
    }
    all.swap_remove(0).1
}

fn leaf<'a>(block: &'a mut BlockLayout, path: &str) -> &'a mut landfall_layout::Leaf {
    block.leaves.iter_mut().find(|leaf| leaf.path == path).expect("there is such a leaf")
}

#[test]
fn the_true_layout_is_confirmed() {
    assert_eq!(caught(&with_fault(|_| {})), []);
}

#[test]
fn an_offset_shifted_by_four_is_caught() {
    let found = caught(&with_fault(|block| {
        let leaf = leaf(block, "tail");
        leaf.offset = leaf.offset.map(|offset| offset + 4);
    }));
    let [(path, cause)] = &found[..] else { panic!("{found:?}") };
    assert_eq!(path, "tail");
    // std140 by hand: lights 16 to 208, weights to 304, four rows of frame to 368, `on`, and
    // a vec2 is aligned to 8: 376. The fault says 380.
    golden().eq(cause, str!["it starts at 376 instead of 380"]);
}

#[test]
fn a_stride_of_twelve_for_sixteen_is_caught() {
    let found = caught(&with_fault(|block| leaf(block, "weights[][]").strides[1] = 12));
    let [(path, cause)] = &found[..] else { panic!("{found:?}") };
    assert_eq!(path, "weights[][]");
    golden().eq(cause, str!["the array stride of the inner dimension is 16 instead of 12"]);
}

#[test]
fn swapped_dimensions_are_caught() {
    // naga 30 takes float[3][2] as three within two: strides 48 and 16 for 32 and 16.
    let found = caught(&with_fault(|block| leaf(block, "weights[][]").strides[0] = 48));
    let [(path, cause)] = &found[..] else { panic!("{found:?}") };
    assert_eq!(path, "weights[][]");
    golden().eq(cause, str!["the array stride of the outer dimension is 32 instead of 48"]);
}

#[test]
fn rows_taken_for_columns_are_caught() {
    let found = caught(&with_fault(|block| leaf(block, "frame").row_major = false));
    let [(path, cause)] = &found[..] else { panic!("{found:?}") };
    assert_eq!(path, "frame");
    golden().eq(cause, str!["rows and columns are swapped"]);
}

#[test]
fn a_structure_that_is_not_rounded_up_is_caught() {
    // Attenuation has 8 bytes, 16 in std140: what follows it comes 8 bytes early.
    let found = caught(&with_fault(|block| {
        let power = leaf(block, "lights[].power");
        power.offset = power.offset.map(|offset| offset - 8);
    }));
    let [(path, cause)] = &found[..] else { panic!("{found:?}") };
    assert_eq!(path, "lights[].power");
    golden().eq(cause, str!["it starts at 48 instead of 40"]);
}

#[test]
fn a_stale_layout_of_other_rules_is_caught_and_named() {
    let found = caught(&with_fault(|block| {
        let text = LIGHTS.replace("std140", "std430").replace("uniform", "buffer");
        let stale = landfall_layout::layout(
            &Source::new("lights.frag", text.as_str()),
            &landfall_layout::Options::default(),
        );
        assert_eq!(stale.blocks[0].rules, Rules::Std430);
        block.leaves.clone_from(&stale.blocks[0].leaves);
    }));
    let paths: Vec<&str> = found.iter().map(|(path, _)| path.as_str()).collect();
    assert!(paths.contains(&"weights[][]") && paths.contains(&"lights[].power"), "{paths:?}");
}

#[test]
fn a_driver_that_reads_by_its_own_rules_is_told_apart() {
    // Mesa packs `shared` blocks like std430; landfall says std140, and that it is a guess.
    let text = "#version 450\nlayout(shared, binding = 0) uniform B { float a; float b[3]; };\n\
                void main() {}\n";
    let source = Source::new("shared.frag", text);
    let report = verified(&source, &VerifyOptions::default());
    let (_, gl) =
        each(&report).find(|(_, backend)| backend.backend.name() == "gl").expect("gl ran");
    assert_eq!(gl.outcome, Outcome::Disagrees);
    let [cause] = &gl.causes[..] else { panic!("{:?}", gl.causes) };
    assert_eq!(cause.leaf, "b[]");
    golden().eq(&cause.cause, str!["this is its offset in std430; it starts at 4 instead of 16; the array stride is 4 instead of 16"]);
}

/// Seen in naga 30.0.1: what a program reads that hands such a text to wgpu.
#[test]
fn nagas_own_offsets_are_caught() {
    let glsl = "#version 450
        layout(local_size_x = 1) in;
        struct Falloff { float linear; };
        layout(std140, binding = 0) buffer Lamp { float power; Falloff fall; float tail; } lamp;
        void main() {}
    ";
    let wgsl = "struct Inner { @align(16) a: u32 }
        struct Outer { x: u32, inner: Inner, y: u32 }
        @group(0) @binding(0) var<storage, read_write> outer: Outer;
        @compute @workgroup_size(1) fn main() { outer.x = outer.inner.a; }
    ";
    for (name, text, leaf, expected) in
        [("lamp.comp", glsl, "fall.linear", 16), ("outer.wgsl", wgsl, "inner.a", 16)]
    {
        let source = Source::new(name, text);
        let report = verified(&source, &VerifyOptions { naga: true, ..VerifyOptions::default() });
        for backend in ["cpu", "gpu"] {
            let seen =
                each(&report).find(|(_, seen)| seen.backend.name() == backend).expect("it ran").1;
            assert_eq!(seen.outcome, Outcome::Disagrees, "{name} {backend}: {:?}", seen.reason);
            // A structure starts at a multiple of 16 in std140, and `@align(16)` says as much.
            let read = seen
                .reads
                .iter()
                .find(|read| read.leaf == leaf && read.expected_byte == expected)
                .expect("it was read");
            assert_ne!(read.byte_read, Some(expected), "{name} {backend}");
            let cause = seen.causes.iter().find(|cause| cause.leaf == leaf).expect("a cause");
            golden().eq(
                &cause.cause,
                str!["this is its offset in naga's layout; it starts at 4 instead of 16"],
            );
        }
        let report = verified(&source, &VerifyOptions::default());
        assert!(each(&report).all(|(_, seen)| seen.outcome != Outcome::Disagrees));
    }
}

/// Every leaf of every shader of the repository, by every backend that takes it.
#[test]
fn every_leaf_of_our_shaders_is_confirmed() {
    let paths = support::files::shaders();
    assert!(paths.len() > 60, "{}", paths.len());
    // Drivers compile for a second and more: a sample for them, all for the interpreter, which is the first.
    let on_drivers: BTreeSet<u64> = sample(0..paths.len() as u64, 6).collect();
    for (number, path) in (0..).zip(&paths) {
        let source = Source::read(path).expect("a shader of ours is text");
        let backends = if on_drivers.contains(&number) { usize::MAX } else { 1 };
        let report = verified_by(backends, &source, &VerifyOptions::default());
        for (block, backend) in each(&report) {
            let name = format!("{} {block} {}", source.path, backend.backend.name());
            match backend.outcome {
                Outcome::Confirmed => {}
                Outcome::Skipped => {
                    let reason = backend.reason.as_deref().unwrap_or_default();
                    assert!(is_known(&source, backend.backend.name(), reason), "{name}: {reason}");
                }
                Outcome::Disagrees => {
                    // The driver's own rules, as the shader's own comment says.
                    assert!(source.path.ends_with("driver_rules.frag"), "{name}");
                }
                Outcome::Failed => panic!("{name}: {:?}\n{}", backend.reason, backend.log),
            }
        }
    }
}

/// What a backend cannot be asked, said in advance.
fn is_known(source: &Source, backend: &str, reason: &str) -> bool {
    let named = |name: &str| source.path.ends_with(name);
    match backend {
        // OpenGL takes neither WGSL nor what is Vulkan's alone.
        "gl" => {
            named(".wgsl")
                || reason.contains("OpenGL has no")
                || reason.contains("compiler rejects the shader")
                    && [
                        "buffer_reference.comp",
                        "small_and_large_scalars.comp",
                        "specialization_constant.frag",
                        "scene_450.vert",
                        "view_space_450.vert",
                    ]
                    .iter()
                    .any(|name| named(name))
                || named("buffer_reference.comp")
                // Mesa 22.3.6 takes a member's `readonly` for the whole block.
                || named("memory_qualifiers.comp") && reason.contains("compiler rejects")
        }
        // Addresses, and 8-bit numbers, which naga does not have.
        _ => named("buffer_reference.comp") || named("small_and_large_scalars.comp"),
    }
}

/// GLSL 4.60 §4.1.9: the length is the largest constant index plus one. Probes also read by
/// indices that are known only at run time, which such an array does not take.
#[test]
fn arrays_without_a_length_are_read_where_they_are_laid_out() {
    let text = "#version 450
layout(std140, binding = 0) uniform U { float a[]; vec4 last; };
layout(std430, binding = 1) buffer B { vec2 b [ ]; vec4 c; } s;
layout(location = 0) out vec4 o;
void main() { o = vec4(a[7] + a[2]) + last + vec4(s.b[3], 0.0, 0.0) + s.c; }
";
    let report = verified(&Source::new("open.frag", text), &VerifyOptions::default());
    let sizes: Vec<(&str, u64)> =
        report.blocks.iter().map(|block| (&*block.name, block.size)).collect();
    // 8 elements of 16 bytes, and 4 of 8 bytes, each before 16 bytes.
    assert_eq!(sizes, [("U", 144), ("B", 48)]);
    for (block, backend) in each(&report) {
        assert_eq!(backend.outcome, Outcome::Confirmed, "{block}: {backend:?}");
        assert!(backend.reads.len() >= 12, "{block}: {} reads", backend.reads.len());
    }
}

/// OpenGL lists uniforms of blocks and others in one list, which is read until the others are found.
#[test]
fn uniforms_outside_blocks_are_set_wherever_they_are_listed() {
    for (array, b) in [("", "b"), ("[2]", "b[1]")] {
        let text = format!(
            "#version 330
uniform vec3 first;
layout(std140) uniform B {{ vec4 a; float k[5]; }} b{array};
uniform vec4 middle[3];
layout(std140) uniform C {{ vec3 c; mat3 m; }};
uniform sampler2D image;
uniform float last;
out vec4 o;
void main() {{
    o = vec4(first * c * m, last) + {b}.a * {b}.k[3] + middle[1] + texture(image, middle[2].xy);
}}
"
        );
        let report = verified(&Source::new("mixed.frag", text), &VerifyOptions::default());
        let blocks: Vec<&str> = report.blocks.iter().map(|block| &*block.name).collect();
        assert_eq!(blocks, ["B", "C", "DefaultBlock"]);
        for (block, backend) in each(&report) {
            assert_eq!(backend.outcome, Outcome::Confirmed, "{block}{array}: {backend:?}");
        }
    }
}
