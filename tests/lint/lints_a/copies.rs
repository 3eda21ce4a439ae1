//! `block-mismatch`.

use std::process::Command;

use landfall_layout::finding::{Finding, Place};
use landfall_lint::Settings;
use landfall_lint::settings::{MirrorCopy, MirrorGroup};
use snapbox::str;

use super::{found, messages, only, place};
use crate::support::command::golden;

const CODE: &str = "block-mismatch";

fn mismatches(files: &[(&str, &str)]) -> Vec<Finding> {
    found(CODE, files, &Settings::default())
}

/// A fragment or vertex shader of OpenGL 3.3 with one std140 block.
fn shader(members: &str) -> String {
    format!(
        "#version 330 core\nlayout(std140) uniform Light {{\n{members}\n}} u_light;\n\
         void main() {{ }}\n"
    )
}

/// The same for Vulkan.
fn vulkan(slot: &str, name: &str, members: &str) -> String {
    format!(
        "#version 450\nlayout(set = 0, binding = {slot}) uniform {name} {{\n{members}\n}} u;\n\
         void main() {{ }}\n"
    )
}

const GOOD: &str = "vec3 position;\nvec3 color;\nfloat intensity;\nmat4 view;";

#[test]
fn stages_that_swap_two_members_are_told_with_both_offsets() {
    let bad = "vec3 color;\nvec3 position;\nfloat intensity;\nmat4 view;";
    let (vert, frag) = (shader(GOOD), shader(bad));
    let finding = only(mismatches(&[("s/lit.vert", &vert), ("s/lit.frag", &frag)]));
    assert_eq!(
        finding.message,
        "block `Light` is declared differently in s/lit.vert: `color` is at offset 0 here and 16 \
         there, and 1 more difference"
    );
    assert_eq!(finding.notes, ["`position` is at offset 16 here and 0 there"]);
    assert_eq!((finding.place().path.as_str(), place(&finding).as_str()), ("s/lit.frag", "3:6"));
    let other = &finding.related()[0].at;
    assert_eq!((other.path.as_str(), other.line, other.column), ("s/lit.vert", 4, 6));
    assert_eq!(finding.about, "Light");
    assert!(finding.listing.is_some() && finding.help.is_some());
    assert_eq!(messages(&mismatches(&[("s/lit.vert", &vert), ("s/lit.frag", &vert)])), [""; 0]);
}

