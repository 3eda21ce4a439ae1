#version 330 core
// A spotlight with a hard edge: full light inside the cone, ambient light outside.

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

// Unit vector along v; the zero vector stays zero.
vec3 unit(vec3 v) {
    return v * inversesqrt(max(dot(v, v), 1.0e-30));
}

float attenuation(float d) {
    return 1.0 / max(light.constant + d * (light.linear + light.quadratic * d), 1.0e-6);
}

// Inside means a smaller angle, that is, a *larger* cosine. Compared as 1 - cos,
// which is half the squared chord between two unit vectors: in a narrow cone the
// cosines themselves agree in nearly every digit.
bool inside(vec3 toLight) {
    vec3 chord = toLight - unit(-light.direction);
    return 0.5 * dot(chord, chord) < 1.0 - light.cutOff;
}

void main() {
    vec3 path = light.position - FragPos;
    vec3 toLight = unit(path);
    vec3 surface = texture(material.diffuse, TexCoords).rgb;

    // Ambient light is neither cut nor weakened, so that the edge never turns darker inside than outside.
    vec3 sum = light.ambient * surface;
    if (inside(toLight)) {
        vec3 normal = unit(Normal);
        float facing = max(dot(normal, toLight), 0.0);
        float mirror = dot(unit(viewPos - FragPos), reflect(-toLight, normal));
        float highlight = mirror > 0.0 ? pow(min(mirror, 1.0), material.shininess) : 0.0;
        vec3 gloss = texture(material.specular, TexCoords).rgb;
        sum += (light.diffuse * facing * surface + light.specular * highlight * gloss)
             * attenuation(length(path));
    }
    FragColor = vec4(sum, 1.0);
}
