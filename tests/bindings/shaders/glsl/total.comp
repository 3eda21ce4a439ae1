#version 450

layout(local_size_x = 8, local_size_y = 4) in;

layout(set = 0, binding = 0, std430) readonly buffer Values { float values[]; } all;
layout(set = 0, binding = 2, std430) buffer Sums { uint count; vec3 total; } sums;
layout(set = 0, binding = 3, rgba8) uniform writeonly image2D trail;

void main() {
    uint i = gl_LocalInvocationIndex;
    sums.total.x = all.values[i] * float(sums.count);
    imageStore(trail, ivec2(int(i)), vec4(sums.total, 1.0));
}
