// Six lights: a sun, four point lights and a flashlight.
//
// LightBlock has the same bytes as the std140 block of phong_450.frag: an application
// can feed one buffer to both.
//
// Seed form: the formulas as tutorials print them, with what is wrong with them. The
// ids H1, H2, ... are those of tests/hazards/; phong.wgsl is the form to use.

const NR_POINT_LIGHTS = 4;

struct DirLight {
    direction: vec3f, // offset 0, the way the light travels

    ambient: vec3f,   // offset 16
    diffuse: vec3f,   // offset 32
    specular: vec3f,  // offset 48, size 64 in all
}

struct PointLight {
    position: vec3f,  // offset 0

    ambient: vec3f,   // offset 16
    diffuse: vec3f,   // offset 32
    specular: vec3f,  // offset 48

    constant: f32,    // offset 60
    linear: f32,      // offset 64
    quadratic: f32,   // offset 68, size 80 in all
}

struct SpotLight {
    position: vec3f,  // offset 0
    direction: vec3f, // offset 16, the way the light travels

    ambient: vec3f,   // offset 32
    diffuse: vec3f,   // offset 48
    specular: vec3f,  // offset 64

    cutOff: f32,      // offset 76, cosine of the inner cone's half angle
    outerCutOff: f32, // offset 80, cosine of the outer one's: the smaller number

    constant: f32,    // offset 84
    linear: f32,      // offset 88
    quadratic: f32,   // offset 92, size 96 in all
}

struct ViewBlock {
    viewPos: vec3f, // offset 0
}

struct LightBlock {
    dirLight: DirLight,                              // offset 0
    pointLights: array<PointLight, NR_POINT_LIGHTS>, // offset 64
    spotLight: SpotLight,                            // offset 384
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
@group(0) @binding(1) var<uniform> lights: LightBlock;
@group(1) @binding(0) var<uniform> transform: TransformBlock;
@group(2) @binding(0) var<uniform> material: MaterialBlock;
@group(2) @binding(1) var materialDiffuse: texture_2d<f32>;
@group(2) @binding(2) var materialSpecular: texture_2d<f32>;
@group(2) @binding(3) var materialFlashlight: texture_2d<f32>;
@group(2) @binding(4) var materialSampler: sampler;

struct Surface {
    @builtin(position) clip: vec4f,
    @location(0) fragPos: vec3f,
    @location(1) normal: vec3f,
    @location(2) texCoords: vec2f,
}

// The three textures at one point of the surface.
struct Texels {
    diffuse: vec3f,
    specular: vec3f,
    flashlight: vec3f,
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

@fragment
fn fragment_main(in: Surface) -> @location(0) vec4f {
    let texels = Texels(
        textureSample(materialDiffuse, materialSampler, in.texCoords).rgb,
        textureSample(materialSpecular, materialSampler, in.texCoords).rgb,
        textureSample(materialFlashlight, materialSampler, in.texCoords).rgb,
    );
    let normal = normalize(in.normal);
    let viewDir = normalize(view.viewPos - in.fragPos);

    var sum = calcDirLight(lights.dirLight, normal, viewDir, texels);
    for (var i = 0; i < NR_POINT_LIGHTS; i++) {
        sum += calcPointLight(lights.pointLights[i], normal, in.fragPos, viewDir, texels);
    }
    sum += calcSpotLight(lights.spotLight, normal, in.fragPos, viewDir, texels);
    return vec4f(sum, 1.0);
}

// Shines from behind the surface too (H13), and is undefined for pow(0, 0) (H9).
fn highlight(toLight: vec3f, normal: vec3f, viewDir: vec3f, shininess: f32) -> f32 {
    let mirrored = reflect(-toLight, normal);
    return pow(max(dot(viewDir, mirrored), 0.0), shininess);
}

// Divides by zero where nothing has been set (H3), overflows in d * d (H4).
fn attenuation(constant: f32, linear: f32, quadratic: f32, d: f32) -> f32 {
    return 1.0 / (constant + linear * d + quadratic * (d * d));
}

// 0 / 0 where the cones agree (H6); a narrow cone has no digits (H17).
fn cone(toLight: vec3f, direction: vec3f, cutOff: f32, outerCutOff: f32) -> f32 {
    let theta = dot(toLight, normalize(-direction));
    let epsilon = cutOff - outerCutOff;
    return clamp((theta - outerCutOff) / epsilon, 0.0, 1.0);
}

fn calcDirLight(light: DirLight, normal: vec3f, viewDir: vec3f, texels: Texels) -> vec3f {
    let toLight = normalize(-light.direction);
    let diff = max(dot(normal, toLight), 0.0);
    let spec = highlight(toLight, normal, viewDir, material.shininess);
    return light.ambient * texels.diffuse
        + light.diffuse * diff * texels.diffuse
        + light.specular * spec * texels.specular;
}

// No direction where the light is on the fragment (H1).
fn calcPointLight(light: PointLight, normal: vec3f, fragPos: vec3f, viewDir: vec3f, texels: Texels) -> vec3f {
    let toLight = normalize(light.position - fragPos);
    let diff = max(dot(normal, toLight), 0.0);
    let spec = highlight(toLight, normal, viewDir, material.shininess);
    let d = length(light.position - fragPos);
    let weakening = attenuation(light.constant, light.linear, light.quadratic, d);
    return light.ambient * texels.diffuse * weakening
        + light.diffuse * diff * texels.diffuse * weakening
        + light.specular * spec * texels.specular * weakening;
}

fn calcSpotLight(light: SpotLight, normal: vec3f, fragPos: vec3f, viewDir: vec3f, texels: Texels) -> vec3f {
    let toLight = normalize(light.position - fragPos);
    let diff = max(dot(normal, toLight), 0.0);
    let spec = highlight(toLight, normal, viewDir, material.shininess);
    let d = length(light.position - fragPos);
    let weakening = attenuation(light.constant, light.linear, light.quadratic, d)
        * cone(toLight, light.direction, light.cutOff, light.outerCutOff);
    return light.ambient * texels.diffuse * weakening
        + light.diffuse * diff * texels.diffuse * weakening
        + light.specular * spec * texels.flashlight * weakening;
}
