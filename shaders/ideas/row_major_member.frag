#version 330 core
// row_major on single members, and column_major to take it back.

struct Bone {
    mat4x3 pose;    // as the block says where it is used
    float weight;
};

layout(std140) uniform MixedBlock {
    mat4x3 byColumn;                   // offset 0, size 64
    layout(row_major) mat4x3 byRow;    // offset 64, size 48
    layout(row_major) Bone bone;       // offset 112: reaches into the struct, pose is 48 bytes
    layout(column_major) mat3x2 uv;    // offset 176, size 48
    float tail;                        // offset 224
} m;

in vec4 position;
out vec4 color;

void main() {
    vec3 p = m.byColumn * position + m.byRow * position + m.bone.pose * position * m.bone.weight;
    color = vec4(m.uv * p, m.tail, 1.0);
}
