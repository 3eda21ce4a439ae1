#version 330 core
// Six lights: a sun, four point lights and a flashlight, set uniform by uniform
// ("pointLights[2].linear"). There is no block and so no layout until the loose
// uniforms are gathered into one; samplers can never be part of it.

#define NR_POINT_LIGHTS 4

struct Material {
    sampler2D diffuse;
    sampler2D specular;
    sampler2D flashlight; // what the flashlight's highlight is coloured with
    float shininess;
};

struct DirLight {
    vec3 direction; // the way the light travels

    vec3 ambient;
    vec3 diffuse;
    vec3 specular;
};

struct PointLight {
    vec3 position;

    vec3 ambient;
    vec3 diffuse;
    vec3 specular;

    float constant;
    float linear;
    float quadratic;
};

struct SpotLight {
    vec3 position;
    vec3 direction; // the way the light travels

    vec3 ambient;
    vec3 diffuse;
    vec3 specular;

    float cutOff;      // cosine of the inner cone's half angle
    float outerCutOff; // cosine of the outer one's: the smaller number

    float constant;
    float linear;
    float quadratic;
};

in vec3 FragPos;
in vec3 Normal;
in vec2 TexCoords;

uniform vec3 viewPos;
uniform Material material;
uniform DirLight dirLight;
uniform PointLight pointLights[NR_POINT_LIGHTS];
uniform SpotLight spotLight;

out vec4 FragColor;

// Unit vector along v; the zero vector stays zero.
vec3 unit(vec3 v) {
    return v * inversesqrt(max(dot(v, v), 1.0e-30));
}

vec3 CalcDirLight(DirLight light, vec3 normal, vec3 viewDir);
vec3 CalcPointLight(PointLight light, vec3 normal, vec3 fragPos, vec3 viewDir);
vec3 CalcSpotLight(SpotLight light, vec3 normal, vec3 fragPos, vec3 viewDir);

void main() {
    vec3 normal = unit(Normal);
    vec3 viewDir = unit(viewPos - FragPos);

    vec3 sum = CalcDirLight(dirLight, normal, viewDir);
    for (int i = 0; i < NR_POINT_LIGHTS; ++i) {
        sum += CalcPointLight(pointLights[i], normal, FragPos, viewDir);
    }
    sum += CalcSpotLight(spotLight, normal, FragPos, viewDir);

    FragColor = vec4(sum, 1.0);
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

// Phong's highlight: how well the mirrored eye sees the light, to the power `shininess`.
// The eye is mirrored, not the light: that is the same for all lights of a fragment.
// 1 - cos is half the squared chord, which stays exact where the cosine is nearly 1.
// A light behind the surface has no highlight.
float highlight(vec3 toLight, vec3 normal, vec3 viewDir, float shininess) {
    vec3 chord = toLight - reflect(-viewDir, normal);
    float m = dot(normal, toLight) > 0.0 ? 0.5 * dot(chord, chord) : 1.0;
    return power(m, shininess);
}

// Horner's form: no d * d that could overflow before it is scaled down.
float attenuation(float constant, float linear, float quadratic, float d) {
    return 1.0 / max(constant + d * (linear + quadratic * d), 1.0e-4);
}

// 1 inside the inner cone, 0 outside the outer one, linear in the cosine between.
// The cosines are compared as 1 - cos = |a - b|^2 / 2, which stays exact for narrow
// cones, where two cosines next to 1 have no digits left to subtract.
float cone(vec3 toLight, vec3 direction, float cutOff, float outerCutOff) {
    vec3 chord = toLight - unit(-direction);
    float outer = 1.0 - outerCutOff;
    float inner = 1.0 - cutOff;
    return clamp((outer - 0.5 * dot(chord, chord)) / max(outer - inner, 1.0e-9), 0.0, 1.0);
}

vec3 CalcDirLight(DirLight light, vec3 normal, vec3 viewDir) {
    vec3 toLight = unit(-light.direction);
    vec3 surface = texture(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture(material.specular, TexCoords).rgb;
    return (light.ambient + light.diffuse * max(dot(normal, toLight), 0.0)) * surface
         + light.specular * highlight(toLight, normal, viewDir, material.shininess) * gloss;
}

vec3 CalcPointLight(PointLight light, vec3 normal, vec3 fragPos, vec3 viewDir) {
    vec3 path = light.position - fragPos;
    float d2 = dot(path, path);
    float inverse = inversesqrt(max(d2, 1.0e-30)); // one root for the direction and the distance
    vec3 toLight = path * inverse;
    vec3 surface = texture(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture(material.specular, TexCoords).rgb;
    vec3 lit = (light.ambient + light.diffuse * max(dot(normal, toLight), 0.0)) * surface
             + light.specular * highlight(toLight, normal, viewDir, material.shininess) * gloss;
    return lit * attenuation(light.constant, light.linear, light.quadratic, d2 * inverse);
}

vec3 CalcSpotLight(SpotLight light, vec3 normal, vec3 fragPos, vec3 viewDir) {
    vec3 path = light.position - fragPos;
    float d2 = dot(path, path);
    float inverse = inversesqrt(max(d2, 1.0e-30));
    vec3 toLight = path * inverse;
    vec3 surface = texture(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture(material.flashlight, TexCoords).rgb;
    float inside = cone(toLight, light.direction, light.cutOff, light.outerCutOff);
    if (inside <= 0.0) {
        return vec3(0.0); // most fragments are outside: nothing below is worth computing
    }
    vec3 lit = (light.ambient + light.diffuse * max(dot(normal, toLight), 0.0)) * surface
             + light.specular * highlight(toLight, normal, viewDir, material.shininess) * gloss;
    return lit * (inside * attenuation(light.constant, light.linear, light.quadratic, d2 * inverse));
}
