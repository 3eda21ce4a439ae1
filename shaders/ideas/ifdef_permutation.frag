#version 330 core
// One source, many layouts: build it with SHADOWS or another MAX_LIGHTS and the
// members move. The numbers below are those of the build without any define.

#ifndef MAX_LIGHTS
#define MAX_LIGHTS 4
#endif

layout(std140) uniform LightBlock {
    vec4 colors[MAX_LIGHTS];   // offset 0, stride 16
#ifdef SHADOWS
    mat4 shadows[MAX_LIGHTS];
#endif
#if MAX_LIGHTS > 8
    uvec4 clusters[MAX_LIGHTS / 4];
#else
    uint mask;                 // offset 64
#endif
    float bias;                // offset 68
};

in vec4 position;
out vec4 color;

void main() {
    vec4 sum = vec4(0.0);
    for (int i = 0; i < MAX_LIGHTS; i++) {
#if MAX_LIGHTS > 8
        bool lit = (clusters[i / 4].x >> uint(i & 31) & 1u) != 0u;
#else
        bool lit = (mask >> uint(i) & 1u) != 0u;
#endif
        if (lit) {
#ifdef SHADOWS
            sum += colors[i] * step(bias, (shadows[i] * position).z);
#else
            sum += colors[i] + bias;
#endif
        }
    }
    color = sum;
}
