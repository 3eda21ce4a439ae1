//! Members and blocks that no function reads or writes, by naga's module.

use crate::lints_b::{found, one, said};

const CAMERA: &str = "\
#version 450
layout(std140, set = 0, binding = 0) uniform Camera {
    mat4 view;
    mat4 projection;
} camera;
layout(location = 0) in vec4 at;
void main() { gl_Position = camera.view * at; }
";

#[test]
fn a_member_that_nothing_reads_is_reported() {
    let finding = one("unused-member", "a.vert", CAMERA);
    assert_eq!(
        said(&finding),
        "4:10 no function reads or writes `projection` of `Camera`, 64 bytes"
    );
    assert_eq!(finding.about, "Camera.projection");
    let good = CAMERA.replace("camera.view * at", "camera.projection * camera.view * at");
    assert_eq!(found("unused-member", "a.vert", &good), []);
}

#[test]
fn a_block_that_nothing_reads_is_reported_once_and_not_its_members() {
    let text = CAMERA.replace("camera.view * at", "at");
    let finding = one("unused-block", "a.vert", &text);
    assert_eq!(said(&finding), "2:46 no function reads or writes block `Camera`, 128 bytes");
    assert_eq!(found("unused-member", "a.vert", &text), []);
    assert_eq!(found("unused-block", "a.vert", CAMERA), []);
}

#[test]
fn members_of_a_block_without_instance_are_followed_too() {
    let text = "\
#version 450
layout(std140, set = 0, binding = 0) uniform Camera { mat4 view; mat4 projection; };
void main() { gl_Position = view[0]; }
";
    let finding = one("unused-member", "a.vert", text);
    assert_eq!(finding.about, "Camera.projection");
}

const LIGHTS: &str = "\
struct Light { color: vec3f, range: f32, at: vec3f }
struct Lights { count: u32, data: array<Light> }
@group(0) @binding(0) var<storage> lights: Lights;
@fragment fn main() -> @location(0) vec4f {
    var sum = vec3f();
    for (var i = 0u; i < lights.count; i++) {
        sum += lights.data[i].color * lights.data[i].range;
    }
    return vec4f(sum, 1.0);
}
";

#[test]
fn a_member_of_a_structure_in_an_array_is_followed() {
    let finding = one("unused-member", "a.wgsl", LIGHTS);
    assert_eq!(said(&finding), "1:42 no function reads or writes `at` of `Light`, 12 bytes");
}

#[test]
fn a_structure_copied_as_a_whole_uses_all_its_members() {
    let text = |copy: &str| {
        LIGHTS.replace(
            "sum += lights.data[i].color * lights.data[i].range;",
            &format!("{copy} light = lights.data[i]; sum += light.color * light.range;"),
        )
    };
    assert_eq!(found("unused-member", "a.wgsl", &text("var")), []);
    // A name for the value is no copy: what is read of it can be told.
    assert_eq!(one("unused-member", "a.wgsl", &text("let")).about, "Light.at");
}

#[test]
fn what_is_read_and_thrown_away_is_read() {
    let text = "\
struct Light { color: vec4f, at: vec4f }
@group(0) @binding(0) var<uniform> a: Light;
@group(0) @binding(1) var<uniform> b: vec4f;
@group(0) @binding(2) var<storage> c: array<Light>;
@fragment fn main() -> @location(0) vec4f {
    let color = a.color;
    let whole = c[1];
    let at = whole.at;
    _ = b;
    return vec4f();
}
";
    assert_eq!(found("unused-block", "a.wgsl", text), []);
    // Of `Light` one variable reads `color` and the other `at`.
    assert_eq!(found("unused-member", "a.wgsl", text), []);
}

#[test]
fn a_structure_passed_by_pointer_or_written_is_used() {
    let text = "\
struct Particle { at: vec3f, age: f32 }
@group(0) @binding(0) var<storage, read_write> one: Particle;
fn grow(age: ptr<storage, f32, read_write>) { *age += 1.0; }
@compute @workgroup_size(1) fn main() { grow(&one.age); one.at = vec3f(); }
";
    assert_eq!(found("unused-member", "a.wgsl", text), []);
}

#[test]
fn a_structure_that_one_variable_uses_is_used() {
    let text = "\
struct Light { color: vec4f, at: vec4f }
@group(0) @binding(0) var<uniform> a: Light;
@group(0) @binding(1) var<uniform> b: Light;
@fragment fn main() -> @location(0) vec4f { return a.color + b.at; }
";
    assert_eq!(found("unused-member", "a.wgsl", text), []);
    let text = text.replace("b.at", "b.color");
    assert_eq!(one("unused-member", "a.wgsl", &text).about, "Light.at");
}

#[test]
fn names_that_say_padding_are_left_alone() {
    let text = LIGHTS.replace("at: vec3f", "_pad: vec3f");
    assert_eq!(found("unused-member", "a.wgsl", &text), []);
}

#[test]
fn no_claim_is_made_of_a_library_or_of_a_text_with_variants() {
    let library = LIGHTS.replace("@fragment ", "").replace("@location(0) ", "");
    assert_eq!(found("unused-member", "a.wgsl", &library), []);
    let variants = CAMERA.replace("void main", "#ifdef FAR\n#endif\nvoid main");
    assert_eq!(found("unused-member", "a.vert", &variants), []);
    // Nor of a text that naga refuses.
    let old = CAMERA.replace("450", "330").replace(", set = 0, binding = 0", "");
    assert_eq!(found("unused-member", "a.vert", &old), []);
}
