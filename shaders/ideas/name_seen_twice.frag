#version 450
// An input and a block member of one name. Behind an instance name the member is no
// global name: plain `position` is the input, `light.position` the member.

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;

layout(std140, set = 0, binding = 0) uniform LightBlock {
    vec4 color;     // offset 0
    vec3 position;  // offset 16
    vec3 normal;    // offset 32
} light;

layout(location = 0) out vec4 color;

void main() {
    vec3 path = light.position - position;
    float d2 = max(dot(path, path), 1.0e-30);
    color = light.color * max(dot(normal, path), 0.0) * max(dot(light.normal, -path), 0.0) / (d2 * d2);
}
