#version 450
// Up to 128 directional lights in one std140 block, and one ambient light: Vulkan GLSL.
//
// DirectionalLightBlock: 128 lights, 32 bytes apart and without a hole between the
// last two members, then the count at byte 4096; the buffer holds 4112 bytes.

#define DIRECTIONAL_LIGHT_MAX_NUM 128

struct Ambient {
    vec3 color;      // offset 0
    float intensity; // offset 12
};

struct DirectionalLight {
    vec3 dir;        // offset 0, align 16; the way the light travels
    vec3 color;      // offset 16, align 16
    float intensity; // offset 28, align 4; the stride is 32
};

layout(std140, set = 0, binding = 0) uniform AmbientBlock {
    Ambient data; // offset 0
} u_ambient;

layout(std140, set = 0, binding = 1) uniform DirectionalLightBlock {
    DirectionalLight data[DIRECTIONAL_LIGHT_MAX_NUM]; // offset 0
    int actually_used_count;                          // offset 4096
} u_directional_light_array;

// Vulkan has no loose uniforms: the two that are not samplers share a block of 16 bytes.
layout(std140, set = 0, binding = 3) uniform ViewBlock {
    vec3 u_view_pos;                      // offset 0
    float u_specular_highlight_shininess; // offset 12
};

layout(set = 1, binding = 0) uniform sampler2D u_diffuse_texture;
layout(set = 1, binding = 1) uniform sampler2D u_specular_texture;

layout(location = 0) in vec3 v_frag_pos;
layout(location = 1) in vec3 v_normal;
layout(location = 2) in vec2 v_uv;

layout(location = 0) out vec4 o_fragColor;

// Unit vector along v; the zero vector stays zero.
vec3 unit(vec3 v) {
    return v * inversesqrt(max(dot(v, v), 1.0e-30));
}

// x to the power n for a cosine x, defined for every x.
float highlight(float x, float n) {
    return x > 0.0 ? pow(min(x, 1.0), n) : 0.0;
}

// What one directional light adds: no distance, so no attenuation.
vec3 directional_light(DirectionalLight light, vec3 normal, vec3 view_dir,
                       vec3 diffuse_texel, vec3 specular_texel) {
    vec3 light_dir = unit(-light.dir);
    float diffuse = max(dot(normal, light_dir), 0.0);
    float specular = highlight(dot(view_dir, reflect(-light_dir, normal)), u_specular_highlight_shininess);
    return light.color * light.intensity * (diffuse * diffuse_texel + specular * specular_texel);
}

void main() {
    vec3 diffuse_texel = texture(u_diffuse_texture, v_uv).rgb;
    vec3 specular_texel = texture(u_specular_texture, v_uv).rgb;
    vec3 normal = unit(v_normal);
    vec3 view_dir = unit(u_view_pos - v_frag_pos);

    vec3 total = u_ambient.data.color * u_ambient.data.intensity * diffuse_texel;

    int count = min(u_directional_light_array.actually_used_count, DIRECTIONAL_LIGHT_MAX_NUM);
    for (int i = 0; i < count; i++) {
        total += directional_light(u_directional_light_array.data[i], normal, view_dir,
                                   diffuse_texel, specular_texel);
    }

    o_fragColor = vec4(total, 1.0);
}
