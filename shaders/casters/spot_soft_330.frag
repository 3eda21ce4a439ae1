#version 330 core
// 软边聚光灯：内锥之内全亮，外锥之外只剩环境光，两者之间按余弦线性过渡。
// (A spotlight with a soft edge: bright inside the inner cone, ambient light only
// outside the outer cone, and linear in the cosine between the two.)

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
    vec3 direction;    // 光线前进的方向
    float cutOff;      // 内锥半角的余弦
    float outerCutOff; // 外锥半角的余弦，比内锥的小

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

// 边缘系数，0 到 1。用弦长求 1 - cos：锥角很小时两个余弦都接近 1，直接相减会丢掉有效数字。
// 内外两个角相等时分母为零，因此给一个下限，结果退化成硬边。
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
    vec3 surface = texture(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture(material.specular, TexCoords).rgb;
    FragColor = vec4(shade(light, unit(Normal), FragPos, unit(viewPos - FragPos), surface, gloss), 1.0);
}
