#version 330 core
// 软边聚光灯：内锥之内全亮，外锥之外只剩环境光，两者之间按余弦线性过渡。
// (A spotlight with a soft edge: bright inside the inner cone, ambient light only
// outside the outer cone, and linear in the cosine between the two.)

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
    vec3 direction;    // 光线前进的方向
    float cutOff;      // 内锥半角的余弦
    float outerCutOff; // 外锥半角的余弦，比内锥的小

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

// 边缘系数，0 到 1。用弦长求 1 - cos：锥角很小时两个余弦都接近 1，直接相减会丢掉有效数字。
// 内外两个角相等时分母为零，因此给一个下限，结果退化成硬边。
float cone(vec3 toLight) {
    vec3 chord = toLight - unit(-light.direction);
    float outer = 1.0 - light.outerCutOff;
    float inner = 1.0 - light.cutOff;
    return clamp((outer - 0.5 * dot(chord, chord)) / max(outer - inner, 1.0e-9), 0.0, 1.0);
}

void main() {
    vec3 path = light.position - FragPos;
    vec3 toLight = unit(path);
    vec3 normal = unit(Normal);

    float facing = max(dot(normal, toLight), 0.0);
    float mirror = dot(unit(viewPos - FragPos), reflect(-toLight, normal));
    float highlight = mirror > 0.0 ? pow(min(mirror, 1.0), material.shininess) : 0.0;

    vec3 surface = texture(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture(material.specular, TexCoords).rgb;
    vec3 direct = light.diffuse * facing * surface + light.specular * highlight * gloss;

    // 环境光不受锥体和衰减影响
    FragColor = vec4(light.ambient * surface + direct * (cone(toLight) * attenuation(length(path))), 1.0);
}
