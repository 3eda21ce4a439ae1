// A point light that weakens with distance.
//
// PointBlock has the same bytes as the std140 block of point_450.frag.

struct Light {
    position: vec3f, // offset 0

    ambient: vec3f,  // offset 16
    diffuse: vec3f,  // offset 32
    specular: vec3f, // offset 48

    constant: f32,   // offset 60
    linear: f32,     // offset 64
    quadratic: f32,  // offset 68, size 80 in all
}

struct ViewBlock {
    viewPos: vec3f, // offset 0
}

struct PointBlock {
    light: Light, // offset 0
}

struct TransformBlock {
    model: mat4x4f,      // offset 0
    view: mat4x4f,       // offset 64
    projection: mat4x4f, // offset 128
    normal: mat3x3f,     // offset 192: inverse transpose of model, WGSL has no inverse()
}

struct MaterialBlock {
    shininess: f32, // offset 0
}

@group(0) @binding(0) var<uniform> view: ViewBlock;
@group(0) @binding(1) var<uniform> lights: PointBlock;
@group(1) @binding(0) var<uniform> transform: TransformBlock;
@group(2) @binding(0) var<uniform> material: MaterialBlock;
@group(2) @binding(1) var materialDiffuse: texture_2d<f32>;
@group(2) @binding(2) var materialSpecular: texture_2d<f32>;
@group(2) @binding(3) var materialSampler: sampler;

struct Surface {
    @builtin(position) clip: vec4f,
    @location(0) fragPos: vec3f,
    @location(1) normal: vec3f,
    @location(2) texCoords: vec2f,
}

@vertex
fn vertex_main(
    @location(0) pos: vec3f,
    @location(1) normal: vec3f,
    @location(2) texCoords: vec2f,
) -> Surface {
    let world = transform.model * vec4f(pos, 1.0);
    return Surface(transform.projection * (transform.view * world), world.xyz, transform.normal * normal, texCoords);
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
fn highlight(toLight: vec3f, normal: vec3f, viewDir: vec3f, shininess: f32) -> f32 {
    let chord = toLight - reflect(-viewDir, normal);
    let m = select(1.0, 0.5 * dot(chord, chord), dot(normal, toLight) > 0.0);
    return power(m, shininess);
}

// 1 / (constant + linear d + quadratic d^2), kept finite when nothing has been set yet.
fn attenuation(constant: f32, linear: f32, quadratic: f32, d: f32) -> f32 {
    return 1.0 / max(constant + d * (linear + quadratic * d), 1.0e-4);
}

// What the light adds. The ambient term is weakened too, so that many such lights do not
// add up to a bright fog.
fn shade(light: Light, normal: vec3f, fragPos: vec3f, viewDir: vec3f, surface: vec3f, gloss: vec3f) -> vec3f {
    let path = light.position - fragPos;
    let d2 = dot(path, path);
    let inverse = inverseSqrt(max(d2, 1.0e-30)); // one root for the direction and the distance
    let toLight = path * inverse;
    let lit = (light.ambient + light.diffuse * max(dot(normal, toLight), 0.0)) * surface
             + light.specular * highlight(toLight, normal, viewDir, material.shininess) * gloss;
    return lit * attenuation(light.constant, light.linear, light.quadratic, d2 * inverse);
}

@fragment
fn fragment_main(in: Surface) -> @location(0) vec4f {
    let surface = textureSample(materialDiffuse, materialSampler, in.texCoords).rgb;
    let gloss = textureSample(materialSpecular, materialSampler, in.texCoords).rgb;
    let viewDir = unit(view.viewPos - in.fragPos);
    return vec4f(shade(lights.light, unit(in.normal), in.fragPos, viewDir, surface, gloss), 1.0);
}
