#version 330 core
// Six lights: a sun, four point lights and a flashlight, set uniform by uniform
// ("pointLights[2].linear"). There is no block and so no layout until the loose
// uniforms are gathered into one; samplers can never be part of it.
//
// Seed form: the formulas as tutorials print them, with what is wrong with them. The
// ids H1, H2, ... are those of tests/hazards/; phong_330.frag is the form to use.

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

vec3 CalcDirLight(DirLight light, vec3 normal, vec3 viewDir);
vec3 CalcPointLight(PointLight light, vec3 normal, vec3 fragPos, vec3 viewDir);
vec3 CalcSpotLight(SpotLight light, vec3 normal, vec3 fragPos, vec3 viewDir);

void main() {
    vec3 norm = normalize(Normal);
    vec3 viewDir = normalize(viewPos - FragPos);

    vec3 result = CalcDirLight(dirLight, norm, viewDir);
    for (int i = 0; i < NR_POINT_LIGHTS; i++) {
        result += CalcPointLight(pointLights[i], norm, FragPos, viewDir);
    }
    result += CalcSpotLight(spotLight, norm, FragPos, viewDir);

    FragColor = vec4(result, 1.0);
}

// Shines from behind the surface too (H13), and is undefined for pow(0, 0) (H9).
float highlight(vec3 toLight, vec3 normal, vec3 viewDir, float shininess) {
    vec3 mirrored = reflect(-toLight, normal);
    return pow(max(dot(viewDir, mirrored), 0.0), shininess);
}

// Divides by zero where nothing has been set (H3), overflows in d * d (H4).
float attenuation(float constant, float linear, float quadratic, float d) {
    return 1.0 / (constant + linear * d + quadratic * (d * d));
}

// 0 / 0 where the cones agree (H6); a narrow cone has no digits (H17).
float cone(vec3 toLight, vec3 direction, float cutOff, float outerCutOff) {
    float theta = dot(toLight, normalize(-direction));
    float epsilon = cutOff - outerCutOff;
    return clamp((theta - outerCutOff) / epsilon, 0.0, 1.0);
}

vec3 CalcDirLight(DirLight light, vec3 normal, vec3 viewDir) {
    vec3 toLight = normalize(-light.direction);
    float diff = max(dot(normal, toLight), 0.0);
    float spec = highlight(toLight, normal, viewDir, material.shininess);

    vec3 ambient = light.ambient * texture(material.diffuse, TexCoords).rgb;
    vec3 diffuse = light.diffuse * diff * texture(material.diffuse, TexCoords).rgb;
    vec3 specular = light.specular * spec * texture(material.specular, TexCoords).rgb;
    return ambient + diffuse + specular;
}

// No direction where the light is on the fragment (H1).
vec3 CalcPointLight(PointLight light, vec3 normal, vec3 fragPos, vec3 viewDir) {
    vec3 toLight = normalize(light.position - fragPos);
    float diff = max(dot(normal, toLight), 0.0);
    float spec = highlight(toLight, normal, viewDir, material.shininess);

    float d = length(light.position - fragPos);
    float weakening = attenuation(light.constant, light.linear, light.quadratic, d);

    vec3 ambient = light.ambient * texture(material.diffuse, TexCoords).rgb;
    vec3 diffuse = light.diffuse * diff * texture(material.diffuse, TexCoords).rgb;
    vec3 specular = light.specular * spec * texture(material.specular, TexCoords).rgb;
    ambient *= weakening;
    diffuse *= weakening;
    specular *= weakening;
    return ambient + diffuse + specular;
}

vec3 CalcSpotLight(SpotLight light, vec3 normal, vec3 fragPos, vec3 viewDir) {
    vec3 toLight = normalize(light.position - fragPos);
    float diff = max(dot(normal, toLight), 0.0);
    float spec = highlight(toLight, normal, viewDir, material.shininess);

    float d = length(light.position - fragPos);
    float weakening = attenuation(light.constant, light.linear, light.quadratic, d);
    float inside = cone(toLight, light.direction, light.cutOff, light.outerCutOff);

    vec3 ambient = light.ambient * texture(material.diffuse, TexCoords).rgb;
    vec3 diffuse = light.diffuse * diff * texture(material.diffuse, TexCoords).rgb;
    vec3 specular = light.specular * spec * texture(material.flashlight, TexCoords).rgb;
    ambient *= weakening * inside;
    diffuse *= weakening * inside;
    specular *= weakening * inside;
    return ambient + diffuse + specular;
}
