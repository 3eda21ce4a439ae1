#version 450
// Six lights: a sun, four point lights and a flashlight, in std140 blocks with
// explicit bindings, as Vulkan needs them.
//
// A float that follows a vec3 moves into the vec3's fourth component: `constant`
// at 60 and `cutOff` at 76 are no typing errors.
//
// Seed form: the formulas as tutorials print them, with what is wrong with them. The
// ids H1, H2, ... are those of tests/hazards/; phong_450.frag is the form to use.

#define NR_POINT_LIGHTS 4

struct DirLight {
    vec3 direction; // offset 0, the way the light travels

    vec3 ambient;   // offset 16
    vec3 diffuse;   // offset 32
    vec3 specular;  // offset 48, size 64 in all
};

struct PointLight {
    vec3 position;   // offset 0

    vec3 ambient;    // offset 16
    vec3 diffuse;    // offset 32
    vec3 specular;   // offset 48

    float constant;  // offset 60
    float linear;    // offset 64
    float quadratic; // offset 68, size 80 in all
};

struct SpotLight {
    vec3 position;     // offset 0
    vec3 direction;    // offset 16, the way the light travels

    vec3 ambient;      // offset 32
    vec3 diffuse;      // offset 48
    vec3 specular;     // offset 64

    float cutOff;      // offset 76, cosine of the inner cone's half angle
    float outerCutOff; // offset 80, cosine of the outer one's: the smaller number

    float constant;    // offset 84
    float linear;      // offset 88
    float quadratic;   // offset 92, size 96 in all
};

layout(location = 0) in vec3 FragPos;
layout(location = 1) in vec3 Normal;
layout(location = 2) in vec2 TexCoords;

layout(std140, set = 0, binding = 0) uniform ViewBlock {
    vec3 viewPos; // offset 0
};

layout(std140, set = 0, binding = 1) uniform LightBlock {
    DirLight dirLight;                       // offset 0
    PointLight pointLights[NR_POINT_LIGHTS]; // offset 64
    SpotLight spotLight;                     // offset 384, size 480 in all
};

layout(std140, set = 2, binding = 0) uniform MaterialBlock {
    float shininess; // offset 0
} material;

layout(set = 2, binding = 1) uniform sampler2D materialDiffuse;
layout(set = 2, binding = 2) uniform sampler2D materialSpecular;
layout(set = 2, binding = 3) uniform sampler2D materialFlashlight;

layout(location = 0) out vec4 FragColor;

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

    vec3 ambient = light.ambient * texture(materialDiffuse, TexCoords).rgb;
    vec3 diffuse = light.diffuse * diff * texture(materialDiffuse, TexCoords).rgb;
    vec3 specular = light.specular * spec * texture(materialSpecular, TexCoords).rgb;
    return ambient + diffuse + specular;
}

// No direction where the light is on the fragment (H1).
vec3 CalcPointLight(PointLight light, vec3 normal, vec3 fragPos, vec3 viewDir) {
    vec3 toLight = normalize(light.position - fragPos);
    float diff = max(dot(normal, toLight), 0.0);
    float spec = highlight(toLight, normal, viewDir, material.shininess);

    float d = length(light.position - fragPos);
    float weakening = attenuation(light.constant, light.linear, light.quadratic, d);

    vec3 ambient = light.ambient * texture(materialDiffuse, TexCoords).rgb;
    vec3 diffuse = light.diffuse * diff * texture(materialDiffuse, TexCoords).rgb;
    vec3 specular = light.specular * spec * texture(materialSpecular, TexCoords).rgb;
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

    vec3 ambient = light.ambient * texture(materialDiffuse, TexCoords).rgb;
    vec3 diffuse = light.diffuse * diff * texture(materialDiffuse, TexCoords).rgb;
    vec3 specular = light.specular * spec * texture(materialFlashlight, TexCoords).rgb;
    ambient *= weakening * inside;
    diffuse *= weakening * inside;
    specular *= weakening * inside;
    return ambient + diffuse + specular;
}
