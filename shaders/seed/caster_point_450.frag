#version 450
// A point light that weakens with distance.
// Vulkan GLSL: every group of uniforms is a std140 block.
//
// Seed form: the formulas as tutorials print them, with what is wrong with them. The ids
// H1, H2, ... are those of tests/hazards/; casters/point_450.frag is the form to use.

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

// Shines from behind the surface too (H13), and is undefined for pow(0, 0) (H9).
float highlight(vec3 toLight, vec3 normal, vec3 viewDir, float shininess) {
    vec3 mirrored = reflect(-toLight, normal);
    return pow(max(dot(viewDir, mirrored), 0.0), shininess);
}

// Divides by zero where nothing has been set (H3), overflows in d * d (H4).
float attenuation(float constant, float linear, float quadratic, float d) {
    return 1.0 / (constant + linear * d + quadratic * (d * d));
}

vec3 shade(Light light, vec3 normal, vec3 fragPos, vec3 viewDir, vec3 surface, vec3 gloss) {
    vec3 toLight = normalize(light.position - fragPos); // none where the light is on the fragment (H1)
    float diff = max(dot(normal, toLight), 0.0);
    float spec = highlight(toLight, normal, viewDir, material.shininess);
    float d = length(light.position - fragPos);
    float weakening = attenuation(light.constant, light.linear, light.quadratic, d);

    vec3 ambient = light.ambient * surface;
    vec3 diffuse = light.diffuse * diff * surface;
    vec3 specular = light.specular * spec * gloss;
    return (ambient + diffuse + specular) * weakening;
}

void main() {
    vec3 surface = texture(materialDiffuse, TexCoords).rgb;
    vec3 gloss = texture(materialSpecular, TexCoords).rgb;
    FragColor = vec4(shade(light, normalize(Normal), FragPos, normalize(viewPos - FragPos), surface, gloss), 1.0);
}
