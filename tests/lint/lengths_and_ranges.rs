//! Arrays whose lengths are specialised, or taken from their uses, before other members; push
//! constants and immediates of the stages of one program. Offsets are computed by hand from OpenGL
//! 4.6 §7.6.2.2, those of glslang read from its SPIR-V.

use landfall_layout::Options;
use landfall_layout::finding::Finding;
use landfall_lint::Settings;

use crate::asked::{asked, help, said};

/// What a lint finds in shaders that are laid out without errors.
fn found_in(code: &str, files: &[(&str, &str)], given: &[(&str, &str)]) -> Vec<Finding> {
    let mut options = Options::default();
    options.read.overrides =
        given.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect();
    asked(code, files, &options, &Settings::default())
}

fn specialised(declarations: &str, given: &[(&str, &str)]) -> Vec<Finding> {
    let text = format!(
        "#version 450\nlayout(constant_id = 3) const int COUNT = 6;\n{declarations}\nvoid main() {{}}\n"
    );
    found_in("specialised-length", &[("a.frag", &text)], given)
}

fn block(members: &str) -> String {
    format!("layout(std430, set = 0, binding = 0) buffer B {{ {members} }} b;")
}

#[test]
fn members_behind_an_array_of_specialised_length_are_named_with_their_byte() {
    // std430: 6 * 4 = 24.
    let all = specialised(&block("uint a[COUNT]; float b;"), &[]);
    assert_eq!(all.len(), 1, "{all:?}");
    assert_eq!(
        said(&all[0]),
        "3:54 `b` stays at byte 24 behind `a`, whose length depends on the specialisation of `COUNT`"
    );
    assert_eq!(help(&all[0]), "move `a` to the end of the block");
    let all = specialised(&block("uint a[COUNT]; float b;"), &[("COUNT", "10")]);
    assert_eq!(all[0].notes[1], "with the 10 elements of `-O`, `a` takes 40 bytes and lies on `b`");
    let all = specialised(&block("uint a[COUNT];"), &[("3", "10")]);
    assert_eq!(
        said(&all[0]),
        "3:54 `a` ends at byte 40 with the 10 elements of `-O`, but its block is laid out for those \
         up to byte 24"
    );
    for members in [
        // The next element is behind it as well.
        "struct S { float w[COUNT]; };\n",
        "struct S { float w[COUNT]; float n; };\n",
    ] {
        let all = specialised(&format!("{members}{}", block("S s[2];")), &[]);
        assert_eq!(all.len(), 1, "{members}: {all:?}");
    }
}

#[test]
fn arrays_of_specialised_length_that_move_nothing_are_not_reported() {
    for (declarations, given) in [
        (block("float b; uint a[COUNT];"), None),
        (block("float b; uint a[COUNT];"), Some("3")),
        (block("uint a[6]; float b;"), None),
        (block("uint a[COUNT]; layout(offset = 512) float b;"), Some("10")),
        (format!("struct S {{ float w[COUNT]; float n; }};\n{}", block("vec4 a;")), None),
        (block("vec4 a;").replace("set = 0", "set = COUNT - 6"), None),
    ] {
        let given: Vec<_> = given.iter().map(|value| ("COUNT", *value)).collect();
        assert_eq!(specialised(&declarations, &given), [], "{declarations}");
    }
}

/// The offsets are those of glslang 12 and of Mesa, which `by_use` reads.
#[test]
fn members_behind_an_array_without_a_length_are_elsewhere_in_glslangs_spirv() {
    let text = "#version 450\nlayout(local_size_x = 1) in;\n\
                layout(set = 0, binding = 0, std430) buffer C {\n    vec3 a[]; float b[]; vec4 c;\n} u;\n\
                void main() { u.c = vec4(u.a[2], u.b[4]); }\n";
    let found = |text: &str| found_in("length-from-use", &[("a.comp", text)], &[]);
    let finding = found(text).remove(0);
    assert_eq!(
        said(&finding),
        "4:21 `b` is at byte 48, but glslang writes 16 into SPIR-V: `a` has no length of its own"
    );
    assert_eq!(help(&finding), "write `a[3]`");
    // One element is what glslang counts, and the last of a `buffer` has no length.
    let first = text.replace("u.c = vec4(u.a[2], u.b[4]);", "u.c = vec4(u.a[0], u.b[0]);");
    assert_eq!(found(&first), []);
    let last = text.replace("vec4 c;", "vec4 c[];").replace("u.c =", "u.c[7] =");
    assert_eq!(found(&last).len(), 1, "{last}");
    let sized = text.replace("a[]", "a[3]").replace("b[]", "b[5]");
    assert_eq!(found(&sized), []);
}

fn mismatches(files: &[(&str, &str)]) -> Vec<Finding> {
    found_in("block-mismatch", files, &[])
}

fn glsl(name: &str, members: &str) -> String {
    format!(
        "#version 450\nlayout(push_constant) uniform {name} {{ {members} }} pc;\nvoid main() {{}}\n"
    )
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
        "2:40 push constants `Q` read bytes as `tint` (`vec4` at 0) that s/a.vert reads as `clip` \
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
    let file = |member: &str| format!("struct I {{ {member} }}\nvar<immediate> i: I;\n");
    let (vertex, fragment) = (file("x: mat4x4f"), file("y: vec3u"));
    assert_eq!(mismatches(&[("a.vert.wgsl", &vertex), ("a.frag.wgsl", &fragment)]).len(), 1);
    assert_eq!(mismatches(&[("a.wgsl", &vertex), ("b.wgsl", &fragment)]), []);
}
