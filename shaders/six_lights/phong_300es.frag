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

highp float highlight(highp vec3 toLight, highp vec3 normal, highp vec3 viewDir) {
    highp float x = dot(viewDir, reflect(-toLight, normal));
    return x > 0.0 ? pow(min(x, 1.0), material.shininess) : 0.0;
}

highp float attenuation(highp float constant, highp float linear, highp float quadratic, highp float d) {
    return 1.0 / max(constant + d * (linear + quadratic * d), 1.0e-6);
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
         + light.specular * highlight(toLight, normal, viewDir) * gloss;
}

vec3 CalcPointLight(PointLight light, highp vec3 normal, highp vec3 fragPos, highp vec3 viewDir) {
    highp vec3 path = light.position - fragPos;
    highp vec3 toLight = unit(path);
    vec3 surface = texture(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture(material.specular, TexCoords).rgb;
    vec3 lit = (light.ambient + light.diffuse * max(dot(normal, toLight), 0.0)) * surface
             + light.specular * highlight(toLight, normal, viewDir) * gloss;
    return lit * attenuation(light.constant, light.linear, light.quadratic, length(path));
}

vec3 CalcSpotLight(SpotLight light, highp vec3 normal, highp vec3 fragPos, highp vec3 viewDir) {
    highp vec3 path = light.position - fragPos;
    highp vec3 toLight = unit(path);
    vec3 surface = texture(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture(material.specular, TexCoords).rgb;
    vec3 lit = (light.ambient + light.diffuse * max(dot(normal, toLight), 0.0)) * surface
             + light.specular * highlight(toLight, normal, viewDir) * gloss;
    return lit * attenuation(light.constant, light.linear, light.quadratic, length(path))
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
