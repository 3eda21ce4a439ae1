#version 330 core
// A point light that weakens with distance.
//
// Coefficients for a reach of 50 units: constant 1, linear 0.09, quadratic 0.032.
// At that distance the light has fallen to about 1 %, which is still visible.

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

// 1 / (constant + linear d + quadratic d^2), kept finite when nothing has been set yet.
float attenuation(float d) {
    return 1.0 / max(light.constant + d * (light.linear + light.quadratic * d), 1.0e-6);
}

vec3 shade(vec3 toLight, vec3 toEye, vec3 normal, vec3 surface, vec3 gloss) {
    float facing = max(dot(normal, toLight), 0.0);
    float mirror = dot(toEye, reflect(-toLight, normal));
    float highlight = mirror > 0.0 ? pow(min(mirror, 1.0), material.shininess) : 0.0;
    return (light.ambient + light.diffuse * facing) * surface + light.specular * highlight * gloss;
}

void main() {
    vec3 path = light.position - FragPos;
    vec3 surface = texture(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture(material.specular, TexCoords).rgb;

    // The ambient term is weakened too, so that many such lights do not add up to a bright fog.
    vec3 lit = shade(unit(path), unit(viewPos - FragPos), unit(Normal), surface, gloss);
    FragColor = vec4(lit * attenuation(length(path)), 1.0);
}
