// 128 directional lights, 128 point lights and an ambient light, in three uniform blocks.
//
// WGSL puts every member where std140 puts it here, because every struct holds a
// vec3f: 32 bytes a directional light, 48 a point light, the counts at 4096 and 6144.
//
// Seed form: the formulas as an engine book prints them, with what is wrong with them. The
// ids H1, H2, ... are those of tests/hazards/; light_arrays/lights.wgsl is the form to use.

const DIRECTIONAL_LIGHT_MAX_NUM = 128;
const POINT_LIGHT_MAX_NUM = 128;

// Runs over the slots nobody has set: every fragment is NaN (H3b).
override LOOP_TO_MAX: bool = false;

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

// Divides by zero where nothing has been set (H3), overflows in d * d (H4).
fn attenuation(constant: f32, linear: f32, quadratic: f32, d: f32) -> f32 {
    return 1.0 / (constant + linear * d + quadratic * (d * d));
}

// Shines from behind the surface too (H13); a normal longer or shorter than 1 dims the
// highlight or makes it many times too bright (H14).
fn highlight(light_dir: vec3f, normal: vec3f, view_dir: vec3f, shininess: f32) -> f32 {
    let reflect_dir = reflect(-light_dir, normal);
    return pow(max(dot(view_dir, reflect_dir), 0.0), shininess);
}

// No highlight.
fn directional_light(light: DirectionalLight, normal: vec3f, view_dir: vec3f, diffuse_texel: vec3f, specular_texel: vec3f) -> vec3f {
    let light_dir = normalize(-light.dir);
    let diffuse = max(dot(normalize(normal), light_dir), 0.0);
    return light.color * diffuse * light.intensity * diffuse_texel;
}

// The highlight knows no intensity, takes the colour of the diffuse texture, and mirrors
// at the normal as interpolated. No direction where the light is on the fragment (H1).
fn point_light(light: PointLight, frag_pos: vec3f, normal: vec3f, view_dir: vec3f, diffuse_texel: vec3f, specular_texel: vec3f) -> vec3f {
    let light_dir = normalize(light.pos - frag_pos);
    let diffuse = max(dot(normalize(normal), light_dir), 0.0);
    let diffuse_color = light.color * diffuse * light.intensity * diffuse_texel;

    let specular = highlight(light_dir, normal, view_dir, u_view.specular_highlight_shininess);
    let specular_color = light.color * specular * specular_texel.r * diffuse_texel;

    let d = length(light.pos - frag_pos);
    let weakening = attenuation(light.constant, light.linear, light.quadratic, d);
    return diffuse_color * weakening + specular_color * weakening;
}

@fragment
fn fragment_main(in: Surface) -> @location(0) vec4f {
    let diffuse_texel = textureSample(u_diffuse_texture, u_sampler, in.uv).rgb;
    let specular_texel = textureSample(u_specular_texture, u_sampler, in.uv).rgb;
    let view_dir = normalize(u_view.view_pos - in.frag_pos);

    let ambient_color = u_ambient.data.color * u_ambient.data.intensity * diffuse_texel;

    var total: vec3f; // zero in WGSL; nothing at all in GLSL (H12)

    // Never clamped to the array (H23).
    let directional_count = u_directional_light_array.actually_used_count;
    for (var i = 0; i < directional_count; i++) {
        total += directional_light(u_directional_light_array.data[i], in.normal, view_dir, diffuse_texel, specular_texel);
    }
    let point_count = select(u_point_light_array.actually_used_count, POINT_LIGHT_MAX_NUM, LOOP_TO_MAX);
    for (var i = 0; i < point_count; i++) {
        total += point_light(u_point_light_array.data[i], in.frag_pos, in.normal, view_dir, diffuse_texel, specular_texel);
    }

    return vec4f(ambient_color + total, 1.0);
}

// What is wrong here is wrong on purpose.
// landfall: allow-file(unnormalised-normal)
