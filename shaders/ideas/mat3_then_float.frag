#version 330 core
// A mat3 is an array of three vec3 columns, 16 bytes apart: 48 bytes, not 36.
// A float behind it does not move into the hole of the last column.

layout(std140) uniform NormalBlock {
    mat3 normalMatrix;  // offset 0, matrix stride 16
    float scale;        // offset 48
    mat3 probes[2];     // offset 64, stride 48
    vec2 texel;         // offset 160
};

in vec3 normal;
out vec4 color;

void main() {
    vec3 n = normalMatrix * normal * scale;
    color = vec4(probes[0] * n + probes[1] * n.zyx, texel.x + texel.y);
}
