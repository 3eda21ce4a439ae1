//! `block-mismatch` between the stages of one program, whatever way their files name the stage.

use super::{Fixture, Score};

#[rustfmt::skip]
const NAMES: &[(&str, &str)] = &[
    ("sky.vert", "sky.frag"), ("sky_vs.glsl", "sky_fs.glsl"), ("sky.vert.glsl", "sky.frag.glsl"),
    ("skyVert.glsl", "skyFrag.glsl"), ("SkyVS.glsl", "SkyPS.glsl"), ("skyvert.glsl", "skyfrag.glsl"),
    ("skyVertexShader.glsl", "skyFragmentShader.glsl"), ("sky.vert.wgsl", "sky.frag.wgsl"),
    ("sky_vs.wgsl", "sky_fs.wgsl"), ("sky-vertex.wgsl", "sky-fragment.wgsl"),
];

fn shader(path: &str, glsl: &str, wgsl: &str) -> String {
    match path.ends_with(".wgsl") {
        true => {
            format!("struct View {{\n{wgsl}\n}}\n@group(0) @binding(0) var<uniform> view: View;\n")
        }
        false => format!(
            "#version 450\nlayout(std140, binding = 0) uniform View {{ {glsl} }} view;\nvoid main() {{}}\n"
        ),
    }
}

#[test]
fn stages_are_found_by_their_names() {
    let usual = ("mat4 proj; vec3 eye;", "proj: mat4x4f, eye: vec3f,");
    let moved =
        ("mat4 proj; mat4 inverse; vec3 eye;", "proj: mat4x4f, inverse: mat4x4f, eye: vec3f,");
    let head = ("mat4 proj;", "proj: mat4x4f,");
    let mut all = Vec::new();
    for (vertex, fragment) in NAMES {
        let first = shader(vertex, usual.0, usual.1);
        let pair = |second: (&str, &str), file: &str, line| {
            let second = shader(file, second.0, second.1);
            let expected: Vec<(&str, u32)> =
                Option::into_iter(line).map(|line| (file, line)).collect();
            Fixture::of(file, &[(vertex, &first), (file, &second)], &expected)
        };
        all.push(pair(moved, fragment, Some(2)));
        all.push(pair(usual, fragment, None));
        // A stage may declare only the first members, where blocks are matched by slot.
        all.push(pair(head, fragment, None));
        let other = fragment.replace("sky", "fog").replace("Sky", "Fog");
        all.push(pair(moved, &other, None));
    }
    // Two modules of WGSL whose names say no stage.
    let two = [
        ("mesh.wgsl", shader("a.wgsl", usual.0, usual.1)),
        ("task.wgsl", shader("a.wgsl", moved.0, moved.1)),
    ];
    let two: Vec<(&str, &str)> = two.iter().map(|(path, text)| (*path, text.as_str())).collect();
    all.push(Fixture::of("no stages", &two, &[]));
    Score::of("block-mismatch", &all).at_least(1.0, 1.0);
}

#[test]
fn an_array_that_differs_is_reported_at_the_array_once() {
    let text = |count: u32| {
        format!(
            "#version 450\nstruct Lamp {{ vec3 at; vec3 color; float gain; }};\n\
             layout(std140, binding = 0) uniform Lamps {{\n    Lamp lamps[{count}];\n}};\nvoid main() {{}}\n"
        )
    };
    let (a, b) = (text(4), text(8));
    let fixture = Fixture::of("lamps", &[("a.vert", &a), ("a.frag", &b)], &[("a.frag", 4)]);
    let found = fixture.found("block-mismatch");
    assert_eq!(found.len(), 1, "{found:#?}");
    assert_eq!(found[0].place().line, 4);
    assert_eq!(
        found[0].message,
        "block `Lamps` is declared differently in a.vert: `lamps` has 8 elements here and 4 there"
    );
}
