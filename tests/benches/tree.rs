//! A tree of shaders to measure on: as many files as asked, like those people
//! have, no two alike, the same every time.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use fastrand::Rng;

/// Writes `count` shaders below `dir` and returns their paths.
pub fn write(dir: &Path, count: usize) -> Vec<PathBuf> {
    (0..count)
        .map(|i| {
            let mut rng = Rng::with_seed(i as u64);
            let folder = dir.join(format!("set{:02}", i / 100));
            fs::create_dir_all(&folder).expect("a folder for the bench");
            let (name, text) = match i % 8 {
                0..=4 => (format!("light{i}.frag"), vulkan(&mut rng)),
                5 | 6 => (format!("scene{i}.frag"), legacy(&mut rng)),
                _ => (format!("scene{i}.wgsl"), wgsl(&mut rng)),
            };
            let path = folder.join(name);
            fs::write(&path, text).expect("a shader for the bench");
            path
        })
        .collect()
}

/// A fragment shader of Vulkan's GLSL, which naga takes.
pub fn vulkan(rng: &mut Rng) -> String {
    let lights = rng.u32(2..256);
    let mut text = format!(
        "#version 450\n#define LIGHTS {lights}\nstruct PointLight {{\n    vec3 position; // where it is\n    \
         float range;\n    vec3 color;\n    float intensity;\n}};\n\
         layout(std140, set = 0, binding = 0) uniform Lights {{\n    PointLight data[LIGHTS];\n    int used;\n}} lights;\n\
         layout(std140, set = 0, binding = 1) uniform Camera {{\n    mat4 view;\n    mat4 projection;\n    vec3 eye;\n}} camera;\n\
         layout(location = 0) in vec3 world;\nlayout(location = 1) in vec3 normal;\nlayout(location = 0) out vec4 color;\n"
    );
    for f in 0..rng.u32(1..6) {
        let _ = write!(
            text,
            "vec3 shade{f}(PointLight light, vec3 n, vec3 at) {{\n    vec3 to = light.position - at;\n    \
             float d = max(length(to), 0.0001);\n    float lit = max(dot(n, to / d), 0.0);\n    \
             vec3 h = normalize(to / d + normalize(camera.eye - at));\n    \
             float spec = pow(max(dot(n, h), 0.0), {}.0);\n    \
             return light.color * light.intensity * (lit + spec) / (1.0 + d * d);\n}}\n",
            rng.u32(4..128)
        );
    }
    text.push_str(
        "void main() {\n    vec3 sum = vec3(0.0);\n    for (int i = 0; i < lights.used; i++) {\n        \
         sum += shade0(lights.data[i], normalize(normal), world);\n    }\n    color = vec4(sum, 1.0);\n}\n",
    );
    text
}

/// A fragment shader of desktop GLSL with loose uniforms, which naga does not take.
fn legacy(rng: &mut Rng) -> String {
    vulkan(rng)
        .replace("#version 450", "#version 330 core")
        .replace("layout(std140, set = 0, binding = 0) ", "layout(std140) ")
        .replace("layout(std140, set = 0, binding = 1) ", "layout(std140) ")
        .replace("layout(location = 0) in", "in")
        .replace("layout(location = 1) in", "in")
        .replace(
            "layout(location = 0) out",
            "uniform sampler2D albedo;\nuniform vec3 ambient;\nout",
        )
}

/// The same in WGSL.
fn wgsl(rng: &mut Rng) -> String {
    let lights = rng.u32(2..256);
    let mut text = format!(
        "const LIGHTS = {lights}u;\nstruct PointLight {{\n    position: vec3<f32>,\n    range: f32,\n    \
         color: vec3<f32>,\n    intensity: f32,\n}}\nstruct Lights {{\n    data: array<PointLight, LIGHTS>,\n    used: u32,\n}}\n\
         @group(0) @binding(0) var<uniform> lights: Lights;\n"
    );
    for f in 0..rng.u32(1..6) {
        let _ = write!(
            text,
            "fn shade{f}(light: PointLight, n: vec3<f32>, at: vec3<f32>) -> vec3<f32> {{\n    \
             let to = light.position - at;\n    let d = max(length(to), 0.0001);\n    \
             let lit = max(dot(n, to / d), 0.0);\n    let spec = pow(lit, {}.0);\n    \
             return light.color * light.intensity * (lit + spec) / (1.0 + d * d);\n}}\n",
            rng.u32(4..128)
        );
    }
    text.push_str(
        "@fragment\nfn main(@location(0) at: vec3<f32>, @location(1) n: vec3<f32>) -> @location(0) vec4<f32> {\n    \
         var sum = vec3<f32>(0.0);\n    for (var i = 0u; i < lights.used; i++) {\n        \
         sum += shade0(lights.data[i], normalize(n), at);\n    }\n    return vec4<f32>(sum, 1.0);\n}\n",
    );
    text
}
