#version 330 core
// Of four numbers the last says what the light is, 0 for a sun and 1 for a lamp, compared
// without any slack.

in vec3 FragPos;
in vec3 Normal;

out vec4 FragColor;

uniform vec4 sun;
uniform vec3 sunColor;
uniform vec4 lamp;
uniform vec3 lampColor;
uniform vec3 surface;

vec3 lit(vec4 light, vec3 color) {
    vec3 path = light.w == 0.0 ? -light.xyz : light.xyz - FragPos;
    return color * max(dot(normalize(Normal), normalize(path)), 0.0) * surface;
}

void main() {
    FragColor = vec4(lit(sun, sunColor) + lit(lamp, lampColor), 1.0);
}
