#version 300 es
// Six lights for OpenGL ES 3.0. Precision qualifiers change no offset and no size,
// only how the numbers are computed: positions and directions need `highp`,
// colours do not.

precision mediump float;

#define NR_POINT_LIGHTS 4

struct Material {
    sampler2D diffuse;
    sampler2D specular;
    highp float shininess;
};

struct DirLight {
    highp vec3 direction;

    lowp vec3 ambient;
    lowp vec3 diffuse;
    lowp vec3 specular;
};

struct PointLight {
    highp vec3 position;

    mediump float constant;
    mediump float linear;
    highp float quadratic; // the far rows of the usual tables fall below mediump's 2^-14

    lowp vec3 ambient;
    lowp vec3 diffuse;
    lowp vec3 specular;
};

struct SpotLight {
    highp vec3 position;
    highp vec3 direction;
    highp float cutOff;
    highp float outerCutOff;

    mediump float constant;
    mediump float linear;
    highp float quadratic;

    lowp vec3 ambient;
    lowp vec3 diffuse;
    lowp vec3 specular;
};

uniform highp vec3 viewPos;
uniform Material material;
uniform DirLight dirLight;
uniform PointLight pointLights[NR_POINT_LIGHTS];
uniform SpotLight spotLight;

in highp vec3 FragPos;
in mediump vec3 Normal;
in mediump vec2 TexCoords;

out mediump vec4 FragColor;

// Unit vector along v; the zero vector stays zero. 1e-30 needs highp.
highp vec3 unit(highp vec3 v) {
    return v * inversesqrt(max(dot(v, v), 1.0e-30));
}

// Set SQUARINGS where the shininess is known to be 2 to that power: so many squarings take a
// third of the time of any power. -1 is any shininess.
#ifndef SQUARINGS
#define SQUARINGS -1
#endif

// (1 - m)^n for m >= 0 and n >= 0, as exp(n log(1 - m)); 0 from m = 1 on. Where 1 - m has
// lost the digits of m, the logarithm is taken from m itself, by its series.
highp float power(highp float m, highp float n) {
#if SQUARINGS >= 0
    highp float x = max(1.0 - m, 0.0);
    for (int i = 0; i < SQUARINGS; i++) {
        x *= x;
    }
    return x;
#else
    highp float series = m * (1.0 + m * (1.0 / 2.0 + m * (1.0 / 3.0 + m * (1.0 / 4.0 + m * (1.0 / 5.0 + m / 6.0)))));
    highp float exponent = m < 0.015625 ? series : -log(max(1.0 - m, 1.0e-30));
    return m < 1.0 ? exp(-n * exponent) : 0.0;
#endif
}

// 1 - cos is half the squared chord. A light behind the surface has no highlight.
highp float highlight(highp vec3 toLight, highp vec3 normal, highp vec3 viewDir, highp float shininess) {
    highp vec3 chord = toLight - reflect(-viewDir, normal);
    highp float m = dot(normal, toLight) > 0.0 ? 0.5 * dot(chord, chord) : 1.0;
    return power(m, shininess);
}

highp float attenuation(highp float constant, highp float linear, highp float quadratic, highp float d) {
    return 1.0 / max(constant + d * (linear + quadratic * d), 1.0e-4);
}

highp float cone(highp vec3 toLight, highp vec3 direction, highp float cutOff, highp float outerCutOff) {
    highp vec3 chord = toLight - unit(-direction);
    highp float outer = 1.0 - outerCutOff;
    highp float inner = 1.0 - cutOff;
    return clamp((outer - 0.5 * dot(chord, chord)) / max(outer - inner, 1.0e-9), 0.0, 1.0);
}

vec3 CalcDirLight(DirLight light, highp vec3 normal, highp vec3 viewDir) {
    highp vec3 toLight = unit(-light.direction);
    vec3 surface = texture(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture(material.specular, TexCoords).rgb;
    return (light.ambient + light.diffuse * max(dot(normal, toLight), 0.0)) * surface
         + light.specular * highlight(toLight, normal, viewDir, material.shininess) * gloss;
}

vec3 CalcPointLight(PointLight light, highp vec3 normal, highp vec3 fragPos, highp vec3 viewDir) {
    highp vec3 path = light.position - fragPos;
    highp float d2 = dot(path, path);
    highp float inverse = inversesqrt(max(d2, 1.0e-30));
    highp vec3 toLight = path * inverse;
    vec3 surface = texture(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture(material.specular, TexCoords).rgb;
    vec3 lit = (light.ambient + light.diffuse * max(dot(normal, toLight), 0.0)) * surface
             + light.specular * highlight(toLight, normal, viewDir, material.shininess) * gloss;
    return lit * attenuation(light.constant, light.linear, light.quadratic, d2 * inverse);
}

vec3 CalcSpotLight(SpotLight light, highp vec3 normal, highp vec3 fragPos, highp vec3 viewDir) {
    highp vec3 path = light.position - fragPos;
    highp float d2 = dot(path, path);
    highp float inverse = inversesqrt(max(d2, 1.0e-30));
    highp vec3 toLight = path * inverse;
    vec3 surface = texture(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture(material.specular, TexCoords).rgb;
    vec3 lit = (light.ambient + light.diffuse * max(dot(normal, toLight), 0.0)) * surface
             + light.specular * highlight(toLight, normal, viewDir, material.shininess) * gloss;
    return lit * attenuation(light.constant, light.linear, light.quadratic, d2 * inverse)
               * cone(toLight, light.direction, light.cutOff, light.outerCutOff);
}

void main() {
    highp vec3 normal = unit(Normal);
    highp vec3 viewDir = unit(viewPos - FragPos);

    vec3 sum = CalcDirLight(dirLight, normal, viewDir);
    for (int i = 0; i < NR_POINT_LIGHTS; ++i) {
        sum += CalcPointLight(pointLights[i], normal, FragPos, viewDir);
    }
    sum += CalcSpotLight(spotLight, normal, FragPos, viewDir);

    FragColor = vec4(sum, 1.0);
}
