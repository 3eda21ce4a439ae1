#version 450

layout(local_size_x = 8, local_size_y = 4) in;

layout(set = 0, binding = 0, std430) readonly buffer Values { float values[]; };
layout(set = 0, binding = 2, std430) buffer Sums { uint count; vec3 total; } sums;
layout(set = 0, binding = 3, r32f) uniform image2D heights;
layout(set = 0, binding = 4, std140) uniform Scale { vec4 by; } scales[2];

void main() {
    uint i = gl_LocalInvocationIndex;
    sums.total.x = values[i] * scales[1].by.x;
    imageStore(heights, ivec2(i), imageLoad(heights, ivec2(0)) + vec4(sums.count));
}