#[test]
fn what_is_reported_between_opengl_stages_does_not_link() {
    let others = [
        ("vec3 color;\nvec3 position;\nfloat intensity;\nmat4 view;", false),
        ("vec3 position;\nvec4 color;\nfloat intensity;\nmat4 view;", false),
        ("vec3 position;\nvec3 color;\nfloat intensity;", false),
        ("vec3 position;\nvec3 color;\nfloat intensity;\nmat4 view;\nfloat more;", false),
        ("vec3 position;\nvec3 tint;\nfloat intensity;\nmat4 view;", false),
        ("vec3 position;\nvec3 color;\nfloat intensity[2];\nmat4 view;", false),
        (GOOD, true),
        ("vec3 position, color; float intensity; mat4 view;", true),
    ];
    let folder = std::env::temp_dir().join(format!("landfall-copies-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for (members, same) in others {
        // Both stages use the block, so that the linker has to look at it.
        let vert = shader(GOOD).replace("{ }", "{ gl_Position = u_light.view[0]; }");
        let frag = shader(members).replace(
            "void main() { }",
            "out vec4 o; void main() { o = vec4(u_light.position, 1.0); }",
        );
        let paths = [folder.join("lit.vert"), folder.join("lit.frag")];
        std::fs::write(&paths[0], &vert).unwrap();
        std::fs::write(&paths[1], &frag).unwrap();
        let linked = Command::new("glslangValidator").arg("-l").args(&paths).output();
        let linked = linked.expect("glslangValidator (Debian: glslang-tools) runs");
        let said = String::from_utf8_lossy(&linked.stdout).into_owned();
        assert_eq!(linked.status.success(), same, "{members}: {said}");
        let findings = mismatches(&[("s/lit.vert", &vert), ("s/lit.frag", &frag)]);
        assert_eq!(findings.len(), usize::from(!same), "{members}: {:#?}", messages(&findings));
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn types_counts_strides_and_majorness_are_told() {
    let cases = [
        ("vec4 color;", "vec3 color;", "`color` is a `vec4` here and a `vec3` there"),
        ("vec4 a[3];", "vec4 a[4];", "`a[]` is a `vec4[3]` here and a `vec4[4]` there"),
        ("layout(row_major) mat4 m;", "mat4 m;", "`m` is row-major here and column-major there"),
        (
            "layout(row_major) mat2x3 m;",
            "mat2x3 m;",
            "`m` is row-major here and column-major there",
        ),
        ("int n;", "uint n;", "`n` is a `int` here and a `uint` there"),
    ];
    for (here, there, text) in cases {
        let (vert, frag) =
            (shader(&format!("vec4 z; {there}")), shader(&format!("vec4 z; {here}")));
        let finding = only(mismatches(&[("lit.vert", &vert), ("lit.frag", &frag)]));
        assert!(finding.message.ends_with(text), "{}", finding.message);
    }
    let std430 =
        "#version 430\nlayout(std430, binding = 0) buffer B { float w[4]; } b; void main() { }";
    let std140 = std430.replace("std430", "std140");
    let finding = only(mismatches(&[("a.vert", std430), ("a.frag", &std140)]));
    golden().eq(&finding.message, str!["block `B` is declared differently in a.vert: `w[]` has an array stride of 16 here and 4 there"]);
}

#[test]
fn the_odd_one_out_is_reported_not_the_many() {
    let odd = shader(&GOOD.replace("vec3 color", "float pad; vec3 color"));
    let good = shader(GOOD);
    let files: Vec<(&str, &str)> =
        vec![("s/a.frag", &odd), ("s/a.geom", &good), ("s/a.tese", &good), ("s/a.vert", &good)];
    let finding = only(mismatches(&files));
    assert_eq!(finding.place().path, "s/a.frag");
    golden().eq(&finding.message, str!["block `Light` is declared differently in s/a.geom: `pad` (`float` at offset 12) is only here"]);
}

#[test]
fn blocks_that_only_share_a_name_are_let_be() {
    let other = "mat4 bones[16];\nint count;";
    let apart = [("s/a.frag", shader(GOOD)), ("s/b.vert", shader(other))];
    let files: Vec<(&str, &str)> =
        apart.iter().map(|(path, text)| (*path, text.as_str())).collect();
    assert_eq!(messages(&mismatches(&files)), [""; 0]);
    // In another directory it is another program's, even if it looks like a copy.
    let drifted = shader(&GOOD.replace("vec3 color", "vec4 color"));
    let good = shader(GOOD);
    assert_eq!(messages(&mismatches(&[("s/a.frag", &good), ("t/a.vert", &drifted)])), [""; 0]);
    // So it is under another name in the same directory.
    assert_eq!(messages(&mismatches(&[("s/a.frag", &good), ("s/b.vert", &drifted)])), [""; 0]);
    assert_eq!(mismatches(&[("s/a.frag", &good), ("s/a.comp", &drifted)]).len(), 1);
    // Other programs may read the first members only.
    let head = shader("vec3 position;\nvec3 color;\nfloat intensity;");
    assert_eq!(messages(&mismatches(&[("s/a.frag", &good), ("s/a.comp", &head)])), [""; 0]);
}

#[test]
fn files_that_include_one_declaration_are_compared() {
    let folder = std::env::temp_dir().join(format!("landfall-family-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let frame = "layout(std140) uniform Frame { mat4 view; float time; } u_frame;\n";
    std::fs::write(folder.join("frame.glsl"), frame).unwrap();
    std::fs::write(folder.join("noise.glsl"), "float noise(float x) { return fract(x); }\n")
        .unwrap();
    let path = |name: &str| folder.join(name).to_str().unwrap().to_string();
    let with = |include: &str, members: &str| {
        shader(members).replace("core\n", &format!("core\n#include \"{include}\"\n"))
    };
    let drifted = GOOD.replace("vec3 color", "vec4 color");
    let (sky, sea) = (path("sky.frag"), path("sea.frag"));
    for (include, findings) in [("frame.glsl", 1), ("noise.glsl", 0)] {
        let (a, b) = (with(include, GOOD), with(include, &drifted));
        let found = mismatches(&[(&sky, &a), (&sea, &b)]);
        assert_eq!(found.len(), findings, "{include}: {:#?}", messages(&found));
    }
    // One declaration under other macros is `define-changes-layout`'s.
    let counted = "layout(std140) uniform Light { vec3 a; vec3 b; vec3 c; float w[N]; } u_light;\n";
    std::fs::write(folder.join("counted.glsl"), counted).unwrap();
    let with = |n: u32| {
        format!("#version 330 core\n#define N {n}\n#include \"counted.glsl\"\nvoid main() {{ }}\n")
    };
    let (a, b) = (with(1), with(2));
    assert_eq!(messages(&mismatches(&[(&sky, &a), (&sea, &b)])), [""; 0]);
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_member_that_is_missing_is_shown_where_it_would_stand() {
    let (vert, frag) =
        (shader("vec4 a;\nvec4 b;\nvec4 c;\nvec4 end;"), shader("vec4 a;\nvec4 b;\nvec4 c;"));
    let finding = only(mismatches(&[("s/lit.vert", &vert), ("s/lit.frag", &frag)]));
    assert!(finding.message.ends_with("`end` (`vec4` at offset 48) is only there"));
    // The last member there is, not the block.
    assert_eq!((finding.place().path.as_str(), place(&finding).as_str()), ("s/lit.frag", "5:6"));
    assert_eq!(finding.related()[0].at.line, 6);
}

#[test]
fn in_vulkan_names_are_free_and_slots_tell_blocks_apart() {
    let a = vulkan("0", "Ubo", "mat4 view; vec3 eye; float time;");
    let renamed = vulkan("0", "Ubo", "mat4 camera; vec3 eye; float time;");
    let head = vulkan("0", "Ubo", "mat4 view; vec3 eye;");
    let elsewhere = vulkan("1", "Ubo", "vec4 tint; float time;");
    for fine in [&renamed, &head, &elsewhere] {
        assert_eq!(messages(&mismatches(&[("a.vert", &a), ("a.frag", fine)])), [""; 0], "{fine}");
    }
    let moved = vulkan("0", "Ubo", "vec3 eye; mat4 view; float time;");
    assert_eq!(mismatches(&[("a.vert", &a), ("a.frag", &moved)]).len(), 1);
}

#[test]
fn one_binding_under_two_names_is_one_buffer() {
    let a = vulkan("0", "Camera", "mat4 view; vec3 eye; float time;");
    let same = vulkan("0", "Eye", "mat4 v; vec3 e; float t;");
    let other = vulkan("0", "Eye", "mat4 v; vec4 e;");
    assert_eq!(messages(&mismatches(&[("a.vert", &a), ("a.frag", &same)])), [""; 0]);
    let finding = only(mismatches(&[("a.vert", &a), ("a.frag", &other)]));
    golden().eq(finding.message, str!["block `Eye` has the same binding as `Camera` in a.vert but another layout: the `mat4` at offset 0 is named `v` here and `view` there, and 3 more differences"]);
}

#[test]
fn wgsl_modules_of_one_base_name_are_compared() {
    let module = |pick: &str| {
        format!(
            "struct Frame {{ view: mat4x4f, inverse: mat4x4f, pick: {pick}, id: u32 }}\n\
             @group(0) @binding(0) var<uniform> frame: Frame;\n"
        )
    };
    let (a, b) = (module("vec2f"), module("vec2u"));
    let finding = only(mismatches(&[("s/a.vert.wgsl", &a), ("s/a.frag.wgsl", &b)]));
    golden().eq(&finding.message, str!["block `Frame` is declared differently in s/a.vert.wgsl: `pick` is a `vec2<u32>` here and a `vec2<f32>` there"]);
}

#[test]
fn many_blocks_of_one_name_cost_little_and_say_nothing() {
    let texts: Vec<(String, String)> = (0..400)
        .map(|n| (format!("s/p{n}.frag"), shader(&format!("{} float q[{}];", GOOD, n + 1))))
        .collect();
    let files: Vec<(&str, &str)> = texts.iter().map(|(p, t)| (p.as_str(), t.as_str())).collect();
    // No one declares a block in four hundred ways by mistake.
    assert_eq!(messages(&mismatches(&files)), [""; 0]);
}

fn copy(file: &str, block: &str) -> MirrorCopy {
    let place = Place { line: 7, ..Place::file("landfall.toml") };
    MirrorCopy { file: file.into(), block: block.into(), place, ..MirrorCopy::default() }
}

fn mirrored(copies: Vec<MirrorCopy>) -> Settings {
    let group = MirrorGroup { name: "lights".into(), copies, place: Place::file("landfall.toml") };
    Settings { mirror_groups: vec![group], ..Settings::default() }
}

const LIGHTS: &str = "#version 330 core
struct PointLight { vec3 pos; vec3 color; float intensity; };
layout(std140) uniform PointLightBlock { PointLight data[4]; int count; } u_lights;
void main() { }
";

#[test]
fn a_mirror_group_holds_copies_under_other_names_together() {
    let wgsl = "struct L { u_position: vec3f, u_color: vec3f, u_intensity: f32 }
        struct Scene { ambient: vec4f, lamps: array<L, 4> }
        @group(0) @binding(0) var<uniform> scene: Scene;";
    let mut other = copy("**/*.wgsl", "scene.lamps[]");
    other.prefix = "u_".to_string();
    other.aliases = vec![("pos".to_string(), "u_position".to_string())];
    let settings = mirrored(vec![copy("*.frag", "data[]"), other]);
    let files = [("gl/lights.frag", LIGHTS), ("web/lights.wgsl", wgsl)];
    assert_eq!(messages(&found(CODE, &files, &settings)), [""; 0]);
    let drifted = wgsl.replace("u_intensity: f32", "u_pad: f32, u_intensity: f32");
    let files = [("gl/lights.frag", LIGHTS), ("web/lights.wgsl", drifted.as_str())];
    let finding = only(found(CODE, &files, &settings));
    assert_eq!(
        finding.message,
        "`lamps[]` differs from `data[]` in gl/lights.frag: `pad` (`f32` at offset 28) is only \
         here, and 1 more difference"
    );
    assert_eq!(finding.notes, ["`intensity` is at offset 32 here and 28 there"]);
    assert_eq!(finding.place().path, "web/lights.wgsl");
    assert_eq!(finding.related()[1].at.path, "landfall.toml");
    assert_eq!(finding.related()[1].text, "mirror group `lights`");
}

#[test]
fn a_mirror_group_may_name_blocks_instances_and_structures() {
    let other = LIGHTS.replace("PointLightBlock", "Lamps").replace("u_lights", "u_lamps");
    let files = [("a/x.frag", LIGHTS), ("b/y.frag", other.as_str())];
    for (first, second) in [
        ("PointLightBlock", "Lamps"),
        ("u_lights", "u_lamps"),
        ("PointLight", "u_lamps.data[]"),
        ("PointLightBlock.data", "PointLight"),
    ] {
        let settings = mirrored(vec![copy("a/*", first), copy("b/*", second)]);
        assert_eq!(messages(&found(CODE, &files, &settings)), [""; 0], "{first} {second}");
        let drifted = other.replace("float intensity", "vec2 size; float intensity");
        let files = [("a/x.frag", LIGHTS), ("b/y.frag", drifted.as_str())];
        assert_eq!(found(CODE, &files, &settings).len(), 1, "{first} {second}");
    }
}

#[test]
fn a_mirror_group_that_leads_nowhere_is_reported_where_it_stands() {
    let files = [("a/x.frag", LIGHTS)];
    let settings = mirrored(vec![copy("", "PointLightBlok"), copy("b/*.frag", "data[]")]);
    let findings = found(CODE, &files, &settings);
    assert_eq!(
        messages(&findings),
        [
            "mirror group `lights`: no shader has `PointLightBlok`",
            "mirror group `lights`: no shader matches `b/*.frag`",
        ]
    );
    assert_eq!(findings[0].help.as_deref(), Some("did you mean `PointLightBlock`?"));
    let of_files = "`file` is a glob relative to the configuration";
    assert_eq!(findings[1].help.as_deref(), Some(of_files));
    assert_eq!((findings[0].place().path.as_str(), findings[0].place().line), ("landfall.toml", 7));
}
