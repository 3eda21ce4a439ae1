// Three bind groups, a runtime-sized tail, a dynamic offset, vertex inputs and overrides; and `clear`,
// which uses a binding of `sum` for another variable, so that the module is several programs.

struct Viewer {
    view: mat4x4f,
    eye: vec3f,
    exposure: f32,
}

struct Object {
    tint: vec3f,
    weights: array<vec4f, 2>,
    id: u32,
}

struct Light {
    position: vec3f,
    reach: f32,
    color: vec3f,
}

struct Lights {
    count: u32,
    all: array<Light>,
}

struct Outcome {
    sum: vec3f,
    id: u32,
    lit: vec2f,
}

override SCALE: f32 = 2.0;
override BIAS: f32;

@group(0) @binding(0) var<uniform> camera: Viewer;
@group(1) @binding(0) var<storage, read> lights: Lights;
@group(2) @binding(0) var<uniform> object: Object;
@group(2) @binding(1) var<storage, read_write> outcomes: array<Outcome>;
@group(2) @binding(1) var<storage, read_write> words: array<u32>;

struct Corner {
    @location(0) place: vec2f,
    @location(3) value: vec3f,
    @location(1) flags: vec2u,
}

struct Varyings {
    @builtin(position) clip: vec4f,
    @location(0) @interpolate(flat) value: vec3f,
    @location(1) @interpolate(flat) flags: vec2u,
}

@vertex
fn corner(in: Corner) -> Varyings {
    return Varyings(camera.view * vec4f(in.place, 0.0, 1.0), in.value, in.flags);
}

@fragment
fn shade(in: Varyings) -> @location(0) vec4f {
    let rgb = in.value * SCALE + object.tint + vec3f(BIAS);
    return vec4f(rgb, f32(in.flags.y) * camera.exposure + object.weights[1].z);
}

@compute @workgroup_size(4)
fn sum(@builtin(global_invocation_id) at: vec3u) {
    var all = vec3f(0.0);
    for (var i = 0u; i < lights.count; i++) {
        all += lights.all[i].color * lights.all[i].reach + lights.all[i].position;
    }
    let lit = vec2f(object.weights[0].y * SCALE, camera.eye.z + BIAS);
    outcomes[object.id * 4u + at.x] = Outcome(all * f32(at.x + 1u), object.id, lit);
}

@compute @workgroup_size(16)
fn clear(@builtin(global_invocation_id) at: vec3u) {
    words[at.x] = 7u;
}
