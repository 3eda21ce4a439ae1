//! Lints over all shaders find the same in those that digests pick as in all of them.
//!
//! Caches lay out only the shaders picked; what they would miss would be
//! missed without a word.

use fastrand::Rng;
use landfall_layout::finding::Level;
use landfall_layout::{Options, ShaderLayout, Source, layout};
use landfall_lint::digest::{BlockDigest, digest, shaders_to_compare};
use landfall_lint::settings::{Figure, MirrorCopy, MirrorGroup, Table};
use landfall_lint::{Settings, Subject, run};

const TREES: u64 = 400;

/// Shaders of a tree: few names, bindings and bodies, so that many agree and some differ.
fn tree(rng: &mut Rng) -> Vec<Source> {
    (0..rng.usize(2..7))
        .map(|i| if rng.u8(..4) == 0 { wgsl(rng, i) } else { glsl(rng, i) })
        .collect()
}

fn glsl(rng: &mut Rng, i: usize) -> Source {
    let bodies = [
        "vec4 a; vec4 b;",
        "vec4 a; vec3 b; float c;",
        "vec4 b; vec4 a;",
        "mat4 a;",
        "Light a[3];",
    ];
    let mut text = "#version 450\nstruct Light { vec4 pos; vec4 color; };\n".to_string();
    let from = rng.usize(..4);
    for n in 0..rng.usize(1..4) {
        let name = ["Light0", "Camera", "Scene", "Other"][(from + n) % 4];
        let (set, binding) = (rng.u32(..2), rng.u32(..2) + 2 * n as u32);
        let body = bodies[rng.usize(..bodies.len())];
        text += &format!(
            "layout(std140, set = {set}, binding = {binding}) uniform {name} {{ {body} }} u{n};\n"
        );
    }
    let stage = ["vert", "frag"][rng.usize(..2)];
    Source::new(format!("s{}.{stage}", i / 2 * 2 + rng.usize(..2)), text + "void main() {}\n")
}

fn wgsl(rng: &mut Rng, i: usize) -> Source {
    let body = ["a: vec4f, b: vec4f", "a: mat4x4f"][rng.usize(..2)];
    let name = ["Light0", "Camera"][rng.usize(..2)];
    let text =
        format!("struct {name} {{ {body} }}\n@group(0) @binding(0) var<uniform> u0: {name};\n");
    Source::new(format!("s{i}.wgsl"), text)
}

fn settings(rng: &mut Rng) -> Settings {
    let all = vec![("all".to_string(), Level::Warn)];
    let mut settings = Settings { levels: all, ..Settings::default() };
    if rng.u8(..3) == 0 {
        let copy = |block: &str| MirrorCopy { block: block.to_string(), ..MirrorCopy::default() };
        let copies = vec![copy("Light0"), copy(["Camera", "Gone"][rng.usize(..2)])];
        settings.mirror_groups =
            vec![MirrorGroup { name: "lights".to_string(), copies, ..MirrorGroup::default() }];
    }
    if rng.u8(..3) == 0 {
        let size = Figure { bytes: 16, written: "16".to_string(), ..Figure::default() };
        let block = ["Scene", "u1", "Scen"][rng.usize(..3)].to_string();
        settings.tables = vec![Table { block, size: Some(size), ..Table::default() }];
    }
    settings
}

#[test]
fn lints_over_all_shaders_find_the_same_in_those_that_digests_pick() {
    let options = Options::default().with_naga(true);
    for seed in 0..TREES {
        let mut rng = Rng::with_seed(seed);
        let (sources, settings) = (tree(&mut rng), settings(&mut rng));
        let shaders: Vec<ShaderLayout> = sources.iter().map(|s| layout(s, &options)).collect();
        assert!(shaders.iter().all(|shader| !shader.has_errors()), "seed {seed}: {sources:?}");
        let subjects: Vec<Subject<'_>> = sources
            .iter()
            .zip(&shaders)
            .map(|(source, shader)| Subject { source, options: &options, shader })
            .collect();
        let digests: Vec<Vec<BlockDigest>> = shaders.iter().map(digest).collect();
        let digests: Vec<(&str, &[BlockDigest])> = sources
            .iter()
            .zip(&digests)
            .map(|(source, blocks)| (source.path.as_str(), blocks.as_slice()))
            .collect();
        let picked = shaders_to_compare(&digests, &settings);
        let picked: Vec<Subject<'_>> = picked.into_iter().map(|i| subjects[i]).collect();
        let (all, some) = (
            run::tree_unsuppressed(&subjects, &settings),
            run::tree_unsuppressed(&picked, &settings),
        );
        assert_eq!(all, some, "seed {seed}: {} of {} shaders", picked.len(), subjects.len());
    }
}
