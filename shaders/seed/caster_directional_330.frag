#version 330 core
// A directional light: parallel rays, the same direction for every fragment.
//
// Seed form: the formulas as tutorials print them, with what is wrong with them. The ids
// H1, H2, ... are those of tests/hazards/; casters/directional_330.frag is the form to use.

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
    vec3 direction; // the way the light travels

    vec3 ambient;
    vec3 diffuse;
    vec3 specular;
};

uniform Light light;
uniform Material material;

// Shines from behind the surface too (H13), and is undefined for pow(0, 0) (H9).
float highlight(vec3 toLight, vec3 normal, vec3 viewDir, float shininess) {
    vec3 mirrored = reflect(-toLight, normal);
    return pow(max(dot(viewDir, mirrored), 0.0), shininess);
}

vec3 shade(Light light, vec3 normal, vec3 fragPos, vec3 viewDir, vec3 surface, vec3 gloss) {
    vec3 toLight = normalize(-light.direction);
    float diff = max(dot(normal, toLight), 0.0);
    float spec = highlight(toLight, normal, viewDir, material.shininess);

    vec3 ambient = light.ambient * surface;
    vec3 diffuse = light.diffuse * diff * surface;
    vec3 specular = light.specular * spec * gloss;
    return ambient + diffuse + specular;
}

void main() {
    vec3 surface = texture(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture(material.specular, TexCoords).rgb;
    FragColor = vec4(shade(light, normalize(Normal), FragPos, normalize(viewPos - FragPos), surface, gloss), 1.0);
}
