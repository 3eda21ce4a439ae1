#version 450
// An array of blocks is three buffers of one layout, not one buffer three times as
// long. In Vulkan they share a binding, in OpenGL they take three in a row.

layout(std140, set = 0, binding = 0) uniform LightBlock {
    vec3 direction;  // offset 0
    float intensity; // offset 12
    vec3 color;      // offset 16
} lights[3];

layout(std430, set = 0, binding = 1) readonly buffer ClusterBuffer {
    uint first;     // offset 0
    uint indices[]; // offset 4, stride 4
} clusters[2];

layout(location = 0) in vec3 normal;
layout(location = 0) out vec4 color;

void main() {
    vec3 sum = vec3(0.0);
    sum += lights[0].color * lights[0].intensity * max(dot(normal, -lights[0].direction), 0.0);
    sum += lights[1].color * lights[1].intensity * max(dot(normal, -lights[1].direction), 0.0);
    sum += lights[2].color * lights[2].intensity * max(dot(normal, -lights[2].direction), 0.0);
    color = vec4(sum, float(clusters[0].indices[clusters[1].first]));
}
