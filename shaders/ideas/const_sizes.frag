#version 330 core
// Array sizes from macros and constant expressions.

#define CASCADES 4
#define PAIRS(n) ((n) * 2)

const int LIGHTS = 3;
const int SLOTS = max(LIGHTS, CASCADES) + 1;
const float KERNEL[] = float[](0.25, 0.5, 0.25);
const uint HEX = 0x2u;

layout(std140) uniform SizeBlock {
    vec4 a[CASCADES];         // offset 0, stride 16
    vec4 b[PAIRS(LIGHTS)];    // offset 64, stride 16
    vec4 c[SLOTS];            // offset 160, stride 16
    vec4 d[KERNEL.length()];  // offset 240, stride 16
    vec4 e[HEX << 1];         // offset 288, stride 16
    vec4 f[LIGHTS == 3 ? 2 : 9]; // offset 352, stride 16
    float tail;               // offset 384
};

out vec4 color;

void main() {
    color = (a[3] + b[5] + c[4] + d[2] * KERNEL[1] + e[3] + f[1]) * tail;
}
