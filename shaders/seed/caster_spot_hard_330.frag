#version 330 core
// A spotlight with a hard edge: full light inside the cone, ambient light outside.
//
// Seed form: the formulas as tutorials print them, with what is wrong with them. The ids
// H1, H2, ... are those of tests/hazards/; casters/spot_hard_330.frag is the form to use.

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

// Shines from behind the surface too (H13), and is undefined for pow(0, 0) (H9).
float highlight(vec3 toLight, vec3 normal, vec3 viewDir, float shininess) {
    vec3 mirrored = reflect(-toLight, normal);
    return pow(max(dot(viewDir, mirrored), 0.0), shininess);
}

// Divides by zero where nothing has been set (H3), overflows in d * d (H4).
float attenuation(float constant, float linear, float quadratic, float d) {
    return 1.0 / (constant + linear * d + quadratic * (d * d));
}

// A cutoff in degrees is never passed, one in radians always (H7); a narrow cone has no
// digits (H17).
float cone(vec3 toLight, vec3 direction, float cutOff) {
    float theta = dot(toLight, normalize(-direction));
    return theta > cutOff ? 1.0 : 0.0;
}

vec3 shade(Light light, vec3 normal, vec3 fragPos, vec3 viewDir, vec3 surface, vec3 gloss) {
    vec3 toLight = normalize(light.position - fragPos); // none where the light is on the fragment (H1)
    float diff = max(dot(normal, toLight), 0.0);
    float spec = highlight(toLight, normal, viewDir, material.shininess);
    float d = length(light.position - fragPos);
    float weakening = attenuation(light.constant, light.linear, light.quadratic, d);
    float inside = cone(toLight, light.direction, light.cutOff);

    vec3 ambient = light.ambient * surface;
    vec3 diffuse = light.diffuse * diff * surface;
    vec3 specular = light.specular * spec * gloss;
    return ambient + (diffuse + specular) * inside * weakening;
}

void main() {
    vec3 surface = texture(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture(material.specular, TexCoords).rgb;
    FragColor = vec4(shade(light, normalize(Normal), FragPos, normalize(viewPos - FragPos), surface, gloss), 1.0);
}
