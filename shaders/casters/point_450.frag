#version 450
// A point light that weakens with distance.
// Vulkan GLSL: every group of uniforms is a std140 block.

layout(location = 0) in vec3 FragPos;
layout(location = 1) in vec3 Normal;
layout(location = 2) in vec2 TexCoords;

layout(location = 0) out vec4 FragColor;

struct Light {
    vec3 position;   // offset 0

    vec3 ambient;    // offset 16
    vec3 diffuse;    // offset 32
    vec3 specular;   // offset 48

    float constant;  // offset 60
    float linear;    // offset 64
    float quadratic; // offset 68, size 80 in all
};

layout(std140, set = 0, binding = 0) uniform ViewBlock {
    vec3 viewPos; // offset 0
};

layout(std140, set = 0, binding = 1) uniform PointBlock {
    Light light; // offset 0
};

layout(std140, set = 2, binding = 0) uniform MaterialBlock {
    float shininess; // offset 0
} material;

layout(set = 2, binding = 1) uniform sampler2D materialDiffuse;
layout(set = 2, binding = 2) uniform sampler2D materialSpecular;

// Unit vector along v; the zero vector stays zero.
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
float highlight(vec3 toLight, vec3 normal, vec3 viewDir, float shininess) {
    vec3 chord = toLight - reflect(-viewDir, normal);
    float m = dot(normal, toLight) > 0.0 ? 0.5 * dot(chord, chord) : 1.0;
    return power(m, shininess);
}

// 1 / (constant + linear d + quadratic d^2), kept finite when nothing has been set yet.
float attenuation(float constant, float linear, float quadratic, float d) {
    return 1.0 / max(constant + d * (linear + quadratic * d), 1.0e-4);
}

// What the light adds. The ambient term is weakened too, so that many such lights do not
// add up to a bright fog.
vec3 shade(Light light, vec3 normal, vec3 fragPos, vec3 viewDir, vec3 surface, vec3 gloss) {
    vec3 path = light.position - fragPos;
    float d2 = dot(path, path);
    float inverse = inversesqrt(max(d2, 1.0e-30)); // one root for the direction and the distance
    vec3 toLight = path * inverse;
    vec3 lit = (light.ambient + light.diffuse * max(dot(normal, toLight), 0.0)) * surface
             + light.specular * highlight(toLight, normal, viewDir, material.shininess) * gloss;
    return lit * attenuation(light.constant, light.linear, light.quadratic, d2 * inverse);
}

void main() {
    vec3 surface = texture(materialDiffuse, TexCoords).rgb;
    vec3 gloss = texture(materialSpecular, TexCoords).rgb;
    FragColor = vec4(shade(light, unit(Normal), FragPos, unit(viewPos - FragPos), surface, gloss), 1.0);
}
