// A textured surface: every kind of texture and sampler, vertex inputs of a structure and of
// parameters, a group that is not used, and names that local variables hide.

struct Camera {
    view_projection: mat4x4f,
    eye: vec3f,
}

struct Light {
    position: vec3f,
    color: vec3f,
}

struct Lights {
    count: u32,
    all: array<Light>,
}

alias Albedo = texture_2d<f32>;

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(3) var<storage> lights: Lights;
@group(0) @binding(5) var<storage, read> tints: array<vec4f>;
@group(2) @binding(0) var albedo: Albedo;
@group(2) @binding(1) var linear: sampler;
@group(2) @binding(2) var shadows: texture_depth_2d_array;
@group(2) @binding(3) var compare: sampler_comparison;
@group(2) @binding(4) var sky: texture_cube<f32>;
@group(2) @binding(5) var samples: texture_multisampled_2d<f32>;
@group(2) @binding(6) var ids: texture_2d<u32>;
@group(2) @binding(7) var nearest: sampler;
@group(2) @binding(8) var levels: texture_3d<i32>;
@group(2) @binding(9) var probes: texture_cube_array<f32>;
@group(2) @binding(10) var depth_samples: texture_depth_multisampled_2d;
@group(2) @binding(11) var line: texture_1d<f32>;
// Declared, but no entry point uses it.
@group(1) @binding(0) var<uniform> spare: Camera;

struct Corner {
    @location(0) position: vec3f,
    @location(2) uv: vec2f,
    @builtin(vertex_index) index: u32,
}

struct Varyings {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) uv: vec2f,
}

@vertex
fn corner(
    in: Corner,
    @location(5) offset: vec4i,
    @builtin(instance_index) instance: u32,
    @location(1) weight: f32,
    @location(4) flags: vec2u,
) -> Varyings {
    // Hides the storage buffer, which only the fragment shader uses.
    let lights = vec3f(offset.xyz) * f32(instance + in.index + flags.x);
    let world = in.position * weight + lights;
    return Varyings(camera.view_projection * vec4f(world, 1.0), world, in.uv);
}

fn lit(world: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    for (var tints = 0u; tints < lights.count; tints++) {
        sum += lights.all[tints].color / distance(lights.all[tints].position, world);
    }
    // The loop's variable is gone.
    return sum * tints[0].rgb;
}

fn shadow(uv: vec2f) -> f32 {
    return textureSampleCompareLevel(shadows, compare, uv, 1, 0.5)
        + textureLoad(depth_samples, vec2i(0), 0);
}

@fragment
fn shade(in: Varyings) -> @location(0) vec4f {
    let base = textureSample(albedo, linear, in.uv);
    let id = textureGather(0, ids, nearest, in.uv);
    let level = textureLoad(levels, vec3i(0), 0).x;
    let ambient = textureSample(sky, linear, in.world)
        + textureSample(probes, linear, in.world, 1)
        + textureLoad(samples, vec2i(0), 0)
        + textureSample(line, linear, in.uv.x);
    return base * (ambient + vec4f(lit(in.world), f32(level) + f32(id.x))) * shadow(in.uv);
}
