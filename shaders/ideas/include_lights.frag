#version 450
#extension GL_GOOGLE_include_directive : require
// Structs and functions come from a shared header; the block is declared here.

#include "../include/lights.glsl"

layout(std140, set = 0, binding = 0) uniform LightBlock {
    DirectionalLight sun;  // offset 0, size 32
    PointLight lamps[16];  // offset 32, stride 32
    int count;             // offset 544
} lights;

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 0) out vec4 color;

void main() {
    vec3 n = unit(normal);
    vec3 sum = directional_diffuse(lights.sun, n);
    for (int i = 0; i < min(lights.count, 16); i++) {
        sum += point_diffuse(lights.lamps[i], position, n);
    }
    color = vec4(sum, 1.0);
}
