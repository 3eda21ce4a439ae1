// A directional light: parallel rays, the same direction for every fragment.
//
// DirectionalBlock has the same bytes as the std140 block of directional_450.frag.
//
// Seed form: the formulas as tutorials print them, with what is wrong with them. The ids
// H1, H2, ... are those of tests/hazards/; casters/directional.wgsl is the form to use.

struct Light {
    direction: vec3f, // offset 0, the way the light travels

    ambient: vec3f,   // offset 16
    diffuse: vec3f,   // offset 32
    specular: vec3f,  // offset 48, size 64 in all
}

struct ViewBlock {
    viewPos: vec3f, // offset 0
}

struct DirectionalBlock {
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
@group(0) @binding(1) var<uniform> lights: DirectionalBlock;
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

// Shines from behind the surface too (H13), and is undefined for pow(0, 0) (H9).
fn highlight(toLight: vec3f, normal: vec3f, viewDir: vec3f, shininess: f32) -> f32 {
    let mirrored = reflect(-toLight, normal);
    return pow(max(dot(viewDir, mirrored), 0.0), shininess);
}

fn shade(light: Light, normal: vec3f, fragPos: vec3f, viewDir: vec3f, surface: vec3f, gloss: vec3f) -> vec3f {
    let toLight = normalize(-light.direction);
    let diff = max(dot(normal, toLight), 0.0);
    let spec = highlight(toLight, normal, viewDir, material.shininess);

    let ambient = light.ambient * surface;
    let diffuse = light.diffuse * diff * surface;
    let specular = light.specular * spec * gloss;
    return ambient + diffuse + specular;
}

@fragment
fn fragment_main(in: Surface) -> @location(0) vec4f {
    let surface = textureSample(materialDiffuse, materialSampler, in.texCoords).rgb;
    let gloss = textureSample(materialSpecular, materialSampler, in.texCoords).rgb;
    let viewDir = normalize(view.viewPos - in.fragPos);
    return vec4f(shade(lights.light, normalize(in.normal), in.fragPos, viewDir, surface, gloss), 1.0);
}
