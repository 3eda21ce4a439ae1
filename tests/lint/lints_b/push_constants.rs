//! Push constants and immediates of the stages of one program, which share one range of bytes.

use super::said;
use landfall_layout::finding::Finding;
use landfall_layout::{Options, Source, layout};
use landfall_lint::{Check, Settings, Subject, lint};

fn mismatches(files: &[(&str, &str)]) -> Vec<Finding> {
    let options = Options::default();
    let all: Vec<_> = files
        .iter()
        .map(|(path, text)| {
            let source = Source::new(*path, *text);
            let shader = layout(&source, &options);
            assert!(!shader.has_errors(), "{:?}", shader.diagnostics);
            (source, shader)
        })
        .collect();
    let subjects: Vec<Subject<'_>> =
        all.iter().map(|(source, shader)| Subject { source, options: &options, shader }).collect();
    match lint("block-mismatch").expect("a lint").check {
        Check::Tree(check) => check(&subjects, &Settings::default()),
        _ => panic!("it looks at all shaders"),
    }
}

fn glsl(name: &str, members: &str) -> String {
    format!("#version 450\nlayout(push_constant) uniform {name} {{ {members} }} pc;\nvoid main() {{}}\n")
}

fn pair(vertex: &str, fragment: &str) -> Vec<Finding> {
    let mut found = Vec::new();
    for name in ["P", "Q"] {
        let (vertex, fragment) = (glsl("P", vertex), glsl(name, fragment));
        let all = mismatches(&[("s/a.vert", &vertex), ("s/a.frag", &fragment)]);
        let apart = mismatches(&[("s/a.vert", &vertex), ("s/b.frag", &fragment)]);
        assert_eq!(apart, [], "two programs");
        found.push(all);
    }
    assert_eq!(found[0].len(), found[1].len(), "whatever the names");
    found.remove(1)
}

#[test]
fn bytes_that_two_stages_read_as_different_types_are_reported() {
    let found = pair("mat4 clip; vec4 tint;", "vec4 tint; float k;");
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(
        said(&found[0]),
        "2:44 push constants `Q` read bytes as `tint` (`vec4` at 0) that s/a.vert reads as `clip` \
         (`mat4` at 0)"
    );
    assert_eq!(found[0].notes[1], "`k` (`float` at 16) and `clip` (`mat4` at 0)");
    for (vertex, fragment) in [
        ("vec4 a;", "float b;"),
        ("vec4 a; uint n;", "vec4 a; float n;"),
        ("vec4 a[4];", "layout(offset = 48) vec2 b;"),
        ("layout(row_major) mat4 m;", "mat4 m;"),
    ] {
        assert_eq!(pair(vertex, fragment).len(), 1, "{vertex} and {fragment}");
    }
}

#[test]
fn stages_that_agree_on_every_byte_they_share_are_not() {
    for (vertex, fragment) in [
        ("mat4 clip; vec4 tint;", "mat4 clip; vec4 tint;"),
        ("mat4 clip; vec4 tint;", "layout(offset = 64) vec4 tint;"),
        ("mat4 clip;", "layout(offset = 64) vec4 tint; float k;"),
        ("vec4 a[4];", "vec4 b[2];"),
        ("vec4 a[4];", "layout(offset = 16) vec4 b;"),
        ("mat4 clip; vec4 tint;", "mat4 view;"),
    ] {
        assert_eq!(pair(vertex, fragment), [], "{vertex} and {fragment}");
    }
}

#[test]
fn immediates_of_wgsl_likewise() {
    let module = |vertex: &str, fragment: &str, uses: (&str, &str)| {
        format!(
            "struct A {{ {vertex} }}\nstruct B {{ {fragment} }}\n\
             var<immediate> a: A;\nvar<immediate> b: B;\n\
             @vertex fn v() -> @builtin(position) vec4f {{ return vec4f({}); }}\n\
             @fragment fn f() -> @location(0) vec4f {{ return vec4f({}); }}\n",
            uses.0, uses.1
        )
    };
    let apart = module("x: vec4f", "y: mat4x4f", ("a.x.x", "b.y[0].x"));
    assert_eq!(mismatches(&[("m.wgsl", &apart)]).len(), 1);
    let same = module("x: vec4f", "y: vec4f, z: f32", ("a.x.x", "b.z"));
    assert_eq!(mismatches(&[("m.wgsl", &same)]), []);
    let one = module("x: vec4f", "y: mat4x4f", ("a.x.x", "a.x.y"));
    assert_eq!(mismatches(&[("m.wgsl", &one)]), []);
    let file = |member: &str| {
        format!("struct I {{ {member} }}\nvar<immediate> i: I;\n")
    };
    let (vertex, fragment) = (file("x: mat4x4f"), file("y: vec3u"));
    assert_eq!(mismatches(&[("a.vert.wgsl", &vertex), ("a.frag.wgsl", &fragment)]).len(), 1);
    assert_eq!(mismatches(&[("a.wgsl", &vertex), ("b.wgsl", &fragment)]), []);
}
