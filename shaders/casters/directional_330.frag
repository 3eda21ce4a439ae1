#version 330 core
// A directional light: parallel rays, the same direction for every fragment.

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

// Unit vector along v; the zero vector stays zero.
vec3 unit(vec3 v) {
    return v * inversesqrt(max(dot(v, v), 1.0e-30));
}

// Light that arrives from `toLight` and leaves towards `toEye`.
vec3 shade(vec3 toLight, vec3 toEye, vec3 normal, vec3 surface, vec3 gloss) {
    float facing = max(dot(normal, toLight), 0.0);
    float mirror = dot(toEye, reflect(-toLight, normal));
    float highlight = mirror > 0.0 ? pow(min(mirror, 1.0), material.shininess) : 0.0;
    return (light.ambient + light.diffuse * facing) * surface + light.specular * highlight * gloss;
}

void main() {
    vec3 surface = texture(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture(material.specular, TexCoords).rgb;
    FragColor = vec4(shade(unit(-light.direction), unit(viewPos - FragPos), unit(Normal), surface, gloss), 1.0);
}
