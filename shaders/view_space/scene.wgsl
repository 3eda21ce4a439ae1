// Ambient, directional, point and spot lights in view space.
//
// WGSL does not round Attenuation up to 16 bytes as std140 does: it is 12 bytes,
// aligned to 4. LightBlock still matches scene_450.frag byte for byte, because
// Attenuation comes last in a struct that a vec3f aligns to 16 anyway.

const MAX_POINT_LIGHTS = 5;
const MAX_SPOT_LIGHTS = 5;

struct Attenuation {
    constant: f32, // offset 0
    linear: f32,   // offset 4
    exponent: f32, // offset 8, the factor of the squared distance
}

struct Material {
    ambient: vec4f,   // offset 0
    diffuse: vec4f,   // offset 16
    specular: vec4f,  // offset 32
    reflectance: f32, // offset 48, 0: no highlight
}

struct AmbientLight {
    intensity: f32, // offset 0
    color: vec3f,   // offset 16
}

struct PointLight {
    position: vec3f,  // offset 0
    color: vec3f,     // offset 16
    intensity: f32,   // offset 28, 0: an unused slot of the array
    att: Attenuation, // offset 32, size 48 in all
}

struct SpotLight {
    pl: PointLight, // offset 0
    conedir: vec3f, // offset 48, the way the light travels
    cutoff: f32,    // offset 60, cosine of the cone's half angle
}

struct DirLight {
    color: vec3f,     // offset 0
    direction: vec3f, // offset 16, towards the light
    intensity: f32,   // offset 28
}

struct LightBlock {
    ambientLight: AmbientLight,                       // offset 0
    pointLights: array<PointLight, MAX_POINT_LIGHTS>, // offset 32
    spotLights: array<SpotLight, MAX_SPOT_LIGHTS>,    // offset 272
    dirLight: DirLight,                               // offset 592
    cameraPosition: vec3f,                            // offset 624
}

struct CameraBlock {
    projectionMatrix: mat4x4f, // offset 0
    viewMatrix: mat4x4f,       // offset 64
}

struct ModelBlock {
    modelMatrix: mat4x4f,  // offset 0
    normalMatrix: mat3x3f, // offset 64: inverse transpose of the model-view matrix
}

@group(0) @binding(0) var<uniform> camera: CameraBlock;
@group(0) @binding(1) var<uniform> lights: LightBlock;
@group(1) @binding(0) var<uniform> material: Material;
@group(1) @binding(1) var txtSampler: texture_2d<f32>;
@group(1) @binding(2) var txtSamplerState: sampler;
@group(2) @binding(0) var<uniform> model: ModelBlock;

struct Surface {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) texCoord: vec2f,
}

@vertex
fn vertex_main(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) texCoord: vec2f,
) -> Surface {
    let seen = camera.viewMatrix * (model.modelMatrix * vec4f(position, 1.0));
    return Surface(camera.projectionMatrix * seen, seen.xyz, unit(model.normalMatrix * normal), texCoord);
}

// Unit vector along v; the zero vector stays zero.
fn unit(v: vec3f) -> vec3f {
    return v * inverseSqrt(max(dot(v, v), 1.0e-30));
}

// Phong's highlight to the power 10. The eye is mirrored, not the light: that is the same
// for all lights of a fragment. 1 - cos is half the squared chord, which stays exact where
// the cosine is nearly 1, and squarings are cheaper than pow and defined at 0. A light
// behind the surface has no highlight.
fn highlight(toLight: vec3f, normal: vec3f, toEye: vec3f) -> f32 {
    let chord = toLight - reflect(-toEye, normal);
    let x = select(0.0, max(1.0 - 0.5 * dot(chord, chord), 0.0), dot(normal, toLight) > 0.0);
    let x2 = x * x;
    let x4 = x2 * x2;
    return x4 * x4 * x2;
}

// 1 / (constant + linear d + exponent d^2), kept finite when nothing has been set yet.
fn attenuation(constant: f32, linear: f32, exponent: f32, d: f32) -> f32 {
    return 1.0 / max(constant + d * (linear + exponent * d), 1.0e-4);
}

// 1 on the axis, falling to 0 at the cone, linear in the cosine.
fn cone(toLight: vec3f, conedir: vec3f, cutoff: f32) -> f32 {
    let chord = toLight + unit(conedir);
    let offAxis = 0.5 * dot(chord, chord); // 1 - cos, exact near the axis
    return max(1.0 - offAxis / max(1.0 - cutoff, 1.0e-9), 0.0);
}

fn calcAmbient(light: AmbientLight, materialAmbient: vec4f) -> vec4f {
    return vec4f(light.intensity * light.color, 1.0) * materialAmbient;
}

// Diffuse and specular reflection of a light without its attenuation.
fn calcLightColor(mat: Material, lightColor: vec3f, intensity: f32, position: vec3f, toLight: vec3f, normal: vec3f) -> vec4f {
    var sum = mat.diffuse * max(dot(normal, toLight), 0.0);
    if mat.reflectance > 0.0 {
        sum += mat.specular * highlight(toLight, normal, unit(lights.cameraPosition - position));
    }
    return vec4f(lightColor, 1.0) * intensity * sum;
}

fn calcPointLight(mat: Material, light: PointLight, position: vec3f, normal: vec3f) -> vec4f {
    let path = light.position - position;
    let d2 = dot(path, path);
    let inverse = inverseSqrt(max(d2, 1.0e-30)); // one root for the direction and the distance
    let weakening = attenuation(light.att.constant, light.att.linear, light.att.exponent, d2 * inverse);
    return calcLightColor(mat, light.color, light.intensity, position, path * inverse, normal) * weakening;
}

// A point light inside a cone.
fn calcSpotLight(mat: Material, light: SpotLight, position: vec3f, normal: vec3f) -> vec4f {
    let inside = cone(unit(light.pl.position - position), light.conedir, light.cutoff);
    if inside <= 0.0 {
        return vec4f();
    }
    return calcPointLight(mat, light.pl, position, normal) * inside;
}

fn calcDirLight(mat: Material, light: DirLight, position: vec3f, normal: vec3f) -> vec4f {
    return calcLightColor(mat, light.color, light.intensity, position, unit(light.direction), normal);
}

@fragment
fn fragment_main(in: Surface) -> @location(0) vec4f {
    let texel = textureSample(txtSampler, txtSamplerState, in.texCoord);
    var mat = material;
    if texel.a > 0.0 { // a transparent texel means: no texture here
        mat.ambient *= texel;
        mat.diffuse *= texel;
    }

    let normal = unit(in.normal);
    var sum = calcAmbient(lights.ambientLight, mat.ambient);
    sum += calcDirLight(mat, lights.dirLight, in.position, normal);

    for (var i = 0; i < MAX_POINT_LIGHTS; i++) {
        if lights.pointLights[i].intensity > 0.0 {
            sum += calcPointLight(mat, lights.pointLights[i], in.position, normal);
        }
    }
    for (var i = 0; i < MAX_SPOT_LIGHTS; i++) {
        if lights.spotLights[i].pl.intensity > 0.0 {
            sum += calcSpotLight(mat, lights.spotLights[i], in.position, normal);
        }
    }

    return vec4f(sum.rgb, mat.diffuse.a);
}
