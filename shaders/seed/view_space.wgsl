// Ambient, directional, point and spot lights in view space.
//
// WGSL does not round Attenuation up to 16 bytes as std140 does: it is 12 bytes,
// aligned to 4. LightBlock still matches scene_450.frag byte for byte, because
// Attenuation comes last in a struct that a vec3f aligns to 16 anyway.
//
// Seed form: the formulas as a book prints them, with what is wrong with them. The ids
// H1, H2, ... are those of tests/hazards/; view_space/scene.wgsl is the form to use.

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
    let modelViewMatrix = camera.viewMatrix * model.modelMatrix;
    let seen = modelViewMatrix * vec4f(position, 1.0);
    // The inverse transpose of the whole matrix gives a normal a fourth component, by the
    // camera's distance. What normalizing leaves for x, y, z has another length at every
    // vertex, and interpolation bends it (H15).
    let turned = model.normalMatrix * normal;
    let bent = normalize(vec4f(turned, -dot(modelViewMatrix[3].xyz, turned)));
    return Surface(camera.projectionMatrix * seen, seen.xyz, bent.xyz, texCoord);
}

const SPECULAR_POWER = 10.0;

// pow(0, 0) where the material does not reflect and the light is beside the mirrored ray
// (H9); shines from behind the surface too (H13).
fn highlight(toLight: vec3f, normal: vec3f, toEye: vec3f, reflectance: f32) -> f32 {
    let mirrored = normalize(reflect(-toLight, normal));
    let x = max(dot(toEye, mirrored), 0.0);
    return pow(x, select(0.0, SPECULAR_POWER, reflectance > 0.0));
}

// (0, 0, 1) divides by zero on the light itself (H1b); the square overflows (H4).
fn attenuation(constant: f32, linear: f32, exponent: f32, d: f32) -> f32 {
    return 1.0 / (constant + linear * d + exponent * d * d);
}

// With a cutoff of 1 every fragment whose cosine rounds past 1 is divided by zero (H8).
fn cone(toLight: vec3f, conedir: vec3f, cutoff: f32) -> f32 {
    let x = dot(-toLight, normalize(conedir));
    if x > cutoff {
        return clamp((x - cutoff) / (1.0 - cutoff), 0.0, 1.0);
    }
    return 0.0;
}

fn calcAmbient(light: AmbientLight, materialAmbient: vec4f) -> vec4f {
    return vec4f(light.intensity * light.color, 1.0) * materialAmbient;
}

fn calcLightColor(mat: Material, lightColor: vec3f, intensity: f32, position: vec3f, toLight: vec3f, normal: vec3f) -> vec4f {
    let toEye = normalize(lights.cameraPosition - position); // none where the camera is (H2)
    let facing = max(dot(normal, toLight), 0.0);
    let diffuse = mat.diffuse * vec4f(lightColor, 1.0) * intensity * facing;
    var specular = mat.specular * vec4f(lightColor, 1.0) * intensity * highlight(toLight, normal, toEye, mat.reflectance);
    if mat.reflectance <= 0.0 {
        specular = vec4f();
    }
    return diffuse + specular;
}

// No direction where the light is on the fragment (H1).
fn calcPointLight(mat: Material, light: PointLight, position: vec3f, normal: vec3f) -> vec4f {
    let path = light.position - position;
    let color = calcLightColor(mat, light.color, light.intensity, position, normalize(path), normal);
    return color * attenuation(light.att.constant, light.att.linear, light.att.exponent, length(path));
}

fn calcSpotLight(mat: Material, light: SpotLight, position: vec3f, normal: vec3f) -> vec4f {
    let toLight = normalize(light.pl.position - position);
    return calcPointLight(mat, light.pl, position, normal) * cone(toLight, light.conedir, light.cutoff);
}

fn calcDirLight(mat: Material, light: DirLight, position: vec3f, normal: vec3f) -> vec4f {
    return calcLightColor(mat, light.color, light.intensity, position, normalize(light.direction), normal);
}

@fragment
fn fragment_main(in: Surface) -> @location(0) vec4f {
    let texel = textureSample(txtSampler, txtSamplerState, in.texCoord);
    var mat = material;
    if texel.a > 0.0 { // a transparent texel means: no texture here
        mat.ambient *= texel;
        mat.diffuse *= texel;
    }

    let normal = normalize(in.normal);
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
