#version 450
// A spotlight with a soft edge: bright inside the inner cone, ambient light only
// outside the outer cone, and linear in the cosine between the two.
// Vulkan GLSL: every group of uniforms is a std140 block.

layout(location = 0) in vec3 FragPos;
layout(location = 1) in vec3 Normal;
layout(location = 2) in vec2 TexCoords;

layout(location = 0) out vec4 FragColor;

struct Light {
    vec3 position;     // offset 0
    vec3 direction;    // offset 16, the way the light travels
    float cutOff;      // offset 28, cosine of the inner cone's half angle
    float outerCutOff; // offset 32, cosine of the outer one's: the smaller number

    vec3 ambient;      // offset 48
    vec3 diffuse;      // offset 64
    vec3 specular;     // offset 80

    float constant;    // offset 92
    float linear;      // offset 96
    float quadratic;   // offset 100, size 112 in all
};

layout(std140, set = 0, binding = 0) uniform ViewBlock {
    vec3 viewPos; // offset 0
};

layout(std140, set = 0, binding = 1) uniform SoftSpotBlock {
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

// 1 inside the inner cone, 0 outside the outer one, linear in the cosine between. 1 - cos
// is half the squared chord, which stays exact in narrow cones; cones that agree give a
// hard edge.
float cone(vec3 toLight, vec3 direction, float cutOff, float outerCutOff) {
    vec3 chord = toLight - unit(-direction);
    float outer = 1.0 - outerCutOff;
    float inner = 1.0 - cutOff;
    return clamp((outer - 0.5 * dot(chord, chord)) / max(outer - inner, 1.0e-9), 0.0, 1.0);
}

// What the light adds.
vec3 shade(Light light, vec3 normal, vec3 fragPos, vec3 viewDir, vec3 surface, vec3 gloss) {
    vec3 path = light.position - fragPos;
    float d2 = dot(path, path);
    float inverse = inversesqrt(max(d2, 1.0e-30)); // one root for the direction and the distance
    vec3 toLight = path * inverse;

    // Ambient light is neither cut nor weakened, so that the edge never turns darker inside than outside.
    vec3 sum = light.ambient * surface;
    float inside = cone(toLight, light.direction, light.cutOff, light.outerCutOff);
    if (inside > 0.0) {
        vec3 direct = light.diffuse * max(dot(normal, toLight), 0.0) * surface
                    + light.specular * highlight(toLight, normal, viewDir, material.shininess) * gloss;
        sum += direct * (inside * attenuation(light.constant, light.linear, light.quadratic, d2 * inverse));
    }
    return sum;
}

void main() {
    vec3 surface = texture(materialDiffuse, TexCoords).rgb;
    vec3 gloss = texture(materialSpecular, TexCoords).rgb;
    FragColor = vec4(shade(light, unit(Normal), FragPos, unit(viewPos - FragPos), surface, gloss), 1.0);
}
