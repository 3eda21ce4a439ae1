#version 450
#extension GL_GOOGLE_include_directive : require

layout(local_size_x = 8, local_size_y = 4) in;

#include "include/sums.glsl" // The file includes another.
#include "include/sums.glsl"
#ifdef NEVER
#include "include/missing.glsl"
#endif

void main() {
    uint i = gl_LocalInvocationIndex;
    sums.total.x = scaled(all.values[i], sums.count);
    imageStore(trail, ivec2(int(i)), vec4(sums.total, 1.0));
}
