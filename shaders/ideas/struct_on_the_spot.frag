#version 330 core
// Structs declared where they are used, with and without a name, and several names
// behind one type.

uniform struct Sun {
    vec3 direction, color;
    float intensity;
} sun, moon;

uniform struct {
    vec3 color;
    float density, height[2];
} fog;

in vec3 normal;
in vec3 position;
out vec4 color;

vec3 diffuse(Sun light) {
    return light.color * light.intensity * max(dot(normal, -light.direction), 0.0);
}

void main() {
    float haze = clamp(fog.density * (position.y - fog.height[0]) / max(fog.height[1], 1.0e-6), 0.0, 1.0);
    color = vec4(mix(diffuse(sun) + diffuse(moon), fog.color, haze), 1.0);
}
