// 128 directional lights, 128 point lights and an ambient light, in three uniform blocks.
//
// WGSL puts every member where std140 puts it here, because every struct holds a
// vec3f: 32 bytes a directional light, 48 a point light, the counts at 4096 and 6144.

const DIRECTIONAL_LIGHT_MAX_NUM = 128;
const POINT_LIGHT_MAX_NUM = 128;

struct Ambient {
    color: vec3f,   // offset 0
    intensity: f32, // offset 12
}

struct DirectionalLight {
    dir: vec3f,     // offset 0, the way the light travels
    color: vec3f,   // offset 16
    intensity: f32, // offset 28
}

struct PointLight {
    pos: vec3f,     // offset 0
    color: vec3f,   // offset 16
    intensity: f32, // offset 28

    constant: f32,  // offset 32
    linear: f32,    // offset 36
    quadratic: f32, // offset 40
}

struct AmbientBlock {
    data: Ambient, // offset 0
}

struct DirectionalLightBlock {
    data: array<DirectionalLight, DIRECTIONAL_LIGHT_MAX_NUM>, // offset 0
    actually_used_count: i32,                                 // offset 4096
}

struct PointLightBlock {
    data: array<PointLight, POINT_LIGHT_MAX_NUM>, // offset 0
    actually_used_count: i32,                     // offset 6144
}

struct ViewBlock {
    projection_view: mat4x4f,           // offset 0
    view_pos: vec3f,                    // offset 64
    specular_highlight_shininess: f32,  // offset 76
}

struct ObjectBlock {
    model: mat4x4f,         // offset 0
    normal_matrix: mat3x3f, // offset 64
}

@group(0) @binding(0) var<uniform> u_ambient: AmbientBlock;
@group(0) @binding(1) var<uniform> u_directional_light_array: DirectionalLightBlock;
@group(0) @binding(2) var<uniform> u_point_light_array: PointLightBlock;
@group(0) @binding(3) var<uniform> u_view: ViewBlock;

@group(1) @binding(0) var u_diffuse_texture: texture_2d<f32>;
@group(1) @binding(1) var u_specular_texture: texture_2d<f32>;
@group(1) @binding(2) var u_sampler: sampler;

@group(2) @binding(0) var<uniform> u_object: ObjectBlock;

struct Surface {
    @builtin(position) clip: vec4f,
    @location(0) frag_pos: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
}

@vertex
fn vertex_main(
    @location(0) pos: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
) -> Surface {
    let world = u_object.model * vec4f(pos, 1.0);
    return Surface(u_view.projection_view * world, world.xyz, u_object.normal_matrix * normal, uv);
}

// Unit vector along v; the zero vector stays zero.
fn unit(v: vec3f) -> vec3f {
    return v * inverseSqrt(max(dot(v, v), 1.0e-30));
}

// Set SQUARINGS where the shininess is known to be 2 to that power: so many squarings take a
// third of the time of any power. -1 is any shininess.
override SQUARINGS: i32 = -1;

// (1 - m)^n for m >= 0 and n >= 0, as exp(n log(1 - m)); 0 from m = 1 on. Where 1 - m has
// lost the digits of m, the logarithm is taken from m itself, by its series.
fn power(m: f32, n: f32) -> f32 {
    if SQUARINGS >= 0 {
        var x = max(1.0 - m, 0.0);
        for (var i = 0; i < SQUARINGS; i++) {
            x *= x;
        }
        return x;
    }
    let series = m * (1.0 + m * (1.0 / 2.0 + m * (1.0 / 3.0 + m * (1.0 / 4.0 + m * (1.0 / 5.0 + m / 6.0)))));
    let exponent = select(-log(max(1.0 - m, 1.0e-30)), series, m < 0.015625);
    return select(0.0, exp(-n * exponent), m < 1.0);
}

// Phong's highlight. The eye is mirrored, not the light: that is the same for all lights
// of a fragment. 1 - cos is half the squared chord, which stays exact where the cosine is
// nearly 1. A light behind the surface has no highlight.
fn highlight(light_dir: vec3f, normal: vec3f, view_dir: vec3f, shininess: f32) -> f32 {
    let chord = light_dir - reflect(-view_dir, normal);
    let m = select(1.0, 0.5 * dot(chord, chord), dot(normal, light_dir) > 0.0);
    return power(m, shininess);
}

// 1 / (constant + linear d + quadratic d^2), kept finite when nothing has been set yet.
fn attenuation(constant: f32, linear: f32, quadratic: f32, d: f32) -> f32 {
    return 1.0 / max(constant + d * (linear + quadratic * d), 1.0e-4);
}

// What one directional light adds: no distance, so no attenuation.
fn directional_light(light: DirectionalLight, normal: vec3f, view_dir: vec3f, diffuse_texel: vec3f, specular_texel: vec3f) -> vec3f {
    let light_dir = unit(-light.dir);
    let diffuse = max(dot(normal, light_dir), 0.0);
    let specular = highlight(light_dir, normal, view_dir, u_view.specular_highlight_shininess);
    return light.color * light.intensity * (diffuse * diffuse_texel + specular * specular_texel);
}

// What one point light adds. `normal` and `view_dir` are unit vectors away from the surface.
fn point_light(light: PointLight, frag_pos: vec3f, normal: vec3f, view_dir: vec3f, diffuse_texel: vec3f, specular_texel: vec3f) -> vec3f {
    let offset = light.pos - frag_pos;
    let d2 = dot(offset, offset);
    let inverse_d = inverseSqrt(max(d2, 1.0e-30)); // one root for direction and distance
    let light_dir = offset * inverse_d;

    let diffuse = max(dot(normal, light_dir), 0.0);
    let specular = highlight(light_dir, normal, view_dir, u_view.specular_highlight_shininess);

    let weakening = attenuation(light.constant, light.linear, light.quadratic, d2 * inverse_d);
    return light.color * (light.intensity * weakening) * (diffuse * diffuse_texel + specular * specular_texel);
}

@fragment
fn fragment_main(in: Surface) -> @location(0) vec4f {
    let diffuse_texel = textureSample(u_diffuse_texture, u_sampler, in.uv).rgb;
    let specular_texel = textureSample(u_specular_texture, u_sampler, in.uv).rgb;
    let normal = unit(in.normal);
    let view_dir = unit(u_view.view_pos - in.frag_pos);

    var total = u_ambient.data.color * u_ambient.data.intensity * diffuse_texel;

    let directional_count = clamp(u_directional_light_array.actually_used_count, 0, DIRECTIONAL_LIGHT_MAX_NUM);
    for (var i = 0; i < directional_count; i++) {
        total += directional_light(u_directional_light_array.data[i], normal, view_dir, diffuse_texel, specular_texel);
    }

    // The unused tail of the array is whatever the buffer held, so stop at the count,
    // and never read past the array when the count is wrong.
    let point_count = clamp(u_point_light_array.actually_used_count, 0, POINT_LIGHT_MAX_NUM);
    for (var i = 0; i < point_count; i++) {
        total += point_light(u_point_light_array.data[i], in.frag_pos, normal, view_dir, diffuse_texel, specular_texel);
    }

    return vec4f(total, 1.0);
}
