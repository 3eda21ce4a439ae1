#version 330 core
// Up to 128 point lights in one std140 block, and one ambient light.
//
// PointLightBlock: 128 lights, 48 bytes apart, then the count at byte 6144;
// the buffer holds 6160 bytes. Member k of light i starts at 48 * i + offset(k).

#ifndef POINT_LIGHT_MAX_NUM
#define POINT_LIGHT_MAX_NUM 128
#endif

struct Ambient {
    vec3 color;      // offset 0, align 16
    float intensity; // offset 12, align 4: fits behind the vec3
};

struct PointLight {
    vec3 pos;        // offset 0, align 16; bytes 12..16 stay unused
    vec3 color;      // offset 16, align 16
    float intensity; // offset 28, align 4: fits behind the vec3

    float constant;  // offset 32, align 4
    float linear;    // offset 36, align 4
    float quadratic; // offset 40, align 4; 4 bytes of tail padding make the stride 48
};

layout(std140) uniform AmbientBlock {
    Ambient data; // offset 0
} u_ambient;

layout(std140) uniform PointLightBlock {
    PointLight data[POINT_LIGHT_MAX_NUM]; // offset 0
    int actually_used_count;              // offset 6144
} u_point_light_array;

uniform sampler2D u_diffuse_texture;
uniform sampler2D u_specular_texture;
uniform vec3 u_view_pos;
uniform float u_specular_highlight_shininess;

in vec3 v_frag_pos;
in vec3 v_normal;
in vec2 v_uv;

out vec4 o_fragColor;

// Unit vector along v. The zero vector stays zero where normalize() may give NaN.
vec3 unit(vec3 v) {
    return v * inversesqrt(max(dot(v, v), 1.0e-30));
}

// Set SQUARINGS where the shininess is known to be 2 to that power: so many squarings take a
// third of the time of any power. -1 is any shininess.
#ifndef SQUARINGS
#define SQUARINGS -1
#endif

// (1 - m)^n for m >= 0 and n >= 0, as exp(n log(1 - m)); 0 from m = 1 on. Where 1 - m has
// lost the digits of m, the logarithm is taken from m itself, by its series.
float power(float m, float n) {
#if SQUARINGS >= 0
    float x = max(1.0 - m, 0.0);
    for (int i = 0; i < SQUARINGS; i++) {
        x *= x;
    }
    return x;
#else
    float series = m * (1.0 + m * (1.0 / 2.0 + m * (1.0 / 3.0 + m * (1.0 / 4.0 + m * (1.0 / 5.0 + m / 6.0)))));
    float exponent = m < 0.015625 ? series : -log(max(1.0 - m, 1.0e-30));
    return m < 1.0 ? exp(-n * exponent) : 0.0;
#endif
}

// Phong's highlight. The eye is mirrored, not the light: that is the same for all lights
// of a fragment. 1 - cos is half the squared chord, which stays exact where the cosine is
// nearly 1. A light behind the surface has no highlight.
float highlight(vec3 light_dir, vec3 normal, vec3 view_dir, float shininess) {
    vec3 chord = light_dir - reflect(-view_dir, normal);
    float m = dot(normal, light_dir) > 0.0 ? 0.5 * dot(chord, chord) : 1.0;
    return power(m, shininess);
}

// 1 / (constant + linear d + quadratic d^2). A light whose coefficients were never set
// would divide by zero; the floor keeps its black colour black.
float attenuation(float constant, float linear, float quadratic, float d) {
    return 1.0 / max(constant + d * (linear + quadratic * d), 1.0e-4);
}

// What one point light adds. `normal` and `view_dir` are unit vectors away from the surface.
vec3 point_light(PointLight light, vec3 frag_pos, vec3 normal, vec3 view_dir,
                 vec3 diffuse_texel, vec3 specular_texel) {
    vec3 offset = light.pos - frag_pos;
    float d2 = dot(offset, offset);
    float inverse_d = inversesqrt(max(d2, 1.0e-30)); // one root for direction and distance
    vec3 light_dir = offset * inverse_d;

    float diffuse = max(dot(normal, light_dir), 0.0);
    float specular = highlight(light_dir, normal, view_dir, u_specular_highlight_shininess);

    float weakening = attenuation(light.constant, light.linear, light.quadratic, d2 * inverse_d);
    return light.color * (light.intensity * weakening) * (diffuse * diffuse_texel + specular * specular_texel);
}

void main() {
    vec3 diffuse_texel = texture(u_diffuse_texture, v_uv).rgb;
    vec3 specular_texel = texture(u_specular_texture, v_uv).rgb;
    vec3 normal = unit(v_normal);
    vec3 view_dir = unit(u_view_pos - v_frag_pos);

    vec3 total = u_ambient.data.color * u_ambient.data.intensity * diffuse_texel;

    // The unused tail of the array is whatever the buffer held, so stop at the count,
    // and never read past the array when the count is wrong.
    int point_count = clamp(u_point_light_array.actually_used_count, 0, POINT_LIGHT_MAX_NUM);
    for (int i = 0; i < point_count; i++) {
        total += point_light(u_point_light_array.data[i], v_frag_pos, normal, view_dir,
                             diffuse_texel, specular_texel);
    }

    o_fragColor = vec4(total, 1.0);
}
