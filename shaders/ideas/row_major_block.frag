#version 330 core
// row_major on the block: every matrix is stored row by row. Only the bytes change;
// the shader still writes m[column][row].

layout(std140, row_major) uniform RowBlock {
    mat2x4 m24; // offset 0, size 64: four rows of two
    mat3x2 m32; // offset 64, size 32: two rows of three
    mat4 m44;   // offset 96, size 64
    mat2 m22[2]; // offset 160, stride 32
    float tail; // offset 224
} r;

out vec4 color;

void main() {
    color = r.m24[1] + vec4(r.m32[2], r.m22[1][0]) + r.m44[3] * r.tail;
}
