#version 330 core
// A spotlight with a hard edge: full light inside the cone, ambient light outside.

in vec3 FragPos;
in vec3 Normal;
in vec2 TexCoords;

out vec4 FragColor;

uniform vec3 viewPos;

struct Material {
    sampler2D diffuse;
    sampler2D specular;
    float shininess;
};

struct Light {
    vec3 position;
    vec3 direction; // the way the light travels
    float cutOff;   // cosine of the cone's half angle, neither degrees nor radians

    vec3 ambient;
    vec3 diffuse;
    vec3 specular;

    float constant;
    float linear;
    float quadratic;
};

uniform Light light;
uniform Material material;

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

// 1 inside, 0 outside. Inside means a smaller angle, that is, a *larger* cosine. Compared
// as 1 - cos, which is half the squared chord between two unit vectors: in a narrow cone
// the cosines themselves agree in nearly every digit.
float cone(vec3 toLight, vec3 direction, float cutOff) {
    vec3 chord = toLight - unit(-direction);
    return 0.5 * dot(chord, chord) < 1.0 - cutOff ? 1.0 : 0.0;
}

// What the light adds.
vec3 shade(Light light, vec3 normal, vec3 fragPos, vec3 viewDir, vec3 surface, vec3 gloss) {
    vec3 path = light.position - fragPos;
    float d2 = dot(path, path);
    float inverse = inversesqrt(max(d2, 1.0e-30)); // one root for the direction and the distance
    vec3 toLight = path * inverse;

    // Ambient light is neither cut nor weakened, so that the edge never turns darker inside than outside.
    vec3 sum = light.ambient * surface;
    float inside = cone(toLight, light.direction, light.cutOff);
    if (inside > 0.0) {
        vec3 direct = light.diffuse * max(dot(normal, toLight), 0.0) * surface
                    + light.specular * highlight(toLight, normal, viewDir, material.shininess) * gloss;
        sum += direct * (inside * attenuation(light.constant, light.linear, light.quadratic, d2 * inverse));
    }
    return sum;
}

void main() {
    vec3 surface = texture(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture(material.specular, TexCoords).rgb;
    FragColor = vec4(shade(light, unit(Normal), FragPos, unit(viewPos - FragPos), surface, gloss), 1.0);
}
