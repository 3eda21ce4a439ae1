#version 330 core
// All nine shapes. matCxR has C columns of R rows; in std140 each column of a
// column-major matrix takes 16 bytes, so the size depends on C alone.

layout(std140) uniform ColumnBlock {
    mat2 m22;   // offset 0, size 32
    mat2x3 m23; // offset 32, size 32
    mat2x4 m24; // offset 64, size 32
    mat3x2 m32; // offset 96, size 48
    mat3 m33;   // offset 144, size 48
    mat3x4 m34; // offset 192, size 48
    mat4x2 m42; // offset 240, size 64
    mat4x3 m43; // offset 304, size 64
    mat4 m44;   // offset 368, size 64
    float tail; // offset 432
} c;

out vec4 color;

void main() {
    vec2 two = c.m22[1] + c.m32[2] + c.m42[3];
    vec3 three = c.m23[1] + c.m33[2] + c.m43[3];
    vec4 four = c.m24[1] + c.m34[2] + c.m44[3];
    color = vec4(two, 0.0, 0.0) + vec4(three, 0.0) + four * c.tail;
}
